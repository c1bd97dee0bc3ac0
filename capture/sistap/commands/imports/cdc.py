# SPDX-License-Identifier: GPL-2.0-or-later
"""Decodes what CDC ACM adapters and the PL2303 say over USB: settings in requests, line errors in notifications.

USB Communications Class, PSTN subclass: SET_LINE_CODING, SERIAL_STATE. The PL2303 has both without being of that class.
"""

from __future__ import annotations

import struct

from sistap.commands.imports.usb_line import rate, with_format
from sistap.commands.imports.usb_transfers import Setup
from sistap.tap.line.settings import Flag, LineSettings

CLASSES = frozenset({0x02, 0x0A})  # of its interfaces: control and data
PL2303_VENDORS = frozenset({0x067B})

# Linux sends it when the adapter is plugged in, and not again while it stays the same.
NO_RATE = "a driver tells a CDC adapter its rate only when it changes"

_SET_LINE_CODING = (0x21, 0x20)
REQUESTS = frozenset({_SET_LINE_CODING, (0x21, 0x22)})  # and the control lines
PL2303_REQUESTS = REQUESTS | {(0x40, 0x01)}  # and its own registers
_LINE_CODING = struct.Struct("<IBBB")  # rate, stop bits, parity, data bits
_NOTIFICATION, _SERIAL_STATE = 0xA1, 0x20
_STATE_AT = 8  # after the header of the notification
_BREAK, _FRAMING, _PARITY, _OVERRUN = 0x04, 0x10, 0x20, 0x40

# A rate that the PL2303 does not know by itself is a divisor of its clock, with an exponent.
_IS_DIVISOR = 1 << 31
_CLOCK = 12_000_000 * 32  # Hz


def settings_after(setup: Setup, data: bytes, settings: LineSettings) -> LineSettings:
    """Return the line settings after a request."""
    if (setup.type, setup.request) != _SET_LINE_CODING or len(data) < _LINE_CODING.size:
        return settings
    baud, stop, parity, bits = _LINE_CODING.unpack_from(data)
    changed = with_format(settings, bits, parity, stop)
    return settings if changed is settings else changed._replace(baud=baud)


def pl2303_settings_after(setup: Setup, data: bytes, settings: LineSettings) -> LineSettings:
    """Return the line settings after a request to a PL2303."""
    after = settings_after(setup, data, settings)
    return after._replace(baud=_rate(after.baud)) if after.baud & _IS_DIVISOR else after


def _rate(coded: int) -> int:
    """Return the rate of a divisor. Its place, and the base of its exponent, depend on the chip."""
    usual = _CLOCK / (max(coded & 0x01FF, 1) << 2 * (coded >> 9 & 7))
    of_ta_and_tb = _CLOCK / (max(coded & 0x07FF, 1) << (coded >> 12 & 0x0E | coded >> 16 & 1))
    return rate(usual, of_ta_and_tb)


def errors(notification: bytes) -> Flag:
    """Return the line errors in a notification. It does not say which character has them."""
    if len(notification) <= _STATE_AT or notification[:2] != bytes([_NOTIFICATION, _SERIAL_STATE]):
        return Flag(0)
    state = notification[_STATE_AT]
    damaged = Flag.UNLOCATED_ERROR if state & (_BREAK | _FRAMING | _PARITY) else Flag(0)
    return damaged | (Flag.LOST_BEFORE if state & _OVERRUN else Flag(0))
