# SPDX-License-Identifier: GPL-2.0-or-later
"""The bus at a real port: each character is sent there at its time."""

from __future__ import annotations

from sistap.bus.playing.played import Played
from sistap.bus.wires.pace import Pace
from sistap.bus.wires.transmitting import TransmittingPort
from sistap.line.settings import LineSettings


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
