# SPDX-License-Identifier: GPL-2.0-or-later
"""Turns reads into records: cut line by line, in order of time, with an event where the settings of a line change."""

from __future__ import annotations

import heapq
import itertools
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.cut import SIS, Cut
from sistap.tap.records.framer import Framer
from sistap.tap.records.record import Event, Record, event

HOLD_NS = 500_000_000  # the longest telegram (263 characters) takes 301 ms at 9600 Bd


class Order:
    """Sorts the records of several lines by the times of their first characters.

    A record waits while a telegram that began earlier is still coming in on the other line, but no longer than HOLD_NS.
    Then it is written, and what began earlier follows it. `now_ns` may be any monotonic clock; the other times are
    those of the records.
    """

    def __init__(self) -> None:
        self._waiting: list[tuple[int, int, Record]] = []  # time, number: records of equal time keep their order
        self._number = itertools.count()
        self._since: deque[tuple[int, int]] = deque()  # when each began to wait, and its time
        self._overdue_ns = 0  # nothing that is at least this old waits

    def add(self, records: Iterable[Record], now_ns: int) -> None:
        """Add records."""
        for record in records:
            heapq.heappush(self._waiting, (record.time_ns, next(self._number), record))
            self._since.append((now_ns, record.time_ns))

    def due(self, unfinished_ns: Iterable[int | None], now_ns: int) -> Iterator[Record]:
        """Yield records that need not wait any longer; `unfinished_ns`: for each line, the oldest time not in a
        record.
        """
        while self._since and now_ns - self._since[0][0] >= HOLD_NS:
            self._overdue_ns = max(self._overdue_ns, self._since.popleft()[1])
        first_ns = min((time_ns for time_ns in unfinished_ns if time_ns is not None), default=None)
        while self._waiting and (first_ns is None or self._waiting[0][0] <= max(first_ns, self._overdue_ns)):
            yield heapq.heappop(self._waiting)[2]

    @property
    def empty(self) -> bool:
        """Tell whether nothing waits."""
        return not self._waiting


@dataclass
class _FramedLine:
    """A line, and its state."""

    framer: Framer
    arrived_ns: int  # time of the last arrival
    why: str | None = None  # reason for settings that differ from those of the last read


class Assembler:
    """The lines of one tap. `now_ns` may be any monotonic clock; the other times are those of the characters.

    After each call, take what is `due`.
    """

    def __init__(self, cut: Cut = SIS) -> None:
        """Cut frames as `cut` says."""
        self._lines: dict[int, _FramedLine] = {}
        self._order = Order()
        self.cut = cut

    def add_line(self, number: int, settings: LineSettings, now_ns: int) -> None:
        """Begin a line."""
        self._lines[number] = _FramedLine(self.cut.framer(number, settings), now_ns)

    @property
    def lines(self) -> Sequence[int]:
        """Return the numbers of the lines, in the order in which they were added."""
        return tuple(self._lines)

    @property
    def empty(self) -> bool:
        """Tell whether all characters are in records."""
        return all(line.framer.empty for line in self._lines.values())

    @property
    def holds(self) -> bool:
        """Tell whether it has records, which may be due."""
        return not self._order.empty

    def settings(self, number: int) -> LineSettings:
        """Return the present settings of a line."""
        return self._lines[number].framer.settings

    def arrived_ns(self, number: int) -> int:
        """Return the time of the last arrival on a line."""
        return self._lines[number].arrived_ns

    def take(self, read: Read, now_ns: int, why: str) -> list[Record]:
        """Take what was read, and `why` its settings are new, if they are.

        Return at once what it completed: an event of new settings, and records. In their order they are `due` later.
        """
        line = self._lines[read.line]
        line.arrived_ns = now_ns
        if read.data and read.settings and read.settings != line.framer.settings:
            self.change(read.line, read.settings, why, now_ns)
        completed: list[Record] = []
        if line.why is not None:
            settings = line.framer.settings
            text = f"{settings}: {line.why}"
            completed.append(event(read.time_ns, read.line, settings, Event.SETTINGS_CHANGED, text))
            line.why = None
        completed += line.framer.feed(read)
        if completed or len(self._lines) > 1:
            self.add(completed + self._beside(read), now_ns)
        return completed

    def _beside(self, read: Read) -> list[Record]:
        """Let the framers of the other lines take what was read; return the records that it completed."""
        others = (line.framer for number, line in self._lines.items() if number != read.line)
        return [record for framer in others for record in framer.beside(read)]

    def change(self, number: int, settings: LineSettings, why: str, now_ns: int) -> None:
        """Change the settings of a line. The event comes with the next read, at its time."""
        self.flush([number], now_ns)
        self._lines[number].framer.settings = settings
        self._lines[number].why = why

    def idle(self, now_ns: int) -> list[tuple[int, list[Record]]]:
        """Check which lines have been silent for long. Return the records that this completed, with their lines."""
        completed = []
        for number, line in self._lines.items():
            records = line.framer.idle(now_ns - line.arrived_ns)
            self.add(records, now_ns)
            completed.append((number, records))
        return completed

    def flush(self, numbers: Iterable[int], now_ns: int) -> None:
        """End the unfinished records of these lines."""
        for number in numbers:
            self.add(self._lines[number].framer.flush(), now_ns)

    def restart(self, number: int, now_ns: int) -> None:
        """Continue with another clock."""
        self.add(self._lines[number].framer.restart(), now_ns)

    def add(self, records: Iterable[Record], now_ns: int) -> None:
        """Add records, also events from outside."""
        self._order.add(records, now_ns)

    def due(self, now_ns: int) -> Iterable[Record]:
        """Return the records that wait for none of another line any more, in order of their times."""
        return self._order.due((line.framer.oldest_ns for line in self._lines.values()), now_ns)
