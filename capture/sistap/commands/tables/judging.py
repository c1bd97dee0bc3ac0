# SPDX-License-Identifier: GPL-2.0-or-later
"""What happened, over several captures: files that continue one another are judged as one, as `sistap report` does."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from sistap.commands.tables.rows import Row, of_episode
from sistap.commands.tables.schema import TABLES
from sistap.dissected.episodes.engine import Engine
from sistap.dissected.episodes.episode import Episode
from sistap.dissected.episodes.rules import Thresholds
from sistap.dissected.packets.dissection import Packet


class _JudgedCapture(NamedTuple):
    """A capture in a course."""

    before: int  # packets before its first one
    begin_s: float
    file: str


class _Course:
    """Captures that continue one another."""

    def __init__(self, thresholds: Thresholds) -> None:
        self.ended_s = -math.inf
        self._packets = 0
        self._parts: list[_JudgedCapture] = []
        self._engine = Engine(thresholds=thresholds)

    def begin(self, file: str, begin_s: float) -> None:
        """Go on with the next capture."""
        self._parts.append(_JudgedCapture(self._packets, begin_s, file))

    def add(self, packet: Packet) -> None:
        """Judge a packet of it. From then on, its number counts the packets of all captures."""
        packet.number += self._parts[-1].before
        self._packets, self.ended_s = packet.number, packet.epoch_s
        self._engine.add(packet)

    def rows(self) -> Iterator[Row]:
        """Yield what happened, and where: in a capture, and the packet of that capture."""
        for episode in self._engine.finish():
            part = self._part(episode)
            yield of_episode(episode, part.file, episode.packets[0] - part.before if episode.packets else None)

    def _part(self, episode: Episode) -> _JudgedCapture:
        """Return the capture in which it begins."""
        if episode.packets:
            after = bisect_right(self._parts, episode.packets[0] - 1, key=lambda part: part.before)
        else:
            after = bisect_right(self._parts, episode.from_s, key=lambda part: part.begin_s)
        return self._parts[max(after - 1, 0)]


class Judging:
    """All captures of a call, in the order of their time.

    A capture continues the one that ended last before it begins. If all others still go on, it begins a course of its
    own: it is another line, or has a part of another capture, and would be counted twice.
    """

    def __init__(self, thresholds: Thresholds) -> None:
        self._thresholds = thresholds
        self._courses: list[_Course] = []
        self.name = ""  # stays the same if more captures come

    def packets(self, packets: Iterable[Packet], file: str) -> Iterator[Packet]:
        """Yield the packets of the next capture, and judge them after that."""
        course = None
        for packet in packets:
            yield packet
            if course is None:
                course = self._continued(packet.epoch_s)
                self.name = self.name or f"{file}\0{packet.epoch_s}\0episodes"
                course.begin(file, packet.epoch_s)
            course.add(packet)

    def rows(self) -> Iterator[Row]:
        """Yield what happened, once where captures have the same telegrams."""
        same = ("port", *TABLES["episodes"].same)
        told = set()
        for row in (row for course in self._courses for row in course.rows()):
            key = tuple(row.values[name] for name in same)
            if key not in told:
                told.add(key)
                yield row

    def _continued(self, begin_s: float) -> _Course:
        ended = [course for course in self._courses if course.ended_s <= begin_s]
        if not ended:
            ended = [_Course(self._thresholds)]
            self._courses += ended
        return max(ended, key=lambda course: course.ended_s)
