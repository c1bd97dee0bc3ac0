# SPDX-License-Identifier: GPL-2.0-or-later
"""Stations that answer slower: steadily, or from a time on."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from sistap.dissected.episodes.episode import ARROW, Hit
from sistap.dissected.episodes.levels import goes_on
from sistap.dissected.episodes.rules import THRESHOLDS, Thresholds
from sistap.dissected.episodes.trend import Slots, trend
from sistap.dissected.packets.dissection import Packet

_MINUTE_S = 60.0
_LEAST = 16  # points


_Points = Sequence[tuple[float, float]]


class _Change(NamedTuple):
    """From when on a station answers how much later."""

    at_s: float
    first_s: float
    last_s: float


class _Pace:
    """The reaction times of a station: their mean of each minute."""

    __slots__ = ("count", "minute", "slots", "sum_s")

    def __init__(self) -> None:
        self.slots = Slots()
        self.minute, self.count, self.sum_s = 0.0, 0, 0.0

    def end_minute(self, minute: float) -> None:
        if self.count:
            self.slots.add(self.minute * _MINUTE_S, self.sum_s / self.count)
        self.minute, self.count, self.sum_s = minute, 0, 0.0


class Paces:
    """Those of a bus."""

    def __init__(self, thresholds: Thresholds = THRESHOLDS) -> None:
        """Begin with none."""
        self._thresholds = thresholds
        self._paces: dict[int, _Pace] = {}

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Count the reaction times of a packet."""
        for telegram in packet.telegrams:
            reaction = telegram.reaction
            if reaction is None or not reaction.time_s or telegram.talker is None:
                continue
            pace = self._paces.get(telegram.talker)
            if pace is None:
                pace = self._paces[telegram.talker] = _Pace()
            minute = packet.epoch_s // _MINUTE_S
            if minute != pace.minute:
                pace.end_minute(minute)
            pace.count += 1
            pace.sum_s += reaction.time_s
        return ()

    def finish(self, port: str) -> Iterator[Hit]:
        """Yield the stations that became slower, and do so to the end."""
        for station, pace in self._paces.items():
            pace.end_minute(0)
            points = pace.slots.points()
            if len(points) < _LEAST or points[-1][0] - points[0][0] < self._thresholds.drift_s:
                continue
            change = self._rise(points) or self._jump(points)
            if change:
                at_s, first_s, last_s = change
                detail = f"reaction time {first_s * 1e3:.1f}{ARROW}{last_s * 1e3:.1f} ms"
                yield Hit("slower", 0, at_s, points[-1][0], station, "", detail, last_s - first_s, port=port)

    def _rise(self, points: _Points) -> _Change | None:
        """Return a rise that goes on to the end."""
        found = trend(points)
        risen_s = found.slope * (points[-1][0] - points[0][0])
        usual_s = statistics.median(value for _, value in points)
        least_s = max(self._least(usual_s), self._thresholds.drift_noise * found.scatter)
        is_one = risen_s >= least_s and goes_on(points, found)
        return _Change(points[0][0], points[0][1], points[-1][1]) if is_one else None

    def _jump(self, points: _Points) -> _Change | None:
        """Return a jump after which all are above all before."""
        for place in range(_LEAST // 2, len(points) - _LEAST // 2 + 1):
            before, after = ([value for _, value in part] for part in (points[:place], points[place:]))
            first_s, last_s = statistics.median(before), statistics.median(after)
            if min(after) > max(before) and last_s - first_s >= self._least(first_s):
                return _Change(points[place][0], first_s, last_s)
        return None

    def _least(self, usual_s: float) -> float:
        return max(self._thresholds.slower_s, self._thresholds.slower_part * usual_s)
