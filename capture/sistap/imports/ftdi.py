# SPDX-License-Identifier: GPL-2.0-or-later
"""Decodes what an FTDI adapter says over USB: line settings in requests, two status bytes before the characters.

The layout follows Wireshark's ftdi-ft dissector and Linux' ftdi_sio.
"""

from __future__ import annotations

from collections.abc import Iterator

from sistap.imports.usb_transfers import Setup
from sistap.line.settings import Flag, LineSettings

VENDOR = 0x0403
LATENCY_MS = 16  # of the timer after power-on
STATUS_LENGTH = 2

_VENDOR_REQUEST = 0x40
_SET_BAUD_RATE, _SET_DATA, _SET_LATENCY_TIMER = 3, 4, 9

# The line status, the second of the two bytes.
_OVERRUN, _PARITY, _FRAMING, _BREAK = 0x02, 0x04, 0x08, 0x10

# The lower half of the modem status states the size of a packet: 1 full speed, 2 high speed.
_PACKET_SIZES = {0x01: 64, 0x02: 512}

_CLOCK, _HIGH_SPEED_CLOCK = 3_000_000, 12_000_000  # Hz; the rate is a fraction of them
_EIGHTHS = (0, 4, 2, 1, 3, 5, 6, 7)  # what the three bits beside the divisor add to it
_USUAL_RATES = (300, 600, 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200, 230400, 460800, 921600)
_TOLERANCE = 0.01  # a divisor is closer than this to the usual rates


def is_request(setup: Setup) -> bool:
    """Tell whether only an FTDI adapter receives such a request."""
    return setup.type == _VENDOR_REQUEST and setup.request in (_SET_BAUD_RATE, _SET_DATA, _SET_LATENCY_TIMER)


def port_of_request(setup: Setup) -> int:
    """Return the port of a chip with several, from 0. Chips with one port use the field for something else."""
    return max((setup.place & 0xFF) - 1, 0)


def port_of_endpoint(endpoint: int) -> int:
    """Return the port, from 0, that has this endpoint. The endpoints are 1 and 2, then 3 and 4, and so on."""
    return ((endpoint & 0x0F) - 1) // 2


def settings_after(setup: Setup, data: bytes, settings: LineSettings) -> LineSettings:
    """Return the line settings after a request."""
    if setup.type != _VENDOR_REQUEST:
        return settings
    if setup.request == _SET_BAUD_RATE:
        return settings._replace(baud=baud_rate(setup.value, setup.place))
    if setup.request == _SET_DATA:
        bits, parity, stop = setup.value & 0xFF, setup.value >> 8 & 0x07, setup.value >> 11 & 0x03
        if bits in (7, 8) and parity <= 4 and stop <= 2:
            return settings._replace(data_bits=bits, parity="NOEMS"[parity], stop_half_bits=stop + 2)
    return settings


def latency_ms(setup: Setup) -> int | None:
    """Return the latency timer in ms that a request sets; None if it sets none."""
    is_timer = setup.type == _VENDOR_REQUEST and setup.request == _SET_LATENCY_TIMER
    return setup.value & 0xFF if is_timer else None


def baud_rate(value: int, place: int) -> int:
    """Return the rate in Bd of a SetBaudRate request (wValue, wIndex).

    The place of the third bit of the fraction depends on the chip, which a capture need not show. Of both readings, the
    one closer to a usual rate is right.
    """
    high = place >> 8
    readings = {_rate(value, place & 1, _CLOCK), _rate(value, high & 1, _CLOCK)}
    if high & 2:
        readings = {_rate(value, high & 1, _HIGH_SPEED_CLOCK)}
    error, usual, rate = min((abs(rate / usual - 1), usual, rate) for rate in readings for usual in _USUAL_RATES)
    return usual if error < _TOLERANCE else round(rate)


def _rate(value: int, third_bit: int, clock: int) -> float:
    whole, fraction = value & 0x3FFF, _EIGHTHS[value >> 14 | third_bit << 2]
    if not fraction and whole <= 1:
        return clock / (1.5 if whole else 1)
    return clock / (whole + fraction / 8)


def looks_like(data: bytes) -> bool:
    """Tell whether the adapter can have sent this: a transfer begins with a modem status."""
    return len(data) >= STATUS_LENGTH and data[0] & 0x0F in _PACKET_SIZES


def packets(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Split a transfer: characters and flags of each packet that has any.

    The status applies to the whole packet, so an error has a known place only in a packet of one character. An error
    without characters is ignored: the adapter repeats it until it is fetched.
    """
    size = _PACKET_SIZES.get(data[0] & 0x0F, 64) if data else 64
    for start in range(0, len(data), size):
        status, characters = data[start + 1 : start + 2], data[start + STATUS_LENGTH : start + size]
        if characters:
            yield characters, _flags(status[0], len(characters))


def is_full(data: bytes) -> bool:
    """Tell whether more may have waited in the adapter: the last packet is full."""
    size = _PACKET_SIZES.get(data[0] & 0x0F, 64) if data else 64
    return bool(data) and len(data) % size == 0


def _flags(status: int, count: int) -> bytes:
    error = 0
    if status & _BREAK:
        error = Flag.BREAK
    elif status & (_PARITY | _FRAMING):
        error = Flag.CHARACTER_ERROR
    if (error or status & _OVERRUN) and count > 1:  # a loss is before one of them, too
        error = Flag.UNLOCATED_ERROR
    first = error | (Flag.LOST_BEFORE if status & _OVERRUN else 0)
    return bytes([first]) + bytes([error]) * (count - 1)
