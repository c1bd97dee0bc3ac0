# SPDX-License-Identifier: GPL-2.0-or-later
"""A real port: opened for writing, which only --transmit allows, and a bus played there."""

from __future__ import annotations

import sys
from contextlib import suppress

from sisbus.playing.characters import Played
from sisbus.wires.wire import Pace
from sistap.tap.line import ports
from sistap.tap.line.reader import PortError, PortLost
from sistap.tap.line.reader.pyserial import closed_serial
from sistap.tap.line.reader.trouble import device_trouble, url_trouble
from sistap.tap.line.settings import LineSettings

if sys.platform == "win32":
    _TROUBLE: tuple[type[Exception], ...] = (OSError, ValueError, KeyError, OverflowError)
else:
    import termios

    _TROUBLE = (OSError, ValueError, KeyError, OverflowError, termios.error)

_WRITE_S = 2.0  # longest time that a port may accept nothing


class TransmittingPort:
    """A device or URL that pyserial opens, with RTS and DTR low."""

    def __init__(self, name: str, settings: LineSettings) -> None:
        """Open it. May raise PortError."""
        self.name = name
        self._pseudo_terminal = ports.adapter(name).pseudo_terminal
        self.settings = settings
        try:
            # Linux strips the parity of a pty, and then refuses it the second time.
            self._device = closed_serial(name, settings._replace(parity="N") if self._pseudo_terminal else settings)
            self._device.write_timeout = _WRITE_S
            self._device.open()
        except _TROUBLE as error:
            raise PortError(_trouble(name, settings, error)) from error

    def wait_for_partner(self) -> None:
        """Return at once: a port cannot tell whether somebody is there."""

    def write(self, data: bytes) -> None:
        """Send; return when the system has the data. May raise PortLost."""
        try:
            self._device.write(data)
        except _TROUBLE as error:
            raise self._lost(error) from error

    def drain(self) -> None:
        """Return when all was sent. May raise PortLost."""
        try:
            self._device.flush()
        except _TROUBLE as error:
            raise self._lost(error) from error

    def read(self, timeout_s: float) -> bytes:
        """Return what arrived; empty if nothing did in that time. May raise PortLost."""
        try:
            self._device.timeout = timeout_s
            data: bytes = self._device.read(1)
            if data and (waiting := self._device.in_waiting):
                data += self._device.read(waiting)
        except _TROUBLE as error:
            raise self._lost(error) from error
        return data

    def change(self, settings: LineSettings) -> None:
        """Continue at another rate after sending everything. PortError if the port cannot; PortLost."""
        self.drain()
        try:
            self._device.baudrate = settings.baud
        except _TROUBLE as error:
            raise PortError(_trouble(self.name, settings, error)) from error
        self.settings = settings

    def close(self) -> None:
        """Release it after sending the rest."""
        with suppress(PortLost):
            self.drain()
        self._device.close()

    def _lost(self, error: Exception) -> PortLost:
        return PortLost(f"{self.name} is gone or accepts nothing ({error}): connect it and start again")


def _trouble(name: str, settings: LineSettings, error: Exception) -> str:
    """Return why it cannot be opened or changed: on Windows only pyserial's message tells."""
    trouble = url_trouble if "://" in name or sys.platform == "win32" else device_trouble
    return trouble(name, settings, error)


class PortWire:
    """A port that sends. It carries values, times and rates, but no parity errors and no breaks."""

    deserted = False  # a port cannot tell whether somebody listens

    def __init__(self, pace: Pace, port: str, settings: LineSettings) -> None:
        """Open it. May raise PortError."""
        self.name = port
        self._pace = pace
        self._port = TransmittingPort(port, settings)

    def wait_for_listener(self) -> None:
        """Begin at once."""
        self._pace.start()

    def deliver(self, played: Played) -> list[str]:
        """Send each character so that it ends at its time. May raise PortError or PortLost."""
        if played.settings.baud != self._port.settings.baud:
            self._port.change(played.settings)
        for character in played.characters:
            self._pace.wait_until(character.time_ns - played.settings.character_ns)
            self._port.write(bytes([character.value]))
        return []

    def close(self) -> None:
        """Release the port."""
        self._port.close()
