# SPDX-License-Identifier: GPL-2.0-or-later
"""The interface of a line: the simulated one (player.py) or a real one (real/talking.py)."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import Protocol

from sistap.bus.playing.played import Played
from sistap.bus.playing.script import Rate
from sistap.line.settings import LineSettings

Exchange = Generator[Played, None, bytes | None]  # yields what is sent, returns the reaction


class Line(Protocol):
    """Carries what a master says to the stations."""

    collided: bool  # in the last exchange, with the rival's command

    @property
    def settings(self) -> LineSettings:
        """Return the present settings."""

    @property
    def now_ns(self) -> int:
        """Return the time in ns since the bus was started; nothing more is sent before it."""

    def exchange(self, command: bytes, rival: bytes | None) -> Exchange:
        """Send a command; return its reaction, or None after TrS. `rival` is a command that another master may send."""

    def send(self, characters: bytes) -> Iterator[Played]:
        """Send characters that need no answer."""

    def wait(self, ns: int) -> None:
        """Be silent for that long."""

    def change(self, rate: Rate) -> None:
        """Continue at another rate."""
