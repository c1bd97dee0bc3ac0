# SPDX-License-Identifier: GPL-2.0-or-later
"""The clock: right intervals, no jumps, never backwards, and finally the wall clock."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sistap.tap.line.clock import Clock

pytestmark = pytest.mark.tap

SECOND = 1_000_000_000
EPOCH = 1_700_000_000 * SECOND


class Machine:
    """Two clocks that a test sets."""

    def __init__(self) -> None:
        self.monotonic = 5 * SECOND
        self.wall = EPOCH

    def clock(self) -> Clock:
        return Clock(lambda: self.monotonic, lambda: self.wall)

    def turn(self, ns: int, ppm: int = 0) -> None:
        self.monotonic += ns
        self.wall += ns + ns * ppm // 1_000_000


def test_starts_at_the_wall_clock() -> None:
    machine = Machine()
    clock = machine.clock()
    assert clock.now_ns() == EPOCH
    assert clock.wall_ns(machine.monotonic + 1234) == EPOCH + 1234


def test_follows_a_drift_that_it_is_allowed_to_follow() -> None:
    machine = Machine()
    clock = machine.clock()
    for _ in range(600):
        machine.turn(SECOND, ppm=100)
        clock.now_ns()
    # 600 s of 100 ppm are 60 ms; behind by no more than what drifts between two looks at the wall clock.
    assert abs(clock.now_ns() - machine.wall) <= 2 * 100_000


def test_catches_up_after_a_long_silence_without_overshooting() -> None:
    machine = Machine()
    clock = machine.clock()
    machine.turn(SECOND)
    machine.wall += 1_000_000
    clock.now_ns()  # sees that it is 1 ms behind
    machine.turn(3600 * SECOND)
    assert clock.now_ns() == machine.wall


def test_clock_set_by_an_hour_changes_an_interval_by_no_more_than_500_ppm() -> None:
    for hour in (3600 * SECOND, -3600 * SECOND):
        machine = Machine()
        clock = machine.clock()
        machine.wall += hour
        machine.turn(2 * SECOND)
        before = clock.now_ns()
        machine.turn(10_000_000)
        assert abs(clock.now_ns() - before - 10_000_000) == 5_000  # 500 ppm of 10 ms


def test_a_step_is_told_once_and_drift_never() -> None:
    machine = Machine()
    clock = machine.clock()
    for _ in range(30_000):  # 100 ppm of that are 3 s
        machine.turn(SECOND, ppm=100)
        assert clock.step_ns() == 0
    for hour in (3600 * SECOND, -3600 * SECOND):
        machine.wall += hour
        machine.turn(SECOND)
        assert clock.step_ns() == hour
        machine.turn(SECOND)
        assert clock.step_ns() == 0
    machine.wall += SECOND
    machine.turn(SECOND)
    assert clock.step_ns() == 0  # not more than a second


# Of seconds, and of years: as of a computer whose clock has no battery.
JUMPS = st.integers(-3 * SECOND, 3 * SECOND) | st.integers(-50, 200).map(lambda years: years * 365 * 86_400 * SECOND)


@pytest.mark.attack("the clock of this computer jumps by seconds or years", "times go on; intervals stay right")
@given(st.lists(st.tuples(st.integers(0, 5 * SECOND), JUMPS), max_size=40))
def test_never_backwards_and_intervals_within_500_ppm(steps: list[tuple[int, int]]) -> None:
    machine = Machine()
    clock = machine.clock()
    last = clock.now_ns()
    for elapsed, set_by in steps:
        machine.turn(elapsed)
        machine.wall += set_by
        now = clock.now_ns()
        assert now >= last
        assert abs(now - last - elapsed) <= elapsed * 500 // 1_000_000 + 1
        last = now


def test_a_pause_between_the_two_clock_calls_is_not_taken_for_an_offset() -> None:
    machine = Machine()
    pauses = iter([50_000_000, 0, 0, *[0] * 20])  # the process is put aside in the first try only

    def wall() -> int:
        now = machine.wall
        machine.turn(next(pauses))
        return now

    clock = Clock(lambda: machine.monotonic, wall)
    assert clock.now_ns() == machine.wall
