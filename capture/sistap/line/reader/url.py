# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads any URL that pyserial can open."""

from __future__ import annotations

from contextlib import suppress

from sistap.line.clock import CLOCK
from sistap.line.clocks import STEADY, monotonic_ns
from sistap.line.reader.contract import READ_SIZE, PortError, PortLost
from sistap.line.reader.listening import closed_serial, configure
from sistap.line.reader.trouble import url_trouble
from sistap.line.settings import LineSettings, Read


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
        self.timing = f"times are those of arrival at this program over {over}; {STEADY}; uncertainty unknown"
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
        """Read with other settings from now on. PortError if the port does not support them: then the old settings
        stay.
        """
        try:
            configure(self._device, settings)
        except (OSError, ValueError) as error:
            with suppress(OSError, ValueError):
                configure(self._device, self.settings)
            raise PortError(url_trouble(self.name, settings, error)) from error
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
