# SPDX-License-Identifier: GPL-2.0-or-later
"""Millions of values in bounded memory, in the order in which they came: some dozens of pieces with counts.

Neighbouring values on a bus are alike: a slow hour has thousands of slow reactions and is one event. So pieces of the
time are compared, not single values.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

from sistap.dissected.packets.distribution import Distribution

MOST = 96  # pieces; merging neighbours leaves half of them
_ZERO = -(10**6)  # the bin of 0, which has no logarithm


class SamplePiece:
    """Consecutive values: how many there are, and how often each bin came."""

    __slots__ = ("counts", "values")

    def __init__(self) -> None:
        self.values = 0
        self.counts: Counter[int] = Counter()

    def __iadd__(self, other: SamplePiece) -> SamplePiece:
        self.values += other.values
        self.counts.update(other.counts)
        return self


class SamplePieces:
    """All pieces of a side, of equal length except the last."""

    def __init__(self) -> None:
        self.all: list[SamplePiece] = []
        self.length = 1  # values

    def add(self, bins: Sequence[int]) -> None:
        """Count values that came together: they belong to one piece."""
        if not self.all or self.all[-1].values >= self.length:
            if len(self.all) == MOST:
                self._halve()
            self.all.append(SamplePiece())
        self.all[-1].values += len(bins)
        self.all[-1].counts.update(bins)

    def of_length(self, length: int) -> list[SamplePiece]:
        """Merge neighbours until a piece has this many values, a power of 2."""
        together = length // self.length
        made = []
        for first in range(0, len(self.all), together):
            made.append(SamplePiece())
            for piece in self.all[first : first + together]:
                made[-1] += piece
        return made

    def _halve(self) -> None:
        self.all = self.of_length(2 * self.length)
        self.length *= 2


class Samples:
    """Values from 0 on, such as times in s."""

    def __init__(self) -> None:
        self.whole = Distribution()
        self.pieces = SamplePieces()  # by bin; bins are in the order of their values

    def add(self, values: Sequence[float]) -> None:
        """Add values that came together."""
        if values:
            self.whole.add(values)
            self.pieces.add(list(map(_bin, values)))


def _bin(value: float) -> int:
    return math.floor(math.log10(value) * Distribution.PER_DECADE) if value > 0 else _ZERO
