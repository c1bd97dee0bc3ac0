# SPDX-License-Identifier: GPL-2.0-or-later
"""Logs of other programs, explained: lines, bytes (`reading`), telegrams (`cutting`), tshark, and text or a page.

A capture as such a log is here, too (`log`). It may use all rooms but the other products.
"""
