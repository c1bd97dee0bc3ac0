# SPDX-License-Identifier: GPL-2.0-or-later
"""Captures that are there: read as blocks, packets or records (reading), several as one (joining), in memory
(stream), from when on they are told (since).

It may use files and common.
"""
