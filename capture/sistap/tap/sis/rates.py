# SPDX-License-Identifier: GPL-2.0-or-later
"""The rates of SIS, and their masks in service 0x03 (IF02 chapter 6, fig. 6-11)."""

from __future__ import annotations

BAUD_MASKS = {9600: 0x00, 19200: 0x01, 38400: 0x02, 57600: 0x04, 115200: 0x08}
RATES = tuple(BAUD_MASKS)


def rate_of(mask: int) -> int | None:
    """Return the rate in Bd of a mask; None if it has several bits or none, which is not defined."""
    return next((baud for baud, of_baud in BAUD_MASKS.items() if of_baud == mask), None)
