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

Piece = Counter[int]  # consecutive values: how often each bin came; bins are in the order of their values


class Samples:
    """Values from 0 on, such as times in s; in pieces of equal length, except the last."""

    def __init__(self) -> None:
        self.whole = Distribution()
        self.pieces: list[Piece] = []
        self.length = 1  # values in a piece

    def add(self, values: Sequence[float]) -> None:
        """Add values that came together: they belong to one piece."""
        if not values:
            return
        self.whole.add(values)
        if not self.pieces or self.pieces[-1].total() >= self.length:
            if len(self.pieces) == MOST:
                self.pieces = self.of_length(2 * self.length)
                self.length *= 2
            self.pieces.append(Counter())
        self.pieces[-1].update(map(_bin, values))

    def of_length(self, length: int) -> list[Piece]:
        """Merge neighbours until a piece has this many values, a power of 2."""
        together = length // self.length
        return [sum(self.pieces[at : at + together], Counter()) for at in range(0, len(self.pieces), together)]


def _bin(value: float) -> int:
    return math.floor(math.log10(value) * Distribution.PER_DECADE) if value > 0 else _ZERO
