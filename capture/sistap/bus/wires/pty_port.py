# SPDX-License-Identifier: GPL-2.0-or-later
"""A pseudo terminal that a real master opens instead of a port."""

from __future__ import annotations

import os
import random
import select
import sys
import time
import tty

from sistap.bus.playing.hearing import hear
from sistap.bus.wires.pseudo_terminal import set_speed, speed
from sistap.line.settings import LineSettings

if sys.platform == "win32":
    raise ImportError("Windows has no pseudo terminals")

_READ_SIZE = 4096


class PseudoTerminalPort:
    """A pty with stations. As on a wire, master and stations with different rates hear noise."""

    name: str

    def __init__(self, settings: LineSettings, seed: int) -> None:
        """Open it raw. May raise OSError."""
        self.settings = settings
        self._noise = random.Random(f"{seed} port")
        self._ours, self._theirs = os.openpty()  # theirs stays open, to keep its settings between two masters
        self.name = os.ttyname(self._theirs)
        tty.setraw(self._theirs)
        set_speed(self._theirs, settings.baud)
        os.set_blocking(self._ours, False)

    def read(self, timeout_s: float) -> bytes:
        """Return what arrived; empty if nothing did in that time."""
        if not select.select([self._ours], [], [], timeout_s)[0]:
            return b""
        masters = self._masters
        return bytes(self._heard(value, masters, self.settings) for value in os.read(self._ours, _READ_SIZE))

    def write(self, data: bytes) -> None:
        """Send each character at its time; as on a wire, what a master does not read is lost."""
        begun = time.monotonic()
        for place, value in enumerate(data, start=1):
            time.sleep(max(0.0, begun + place * self.settings.character_ns / 1e9 - time.monotonic()))
            try:
                os.write(self._ours, bytes([self._heard(value, self.settings, self._masters)]))
            except BlockingIOError:
                return

    def drain(self) -> None:
        """Do nothing: all was sent."""

    def change(self, settings: LineSettings) -> None:
        """Continue at another rate."""
        self.settings = settings

    def close(self) -> None:
        """Disconnect the master."""
        os.close(self._theirs)
        os.close(self._ours)

    @property
    def _masters(self) -> LineSettings:
        """Return the settings with which the master has it open; its parity is unknown."""
        return self.settings._replace(baud=speed(self._ours) or self.settings.baud)

    def _heard(self, value: int, line: LineSettings, other: LineSettings) -> int:
        return value if line.baud == other.baud else hear(value, line, other, self._noise)[0]
