# SPDX-License-Identifier: GPL-2.0-or-later
"""How likely chance alone makes a difference: exact rank tests, corrected for the number of comparisons."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Hashable, Sequence
from typing import Any, NamedTuple

from sistap.commands.compare.samples import Piece, Pieces, Samples

TAIL = 0.99  # the share of all values that are not in the tail
CERTAIN = 0.01  # a difference that chance makes less often than this is certain
_FEW, _ENOUGH = 8, 16  # pieces on each side
_EXACT = 1000  # events; above this the normal distribution is as good


def of_middle(good: Samples, bad: Samples) -> float:
    """Return how likely chance makes the values of one side larger than those of the other."""
    ranks = _middle_ranks(_together(good, bad))
    return rank_test(*([_average(piece, ranks) for piece in side] for side in _alike(good.pieces, bad.pieces)))


def _alike(good: Pieces, bad: Pieces) -> list[list[Piece]]:
    """Cut both sides into pieces of equal length, no more than needed. None if a side then has too few.

    Longer pieces depend less on each other. Averages of shorter ones lie farther apart.
    """
    sides = (good, bad)
    length = max(side.length for side in sides)
    while min(len(side.all) * side.length for side in sides) > length * _ENOUGH:
        length *= 2
    made = []
    for side in sides:
        own = length
        while own > side.length and len(side.all) * side.length < own * _FEW:
            own //= 2
        made.append(side.of_length(own))
    return made


def of_tail(good: Samples, bad: Samples) -> float:
    """Return how likely chance gives one side more of the largest values, those above TAIL of all."""
    together = _together(good, bad)
    passed, wanted = 0, TAIL * together.total()
    tail = set(together)
    for number in sorted(together):
        passed += together[number]
        tail.remove(number)
        if passed >= wanted:
            break
    return of_share(good.pieces, bad.pieces, tail)


def of_share(good: Pieces, bad: Pieces, kinds: Collection[Hashable]) -> float:
    """Return how likely chance gives one side more events of these kinds, as a share of its values.

    Events in bursts count as fewer events: divided by how much more pieces differ than single events would.
    """
    sides = [
        [_Count(sum(piece.counts[kind] for kind in kinds), piece.values) for piece in side.all] for side in (good, bad)
    ]
    if not all(sides):
        return 1.0
    burst = _burst(sides)
    good_events, bad_events = (round(sum(one.events for one in side) / burst) for side in sides)
    values = [sum(one.values for one in side) for side in sides]
    return of_counts(good_events, bad_events, values[1] / sum(values))


class _Count(NamedTuple):
    """Counts of a piece."""

    events: int
    values: int


def _together(good: Samples, bad: Samples) -> Counter[Any]:
    together: Counter[Any] = Counter()
    for piece in (*good.pieces.all, *bad.pieces.all):
        together.update(piece.counts)
    return together


def _burst(sides: Sequence[Sequence[_Count]]) -> float:
    """Return how many events come together: the variance between the pieces of a side, as a multiple of Poisson's."""
    total, freedom = 0.0, 0
    for pieces in sides:
        share = sum(piece.events for piece in pieces) / sum(piece.values for piece in pieces)
        if share > 0:
            total += sum((piece.events - piece.values * share) ** 2 / (piece.values * share) for piece in pieces)
            freedom += len(pieces) - 1
    return max(total / freedom, 1.0) if freedom else 1.0


def of_counts(good: int, bad: int, share: float) -> float:
    """Return how likely chance distributes events like this, or worse; the bad side has this share of the time.

    This is the exact test of the binomial distribution, upwards or downwards.
    """
    times = good + bad
    if not times or not 0 < share < 1:
        return 1.0
    middle, deviation = times * share, math.sqrt(times * share * (1 - share))
    if times > _EXACT:
        return math.erfc(max(abs(bad - middle) - 0.5, 0.0) / deviation / math.sqrt(2))
    log, log_other = math.log(share), math.log1p(-share)
    ways = [
        math.exp(_log_choose(times, count) + count * log + (times - count) * log_other) for count in range(times + 1)
    ]
    return min(2 * min(sum(ways[: bad + 1]), sum(ways[bad:])), 1.0)


def _log_choose(times: int, count: int) -> float:
    return math.lgamma(times + 1) - math.lgamma(count + 1) - math.lgamma(times - count + 1)


def corrected(chances: Sequence[float]) -> list[float]:
    """Correct for the number of comparisons (Holm): among a hundred differences, chance makes one in a hundred."""
    order = sorted(range(len(chances)), key=chances.__getitem__)
    result = [1.0] * len(chances)
    most = 0.0
    for place, index in enumerate(order):
        most = max(most, min(chances[index] * (len(chances) - place), 1.0))
        result[index] = most
    return result


def _average(piece: Piece, ranks: dict[Any, float]) -> float:
    return math.fsum(ranks[number] * count for number, count in piece.counts.items()) / piece.values


def _middle_ranks(counts: Counter[Any]) -> dict[Any, float]:
    ranks = {}
    passed = 0
    for number in sorted(counts):
        ranks[number] = passed + (counts[number] + 1) / 2
        passed += counts[number]
    return ranks


def rank_test(good: Sequence[float], bad: Sequence[float]) -> float:
    """Return how likely chance separates the ranks this far, upwards or downwards, by counting all ways to deal them.

    This is the exact test of Wilcoxon, Mann and Whitney, also for equal values.
    """
    if not good or not bad:
        return 1.0
    values = sorted((*good, *bad))
    counts = Counter(values)
    twice: dict[float, int] = {}  # their ranks, twice: equal values may have half ranks
    passed = 0
    for value in sorted(counts):
        twice[value] = 2 * passed + counts[value] + 1
        passed += counts[value]
    few, many = sorted((good, bad), key=len)
    ways = _ways([twice[value] for value in values], len(few))
    middle = len(few) * (len(values) + 1)
    apart = abs(sum(twice[value] for value in few) - middle)
    as_far = sum(count for total, count in ways.items() if abs(total - middle) >= apart)
    return as_far / sum(ways.values())


def _ways(ranks: Sequence[int], chosen: int) -> dict[int, int]:
    """Return, for each sum, in how many ways that many ranks have it."""
    # A list of counts is one long number with a field for each sum: Python adds thousands of them at once.
    width = len(ranks) + 1  # bits: no count is above 2 ** len(ranks)
    sums = [1] + [0] * chosen
    for rank in ranks:
        for size in range(chosen, 0, -1):
            sums[size] += sums[size - 1] << (rank * width)
    mask = (1 << width) - 1
    found = {}
    data, total = sums[chosen], 0
    while data:
        if count := data & mask:
            found[total] = count
        data >>= width
        total += 1
    return found
