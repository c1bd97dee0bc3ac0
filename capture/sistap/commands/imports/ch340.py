# SPDX-License-Identifier: GPL-2.0-or-later
"""Decodes what a CH340 or CH341 is told over USB: rate and format, written to its registers.

The registers follow Linux' ch341 and the maker's own driver. The second writes all of them with one request.
"""

from __future__ import annotations

from sistap.commands.imports.usb_line import rate, with_format
from sistap.commands.imports.usb_transfers import Setup
from sistap.tap.line.settings import LineSettings

VENDORS = frozenset({0x1A86, 0x4348, 0x9986})
_VENDOR_REQUEST = 0x40
_WRITE, _INITIALIZE = 0x9A, 0xA1
# Write, initialize, modem control; read, version.
REQUESTS = frozenset({(0x40, _WRITE), (0x40, _INITIALIZE), (0x40, 0xA4), (0xC0, 0x95), (0xC0, 0x5F)})

_RATE_REGISTERS, _FORMAT_REGISTERS = 0x1312, 0x2518  # two in one write: wIndex has the values, in the same order
_WITH_BOTH = 0x9C  # bits in the request of the maker's driver: format and rate follow
_RECEIVES = 0x80  # bit of the format register; without it the value is no format
_CLOCK = 48_000_000  # Hz


def settings_after(setup: Setup, data: bytes, settings: LineSettings) -> LineSettings:  # noqa: ARG001
    """Return the line settings after a request."""
    if setup.type != _VENDOR_REQUEST:
        return settings
    if setup.request == _INITIALIZE and setup.value & _WITH_BOTH == _WITH_BOTH:
        return _formatted(settings, setup.value >> 8)._replace(baud=baud_rate(setup.place))
    if (setup.request, setup.value) == (_WRITE, _RATE_REGISTERS):
        return settings._replace(baud=baud_rate(setup.place))
    if (setup.request, setup.value) == (_WRITE, _FORMAT_REGISTERS):
        return _formatted(settings, setup.place & 0xFF)
    return settings


def baud_rate(registers: int) -> int:
    """Return the rate in Bd: the upper byte counts up to 256, the lower one has the prescaler."""
    prescaler = 12 - 3 * (registers & 3) - (registers >> 2 & 1)
    return rate(_CLOCK / ((256 - (registers >> 8)) << prescaler))


def _formatted(settings: LineSettings, control: int) -> LineSettings:
    if not control & _RECEIVES:
        return settings
    parity = 1 + (control >> 4 & 3) if control & 0x08 else 0
    return with_format(settings, 5 + (control & 3), parity, 2 if control & 0x04 else 0)
