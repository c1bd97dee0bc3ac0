# SPDX-License-Identifier: GPL-2.0-or-later
"""Ports of pyserial: made to listen only from the moment they are open, and URLs read through it."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from sistap.tap.line.clock import CLOCK, STEADY, monotonic_ns
from sistap.tap.line.drivers import NOT_REPORTED
from sistap.tap.line.reader.contract import READ_SIZE, PortError, PortLost
from sistap.tap.line.reader.trouble import url_trouble
from sistap.tap.line.settings import LineSettings, Read

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


def reconfigure(device: serial.Serial, old: LineSettings, new: LineSettings) -> None:
    """Set other settings of an open port. PortError if it does not support them: then the old ones stay."""
    try:
        configure(device, new)
    except (OSError, ValueError) as error:
        with suppress(OSError, ValueError):
            configure(device, old)
        raise PortError(url_trouble(str(device.port), new, error)) from error


class UrlReader:
    """Reads through pyserial: URLs such as socket:// and rfc2217://. It has no error flags."""

    def __init__(self, port: str, settings: LineSettings, line: int = 0) -> None:
        """Open the port. May raise PortError."""
        self.name = port
        self.adapter = port
        self.settings = settings
        self.line = line
        scheme, separator, _ = port.partition("://")
        over = scheme + separator
        clock = f"times are those of arrival at this program over {over}; {STEADY}; uncertainty unknown"
        self.timing = f"{clock}; {NOT_REPORTED}"
        self.notes: tuple[str, ...] = (
            f"{port}: without a known uncertainty no verdict on its times is possible: use a port of this computer",
        )
        try:
            self._device = closed_serial(port, settings)
            self._device.open()
        except (OSError, ValueError, KeyError) as error:  # KeyError: an option of loop:// that pyserial does not know
            raise PortError(url_trouble(port, settings, error)) from error
        self._lost: str | None = None

    def read(self, timeout_s: float) -> Read | None:
        """Return what arrived; None if nothing arrived in that time. May raise PortLost."""
        end_ns = monotonic_ns() + int(timeout_s * 1e9)
        data = b""
        while not self._lost and not data and monotonic_ns() <= end_ns:
            data = self._waiting()
        if data:
            return Read(self.line, CLOCK.wall_ns(monotonic_ns()), data, bytes(len(data)), settings=self.settings)
        if self._lost:
            raise PortLost(self._lost)
        return None

    def change(self, settings: LineSettings) -> None:
        """Read with other settings from now on. PortError if the port does not support them."""
        reconfigure(self._device, self.settings, settings)
        self.settings = settings

    def _waiting(self) -> bytes:
        """Read one character and all that wait with it; keep what came before the port was lost."""
        data = b""
        try:
            data = self._device.read(1)
            while data and len(data) < READ_SIZE and (waiting := self._device.in_waiting):
                data += self._device.read(waiting)
        except OSError as error:
            self._lost = f"{self.name} is gone ({error}): connect it again and start a new capture"
        return data

    def close(self) -> None:
        """Release the port."""
        self._device.close()
