# SPDX-License-Identifier: GPL-2.0-or-later
"""The rates that SIS knows, and how service 0x03 says them (IF02 chapter 6, fig. 6-11)."""

from __future__ import annotations

BAUD_MASKS = {9600: 0x00, 19200: 0x01, 38400: 0x02, 57600: 0x04, 115200: 0x08}
RATES = tuple(BAUD_MASKS)


def rate_of(mask: int) -> int | None:
    """Return the rate in Bd that a mask says; None if it says several or none: that is not defined."""
    return next((baud for baud, of_baud in BAUD_MASKS.items() if of_baud == mask), None)
