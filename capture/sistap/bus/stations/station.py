# SPDX-License-Identifier: GPL-2.0-or-later
"""What a station of the virtual bus is to everybody else: command telegram in, reaction telegram out."""

from __future__ import annotations

from typing import Protocol

from sistap.bus.stations.initialization import Initialization


class Station(Protocol):
    """Whatever hears commands.

    Its time is the bus's, in ns since the bus was started, and never goes back.
    """

    @property
    def address(self) -> int:
        """Its number on its level."""

    @property
    def initialization(self) -> Initialization:
        """What it was told of its line with service 0x03."""

    def react(self, command: bytes, now_ns: int) -> bytes | None:
        """Return the reaction to a command whose last character has come; None if there is none, e.g. for another."""
