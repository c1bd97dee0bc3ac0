# SPDX-License-Identifier: GPL-2.0-or-later
"""The chosen clocks: the usual ones, unless they are coarse, as those of Windows before Python 3.13."""

from __future__ import annotations

import ctypes
import sys
import time
from collections.abc import Callable
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from sistap.tap.line import clock
from sistap.tap.line.settings import LineSettings

TICK_S = 0.015625


def described(coarse: str = "") -> Callable[[str], clock.Info]:
    """Describe clocks as Python does; those named in `coarse` move in ticks."""
    return lambda name: SimpleNamespace(resolution=TICK_S if name in coarse.split() else 1e-7)


def test_a_fine_monotonic_clock_is_taken() -> None:
    found = clock.steady(described())
    assert found.now_ns is time.monotonic_ns
    assert str(found) == "clock monotonic, in steps of 100 ns"


def test_the_performance_counter_stands_in_for_a_coarse_one() -> None:
    found = clock.steady(described("monotonic"))
    assert found.now_ns is time.perf_counter_ns
    assert str(found) == "clock perf_counter, in steps of 100 ns"
    assert "in steps of 15.6 ms" in str(clock.steady(described("monotonic perf_counter")))


class Kernel:
    """Of kernel32.dll the precise wall clock, at 2026-11-20 12:00:00.1234567 UTC."""

    def GetSystemTimePreciseAsFileTime(self, place: Any) -> None:
        seconds = 1_795_176_000 + 11_644_473_600
        ctypes.cast(place, ctypes.POINTER(ctypes.c_uint64))[0] = seconds * 10_000_000 + 1_234_567


def test_the_wall_clock_of_windows_is_the_precise_one() -> None:
    assert clock.wall(described(), Kernel()) is time.time_ns
    assert clock.wall(described("time"), Kernel())() == 1_795_176_000_123_456_700
    assert clock.wall(described("time"), object()) is time.time_ns  # Windows 7 has none


def test_all_of_sistap_has_one_steady_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    from sisbus.wires import wire
    from sistap.tap import windows
    from sistap.tap.capture import session
    from sistap.tap.line.reader import computer, pyserial, several

    modules: list[ModuleType] = [wire, session, computer, several, pyserial, windows]
    if sys.platform != "win32":
        from sistap.tap.line.reader import delay, device

        modules += [delay, device]
    for module in modules:
        assert module.__dict__["monotonic_ns"] is clock.monotonic_ns, module


def test_what_a_url_says_of_its_times_names_the_clock() -> None:
    from sistap.tap.line.reader.pyserial import UrlReader

    reader = UrlReader("loop://", LineSettings())
    reader.close()
    assert str(clock.STEADY) in reader.timing
