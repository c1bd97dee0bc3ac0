# SPDX-License-Identifier: GPL-2.0-or-later
"""Summaries of millions of values in bounded memory: how often each time came, and how much happened when."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence

from sistap.tap.common.quantiles import quantile


class Bin:
    """Times that are nearly equal."""

    __slots__ = ("count", "longest_s")

    def __init__(self) -> None:
        self.count = 0
        self.longest_s = 0.0

    def join(self, other: Bin) -> None:
        """Take in others."""
        self.count += other.count
        self.longest_s = max(self.longest_s, other.longest_s)


class Distribution:
    """How often each time came, in s, of whole ns. Count, sum and extremes are exact, and so is a share of few.

    Bins are 2.4 % wide.
    """

    PER_DECADE = 100
    FEW = 4096  # times; so many are sorted into bins together: one by one takes several times as long
    _JOINED = 5  # bins that make one bar

    def __init__(self) -> None:
        self._total_ns = 0
        self._sorted = 0  # into bins
        self._shortest_s = math.inf
        self._longest_s = 0.0
        self._bins: defaultdict[int, Bin] = defaultdict(Bin)
        self._zeros = 0
        self._waiting: list[float] = []  # in no bin yet
        self._few: list[float] = []  # all of them, or none if there are more

    @classmethod
    def union(cls, parts: Iterable[Distribution]) -> Distribution:
        """Return one of all times of these."""
        union = cls()
        for part in parts:
            part._sort()
            union._total_ns += part._total_ns
            union._sorted += part._sorted
            union._few += part._few
            union._zeros += part._zeros
            union._shortest_s = min(union._shortest_s, part._shortest_s)
            union._longest_s = max(union._longest_s, part._longest_s)
            for number, found in part._bins.items():
                union._bins[number].join(found)
        if union._sorted > cls.FEW:
            union._few = []
        return union

    def add(self, times_s: Sequence[float]) -> None:
        """Count times."""
        self._total_ns += round(sum(times_s) * 1e9)
        self._waiting += times_s
        if len(self._waiting) >= self.FEW:
            self._sort()

    @property
    def count(self) -> int:
        """Return how many there are."""
        return self._sorted + len(self._waiting)

    @property
    def shortest_s(self) -> float | None:
        """Return the shortest time; None without any."""
        self._sort()
        return self._shortest_s if self.count else None

    @property
    def longest_s(self) -> float:
        """Return the longest time; 0 without any."""
        self._sort()
        return self._longest_s

    @property
    def zeros(self) -> int:
        """Return how many are 0, which has no logarithm."""
        self._sort()
        return self._zeros

    @property
    def bins(self) -> Mapping[int, Bin]:
        """Return the bins of all others, by PER_DECADE * log10(s), rounded down."""
        self._sort()
        return self._bins

    def _sort(self) -> None:
        """Put what waits into bins."""
        if not self._waiting:
            return
        self._sorted += len(self._waiting)
        if self._sorted <= self.FEW:
            self._few += self._waiting
        else:
            self._few = []
        times_s = sorted(self._waiting)
        self._waiting.clear()
        self._shortest_s = min(self._shortest_s, times_s[0])
        self._longest_s = max(self._longest_s, times_s[-1])
        begin = bisect_right(times_s, 0.0)
        self._zeros += begin
        while begin < len(times_s):
            number = self._number(times_s[begin])
            end = bisect_right(times_s, number, begin, key=self._number)
            found = self._bins[number]
            found.count += end - begin
            found.longest_s = max(found.longest_s, times_s[end - 1])
            begin = end

    @classmethod
    def _number(cls, time_s: float) -> int:
        return math.floor(math.log10(time_s) * cls.PER_DECADE)

    def within_s(self, share: float) -> float:
        """Return the time that this share (0 to 1) of all does not exceed; of more than FEW up to 2.4 % too much."""
        self._sort()
        if self._few:
            return quantile(sorted(self._few), share)
        wanted = share * self.count
        passed = self.zeros
        longest_s = 0.0
        for _, found in sorted(self.bins.items()):
            if passed >= wanted:
                break
            passed += found.count
            longest_s = found.longest_s
        return longest_s

    @property
    def average_s(self) -> float:
        """Return the average; 0 without any."""
        return self._total_ns / 1e9 / self.count if self.count else 0.0

    def bars(self) -> tuple[list[int], list[float]]:
        """Join bins to bars without a gap; return their counts and edges in s. Nothing without a bin."""
        numbers = [number // self._JOINED for number in self.bins]
        if not numbers:
            return [], []
        first = min(numbers)
        counts = [0] * (max(numbers) - first + 1)
        for number, found in self.bins.items():
            counts[number // self._JOINED - first] += found.count
        return counts, [self.edge_s((first + number) * self._JOINED) for number in range(len(counts) + 1)]

    @classmethod
    def edge_s(cls, number: int) -> float:
        """Return the lower edge of a bin."""
        return math.pow(10, number / cls.PER_DECADE)


class Slices:
    """Counts along the time of a capture of unknown length.

    When the time exceeds the slices, each pair of neighbours is merged.
    """

    COUNT = 480

    def __init__(self) -> None:
        self.width_s = 0.001
        self.counts: defaultdict[str, list[int]] = defaultdict(lambda: [0] * self.COUNT)
        self.loads: list[float | None] = [None] * self.COUNT  # percent; the highest in each slice, None: no telegram
        self.latest_s = 0.0

    def at(self, times_s: Sequence[float]) -> Sequence[int]:
        """Return the slices of times since the first packet; an earlier time belongs to the first."""
        self.latest_s = max(self.latest_s, *times_s)
        while self.used > self.COUNT:
            self._double()
        return [max(int(time_s / self.width_s), 0) for time_s in times_s]

    @property
    def used(self) -> int:
        """Return the number of slices in use."""
        return int(self.latest_s / self.width_s) + 1

    def count(self, name: str, numbers: Iterable[int]) -> None:
        """Count something in each of these slices."""
        counts = self.counts[name]
        for number in numbers:
            counts[number] += 1

    def add_load(self, number: int, percent: float) -> None:
        """Keep the load of the bus, in percent, if it is the highest in its slice."""
        load = self.loads[number]
        self.loads[number] = percent if load is None else max(load, percent)

    def _double(self) -> None:
        self.width_s *= 2
        rest = self.COUNT // 2
        for counts in self.counts.values():
            counts[:] = [a + b for a, b in zip(counts[::2], counts[1::2], strict=True)] + [0] * rest
        pairs = zip(self.loads[::2], self.loads[1::2], strict=True)
        self.loads[:] = [max((load for load in pair if load is not None), default=None) for pair in pairs]
        self.loads += [None] * rest
