# SPDX-License-Identifier: GPL-2.0-or-later
"""Brings what is played to listeners, at its time."""

from __future__ import annotations

import time
from collections.abc import Iterable
from pathlib import Path
from typing import Protocol

from sistap.bus.playing import Played
from sistap.clock import CLOCK

_SPIN_NS = 150_000  # a sleep ends up to about this much late


class Pace:
    """The bus's time: when its time 0 was, and how to wait for what comes later."""

    def __init__(self, simulated: bool = False) -> None:
        """Simulated time goes as fast as it is asked for."""
        self.simulated = simulated
        self.start()

    def start(self, delay_s: float = 0) -> None:
        """Let time 0 be so much later than now."""
        self._zero = time.monotonic_ns() + int(delay_s * 1e9)
        self._wall_zero = CLOCK.wall_ns(self._zero)

    def wait_until(self, time_ns: int) -> None:
        """Sleep until close to the instant, then watch the clock: some tens of microseconds are a character."""
        if self.simulated:
            return
        instant = self._zero + time_ns
        remaining = instant - time.monotonic_ns()
        if remaining > _SPIN_NS:
            time.sleep((remaining - _SPIN_NS) / 1e9)
        while time.monotonic_ns() < instant:
            pass

    def wall_ns(self, time_ns: int = 0) -> int:
        """Give the instant in ns since 1970."""
        return self._wall_zero + time_ns


class Wire(Protocol):
    """A way to listeners."""

    name: str  # what a listener opens

    def wait_for_listener(self) -> None:
        """Come back when somebody listens; the bus then starts."""

    def deliver(self, played: Played) -> list[str]:
        """Deliver all characters at their times; gives marks for what did not get through."""

    @property
    def deserted(self) -> bool:
        """Whether nobody listens and it makes no sense to go on."""

    def close(self) -> None:
        """Let all listeners have what was delivered, then leave them."""


class Log:
    """One line for each telegram: seconds since the start, the bytes as sent, marks; the first line is a comment."""

    def __init__(self, path: Path) -> None:
        """Open the file. May raise OSError."""
        self._file = path.open("wb", buffering=0)  # whoever reads along sees whole lines

    def begin(self, text: str) -> None:
        """Write the comment."""
        self._write(f"# {text}")

    def add(self, played: Played, marks: Iterable[str]) -> None:
        """Write what was sent."""
        time_text = f"{played.time_ns // 1_000_000_000}.{played.time_ns % 1_000_000_000:09d}"
        self._write(" ".join([time_text, played.sent.hex().upper(), *played.marks, *marks]))

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _write(self, line: str) -> None:
        self._file.write(f"{line}\n".encode())


def serve(wire: Wire, telegrams: Iterable[Played], log: Log | None) -> None:
    """Deliver everything to a wire whose bus has started. May raise OSError."""
    for played in telegrams:
        marks = wire.deliver(played)
        if log:
            log.add(played, marks)
        if wire.deserted:
            break
