# SPDX-License-Identifier: GPL-2.0-or-later
"""Intervals between the characters of a telegram, by talker, rate and place: which TzA would be kept.

Every interval I is known up to the uncertainty u. So a limit is surely kept if it is at least I + u. No document says
whether the character that ends an interval counts: if not, I less a character time counts, the pause alone.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

from sistap.dissected.packets.dissection import LOST, UNRESOLVED, Judged, Packet
from sistap.dissected.packets.distribution import Distribution
from sistap.tap.line.settings import LineSettings

MOST_PLACES = 24  # characters of a telegram that have a place of their own
_THREE = 3.0  # of n without a single one: with 95 % confidence less than 3 of n in the long run


@lru_cache(256)
def _character_s(baud: int | None, text: str) -> float:
    """Return the time of a character in the format that a packet shows; 0: unknown."""
    try:
        return LineSettings.parse(baud, text).character_ns / 1e9 if baud else 0.0
    except ValueError:
        return 0.0


class Talker(NamedTuple):
    """Who talks, at which rate; 0: unknown."""

    station: int
    baud: int


@dataclass
class Pause:
    """The longest intervals of a talker, one of each telegram; times in s."""

    telegrams: int = 0
    times: Distribution = field(default_factory=Distribution)
    longest_s: float = 0.0
    position: int | None = None  # of the character after the longest, from 1
    most_s: float = 0.0  # the largest I + u
    most_alone_s: float = 0.0  # the same of the pause alone
    has_unknown: bool = False  # a telegram without an uncertainty
    unresolved: int = 0
    ambiguous: int = 0  # of these: no uncertainty decides them, because they depend on what counts
    exact_s: float = math.inf  # an uncertainty that would have decided all others of these
    limits_s: set[float] = field(default_factory=set)
    ratio: float = 0.0  # the largest I + u as a part of the limit
    _longest_in: int = 0  # packet

    def add(self, packets: Sequence[Packet]) -> None:
        """Count the telegrams of packets that say the same, one of each packet."""
        found = [(packet, pause) for packet in packets if (pause := packet.telegrams[0].pause)]
        if not found:
            return
        _, limit_s, verdict = found[0][1]
        self.telegrams += len(found)
        self.times.add([pause.time_s for _, pause in found if pause.time_s])
        self._note_longest(*max(found, key=lambda one: one[1].time_s))
        known = [(pause.time_s, packet.uncertainty_s) for packet, pause in found if packet.uncertainty_s is not None]
        self.has_unknown |= len(known) < len(found)
        if not known:
            return
        most_s = max(time_s + uncertainty_s for time_s, uncertainty_s in known)
        self.most_s = max(self.most_s, most_s)
        character_s = _character_s(packets[0].baud, packets[0].format)
        self.most_alone_s = max(self.most_alone_s, most_s - character_s)
        if limit_s:
            self.limits_s.add(limit_s)
            self.ratio = max(self.ratio, most_s / limit_s)
            if verdict == UNRESOLVED:
                self._note_unresolved([time_s for time_s, _ in known], limit_s, character_s)

    def _note_unresolved(self, times_s: Sequence[float], limit_s: float, character_s: float) -> None:
        """Note what would decide them: they are too long if the pause alone is, and right if the interval is."""
        self.unresolved += len(times_s)
        for time_s in times_s:
            if time_s <= limit_s:
                self.exact_s = min(self.exact_s, limit_s - time_s)
            elif character_s and time_s - character_s > limit_s:
                self.exact_s = min(self.exact_s, time_s - character_s - limit_s)
            else:
                self.ambiguous += 1

    def _note_longest(self, packet: Packet, pause: Judged) -> None:
        """Note the longest of some packets. Of equal ones, the first counts."""
        is_first = pause.time_s == self.longest_s and packet.number < self._longest_in
        if pause.time_s > self.longest_s or is_first:
            self.longest_s, self.position = pause.time_s, packet.telegrams[0].pause_position
            self._longest_in = packet.number

    @property
    def safe_ms(self) -> int | None:
        """Return the smallest TzA in ms that all of these telegrams surely kept; None if nobody knows."""
        return self._whole_ms(self.most_s)

    @property
    def safe_alone_ms(self) -> int | None:
        """Return the same if only the pause between two characters counts."""
        return self._whole_ms(self.most_alone_s)

    def _whole_ms(self, most_s: float) -> int | None:
        return None if self.has_unknown or not self.telegrams else max(math.ceil(round(most_s * 1e3, 6)), 1)

    @property
    def one_in(self) -> int:
        """Return of how many telegrams at most one exceeds it, with 95 % confidence."""
        return int(self.telegrams / _THREE)


@dataclass
class Pauses:
    """All of a capture, in bounded memory."""

    _TOGETHER = 1024  # telegrams are sorted in groups: one by one takes several times as long

    count: int = 0  # intervals in telegrams
    same_read: int = 0  # of these: whose two characters came in one read
    talkers: defaultdict[Talker, Pause] = field(default_factory=lambda: defaultdict(Pause))
    _places: list[Distribution] = field(default_factory=lambda: [Distribution() for _ in range(2, MOST_PLACES + 1)])
    _waiting: defaultdict[int, list[list[float]]] = field(default_factory=lambda: defaultdict(list))  # by length

    _others: Distribution = field(default_factory=Distribution)  # intervals in other telegrams

    def add(self, packets: Sequence[Packet]) -> None:
        """Count the telegrams of packets that say the same, unless characters were lost or all came in one read."""
        packet = packets[0]
        if packet.errors & LOST or not packet.telegrams:
            return
        self.count += sum(len(one.intervals_s) for one in packets)
        self.same_read += packet.same_read * len(packets)
        if packet.is_of_one_read:
            return
        telegram = packet.telegrams[0]
        if len(packet.telegrams) > 1 or not telegram.good:
            for one in packets:
                self._others.add(one.intervals_s)
            return
        if telegram.talker is not None:
            self.talkers[Talker(telegram.talker, packet.baud or 0)].add(packets)
        for one in packets:
            self._wait(one.intervals_s)

    def _wait(self, intervals_s: list[float]) -> None:
        alike = self._waiting[len(intervals_s)]
        alike.append(intervals_s)
        if len(alike) == self._TOGETHER:
            self._sort()

    def _sort(self) -> None:
        *places, last = self._places
        for alike in self._waiting.values():
            columns = list(zip(*alike, strict=True))
            for place, intervals_s in zip(places, columns, strict=False):
                place.add(intervals_s)
            for intervals_s in columns[len(places) :]:
                last.add(intervals_s)
        self._waiting.clear()

    def longest_s(self, station: int) -> float:
        """Return the longest interval of a station; 0: not known."""
        return max((one.longest_s for talker, one in self.talkers.items() if talker.station == station), default=0.0)

    @property
    def intervals(self) -> Distribution:
        """Return all intervals inside telegrams, except for those that came in one read as a whole."""
        self._sort()
        return Distribution.union([*self._places, self._others])

    @property
    def places(self) -> dict[int, Distribution]:
        """Return the intervals before each character, from the second on, that telegrams had."""
        self._sort()
        return {number: place for number, place in enumerate(self._places, 2) if place.count}
