# SPDX-License-Identifier: GPL-2.0-or-later
"""Cyclic redundancy checks of serial protocols: low bit first."""

from __future__ import annotations


def crc(data: bytes, polynomial: int, start: int) -> int:
    """Return the check of `data`; the polynomial without its highest term, its bits reversed."""
    value = start
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (polynomial if value & 1 else 0)
    return value
