# SPDX-License-Identifier: GPL-2.0-or-later
"""Captures of other tools, made into captures of ours: `sistap import`."""
