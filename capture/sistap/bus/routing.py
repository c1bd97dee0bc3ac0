# SPDX-License-Identifier: GPL-2.0-or-later
"""Passing telegrams on to stations on lower levels (IF02 chapter 2.2, fig. 2-10 to 2-15)."""

from __future__ import annotations

from collections.abc import Iterable

from sistap.bus.drive import Station
from sistap.telegram import build, parse


class Router:
    """A station that answers for itself and passes on what has subaddresses."""

    def __init__(self, station: Station, behind: Iterable[Station]) -> None:
        """Put a level with the stations `behind` below `station`."""
        self.address = station.address
        self._station = station
        self._behind = {lower.address: lower for lower in behind}

    def react(self, command: bytes) -> bytes | None:
        """Give the station's own reaction, or that from below; None also if nobody below answers."""
        header = parse(command)
        if header.reaction or header.receiver != self.address or not header.subaddresses:
            return self._station.react(command)
        lower = self._behind.get(header.subaddresses[0])
        if lower is None:
            return None
        passed_on = build(
            header.service,
            self.address,
            header.subaddresses[0],
            header.body,
            subaddresses=header.subaddresses[1:],
            number=header.number,
        )
        answer = lower.react(passed_on)
        if answer is None:
            return None
        return build(
            header.service,
            header.sender,
            self.address,
            parse(answer).body,
            reaction=True,
            subaddresses=header.subaddresses,
            number=header.number,
        )
