# SPDX-License-Identifier: GPL-2.0-or-later
"""What masters talk over: the simulated line (player.py) or a real one (real/talking.py)."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import Protocol

from sistap.bus.playing.played import Played
from sistap.bus.playing.script import Rate
from sistap.line.settings import LineSettings

Exchange = Generator[Played, None, bytes | None]  # what is sent, and the reaction it came to


class Line(Protocol):
    """Whoever brings what a master says to the stations."""

    collided: bool  # in the last exchange, with the rival's command

    @property
    def settings(self) -> LineSettings:
        """The settings of now."""

    @property
    def now_ns(self) -> int:
        """The time, in ns since the bus was started; before it nothing more is sent."""

    def exchange(self, command: bytes, rival: bytes | None) -> Exchange:
        """Send a command, come to its reaction, or None when TrS is over; `rival` is what another master may send."""

    def send(self, characters: bytes) -> Iterator[Played]:
        """Send characters that nobody has to answer."""

    def wait(self, ns: int) -> None:
        """Be silent for so long."""

    def change(self, rate: Rate) -> None:
        """Go on at another rate."""
