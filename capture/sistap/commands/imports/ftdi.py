# SPDX-License-Identifier: GPL-2.0-or-later
"""Decodes what an FTDI adapter says over USB: line settings in requests, two status bytes before the characters.

The layout follows Wireshark's ftdi-ft dissector and Linux' ftdi_sio.
"""

from __future__ import annotations

from collections.abc import Iterator

from sistap.commands.imports.usb_line import Plain, flags, rate, with_format
from sistap.commands.imports.usb_transfers import Setup
from sistap.tap.line.settings import LineSettings

VENDORS = frozenset({0x0403})
LATENCY_MS = 16  # of the timer after power-on

_VENDOR_REQUEST = 0x40
_SET_BAUD_RATE, _SET_DATA, _SET_LATENCY_TIMER = 3, 4, 9
# Reset, modem control, flow control, rate, format, event and error character, latency timer.
REQUESTS = frozenset((_VENDOR_REQUEST, request) for request in (0, 1, 2, 3, 4, 6, 7, 9))

_STATUS_LENGTH = 2
# The lower half of the modem status, the first byte, states the size of a packet: 1 full speed, 2 high speed.
_PACKET_SIZES = {0x01: 64, 0x02: 512}

_CLOCK, _HIGH_SPEED_CLOCK = 3_000_000, 12_000_000  # Hz; the rate is a fraction of them
_EIGHTHS = (0, 4, 2, 1, 3, 5, 6, 7)  # what the three bits beside the divisor add to it


def port_of_request(setup: Setup) -> int:
    """Return the port of a chip with several, from 0. Chips with one port use the field for something else."""
    return max((setup.place & 0xFF) - 1, 0)


def port_of_endpoint(endpoint: int) -> int:
    """Return the port, from 0, that has this endpoint. The endpoints are 1 and 2, then 3 and 4, and so on."""
    return ((endpoint & 0x0F) - 1) // 2


def settings_after(setup: Setup, data: bytes, settings: LineSettings) -> LineSettings:  # noqa: ARG001
    """Return the line settings after a request."""
    if setup.type == _VENDOR_REQUEST and setup.request == _SET_BAUD_RATE:
        return settings._replace(baud=baud_rate(setup.value, setup.place))
    if setup.type == _VENDOR_REQUEST and setup.request == _SET_DATA and setup.value & 0xFF in (7, 8):
        return with_format(settings, setup.value & 0xFF, setup.value >> 8 & 0x07, setup.value >> 11 & 0x03)
    return settings


def latency_ms(setup: Setup) -> int | None:
    """Return the latency timer in ms that a request sets; None if it sets none."""
    is_timer = setup.type == _VENDOR_REQUEST and setup.request == _SET_LATENCY_TIMER
    return setup.value & 0xFF if is_timer else None


def baud_rate(value: int, place: int) -> int:
    """Return the rate in Bd of a SetBaudRate request (wValue, wIndex).

    The place of the third bit of the fraction depends on the chip, which a capture need not show.
    """
    high = place >> 8
    if high & 2:
        return rate(_rate(value, high & 1, _HIGH_SPEED_CLOCK))
    return rate(_rate(value, place & 1, _CLOCK), _rate(value, high & 1, _CLOCK))


def _rate(value: int, third_bit: int, clock: int) -> float:
    whole, fraction = value & 0x3FFF, _EIGHTHS[value >> 14 | third_bit << 2]
    if not fraction and whole <= 1:
        return clock / (1.5 if whole else 1)
    return clock / (whole + fraction / 8)


def looks_like(data: bytes) -> bool:
    """Tell whether the adapter can have sent this transfer: each of its packets begins with the same modem status."""
    kind = data[0] & 0x0F
    starts = range(0, len(data), _PACKET_SIZES.get(kind, 64))
    return kind in _PACKET_SIZES and all(
        data[start] & 0x0F == kind and len(data) >= start + _STATUS_LENGTH for start in starts
    )


class Packets(Plain):
    """The transfers of an FTDI adapter: packets that begin with a modem status and a line status."""

    def packets(self, data: bytes) -> Iterator[tuple[bytes, bytes]]:
        """Split a transfer: characters and flags of each packet that has any.

        The status applies to the whole packet, so an error has a known place only in a packet of one character. An
        error without characters is ignored: the adapter repeats it until it is fetched.
        """
        size = _size(data)
        for start in range(0, len(data), size):
            status, characters = data[start + 1 : start + 2], data[start + _STATUS_LENGTH : start + size]
            if characters:
                yield characters, flags(status[0], len(characters))

    def is_full(self, data: bytes) -> bool:
        """Tell whether more may have waited in the adapter: the last packet is full."""
        return bool(data) and len(data) % _size(data) == 0


def _size(data: bytes) -> int:
    return _PACKET_SIZES.get(data[0] & 0x0F, 64) if data else 64
