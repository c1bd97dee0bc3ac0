# SPDX-License-Identifier: GPL-2.0-or-later
"""Intervals between the characters of a telegram, by talker, rate and place: which TzA would be kept.

Every interval I is known up to the uncertainty u. So a limit is surely kept if it is at least I + u.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field
from itertools import zip_longest
from typing import NamedTuple

from sistap.packets.dissection import LOST, UNRESOLVED, Packet, Telegram
from sistap.packets.distribution import Distribution

MOST_PLACES = 24  # characters of a telegram that have a place of their own
_THREE = 3.0  # of n without a single one: with 95 % confidence less than 3 of n in the long run


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
    unknown: int = 0  # telegrams without an uncertainty
    unresolved: int = 0
    exact_s: float = math.inf  # an uncertainty that would have decided all of these
    limits_s: set[float] = field(default_factory=set)
    ratio: float = 0.0  # the largest I + u as a part of the limit

    def add(self, packet: Packet, telegram: Telegram) -> None:
        """Count a telegram."""
        pause = telegram.pause
        if pause is None:
            return
        time_s, limit_s, verdict = pause
        self.telegrams += 1
        if time_s:
            self.times.put(time_s)
        if time_s > self.longest_s:
            self.longest_s, self.position = time_s, telegram.pause_position
        if packet.uncertainty_s is None:
            self.unknown += 1
            return
        most_s = time_s + packet.uncertainty_s
        self.most_s = max(self.most_s, most_s)
        if limit_s:
            self.limits_s.add(limit_s)
            self.ratio = max(self.ratio, most_s / limit_s)
            if verdict == UNRESOLVED:
                self.unresolved += 1
                self.exact_s = min(self.exact_s, abs(time_s - limit_s))

    @property
    def safe_ms(self) -> int | None:
        """Return the smallest TzA in ms that all of these telegrams surely kept; None if nobody knows."""
        return None if self.unknown or not self.telegrams else max(math.ceil(round(self.most_s * 1e3, 6)), 1)

    @property
    def one_in(self) -> int:
        """Return of how many telegrams at most one exceeds it, with 95 % confidence."""
        return int(self.telegrams / _THREE)


@dataclass
class Pauses:
    """All of a capture, in bounded memory."""

    _TOGETHER = 1024  # telegrams are sorted in groups: one by one takes several times as long

    talkers: defaultdict[Talker, Pause] = field(default_factory=lambda: defaultdict(Pause))
    _places: list[Distribution] = field(default_factory=lambda: [Distribution() for _ in range(2, MOST_PLACES + 1)])
    _waiting: list[list[float]] = field(default_factory=list)  # in no place yet

    _others: Distribution = field(default_factory=Distribution)  # intervals in other telegrams
    _total_s: float = 0.0  # of all intervals

    def add(self, packet: Packet) -> None:
        """Count the telegrams of a packet; where characters were lost, no interval is known."""
        if packet.errors & LOST or not packet.telegrams:
            return
        self._total_s += packet.length_s
        telegram = packet.telegrams[0]
        if len(packet.telegrams) > 1 or not telegram.good:
            self._others.add(packet.intervals_s)
            return
        if telegram.talker is not None:
            self.talkers[Talker(telegram.talker, packet.baud or 0)].add(packet, telegram)
        self._waiting.append(packet.intervals_s)
        if len(self._waiting) >= self._TOGETHER:
            self._sort()

    def _sort(self) -> None:
        *places, last = self._places
        for place, intervals_s in zip(places, zip_longest(*self._waiting), strict=False):
            place.add([interval_s for interval_s in intervals_s if interval_s is not None])
        last.add([interval_s for intervals_s in self._waiting for interval_s in intervals_s[len(places) :]])
        self._waiting.clear()

    @property
    def intervals(self) -> Distribution:
        """Return all intervals inside telegrams."""
        self._sort()
        return Distribution.union([*self._places, self._others], self._total_s)

    @property
    def places(self) -> dict[int, Distribution]:
        """Return the intervals before each character, from the second on, that telegrams had."""
        self._sort()
        return {number: place for number, place in enumerate(self._places, 2) if place.count}
