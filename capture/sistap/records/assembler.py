# SPDX-License-Identifier: GPL-2.0-or-later
"""Turns reads into records: cut line by line, in order of time, with an event where the settings of a line change."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from sistap.line.settings import LineSettings, Read
from sistap.records.cut import SIS, Cut
from sistap.records.framer import Framer
from sistap.records.order import Order
from sistap.records.record import Event, Record, event


@dataclass
class _Line:
    """A line, and its state."""

    framer: Framer
    arrived_ns: int  # time of the last arrival
    own_time: bool  # reads without characters tell the time
    why: str | None = None  # reason for settings that differ from those of the last read


class Assembler:
    """The lines of one tap. `now_ns` may be any monotonic clock; the other times are those of the characters."""

    def __init__(self, write: Callable[[Record], None], cut: Cut = SIS) -> None:
        """Call `write` with each record when it is due. Frames are cut as `cut` says."""
        self._write = write
        self._lines: dict[int, _Line] = {}
        self._order = Order()
        self.cut = cut

    def add_line(self, number: int, settings: LineSettings, now_ns: int, *, own_time: bool = False) -> None:
        """Begin a line; `own_time`: a network may deliver late what came in time."""
        self._lines[number] = _Line(self.cut.framer(number, settings), now_ns, own_time)

    @property
    def lines(self) -> Sequence[int]:
        """Return the numbers of the lines, in the order in which they were added."""
        return tuple(self._lines)

    @property
    def empty(self) -> bool:
        """Tell whether all characters are in records."""
        return all(line.framer.empty for line in self._lines.values())

    def settings(self, number: int) -> LineSettings:
        """Return the present settings of a line."""
        return self._lines[number].framer.settings

    def arrived_ns(self, number: int) -> int:
        """Return the time of the last arrival on a line."""
        return self._lines[number].arrived_ns

    def brings_settings(self, read: Read) -> bool:
        """Tell whether this is the first read with other settings."""
        return bool(read.data) and read.settings not in (None, self.settings(read.line))

    def take(self, read: Read, now_ns: int, why: str) -> list[Record]:
        """Take what was read, and `why` its settings are new, if they are. Return the records that it completed."""
        line = self._lines[read.line]
        line.arrived_ns = now_ns
        if read.settings and self.brings_settings(read):
            self.change(read.line, read.settings, why, now_ns)
        if line.why is not None:
            settings = line.framer.settings
            changed = event(read.time_ns, read.line, settings, Event.SETTINGS_CHANGED, f"{settings}: {line.why}")
            line.why = None
            self.emit([changed], now_ns)
        records = line.framer.feed(read)
        self.emit(records, now_ns)
        return records

    def change(self, number: int, settings: LineSettings, why: str, now_ns: int) -> None:
        """Change the settings of a line. The event comes with the next read, at its time."""
        self.flush([number], now_ns)
        self._lines[number].framer.settings = settings
        self._lines[number].why = why

    def idle(self, now_ns: int) -> list[tuple[int, list[Record]]]:
        """Check which lines have been silent for long. Return the records that this completed, with their lines."""
        completed = []
        for number, line in self._lines.items():
            records = [] if line.own_time else line.framer.idle(now_ns - line.arrived_ns)
            self.emit(records, now_ns)
            completed.append((number, records))
        return completed

    def flush(self, numbers: Iterable[int], now_ns: int) -> None:
        """Write all that is left of these lines."""
        for number in numbers:
            self.emit(self._lines[number].framer.flush(), now_ns)

    def restart(self, number: int, now_ns: int) -> None:
        """Continue with another clock."""
        self.emit(self._lines[number].framer.restart(), now_ns)

    def emit(self, records: Sequence[Record], now_ns: int) -> None:
        """Write records and outside events, after earlier ones of the other line."""
        if not records and self._order.empty:
            return
        self._order.add(records, now_ns)
        for record in self._order.due((line.framer.oldest_ns for line in self._lines.values()), now_ns):
            self._write(record)
