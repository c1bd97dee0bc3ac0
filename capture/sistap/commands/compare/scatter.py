# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether two sides differ by more than each side does by itself. What differs by less may be chance.

It is a rule of thumb: a difference counts if it is FAR times as large as its scatter. Of a thousand comparisons of
equal captures, it finds a few.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from statistics import fmean, variance

from sistap.commands.compare.samples import Piece, Samples

TAIL = 0.99  # the share of all values that are not in the tail
FAR = 3.5  # standard deviations of a difference
_FEW, _ENOUGH = 8, 16  # pieces of a side: with fewer nothing is sure, and longer ones depend less on each other


def counts_differ(good: int, bad: int, share: float) -> bool:
    """Tell whether events are surely more frequent on one side; the bad side has this share of the time."""
    times = good + bad
    deviation = math.sqrt(times * share * (1 - share))
    return abs(bad - times * share) > FAR * max(deviation, 1)


def middles_differ(good: Samples, bad: Samples) -> bool:
    """Tell whether the values of one side are surely larger: by the medians of its pieces."""
    return _differ(*([_within(piece, 0.5) for piece in _pieces(side)] for side in (good, bad)))


def tails_differ(good: Samples, bad: Samples) -> bool:
    """Tell whether one side surely has more of the largest values, those above TAIL of all: by the share in pieces."""
    sides = [_pieces(side) for side in (good, bad)]
    if not all(sides):
        return False
    limit = _within(sum((piece for side in sides for piece in side), Counter()), TAIL)
    return _differ(*([_share_above(limit, piece) for piece in side] for side in sides))


def _pieces(side: Samples) -> Sequence[Piece]:
    length = side.length
    while len(side.pieces) * side.length >= 2 * length * _ENOUGH:
        length *= 2
    return side.of_length(length)


def _within(counts: Piece, share: float) -> int:
    """Return the bin that this share of all values does not exceed."""
    left = share * counts.total()
    for place in sorted(counts):
        left -= counts[place]
        if left <= 0:
            break
    return place


def _share_above(limit: int, piece: Piece) -> float:
    return sum(count for place, count in piece.items() if place > limit) / piece.total()


def _differ(good: Sequence[float], bad: Sequence[float]) -> bool:
    """Tell whether the averages are farther apart than the scatter of the pieces explains: bursts are in that."""
    if min(len(good), len(bad)) < _FEW:
        return False
    scatter = math.sqrt(variance(good) / len(good) + variance(bad) / len(bad))
    return abs(fmean(bad) - fmean(good)) > FAR * scatter
