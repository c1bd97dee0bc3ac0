# SPDX-License-Identifier: GPL-2.0-or-later
"""The interface of a station of the virtual bus: command telegram in, reaction telegram out."""

from __future__ import annotations

from typing import Protocol

from sistap.bus.stations.initialization import Initialization


class Station(Protocol):
    """Anything that hears commands.

    Its time is the bus's, in ns since the bus was started, and never goes back.
    """

    @property
    def address(self) -> int:
        """Return its number on its level."""

    @property
    def initialization(self) -> Initialization:
        """Return the settings that service 0x03 has set."""

    def react(self, command: bytes, now_ns: int) -> bytes | None:
        """Return the reaction to a command whose last character has arrived; None if there is none, e.g. for another
        station.
        """
