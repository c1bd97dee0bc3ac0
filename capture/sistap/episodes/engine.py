# SPDX-License-Identifier: GPL-2.0-or-later
"""All that looks for episodes, packet by packet."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from sistap.episodes.baseline import unlike
from sistap.episodes.book import Book
from sistap.episodes.causes import find_causes
from sistap.episodes.episode import Episode, Hit
from sistap.episodes.faults import Faults
from sistap.episodes.masters import Masters, Writes
from sistap.episodes.rules import THRESHOLDS, Thresholds
from sistap.episodes.silence import BusSilence, StationSilence
from sistap.episodes.states import Limits, Phases, Rate, Tap
from sistap.episodes.values import Values
from sistap.packets.dissection import Packet, Telegram


class _Port:
    """What looks at one port; `before` looked at it in a good capture."""

    def __init__(self, thresholds: Thresholds, before: _Port | None = None) -> None:
        self.masters: Masters = Masters(thresholds, before.masters if before else None)
        self.writes: Writes = Writes(self.masters, thresholds, before.writes if before else None)
        self.phases: Phases = Phases(thresholds, before.phases if before else None)
        self.rate: Rate = Rate(before.rate if before else None)
        self.limits: Limits = Limits(before.limits if before else None)
        self.silence = StationSilence(thresholds)
        states = self.phases, self.rate, self.limits
        self.bus = BusSilence(thresholds)
        lookers = (Tap(thresholds), self.bus, Faults(), self.silence, self.masters, self.writes, *states)
        # Most packets are nothing new to any of them. So none is a generator, which costs more than what it looks at.
        self._adds: list[Callable[[Packet], Iterable[Hit]]] = [looker.add for looker in lookers]

    def add(self, packet: Packet) -> list[Hit]:
        return [hit for add in self._adds for hit in add(packet)]


class Engine:
    """Makes episodes of packets."""

    def __init__(self, before: Engine | None = None, thresholds: Thresholds = THRESHOLDS) -> None:
        """Begin with no packet. What was usual before, in a good capture, is usual still: masters, writes, states of
        the bus, levels of values.
        """
        self._before = before
        self._thresholds = thresholds
        self._book = Book()
        self._ports: dict[str, _Port] = {}
        self._values = Values(thresholds)

    def add(self, packet: Packet) -> None:
        """Look at a packet."""
        port = self._of(packet.interface)
        self._values.add(packet)
        hits = port.add(packet)
        if hits:
            self._book.add(hits)

    def live(self, packet: Packet, *, is_learning: bool) -> list[Hit]:
        """Look at a packet; return what it tells by now. Nothing is noted for the end."""
        port = self._of(packet.interface)
        begun = self._values.add(packet)
        hits = [*port.add(packet), *port.silence.under_way(packet.interface)]
        unusual = [*port.writes.first, *self._values.under_way(begun)]
        return hits + [hit for hit in unusual if hit.kind == "changed" or not is_learning]

    def unanswered(self, packet: Packet, command: Telegram) -> None:
        """Learn that a command had no reaction: of a packet that was looked at, only the next command tells it."""
        command.unanswered = True
        alone = replace(packet, telegrams=[command], accesses=[])
        self._of(packet.interface).silence.add(alone)
        self._values.add(alone)

    def silent(self, now_s: float) -> list[Hit]:
        """Return what lasts while no packet comes."""
        return [hit for port in self._ports.values() for hit in port.bus.under_way(now_s)]

    def _of(self, name: str) -> _Port:
        port = self._ports.get(name)
        if port is None:
            before = self._before._port(name) if self._before else None
            port = self._ports[name] = _Port(self._thresholds, before)
        return port

    def finish(self) -> list[Episode]:
        """Return all episodes, in the order of their beginning; some are known only at the end."""
        for name, port in self._ports.items():
            self._book.add(port.silence.finish(name))
            self._book.add(port.writes.finish())
        self._book.add(self._values.finish())
        if self._before:
            self._book.add(unlike(self._before._values, self._values))
        episodes = self._book.episodes()
        find_causes(episodes)
        for one in episodes:
            if one.kind == "write" and one.hit.port in self._ports:
                one.outcome = self._ports[one.hit.port].writes.outcome(one.hit)
        return episodes

    def _port(self, name: str) -> _Port | None:
        """Return the port of this name, in a good capture. An only one may have another name now."""
        only = next(iter(self._ports.values())) if len(self._ports) == 1 else None
        return self._ports.get(name, only)
