# SPDX-License-Identifier: GPL-2.0-or-later
"""Routes telegrams to stations on lower levels (IF02 chapter 2.2, fig. 2-10 to 2-15)."""

from __future__ import annotations

from collections.abc import Sequence

from sistap.bus.stations.initialization import Initialization
from sistap.bus.stations.slave import Slave, damage
from sistap.bus.stations.station import Station
from sistap.sis.telegram import BROADCAST, CONTROL_SYSTEM, Header, build, parse


class Router:
    """A station that answers for itself and routes telegrams with subaddresses."""

    def __init__(self, station: Slave, behind: Sequence[Station]) -> None:
        """Put the stations `behind` on a level below `station`."""
        self.address = station.address
        self._station = station
        self._behind = behind

    @property
    def initialization(self) -> Initialization:
        """Return the settings of the line above."""
        return self._station.initialization

    def react(self, command: bytes, now_ns: int) -> bytes | None:
        """Return the station's own reaction, or that from below; None if nobody answers."""
        if damage(command) is not None:
            return self._station.react(command, now_ns)
        header = parse(command)
        if not header.reaction and header.receiver == BROADCAST:
            self._pass_on(header, BROADCAST, header.subaddresses, now_ns)  # global: for all levels
        if header.reaction or not self._station.is_meant(header.receiver) or not header.subaddresses:
            return self._station.react(command, now_ns)
        answer = self._pass_on(header, header.subaddresses[0], header.subaddresses[1:], now_ns)
        if answer is None:
            return None
        below = parse(answer)
        return build(
            header.service,
            header.sender,
            header.receiver,
            below.body,
            reaction=True,
            system=below.control & CONTROL_SYSTEM,
            subaddresses=header.subaddresses,
            number=header.number,
        )

    def _pass_on(self, header: Header, receiver: int, subaddresses: bytes, now_ns: int) -> bytes | None:
        """Let all stations of the level below hear the command; return the reaction of its receiver."""
        passed_on = build(
            header.service, self.address, receiver, header.body, subaddresses=subaddresses, number=header.number
        )
        reactions = [station.react(passed_on, now_ns) for station in self._behind]
        return next((reaction for reaction in reactions if reaction), None)
