# SPDX-License-Identifier: GPL-2.0-or-later
"""What every wire has to do with: the bus's time, the log, and the wire itself."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import BinaryIO, Protocol

from sisbus.playing.characters import Played
from sistap.tap.line.clock import CLOCK, monotonic_ns

_SPIN_S = 150e-6  # a sleep ends up to this late


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
        if (left_s := self.left_s(time_ns)) > _SPIN_S:
            time.sleep(left_s - _SPIN_S)
        while self.left_s(time_ns) > 0:
            pass

    def now_ns(self) -> int:
        """Return the time, if it is not simulated."""
        return monotonic_ns() - self._zero

    def left_s(self, time_ns: int) -> float:
        """Return the time until the instant, in s; negative if it is past."""
        return (time_ns - self.now_ns()) / 1e9

    def wall_ns(self, time_ns: int = 0) -> int:
        """Return the instant in ns since 1970."""
        return self._wall_zero + time_ns


class Log:
    """One line for each telegram: seconds since the start, the bytes as sent, marks. The first line is a comment."""

    def __init__(self, file: BinaryIO) -> None:
        """Write to this file."""
        self._file = file

    def begin(self, text: str) -> None:
        """Write the comment."""
        self._write(f"# {text}")

    def add(self, played: Played, marks: Iterable[str]) -> None:
        """Write a line for what was sent."""
        time_text = f"{played.time_ns // 1_000_000_000}.{played.time_ns % 1_000_000_000:09d}"
        self._write(" ".join([time_text, played.sent.hex().upper(), *played.marks, *marks]))

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _write(self, line: str) -> None:
        self._file.write(f"{line}\n".encode())
        self._file.flush()  # readers see whole lines at once


class Wire(Protocol):
    """A way to listeners."""

    name: str  # address for a listener

    def wait_for_listener(self) -> None:
        """Return when somebody listens; the bus then starts."""

    def deliver(self, played: Played) -> list[str]:
        """Deliver all characters at their times; return marks for lost ones."""

    @property
    def deserted(self) -> bool:
        """Tell whether nobody listens, so that the bus can stop."""

    def close(self) -> None:
        """Deliver everything to all listeners, then disconnect them."""
