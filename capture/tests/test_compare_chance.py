# SPDX-License-Identifier: GPL-2.0-or-later
"""How likely chance makes a difference: worked out by hand where possible, and by the rate of false alarms."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator

import pytest

from sistap.commands.compare.chance import CERTAIN, corrected, of_counts, of_middle, of_share, of_tail, rank_test
from sistap.commands.compare.samples import MOST, Pieces, Samples


def test_ranks_apart() -> None:
    """3 of 6 can be chosen in 20 ways: two of them are this far apart."""
    assert rank_test([1, 2, 3], [4, 5, 6]) == rank_test([4, 5, 6], [1, 2, 3]) == 2 / 20


def test_ranks_not_as_far_apart() -> None:
    """Of the ranks 1 to 4 the sums of two are 3, 4, 5, 5, 6, 7: 4 and 6 are 1 from the middle, 3 and 7 are 2."""
    assert rank_test([1, 3], [2, 4]) == 4 / 6
    assert rank_test([1, 2], [3, 4]) == 2 / 6


def test_equal_values_share_their_rank() -> None:
    """Ranks 1.5, 1.5, 3: of one value alone 3 is farthest from the middle, 2, by 1; the others by 0.5."""
    assert rank_test([7, 7], [9]) == 1 / 3
    assert rank_test([7, 7], [7]) == 1.0
    assert rank_test([], [7]) == 1.0


def test_counts() -> None:
    assert of_counts(0, 5, 0.5) == pytest.approx(2 / 2**5)
    assert of_counts(5, 0, 0.5) == pytest.approx(2 / 2**5)
    assert of_counts(0, 2, 0.25) == pytest.approx(2 / 16)
    assert of_counts(1, 1, 0.5) == of_counts(0, 0, 0.5) == of_counts(3, 0, 0.0) == 1.0


def test_many_counts() -> None:
    """Where the method of counting changes, the chance does not jump."""
    few, more = of_counts(450, 549, 0.5), of_counts(451, 550, 0.5)
    assert few == pytest.approx(more, rel=0.05)


def test_correction_by_hand() -> None:
    """The smallest of 3 counts threefold, the next twice; none is less than one before it."""
    assert corrected([0.04, 0.01, 0.03]) == pytest.approx([0.06, 0.03, 0.06])
    assert corrected([0.5, 0.9]) == [1.0, 1.0]
    assert corrected([]) == []


def test_pieces_are_few_and_lose_nothing() -> None:
    pieces = Pieces()
    for number in range(1000):
        pieces.add(["odd"] if number % 2 else [], 1)
    assert len(pieces.all) <= MOST
    assert sum(piece.values for piece in pieces.all) == 1000
    assert sum(piece.counts["odd"] for piece in pieces.all) == 500
    assert {piece.values for piece in pieces.all[:-1]} == {pieces.length}


def noise(seed: int, count: int, likeness: float = 0.9, shift: float = 1.0) -> Samples:
    """Return reaction times that each resemble the one before."""
    chance, samples, level = random.Random(seed), Samples(), 0.0
    for _ in range(count):
        level = likeness * level + chance.gauss(0, 1)
        samples.add([0.01 * shift * math.exp(0.1 * level)])
    return samples


@pytest.mark.thorough
def test_noise_is_not_cried_about() -> None:
    """1 in 100 is allowed; 5 in 200 leave room for chance, and for neighbours as similar as these."""
    pairs = [(noise(2 * seed, 1500), noise(2 * seed + 1, 600)) for seed in range(200)]
    assert sum(of_middle(*pair) < CERTAIN for pair in pairs) <= 8
    assert sum(of_tail(*pair) < CERTAIN for pair in pairs) <= 8


def test_what_is_slower_is_found() -> None:
    good, bad = noise(1, 1500), noise(2, 1500, shift=1.5)
    assert of_middle(good, bad) < 0.001
    assert of_middle(good, good) == 1.0


def test_a_slow_share_is_found_in_the_tail() -> None:
    """Every 25th reaction takes ten times as long."""
    good, bad = noise(1, 2000, 0), Samples()
    for number, time_s in enumerate(times(3, 2000)):
        bad.add([time_s * (10 if number % 25 == 0 else 1)])
    assert of_tail(good, bad) < 0.001
    assert of_middle(good, bad) > CERTAIN


def times(seed: int, count: int) -> Iterator[float]:
    chance = random.Random(seed)
    return (0.01 * math.exp(0.1 * chance.gauss(0, 1)) for _ in range(count))


def test_a_burst_is_one_event() -> None:
    """Thirty faults: spread over time they are certain, in one second they may be chance."""
    good, spread, burst = Pieces(), Pieces(), Pieces()
    for number in range(3000):
        good.add([], 1)
        spread.add(["fault"] if number % 100 == 0 else [], 1)
        burst.add(["fault"] if 1000 <= number < 1030 else [], 1)
    assert of_share(good, spread, ["fault"]) < 0.001
    assert of_share(good, burst, ["fault"]) > 0.1
