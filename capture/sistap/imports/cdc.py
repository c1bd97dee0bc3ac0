# SPDX-License-Identifier: GPL-2.0-or-later
"""Decodes what a CDC ACM adapter says over USB: line settings in requests, line errors in notifications.

USB Communications Class, PSTN subclass: SET_LINE_CODING, SERIAL_STATE. Several chips of other kinds accept the first.
"""

from __future__ import annotations

import struct

from sistap.imports.usb_transfers import Setup
from sistap.line.settings import Flag, LineSettings

CLASSES = frozenset({0x02, 0x0A})  # of its interfaces: control and data

# Linux sends it when the adapter is plugged in, and not again while it stays the same.
NO_RATE = "a driver tells a CDC adapter its rate only when it changes"

_CLASS_REQUEST, _SET_LINE_CODING = 0x21, 0x20
_LINE_CODING = struct.Struct("<IBBB")  # rate, stop bits, parity, data bits
_NOTIFICATION, _SERIAL_STATE = 0xA1, 0x20
_STATE_AT = 8  # after the header of the notification
_BREAK, _FRAMING, _PARITY, _OVERRUN = 0x04, 0x10, 0x20, 0x40


def is_request(setup: Setup) -> bool:
    """Tell whether this is a request to a CDC adapter."""
    return (setup.type, setup.request) == (_CLASS_REQUEST, _SET_LINE_CODING)


def settings_after(setup: Setup, data: bytes, settings: LineSettings) -> LineSettings:
    """Return the line settings after a request."""
    if not is_request(setup) or len(data) < _LINE_CODING.size:
        return settings
    baud, stop, parity, bits = _LINE_CODING.unpack_from(data)
    if bits not in (5, 6, 7, 8) or parity > 4 or stop > 2:
        return settings
    return LineSettings(baud, bits, "NOEMS"[parity], stop + 2)


def errors(notification: bytes) -> Flag:
    """Return the line errors in a notification. It does not say which character has them."""
    if len(notification) <= _STATE_AT or notification[:2] != bytes([_NOTIFICATION, _SERIAL_STATE]):
        return Flag(0)
    state = notification[_STATE_AT]
    damaged = Flag.UNLOCATED_ERROR if state & (_BREAK | _FRAMING | _PARITY) else Flag(0)
    return damaged | (Flag.LOST_BEFORE if state & _OVERRUN else Flag(0))
