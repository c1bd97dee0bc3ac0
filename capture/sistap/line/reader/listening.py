# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes ports of pyserial, on every system, so that they only listen from the moment they are open."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sistap.line.settings import LineSettings

if TYPE_CHECKING:  # imported where it is needed: without pyserial the rest still works
    import serial

_URL_TIMEOUT_S = 0.05  # pyserial's own; changing it per read would configure the port each time


def closed_serial(port: str, settings: LineSettings) -> serial.Serial:
    """Make pyserial's port, not yet open, so that RTS and DTR are known to be low before it is."""
    import serial

    device: serial.Serial = serial.serial_for_url(
        port,
        do_not_open=True,
        baudrate=settings.baud,
        bytesize=settings.data_bits,
        parity=settings.parity,
        stopbits=settings.stop_half_bits / 2,
        exclusive=True,
        timeout=_URL_TIMEOUT_S,
    )
    device.dtr = False
    device.rts = False
    return device


def configure(device: serial.Serial, settings: LineSettings) -> None:
    """Change rate and format of an open port of pyserial. OSError or ValueError if it cannot do them."""
    device.baudrate = settings.baud
    device.bytesize = settings.data_bits
    device.parity = settings.parity
    device.stopbits = settings.stop_half_bits / 2
