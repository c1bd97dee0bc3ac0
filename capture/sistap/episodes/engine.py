# SPDX-License-Identifier: GPL-2.0-or-later
"""All that looks for episodes, packet by packet."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from sistap.episodes.book import Book
from sistap.episodes.episode import Episode, Hit
from sistap.episodes.faults import Faults
from sistap.episodes.masters import Masters, Writes
from sistap.episodes.silence import BusSilence, StationSilence
from sistap.episodes.states import Limits, Phases, Rate, Tap
from sistap.episodes.values import Values
from sistap.packets.dissection import Packet


class _Port:
    """What looks at one port."""

    def __init__(self) -> None:
        masters = Masters()
        self.silence = StationSilence()
        self.writes = Writes(masters)
        lookers = (*(Tap(), BusSilence(), Faults(), self.silence), *(masters, self.writes, Phases(), Rate(), Limits()))
        self._adds: list[Callable[[Packet], Iterator[Hit]]] = [looker.add for looker in lookers]

    def add(self, packet: Packet) -> list[Hit]:
        return [hit for add in self._adds for hit in add(packet)]


class Engine:
    """Makes episodes of packets."""

    def __init__(self) -> None:
        """Begin with no packet."""
        self._book = Book()
        self._ports: dict[str, _Port] = {}
        self._values = Values()

    def add(self, packet: Packet) -> list[Episode]:
        """Look at a packet; return the episodes that begin with it."""
        port = self._ports.get(packet.interface)
        if port is None:
            port = self._ports[packet.interface] = _Port()
        self._values.add(packet)
        hits = port.add(packet)
        return self._book.add(hits) if hits else []

    def finish(self) -> list[Episode]:
        """Return all episodes, in the order of their beginning; some are known only at the end."""
        for name, port in self._ports.items():
            self._book.add(port.silence.finish(name))
            self._book.add(port.writes.finish())
        self._book.add(self._values.finish())
        return self._book.episodes()
