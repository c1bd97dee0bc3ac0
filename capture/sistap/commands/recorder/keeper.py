# SPDX-License-Identifier: GPL-2.0-or-later
"""Decides which records go into which file: those around each record that matters, each of them once."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection
from typing import NamedTuple, Protocol

from sistap.dissected.explain.relay import Entry
from sistap.tap.records.before import Before
from sistap.tap.records.record import Record

LARGEST = 100_000_000  # bytes of a file; if records keep mattering, the next file follows
MOST_HISTORY = 128_000_000  # bytes of waiting records; above this, the oldest go
_STEP_NS = 10_000_000_000  # a clock that jumps back this far was set
_LATE_NS = 60_000_000_000  # a step of a value is known so much later, and what came before it is needed, too


class Around(NamedTuple):
    """How much is kept before and after."""

    before_ns: int
    after_ns: int


class File(Protocol):
    """A file that is being written."""

    def write(self, block: bytes) -> None:
        """Write a block."""

    def close(self, reasons: Collection[str]) -> None:
        """Say that it is complete, and all reasons in it, in their order."""


class Beginning(NamedTuple):
    """What a file begins with."""

    heading: bytes  # section and interfaces
    known: list[Record]  # from before: limits, and telegrams that told names, units
    first_ns: int  # time of its first record
    time_ns: int  # of the reason
    reason: str


Begin = Callable[[Beginning], File]


class Keeper:
    """Takes blocks in order, each with the reason why it matters, if any."""

    def __init__(self, around: Around, begin: Begin, heading: bytes, say: Callable[[str], None]) -> None:
        """Begin files with `begin`; `heading` is the section and the interfaces of all of them."""
        self._around = around
        self._begin = begin
        self._heading = heading
        self._known = Before()  # from what came before the file
        self._say = say
        self._waiting: deque[Entry] = deque()  # they may precede a record that matters
        self._waiting_bytes = 0
        self._file: File | None = None
        self._size = 0  # of the file
        self._reason = ""  # the last one
        self._reasons: dict[str, None] = {}  # all of the file
        self._end_ns = 0  # end of the file's time
        self._now_ns = 0
        self._shortened = False

    def take(self, entry: Entry, reason: str = "", from_ns: int | None = None) -> None:
        """Take the next block, and the reason that began with it or at `from_ns`."""
        if entry.time_ns < self._now_ns - _STEP_NS:
            self._break()
        now_ns = max(entry.time_ns, self._now_ns)
        if reason:
            self._keep(entry.time_ns, reason, entry.time_ns if from_ns is None else from_ns)
        self.look(now_ns)
        while self._waiting and self._waiting[0].time_ns < now_ns - self._around.before_ns - _LATE_NS:
            self._forget()
        if self._file and entry.time_ns <= self._end_ns:
            self._write(entry)
        else:
            self._waiting.append(entry)
            self._waiting_bytes += len(entry.block)
            self._bound()

    def keep(self, now_ns: int, reason: str, from_ns: int) -> None:
        """Keep what is around a reason, though no block comes."""
        if self._file or self._waiting:
            self._keep(now_ns, reason, from_ns)

    def look(self, now_ns: int) -> None:
        """End the file if nothing that matters now could belong to it."""
        self._now_ns = now_ns
        self._close_before(now_ns - self._around.before_ns)

    def _close_before(self, time_ns: int) -> None:
        if self._file and time_ns > self._end_ns:
            self._close()

    def end(self) -> None:
        """End the file."""
        if self._file:
            self._close()

    def _keep(self, now_ns: int, reason: str, from_ns: int) -> None:
        since_ns = min(from_ns, now_ns) - self._around.before_ns
        self._close_before(since_ns)
        while not self._file and self._waiting and self._waiting[0].time_ns < since_ns:
            self._forget()
        self._reason = reason
        if not self._file:
            first_ns = self._waiting[0].time_ns if self._waiting else now_ns
            self._open(first_ns, from_ns)
        self._reasons[reason] = None
        self._end_ns = max(self._end_ns, now_ns + self._around.after_ns)
        while self._waiting:  # each is either within `before`, or belongs to the file of the reason before
            self._waiting_bytes -= len(self._waiting[0].block)
            self._write(self._waiting.popleft())

    def _write(self, entry: Entry) -> None:
        assert self._file
        if self._size > LARGEST:
            self._file.close(self._reasons)
            self._open(entry.time_ns, entry.time_ns)
        self._pass(entry)
        self._file.write(entry.block)
        self._size += len(entry.block)

    def _open(self, first_ns: int, time_ns: int) -> None:
        known = list(self._known.records(first_ns))
        self._file = self._begin(Beginning(self._heading, known, first_ns, time_ns, self._reason))
        self._size = 0
        self._reasons = {self._reason: None}

    def _close(self) -> None:
        assert self._file
        self._file.close(self._reasons)
        self._file = None
        self._end_ns = 0

    def _forget(self) -> None:
        oldest = self._waiting.popleft()
        self._waiting_bytes -= len(oldest.block)
        self._pass(oldest)

    def _pass(self, entry: Entry) -> None:
        """Learn from what no later file has."""
        if not entry.is_packet:
            self._heading += entry.block
        if entry.heard:
            self._known.take(entry.heard)

    def _break(self) -> None:
        """Begin a new file after a change of the clock."""
        self.end()
        while self._waiting:
            self._forget()
        self._now_ns = 0

    def _bound(self) -> None:
        while self._waiting_bytes > MOST_HISTORY:
            self._forget()
            left_ns = self._now_ns - self._waiting[0].time_ns
            if left_ns < self._around.before_ns and not self._shortened:
                self._shortened = True
                self._say(f"--before is too long for the memory: files begin {left_ns / 1e9:.0f} s before their reason")
