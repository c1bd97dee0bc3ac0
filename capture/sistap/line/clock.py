# SPDX-License-Identifier: GPL-2.0-or-later
"""Wall time from the monotonic clock: intervals stay right, and time neither jumps nor goes backwards.

The offset between the two clocks is taken once. When they drift apart, the result is slewed towards the wall clock, by
at most SLEW_PPM of an interval. So setting the wall clock changes no interval.
"""

from __future__ import annotations

from collections.abc import Callable

from sistap.line import clocks

SLEW_PPM = 500  # what adjtime(3) allows itself
CHECK_NS = 1_000_000_000  # how often the wall clock is read
STEP_NS = 1_000_000_000  # a clock that moves by more than this between two looks was set


class Clock:
    """Maps instants of the monotonic clock (ns) to ns since 1970."""

    def __init__(
        self, monotonic_ns: Callable[[], int] = clocks.monotonic_ns, wall_ns: Callable[[], int] = clocks.wall_ns
    ) -> None:
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
        most = max(0, elapsed) * SLEW_PPM // 1_000_000
        return min(self._behind, most) if self._behind > 0 else max(self._behind, -most)

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
