# SPDX-License-Identifier: GPL-2.0-or-later
"""The clocks of this system, each as fine as the system has it. All times of a capture come from these two.

Before Python 3.13, `time.monotonic` and `time.time` of Windows move in steps of 15.6 ms.

`Clock` makes wall time from the monotonic clock: intervals stay right, and time neither jumps nor goes backwards. The
offset between the two clocks is taken once. When they drift apart, the result is slewed towards the wall clock, by at
most SLEW_PPM of an interval. So setting the wall clock changes no interval.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

COARSE_S = 0.001  # a clock with larger steps is used only if there is no other

_1601_NS = 11_644_473_600 * 1_000_000_000  # the epoch of Windows, before 1970
_STEP_NS = 100  # the unit of Windows


class Info(Protocol):
    """What Python knows about a clock."""

    resolution: float


class Steady(NamedTuple):
    """A clock that cannot be set."""

    now_ns: Callable[[], int]
    name: str
    step_s: float

    def __str__(self) -> str:
        step = f"{self.step_s * 1e3:.1f} ms" if self.step_s >= COARSE_S else f"{self.step_s * 1e9:.0f} ns"
        return f"clock {self.name}, in steps of {step}"


def steady(info: Callable[[Any], Info] = time.get_clock_info) -> Steady:
    """Return the monotonic clock, or the performance counter if the monotonic clock is coarse."""
    step_s = info("monotonic").resolution
    if step_s < COARSE_S:
        return Steady(time.monotonic_ns, "monotonic", step_s)
    return Steady(time.perf_counter_ns, "perf_counter", info("perf_counter").resolution)


def wall(info: Callable[[Any], Info] = time.get_clock_info, kernel: Any = None) -> Callable[[], int]:
    """Return the wall clock (ns since 1970), or the precise one of Windows if that is coarse.

    `kernel` is kernel32.dll.
    """
    if info("time").resolution < COARSE_S:
        return time.time_ns
    kernel = kernel or _kernel()
    return _precise(kernel) if hasattr(kernel, "GetSystemTimePreciseAsFileTime") else time.time_ns


def _kernel() -> Any:
    if sys.platform == "win32":
        import ctypes

        return ctypes.windll.kernel32
    return None


def _precise(kernel: Any) -> Callable[[], int]:
    import ctypes

    time_of_file = ctypes.c_uint64()  # two halves of 32 bits, the lower one first

    def now_ns() -> int:
        kernel.GetSystemTimePreciseAsFileTime(ctypes.byref(time_of_file))
        return time_of_file.value * _STEP_NS - _1601_NS

    return now_ns


STEADY = steady()
monotonic_ns = STEADY.now_ns
wall_ns = wall()


SLEW_PPM = 500  # what adjtime(3) allows itself
CHECK_NS = 1_000_000_000  # how often the wall clock is read
STEP_NS = 1_000_000_000  # a clock that moves by more than this between two looks was set


class Clock:
    """Maps instants of the monotonic clock (ns) to ns since 1970."""

    def __init__(self, monotonic_ns: Callable[[], int] = monotonic_ns, wall_ns: Callable[[], int] = wall_ns) -> None:
        self._monotonic_ns = monotonic_ns
        self._wall_ns = wall_ns
        self._from = monotonic_ns()
        self._offset = self._measured_offset()
        self._behind = 0  # the wall clock's lag at the last look; negative: ahead
        self._looked_at = self._offset  # offset between the two clocks when a step was last asked for

    def wall_ns(self, monotonic_ns: int) -> int:
        """Return the wall time of an instant; later instants never get earlier times."""
        elapsed = monotonic_ns - self._from
        if elapsed >= CHECK_NS:
            self._check(monotonic_ns)
            elapsed = 0
        return monotonic_ns + self._offset + self._slewed(elapsed)

    def now_ns(self) -> int:
        """Return the wall time of this moment."""
        return self.wall_ns(self._monotonic_ns())

    def step_ns(self) -> int:
        """Return by how much the wall clock was set since the last call, in ns; 0 if not more than STEP_NS.

        Call it every few seconds, because drift in between counts, too. The monotonic clock stops while the computer
        sleeps, which counts as a step.
        """
        self.now_ns()
        before, self._looked_at = self._looked_at, self._offset + self._behind
        step = self._looked_at - before
        return step if abs(step) > STEP_NS else 0

    def _slewed(self, elapsed: int) -> int:
        """Return how far the offset has moved since the last look, of what it was behind."""
        behind, most = self._behind, elapsed * SLEW_PPM // 1_000_000 if elapsed > 0 else 0
        if -most <= behind <= most:
            return behind
        return most if behind > 0 else -most

    def _check(self, monotonic_ns: int) -> None:
        self._offset += self._slewed(monotonic_ns - self._from)
        self._from = monotonic_ns
        self._behind = self._measured_offset() - self._offset

    def _measured_offset(self) -> int:
        """Return wall minus monotonic time, from the quickest of three tries: a pause between the two calls is an
        error.
        """
        tries = []
        for _ in range(3):
            before = self._monotonic_ns()
            wall = self._wall_ns()
            after = self._monotonic_ns()
            tries.append((after - before, wall - (before + after) // 2))
        return min(tries)[1]


CLOCK = Clock()  # one for the whole process, so that the times of two lines can be compared
