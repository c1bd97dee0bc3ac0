# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds the characters with errors, from the marks of the terminal and the counters of the driver.

A driver counts an error before it passes the character on. So a counter is ahead: what it has counted when a read
returns may belong to one of the next reads. Such a read waits for them, or for a silence.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from sistap.tap.line.drivers import Driver, ErrorPlace
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag, Read

# A counter is ahead by no more than two reads. Only reads after a sleep count: otherwise the process is late, and much
# more may be on its way. The hardware also tells of a loss early: a UART with the first character of its FIFO, although
# it lost one after the last.
_AHEAD = 2

SILENCE_NS = 50_000_000  # after so much of it, nothing belongs to the counters any more
MOST_READS = 500  # for which a read waits: they come without a sleep, or with a loss in each

_MARKED = re.compile(rb"[^\0]+")


class Counts(NamedTuple):
    """The error counters of a driver."""

    frame: int
    overrun: int
    parity: int
    breaks: int
    buffer_overrun: int


_NOTHING = Counts(0, 0, 0, 0, 0)


@dataclass(eq=False)
class _Held:
    """A read whose flags are not settled yet; at first they are the marks of the terminal."""

    read: Read
    flags: bytearray
    ahead: int = _AHEAD  # reads that may still have its marks
    lost: bool = False  # characters were lost in it, ...
    losing: int = 0  # ... or in so many of the next reads
    waited: int = 0  # reads
    false_first: bool = False  # the first character may be a false one

    def join(self, read: Read, *, slept: bool) -> int:
        """Append the next read: nobody knows in which of them characters were lost. Return where it begins.

        All bounds of the times stay true (see Read).
        """
        start, before = len(self.flags), self.read
        since_ns = max(read.time_ns - before.time_ns, 0)
        uncertainty_ns = min(max(before.uncertainty_ns + since_ns, read.uncertainty_ns), UNCERTAINTY_UNKNOWN)
        self.read = read._replace(data=before.data + read.data, uncertainty_ns=uncertainty_ns)
        self.flags += read.flags
        self.losing -= slept
        self.ahead = _AHEAD
        return start

    def add_somewhere(self, start: int = 0) -> None:
        """Mark an error somewhere among the characters from `start` on."""
        for at in range(start, len(self.flags)):
            self.flags[at] |= Flag.UNLOCATED_ERROR

    def settled(self) -> Read:
        """Return the read. A loss is before one of its characters, but nobody knows which."""
        if self.false_first:
            self.flags[0] |= Flag.UNLOCATED_ERROR
        if self.lost:
            if len(self.flags) > 1:
                self.add_somewhere()
            self.flags[0] |= Flag.LOST_BEFORE
        return self.read._replace(flags=bytes(self.flags))


class Errors:
    """Settles the flags of reads."""

    def __init__(self, count: Callable[[], Counts | None], driver: Driver) -> None:
        """`count` reads the counters of the driver."""
        self._count = count
        self._counted = count()  # None: this driver never counts
        self._finder = _FINDERS[driver.place](driver)
        self._begins = driver.begins_late
        self._held: deque[_Held] = deque()
        self._silence_ns = 0  # so long nothing came while the process slept

    def take(self, read: Read, *, slept: bool) -> list[Read]:
        """Take a read with the marks of the terminal. Return the reads whose errors are settled, in order.

        `slept`: the process did, until it came.
        """
        moved = self._moved(self._counted) if self._counted else _NOTHING
        self._silence_ns = 0
        false_first, self._begins = self._begins and not read.data[0], False
        if moved is _NOTHING and not (self._held or any(read.flags) or self._finder.expects or false_first):
            return [read]
        for held in self._held:
            held.ahead -= slept
            held.waited += 1
        last = self._held[-1] if self._held else None
        if last and last.losing > 0 and last.read.settings == read.settings:
            start = last.join(read, slept=slept)
        else:
            last, start = _Held(read, bytearray(read.flags), false_first=false_first), 0
            self._held.append(last)
        if moved.overrun or moved.buffer_overrun:
            last.lost, last.losing = True, _AHEAD
        self._finder.find(last, start, moved, slept=slept)
        return self.silent(0)

    def silent(self, slept_ns: int) -> list[Read]:
        """Note that nothing came while the process slept. Return the reads that are settled, or need not wait."""
        self._silence_ns += slept_ns
        is_silent = self._silence_ns >= SILENCE_NS
        if is_silent:
            self._finder.silence()
        settled = []
        while self._held:
            held = self._held[0]
            is_open = held.losing > 0 or (held.ahead > 0 and self._finder.waits(held))
            if is_open and held.waited < MOST_READS and not is_silent:
                break
            self._finder.give_up(held)
            settled.append(self._held.popleft().settled())
        return settled

    def all(self) -> list[Read]:
        """Return all waiting reads."""
        return self.silent(SILENCE_NS)

    def _moved(self, before: Counts) -> Counts:
        now = self._count()
        if now is None or now == before:
            return _NOTHING
        self._counted = now
        return Counts(*(new - old for new, old in zip(now, before, strict=True)))


class _Finder(ABC):
    """Turns the marks of a driver into what is known."""

    @property
    def expects(self) -> bool:
        """Tell whether the next read is concerned, whatever it has."""
        return False

    @abstractmethod
    def find(self, held: _Held, start: int, moved: Counts, *, slept: bool) -> None:
        """Settle the flags of a read from `start` on, with what was counted since the read before."""

    def silence(self) -> None:  # noqa: B027
        """Note that the line is silent, so nothing more belongs to what was counted."""

    def waits(self, held: _Held) -> bool:  # noqa: ARG002
        """Tell whether the next read may say more about this one."""
        return False

    def give_up(self, held: _Held) -> None:  # noqa: B027
        """Settle the read with what is known."""


@dataclass(eq=False)
class _Counted:
    """What was counted with one read, and the marks that belong to it: marks come in the order of the counts."""

    held: _Held
    damaged: int
    breaks: int
    marks: list[tuple[_Held, int]] = field(default_factory=list)
    values: int = 0  # marks of characters other than 00, which are damaged and no breaks

    @property
    def missing(self) -> int:
        """Return how many marks have not come yet."""
        return self.damaged + self.breaks - len(self.marks)

    def settle(self) -> None:
        """Tell breaks from damaged 00s, as far as the numbers allow."""
        if self.missing:
            self.held.add_somewhere()
        if not self.breaks:
            flag = Flag.CHARACTER_ERROR
        elif self.damaged > self.values:  # a 00 may be either
            flag = Flag.CHARACTER_ERROR | Flag.UNLOCATED_ERROR
        else:
            return
        for held, at in self.marks:
            if held.flags[at] & Flag.BREAK:
                held.flags[at] = held.flags[at] & ~Flag.BREAK | flag


class _ByCharacter(_Finder):
    """The driver marks the damaged character. A damaged 00 is marked like a break; only the counters differ."""

    def __init__(self, driver: Driver) -> None:
        self._open: deque[_Counted] = deque()
        self._believed = driver.place in (ErrorPlace.UNKNOWN, ErrorPlace.NOWHERE)  # until it has counted something

    def find(self, held: _Held, start: int, moved: Counts, *, slept: bool) -> None:
        """Assign marks to counts."""
        if moved.frame or moved.parity or moved.breaks:
            self._open.append(_Counted(held, moved.frame + moved.parity, moved.breaks))
            self._believed = False
        for at in [at for at in range(start, len(held.flags)) if held.flags[at]]:
            self._assign(held, at)

    def _assign(self, held: _Held, at: int) -> None:
        is_value = not held.flags[at] & Flag.BREAK
        while self._open:
            counted = self._open[0]
            if is_value and counted.values == counted.damaged:
                self._settle_first()  # the rest of it has no mark
                continue
            counted.marks.append((held, at))
            counted.values += is_value
            if not counted.missing:
                self._settle_first()
            return
        if not self._believed:
            held.flags[at] = held.flags[at] & ~Flag.BREAK | Flag.CHARACTER_ERROR

    def waits(self, held: _Held) -> bool:
        """Tell whether marks are missing for what was counted with it, or before it."""
        return any(counted.held is held or any(mark[0] is held for mark in counted.marks) for counted in self._open)

    def give_up(self, held: _Held) -> None:
        """Settle what is still open: it has no marks."""
        while self.waits(held):
            self._settle_first()

    def _settle_first(self) -> None:
        self._open.popleft().settle()


class _ByPacket(_Finder):
    """The driver marks all characters of a USB packet. Of several packets in a row, nobody sees the border.

    A packet may come in two reads: the kernel's buffers or the terminal were full. So a row of marks at the end of a
    read waits for the next character.
    """

    def __init__(self, driver: Driver) -> None:
        self._breaks = driver.breaks
        self._waiting: list[_Held] = []  # counted, not marked
        self._damaged_packets = self._broken_packets = 0  # counted, not used up by marks
        self._doubtful = 0  # in so many reads, another break may be none
        self._last: tuple[_Held, int] | None = None  # a row of marks at the end of the last read, from there on

    @property
    def expects(self) -> bool:
        """Tell whether the next read is special."""
        return self._doubtful > 0

    def find(self, held: _Held, start: int, moved: Counts, *, slept: bool) -> None:
        """Use up what was counted when marks come."""
        self._damaged_packets += moved.frame + moved.parity
        self._broken_packets += moved.breaks
        self._doubtful -= slept and self._doubtful > 0
        continues = self._continue(held, start)
        if any(held.flags[start:]):
            self._settle(held, start, continues=continues)
            if self._broken_packets:
                self._doubtful = _AHEAD
            self._use_up()
        elif (moved.frame or moved.parity or moved.breaks) and held not in self._waiting:
            self._waiting.append(held)

    def _continue(self, held: _Held, start: int) -> bool:
        """Tell whether the last row of marks goes on in this read: then nothing in it has a place."""
        last, self._last = self._last, None
        if not last or not held.flags[start]:
            return False
        before, first = last
        end = start if before is held else len(before.flags)
        before.flags[first:end] = bytes([Flag.UNLOCATED_ERROR]) * (end - first)
        return True

    def _settle(self, held: _Held, start: int, *, continues: bool) -> None:
        """Claim no more than is known. `continues`: the first row of marks may be the rest of a packet.

        A packet may break off with a break, which is then its last character. The next packet says so, too, if it ends
        with 00, although that is a good one: so there is at most one certain break.
        """
        flags = held.flags
        rows = [match.span() for match in _MARKED.finditer(flags, start)]
        ends = [end - 1 for _, end in rows if flags[end - 1] == Flag.BREAK]
        each_is_a_packet = self._damaged_packets <= len(rows)
        certain = self._breaks and each_is_a_packet and len(ends) == self._broken_packets and not self._doubtful
        broken = self._broken_packets or self._doubtful
        for first, end in rows:
            is_rest = continues and first == start
            alone = self._breaks and not is_rest and end - first == 1 and not (broken and flags[first] == Flag.BREAK)
            flags[first:end] = bytes([Flag.CHARACTER_ERROR if alone else Flag.UNLOCATED_ERROR]) * (end - first)
        if certain and ends:
            flags[ends[0]] = Flag.BREAK
        first, end = rows[-1]
        if self._breaks and end == len(flags):
            self._last = held, first

    def silence(self) -> None:
        """End the doubt."""
        self._doubtful = 0
        self._last = None

    def waits(self, held: _Held) -> bool:
        """Tell whether something was counted with it that no mark has used up, or its end is not settled."""
        return held in self._waiting or (self._last is not None and self._last[0] is held)

    def give_up(self, held: _Held) -> None:
        """Settle it: no mark has come."""
        if held in self._waiting:
            for waiting in self._waiting:
                waiting.add_somewhere()
            self._use_up()

    def _use_up(self) -> None:
        self._waiting.clear()
        self._damaged_packets = self._broken_packets = 0


class _ByRead(_Finder):
    """The driver only counts, and learns of errors by another way: the damaged character may be in a later read."""

    def __init__(self, driver: Driver) -> None:
        self._breaks = driver.breaks
        self._reads = 0  # that may still have what was counted

    @property
    def expects(self) -> bool:
        """Tell whether the next read is concerned."""
        return self._reads > 0

    def find(self, held: _Held, start: int, moved: Counts, *, slept: bool) -> None:
        """Mark this read and the next ones."""
        damaged = moved.frame or moved.parity or (moved.breaks and not self._breaks)
        if damaged or self.expects:
            held.add_somewhere(start)
        self._reads = _AHEAD if damaged else max(self._reads - slept, 0)

    def silence(self) -> None:
        """Expect nothing more."""
        self._reads = 0


_FINDERS: Mapping[ErrorPlace, Callable[[Driver], _Finder]] = {
    **dict.fromkeys((ErrorPlace.CHARACTER, ErrorPlace.NOWHERE, ErrorPlace.UNKNOWN), _ByCharacter),
    ErrorPlace.PACKET: _ByPacket,
    ErrorPlace.READ: _ByRead,
}
