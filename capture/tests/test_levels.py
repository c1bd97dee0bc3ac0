# SPDX-License-Identifier: GPL-2.0-or-later
"""The values of a parameter as levels: where one begins, which are unusual, what drifts."""

from __future__ import annotations

import itertools
import random
from collections.abc import Sequence

import pytest

from sistap.dissected.episodes.levels import Levels
from sistap.dissected.episodes.rules import Severity
from sistap.dissected.episodes.trend import trend


def levels(values: Sequence[float]) -> Levels:
    made = Levels()
    for number, value in enumerate(values):
        made.add(10.0 * number, value, number)
    return made


def scattered(seed: int, count: int, middle: float) -> list[float]:
    numbers = random.Random(seed)
    return [numbers.gauss(middle, 1.5) for _ in range(count)]


def test_a_step_begins_with_its_first_value() -> None:
    made = levels([*scattered(1, 500, 1000), *scattered(2, 30, 700), *scattered(3, 900, 1000)])
    ((level, severity),) = made.unusual()
    assert (level.from_s, level.to_s, level.packet, severity) == (5000, 5290, 500, Severity.WARNING)
    assert level.value == pytest.approx(700, abs=3)


def test_a_drive_that_stood_still_is_followed_as_before() -> None:
    parts = [
        scattered(1, 800, 1000),
        [0.0] * 400,
        scattered(2, 800, 1000),
        scattered(3, 30, 800),
        scattered(4, 800, 1000),
    ]
    found = [(level.from_s, round(level.value, -1)) for level, _ in levels(list(itertools.chain(*parts))).unusual()]
    assert found == [(8000, 0), (20_000, 800)]


@pytest.mark.parametrize("seed", range(10))
def test_scatter_and_values_that_go_back_and_forth_are_no_step(seed: int) -> None:
    numbers = random.Random(seed)
    recipe = [
        value
        for _ in range(40)
        for value in scattered(numbers.randrange(1 << 30), 30, numbers.choice([950, 1000, 1100]))
    ]
    for values in (scattered(seed, 3000, 1000), recipe, [numbers.uniform(0, 360) for _ in range(3000)]):
        made = levels(values)
        assert list(made.unusual()) == []
        assert made.drift() is None


@pytest.mark.parametrize("seed", range(10))
def test_a_position_that_moves_in_some_recipes_and_rests_in_others_has_no_step(seed: int) -> None:
    """Where a turn takes as long as a read, it seems to rest, anywhere."""
    numbers = random.Random(seed)
    values: list[float] = []
    for is_moving in (False, True, False, True, True, False, True, False):
        begin = numbers.uniform(0, 360)
        values += [(begin + 120 * number * is_moving) % 360 for number in range(68)]
    assert list(levels(values).unusual()) == []


def test_a_drift_has_its_slope_and_a_chance() -> None:
    made = levels([value + 0.1 * number for number, value in enumerate(scattered(1, 2000, 100))])
    assert list(made.unusual()) == []
    assert (drift := made.drift())
    assert drift[1].slope == pytest.approx(0.01, rel=0.02)
    assert drift[1].chance < 1e-6
    assert trend([(number, (-1) ** number) for number in range(20)]).chance > 0.5


def test_what_drifts_has_no_step_where_a_drive_only_stood_still() -> None:
    values = [value + 0.05 * number for number, value in enumerate(scattered(1, 1500, 30))]
    made = levels([*values[:400], *[0.0] * 30, *values[430:]])
    assert [(level.from_s, level.value) for level, _ in made.unusual()] == [(4000, 0.0)]
    assert made.drift()


def test_a_level_that_a_good_time_does_not_have() -> None:
    """A drive at 60 % of its speed all night has no step in that night."""
    good, same, slow = (levels(scattered(*how)) for how in ((1, 200, 1000), (2, 300, 1000), (3, 200, 600)))
    assert not [*slow.unusual(), *same.unlike(good)]
    (level,) = slow.unlike(good)
    assert level.from_s == 0.0
    assert level.value == pytest.approx(600, abs=3)
