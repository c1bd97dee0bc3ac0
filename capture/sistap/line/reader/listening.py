# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes pyserial's ports on every system listen only, from the moment they are open."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sistap.line.settings import LineSettings

if TYPE_CHECKING:  # imported late: the rest works without pyserial
    import serial

_URL_TIMEOUT_S = 0.05  # pyserial's own; changing it for each read would configure the port each time


def closed_serial(port: str, settings: LineSettings, device_class: type[serial.Serial] | None = None) -> serial.Serial:
    """Return pyserial's port, not yet open, so that RTS and DTR are certain to be low before it opens.

    Without `device_class`, it has the class for this name or URL.
    """
    import serial

    if device_class:
        device = device_class()
        device.port = port
    else:
        device = serial.serial_for_url(port, do_not_open=True)
    configure(device, settings)
    device.exclusive = True
    device.timeout = _URL_TIMEOUT_S
    device.dtr = False
    device.rts = False
    return device


def configure(device: serial.Serial, settings: LineSettings) -> None:
    """Set rate and format of a port of pyserial, open or not. OSError or ValueError if it does not support them."""
    device.baudrate = settings.baud
    device.bytesize = settings.data_bits
    device.parity = settings.parity
    device.stopbits = settings.stop_half_bits / 2
