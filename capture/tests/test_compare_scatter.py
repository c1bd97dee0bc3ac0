# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether a difference may be chance: worked out by hand where possible, and by the rate of false alarms."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Iterator

import pytest

from sistap.commands.compare.samples import MOST, Samples
from sistap.commands.compare.scatter import counts_differ, middles_differ, tails_differ
from sistap.dissected.packets.distribution import Distribution


@pytest.mark.parametrize(
    ("good", "bad", "share", "differ"),
    [
        (0, 12, 0.5, False),  # 6 from the middle; 3.5 * sqrt(12 / 4) = 6.06
        (0, 13, 0.5, True),  # 6.5; 6.31
        (13, 0, 0.5, True),
        (100, 150, 0.5, False),  # 25; 27.7
        (100, 160, 0.5, True),  # 30; 28.2
        (0, 3, 0.01, False),  # fewer than four events are never certain
        (0, 4, 0.01, True),
        (99, 1, 0.01, False),
        (0, 0, 0.5, False),
        (3, 0, 0.0, False),  # of a side without time nothing is certain
    ],
)
def test_counts(good: int, bad: int, share: float, differ: bool) -> None:
    assert counts_differ(good, bad, share) is differ


def samples(values: Iterable[float]) -> Samples:
    made = Samples()
    for value in values:
        made.add([value])
    return made


def test_pieces_are_few_and_lose_nothing() -> None:
    made = samples(10.0 ** (number % 2) for number in range(1000))
    assert len(made.pieces) <= MOST
    assert sum(piece.total() for piece in made.pieces) == 1000
    assert sum(piece[Distribution.PER_DECADE] for piece in made.pieces) == 500  # the bin of 10
    assert {piece.total() for piece in made.pieces[:-1]} == {made.length}


def test_few_values_are_never_certain() -> None:
    """Seven pieces of a side are too few, however far apart; eight without any scatter are not."""
    assert not middles_differ(samples([0.01] * 7), samples([0.02] * 100))
    assert middles_differ(samples([0.01] * 8), samples([0.02] * 8))
    assert not middles_differ(samples([]), samples([0.02] * 8))
    assert not tails_differ(samples([]), samples([]))


def noise(seed: int, count: int, likeness: float = 0.9, shift: float = 1.0) -> Samples:
    """Return reaction times that each resemble the one before."""
    chance, level, made = random.Random(seed), 0.0, []
    for _ in range(count):
        level = likeness * level + chance.gauss(0, 1)
        made.append(0.01 * shift * math.exp(0.1 * level))
    return samples(made)


@pytest.mark.thorough
def test_noise_is_not_cried_about() -> None:
    """Independent pieces would make no alarm in 200; three leave room for neighbours as similar as these."""
    pairs = [(noise(2 * seed, 1500), noise(2 * seed + 1, 600)) for seed in range(200)]
    assert sum(middles_differ(*pair) for pair in pairs) <= 3
    assert sum(tails_differ(*pair) for pair in pairs) <= 3


def test_what_is_slower_is_found() -> None:
    good, bad = noise(1, 1500), noise(2, 1500, shift=1.5)
    assert middles_differ(good, bad) and middles_differ(bad, good)
    assert not middles_differ(good, good)


def test_a_slow_share_is_found_in_the_tail() -> None:
    """Every 25th reaction takes ten times as long."""
    good = noise(1, 2000, 0)
    bad = samples(time_s * (10 if number % 25 == 0 else 1) for number, time_s in enumerate(times(3, 2000)))
    assert tails_differ(good, bad)
    assert not middles_differ(good, bad)


def times(seed: int, count: int) -> Iterator[float]:
    chance = random.Random(seed)
    return (0.01 * math.exp(0.1 * chance.gauss(0, 1)) for _ in range(count))


def test_a_burst_is_one_event() -> None:
    """Sixty slow reactions: spread over time they are certain, in one second they may be chance."""
    good = samples(times(1, 3000))
    spread = samples(time_s * (10 if number % 50 == 0 else 1) for number, time_s in enumerate(times(2, 3000)))
    burst = samples(time_s * (10 if 1000 <= number < 1060 else 1) for number, time_s in enumerate(times(2, 3000)))
    assert tails_differ(good, spread)
    assert not tails_differ(good, burst)
