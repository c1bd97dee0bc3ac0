# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds the characters with errors, from the marks of the terminal and the counters of the driver.

A driver counts an error before it passes the character on. So the counter can change one read before the mark comes.
Such a read waits a moment for a mark.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from sistap.line.settings import Flag, Read

HOLD_NS = 20_000_000  # how long a read waits for the mark of a counted error

_MARKED = re.compile(rb"[^\0]+")


class Counts(NamedTuple):
    """The error counters of a driver."""

    frame: int
    overrun: int
    parity: int
    breaks: int
    buffer_overrun: int


class Errors:
    """Settles the flags of reads. Times are from any monotonic clock, in ns."""

    def __init__(self, count: Callable[[], Counts | None], *, by_packet: bool) -> None:
        """`count` reads the driver's counters; `by_packet`: the driver marks all characters of a USB packet with an
        error.
        """
        self._count = count
        self._counted = count()
        self._by_packet = by_packet
        self._breaks: int | None = None  # counted but not marked yet; None: nobody knows whether breaks are counted
        self._held: deque[tuple[Read, bool]] = deque()  # and whether an error was counted with it
        self._due_ns = 0

    @property
    def holding(self) -> bool:
        """Tell whether a read waits."""
        return bool(self._held)

    def take(self, read: Read, now_ns: int) -> list[Read]:
        """Take a read with the marks of the terminal. Return the reads whose errors are settled, in order."""
        moved = self._moved()
        damaged = bool(moved.frame or moved.parity or moved.breaks)
        if damaged:
            self._breaks = (self._breaks or 0) + moved.breaks
        marked = any(read.flags)
        read = read._replace(flags=self._located(read.flags))
        if moved.overrun or moved.buffer_overrun:
            read = _with_loss(read)
        if marked:  # it uses up what was counted before
            settled = [held for held, _ in self._held]
            self._held.clear()
            return [*settled, read]
        if not damaged and not self._held:
            return [read]
        if not self._held:
            self._due_ns = now_ns + HOLD_NS
        self._held.append((read, damaged))
        return self.due(now_ns)

    def due(self, now_ns: int) -> list[Read]:
        """Return the reads that have waited long enough."""
        return self.all() if self._held and now_ns >= self._due_ns else []

    def all(self) -> list[Read]:
        """Return all waiting reads: what was counted with them is somewhere among their characters."""
        settled = [_somewhere(read) if damaged else read for read, damaged in self._held]
        self._held.clear()
        return settled

    def _moved(self) -> Counts:
        before, now = self._counted, self._count()
        if before is None or now is None or now == before:
            return Counts(0, 0, 0, 0, 0)
        self._counted = now
        return Counts(*(new - old for new, old in zip(now, before, strict=True)))

    def _located(self, marks: bytes) -> bytes:
        """Return flags that claim no more than is known.

        A damaged 00 is marked like a break, so only a counted break is one. In a run of marked characters the packets
        cannot be told apart. The break of a packet is its last character.
        """
        if not any(marks):
            return marks
        flags = bytearray(marks)
        rows = [match.span() for match in _MARKED.finditer(marks)]
        zeros = {place for place, mark in enumerate(marks) if mark == Flag.BREAK}
        possible = zeros & {end - 1 for _, end in rows} if self._by_packet else zeros
        breaks = possible if self._breaks is None or self._breaks >= len(possible) else set[int]()
        if self._breaks is not None:
            self._breaks = max(self._breaks - len(zeros), 0)
        for start, end in rows:
            unsure = self._by_packet and end - start > 1
            for place in set(range(start, end)) - breaks:
                flags[place] = Flag.UNLOCATED_ERROR if unsure else Flag.CHARACTER_ERROR
        return bytes(flags)


def _somewhere(read: Read) -> Read:
    return read._replace(flags=bytes(flag | Flag.UNLOCATED_ERROR for flag in read.flags))


def _with_loss(read: Read) -> Read:
    """Mark a loss: it is before one of the characters, but nobody knows which."""
    if len(read.flags) > 1:
        read = _somewhere(read)
    return read._replace(flags=bytes([read.flags[0] | Flag.LOST_BEFORE]) + read.flags[1:])
