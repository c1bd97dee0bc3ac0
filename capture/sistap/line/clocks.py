# SPDX-License-Identifier: GPL-2.0-or-later
"""The clocks of this system, each as fine as the system has it. All times of a capture come from these two.

Before Python 3.13, `time.monotonic` and `time.time` of Windows move in steps of 15.6 ms.
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
