# SPDX-License-Identifier: GPL-2.0-or-later
"""Which characters had errors: what the terminal marks and what the driver counts, taken together.

A driver counts an error before it hands the character on. So a counter can move with the read before the one that has
the mark: such a read waits, a moment, whether a mark comes.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from sistap.line.settings import Flag, Read

HOLD_NS = 20_000_000  # so long does a read wait for the mark of an error that was counted

_MARKED = re.compile(rb"[^\0]+")


class Counts(NamedTuple):
    """The error counters of a driver."""

    frame: int
    overrun: int
    parity: int
    breaks: int
    buffer_overrun: int


class Errors:
    """Settles the flags of reads. Times are those of any clock that goes on, in ns."""

    def __init__(self, count: Callable[[], Counts | None], *, by_packet: bool) -> None:
        """`count` asks the driver; `by_packet`: it marks all characters of a USB packet if one is wrong."""
        self._count = count
        self._counted = count()
        self._by_packet = by_packet
        self._breaks: int | None = None  # counted, and not yet marked; None: nobody has seen that breaks are counted
        self._held: deque[tuple[Read, bool]] = deque()  # and whether an error was counted with it
        self._due_ns = 0

    @property
    def holding(self) -> bool:
        """Whether a read waits."""
        return bool(self._held)

    def take(self, read: Read, now_ns: int) -> list[Read]:
        """Take a read with the marks of the terminal. Return the reads of which all is known, in their order."""
        moved = self._moved()
        damaged = bool(moved.frame or moved.parity or moved.breaks)
        if damaged:
            self._breaks = (self._breaks or 0) + moved.breaks
        marked = any(read.flags)
        read = read._replace(flags=self._located(read.flags))
        if moved.overrun or moved.buffer_overrun:
            read = _with_loss(read)
        if marked:  # it takes what was counted before
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
        """Return the reads that wait: what was counted with them is somewhere among their characters."""
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

        A damaged 00 is marked like a break, so a break is one only if it was counted. In a row of marked characters the
        packets cannot be told apart; the break of a packet is its last character.
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
    """Mark a loss: before one of the characters, nobody knows which."""
    if len(read.flags) > 1:
        read = _somewhere(read)
    return read._replace(flags=bytes([read.flags[0] | Flag.LOST_BEFORE]) + read.flags[1:])
