# SPDX-License-Identifier: GPL-2.0-or-later
"""Summaries of many values are bounded, and as exact as they claim."""

import math

from hypothesis import given
from hypothesis import strategies as st

from sistap.dissected.packets.distribution import Distribution, Slices

TIMES = st.integers(0, 10**14).map(lambda ns: ns / 1e9)
BIN = 10 ** (1 / Distribution.PER_DECADE)


def with_share(times: list[float], share: float) -> tuple[float, float]:
    """Return what a Distribution says that the share lies within, and the exact time."""
    distribution, longest_s = Distribution(), max(times)
    for time in times:
        distribution.add([time])
        assert distribution.longest_s <= longest_s  # reading it on the way changes nothing
    return distribution.within_s(share), sorted(times)[math.ceil(share * len(times) - 1e-9) - 1]


@given(st.lists(TIMES, min_size=1), st.floats(0.01, 1.0))
def test_a_share_of_few_times_is_exact(times: list[float], share: float) -> None:
    within_s, least_s = with_share(times, share)
    assert within_s == least_s


@given(st.lists(TIMES, min_size=1, max_size=20), st.floats(0.01, 1.0))
def test_a_share_of_many_times_is_as_exact_as_a_bin(times: list[float], share: float) -> None:
    times *= Distribution.FEW // len(times) + 1
    within_s, least_s = with_share(times, share)
    assert within_s in times
    assert least_s <= within_s <= least_s * BIN * (1 + 1e-9)


def test_of_many_times_the_later_ones_count_too() -> None:
    distribution = Distribution()
    distribution.add([0.001] * Distribution.FEW)
    distribution.add([0.005] * 3 * Distribution.FEW + [0.02])
    assert [distribution.within_s(share) for share in (0.2, 0.5, 1.0)] == [0.001, 0.005, 0.02]


def test_of_several_parts_together_all_count() -> None:
    few, many = Distribution(), Distribution()
    few.add([0.005])
    many.add([0.001] * 2 * Distribution.FEW)
    both = Distribution.union([few, many])
    assert (both.within_s(0.5), both.within_s(1.0)) == (0.001, 0.005)


def test_times_that_are_nearly_equal_are_told_apart_if_they_are_few() -> None:
    """1 and 1.01 ms are in one bin."""
    parts = Distribution(), Distribution()
    for part, time_s in zip(parts, (0.00101, 0.001), strict=True):
        part.add([time_s])
        part.add([time_s])
    assert Distribution.union(parts).within_s(0.5) == 0.001
    parts[0].add([0.001] * 2)
    assert parts[0].within_s(0.5) == 0.001


def test_of_many_times_the_zeros_count_too() -> None:
    """Of one read, all but one interval are 0."""
    distribution = Distribution()
    distribution.add([0.0] * 2 * Distribution.FEW + [0.001] * 2 * Distribution.FEW)
    assert (distribution.within_s(0.5), distribution.within_s(0.9)) == (0.0, 0.001)


@given(st.lists(st.lists(TIMES)))
def test_count_sum_and_extremes_are_exact(parts: list[list[float]]) -> None:
    distribution = Distribution()
    for part in parts:
        distribution.add(part)
    times = [time for part in parts for time in part]
    assert distribution.count == len(times)
    assert math.isclose(distribution.average_s * len(times), math.fsum(times), rel_tol=1e-12)
    if times:
        assert (distribution.shortest_s, distribution.longest_s) == (min(times), max(times))
    assert distribution.zeros + sum(found.count for found in distribution.bins.values()) == len(times)


def test_bins_are_bounded() -> None:
    distribution = Distribution()
    distribution.add([1e-9 * 1.001**number for number in range(30_000)])  # 13 decades
    assert not distribution._waiting
    assert len(distribution.bins) <= 13.1 * Distribution.PER_DECADE


@given(st.lists(st.floats(0, 1e6), min_size=1))
def test_nothing_is_lost_when_slices_are_joined(times: list[float]) -> None:
    slices = Slices()
    for time in times:
        at = slices.at([time])
        slices.count("x", at)
        slices.add_load(at[0], time % 100)
    assert sum(slices.counts["x"]) == len(times)
    assert len(slices.counts["x"]) == len(slices.loads) == Slices.COUNT
    assert max(load for load in slices.loads if load is not None) == max(time % 100 for time in times)
    # Each count is still where its time is.
    assert all(slices.counts["x"][at] > 0 for at in slices.at(times))
    assert slices.used * slices.width_s >= max(times)


def test_a_load_is_the_most_in_its_slice() -> None:
    slices = Slices()
    slices.add_load(slices.at([0.0])[0], 40.0)
    slices.add_load(slices.at([0.0])[0], 10.0)
    assert slices.loads[:2] == [40.0, None]
    slices.add_load(slices.at([10.0])[0], 20.0)
    assert [load for load in slices.loads if load is not None] == [40.0, 20.0]
    both = Slices()
    for time, load in ((0.0, 10.0), (0.001, 40.0), (1.0, 5.0)):  # then the first two are in one slice
        both.add_load(both.at([time])[0], load)
    assert [load for load in both.loads if load is not None] == [40.0, 5.0]
