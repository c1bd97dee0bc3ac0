# SPDX-License-Identifier: GPL-2.0-or-later
"""The bus's time."""

from __future__ import annotations

import time

from sistap.line.clock import CLOCK
from sistap.line.clocks import monotonic_ns

_SPIN_NS = 150_000  # a sleep ends up to this late


class Pace:
    """The bus's time: its zero, and how to wait."""

    def __init__(self, simulated: bool = False, begin_ns: int | None = None) -> None:
        """Simulated time goes as fast as it is asked for; its time 0 can be `begin_ns`, in ns since 1970."""
        self.simulated = simulated
        self._begin_ns = begin_ns if simulated else None
        self.start()

    def start(self, delay_s: float = 0) -> None:
        """Let time 0 be that much later than now."""
        self._zero = monotonic_ns() + int(delay_s * 1e9)
        self._wall_zero = CLOCK.wall_ns(self._zero) if self._begin_ns is None else self._begin_ns

    def wait_until(self, time_ns: int) -> None:
        """Sleep until close to the instant, then watch the clock: a character takes only tens of microseconds."""
        if self.simulated:
            return
        instant = self._zero + time_ns
        remaining = instant - monotonic_ns()
        if remaining > _SPIN_NS:
            time.sleep((remaining - _SPIN_NS) / 1e9)
        while monotonic_ns() < instant:
            pass

    def left_s(self, time_ns: int) -> float:
        """Return the time until the instant, in s."""
        return (self._zero + time_ns - monotonic_ns()) / 1e9

    def wall_ns(self, time_ns: int = 0) -> int:
        """Return the instant in ns since 1970."""
        return self._wall_zero + time_ns
