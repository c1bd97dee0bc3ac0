# SPDX-License-Identifier: GPL-2.0-or-later
"""Robust figures: the middle, the scatter, and a line through values with its chance."""

from __future__ import annotations

import itertools
import math
import statistics
from collections.abc import Sequence
from typing import NamedTuple

_SIGMA = 1.4826  # of the normal distribution, in median deviations


def scatter(values: Sequence[float], middle: float) -> float:
    """Return the scatter, as a standard deviation; a few wild values do not matter."""
    return _SIGMA * statistics.median(abs(value - middle) for value in values)


def quartiles(weighted: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Return the quartiles of values with weights."""
    ordered = sorted(weighted)
    total = sum(weight for _, weight in ordered)
    return _within(ordered, total / 4), _within(ordered, total * 3 / 4)


def _within(ordered: Sequence[tuple[float, float]], wanted: float) -> float:
    sums = itertools.accumulate(weight for _, weight in ordered)
    return next(value for (value, _), passed in zip(ordered, sums, strict=True) if passed >= wanted)


class Trend(NamedTuple):
    """A line through points."""

    slope: float
    scatter: float  # of the points around it
    chance: float  # that points without a trend rise, or fall, as often


def trend(points: Sequence[tuple[float, float]]) -> Trend:
    """Return the line by Theil and Sen: the middle of all slopes; and the chance by Mann and Kendall."""
    slopes = [
        (after[1] - before[1]) / (after[0] - before[0])
        for before, after in itertools.combinations(points, 2)
        if after[0] > before[0]
    ]
    slope = statistics.median(slopes)
    rests = [y - slope * x for x, y in points]
    count = len(points)
    ups = sum((one > 0) - (one < 0) for one in slopes)
    deviation = math.sqrt(count * (count - 1) * (2 * count + 5) / 18)
    return Trend(slope, scatter(rests, statistics.median(rests)), math.erfc(abs(ups) / deviation / math.sqrt(2)))


class Slots:
    """The average of values along the time, in bounded memory."""

    MOST = 64

    def __init__(self) -> None:
        """Begin with none."""
        self._slots: dict[int, tuple[int, float, float]] = {}  # count, sum of times, sum of values
        self._width_s = 1.0

    def add(self, time_s: float, value: float) -> None:
        """Add a value."""
        self._put(self._slots, int(time_s // self._width_s), (1, time_s, value))
        while len(self._slots) > self.MOST:
            self._width_s *= 2
            wider: dict[int, tuple[int, float, float]] = {}
            for number, held in self._slots.items():
                self._put(wider, number // 2, held)
            self._slots = wider

    @staticmethod
    def _put(slots: dict[int, tuple[int, float, float]], number: int, more: tuple[int, float, float]) -> None:
        count, time_s, value = slots.get(number, (0, 0.0, 0.0))
        slots[number] = count + more[0], time_s + more[1], value + more[2]

    def points(self) -> list[tuple[float, float]]:
        """Return time and average of each slot."""
        return [(time_s / count, value / count) for count, time_s, value in sorted(self._slots.values(), key=_time)]


def _time(held: tuple[int, float, float]) -> float:
    return held[1] / held[0]
