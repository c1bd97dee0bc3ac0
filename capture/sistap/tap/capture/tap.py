# SPDX-License-Identifier: GPL-2.0-or-later
"""The lines of a capture: what is read on them becomes records in a sink, filtered and counted."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from sistap.tap.capture.filter import Filter
from sistap.tap.capture.hints import Hints
from sistap.tap.capture.rate import Scan
from sistap.tap.line import drivers
from sistap.tap.line.clock import CLOCK
from sistap.tap.line.reader import OwnTime, Reader
from sistap.tap.line.settings import Read
from sistap.tap.records.assembler import Assembler
from sistap.tap.records.counters import Counters
from sistap.tap.records.cut import SIS, Cut
from sistap.tap.records.record import CLOCK_MOVED, Event, Record, Type, event


class Sink(Protocol):
    """The destination of records."""

    def begin(self, *started: Record) -> None:
        """Begin, with an event for each port that describes how the capture is taken."""

    def write(self, record: Record) -> bool:
        """Take a record; return whether it was written."""

    def look(self, time_ns: int) -> None:
        """Act on the time while nothing comes."""

    def end(self, time_ns: int) -> None:
        """End."""


@dataclass(frozen=True)
class Conditions:
    """What a capture accepts, and when it ends by itself; None: does not apply."""

    cut: Cut = SIS
    only: Filter | None = None  # frames that do not pass are left out
    count: int | None = None  # largest number of records
    duration_s: float | None = None
    formats: Sequence[str] = ()  # search for the rate and one of these formats
    follow: bool = False  # follow rate changes on the bus
    limits: str = ""  # TzA and TrS as the user tells them


EVERYTHING = Conditions()


@dataclass
class _TappedLine:
    """A line: its port, what has come on it, and the hints given."""

    reader: Reader
    counters: Counters
    hints: Hints


class Tapping:
    """Brings reads to a sink. `now` is the time of the monotonic clock, in ns; events have the time of the line."""

    def __init__(
        self,
        readers: Sequence[Reader],
        sink: Sink,
        counters: Counters,
        clock_ns: Callable[[], int],
        conditions: Conditions = EVERYTHING,
    ) -> None:
        """Begin with a line for each reader."""
        self._sink = sink
        self._counters = counters
        self._clock_ns = clock_ns
        self._only = conditions.only
        self._count = conditions.count
        self._several = len(readers) > 1
        self._assembler = Assembler(conditions.cut)
        self._lines: dict[int, _TappedLine] = {}
        self._last: Read | None = None
        for reader in readers:
            self.add_line(reader.line, reader)

    def add_line(self, number: int, reader: Reader) -> None:
        """Begin a line."""
        self._assembler.add_line(number, reader.settings, self._clock_ns())
        counters = Counters() if self._several else self._counters
        self._lines[number] = _TappedLine(reader, counters, self._new_hints(reader))

    def has(self, number: int) -> bool:
        """Tell whether the line exists: one port, a virtual bus, can bring several."""
        return number in self._lines

    def reader(self, number: int) -> Reader:
        """Return the reader of a line."""
        return self._lines[number].reader

    def which(self, number: int) -> str:
        """Return the prefix that names a line in messages; empty with a single port."""
        return f"line {number}: " if self._several else ""

    def begin(self, started: Mapping[int, str], limits: str = "") -> None:
        """Begin the sink, with how the capture is taken on each line, and the limits that the user told."""
        events = [self._event(number, Event.CAPTURE_STARTED, text) for number, text in started.items()]
        if limits:
            events += [self._event(number, Event.LIMITS_TOLD, limits) for number in started]
        self._sink.begin(*events)

    def end(self) -> None:
        """Write what is left, and end the sink."""
        self._assembler.flush(self._lines, self._clock_ns())
        self._write_due()
        self._sink.end(self.wall_ns())

    def lose(self, reader: Reader, number: int, text: str) -> None:
        """Write what is left of the lines of a port that is gone, and the reason."""
        self.flush(reader)
        self.note(number, Event.ADAPTER_LOST, text)

    def replace(self, lost: Reader, reader: Reader) -> None:
        """Continue with the lines of a lost port that is back."""
        for number in self._lines_of(lost):
            self._assembler.restart(number, self._clock_ns())
            if reader.settings != self._assembler.settings(number):
                self._assembler.change(number, reader.settings, "set when the port came back", self._clock_ns())
            self._lines[number].reader = reader
        self._write_due()

    def flush(self, reader: Reader) -> None:
        """Write what is left of the lines of a port."""
        self._assembler.flush(self._lines_of(reader), self._clock_ns())
        self._write_due()

    def note(self, number: int, code: Event, text: str, time_ns: int | None = None) -> None:
        """Write an event that is not in what was read, at the present time or the given one."""
        self._assembler.add([self._event(number, code, text, time_ns)], self._clock_ns())
        self._write_due()

    def note_clock_step(self, number: int) -> str:
        """Write an event if the wall clock was set. Return a message about it, or an empty text."""
        step_ns = CLOCK.step_ns()
        if not step_ns:
            return ""
        moved = f"{CLOCK_MOVED.format(step_ns / 1e9)} (it was set, or the computer slept)"
        text = f"{moved}; times in this capture go on without the step"
        self.note(number, Event.MARKER, text)
        return text

    def take(self, read: Read, now: int, why: str) -> list[Record]:
        """Take what was read; `why` is the reason for new settings. Return what it completed, events of these too."""
        self._last = read
        self._counters.add_read(read)
        if self._several:
            self._lines[read.line].counters.add_read(read)
        completed = self._assembler.take(read, now, why)
        if self._assembler.holds:
            self._write_due()
        return completed

    def idle(self, now: int) -> list[tuple[int, list[Record]]]:
        """Check which lines have been silent for long. Return the records that this completed, with their lines."""
        completed = self._assembler.idle(now)
        self._write_due()
        # What a framer holds is older than now, but a new file would begin with the time now. Without it no record
        # waits.
        if self._assembler.empty:
            self._sink.look(self.wall_ns())
        return completed

    def renew_hints(self, reader: Reader) -> None:
        """Restart the hints of a port, because it has other settings."""
        self._lines[reader.line].hints = self._new_hints(reader)

    def hints(self, reader: Reader, elapsed_s: float, searching: Scan | None) -> Iterator[str]:
        """Return the new hints of a port, each for its line."""
        line = self._lines[reader.line]
        for hint in line.hints.look(line.counters, elapsed_s, searching):
            yield self.which(reader.line) + hint

    def sharing(self, reader: Reader, elapsed_s: float) -> str:
        """Return that another program may take characters of a port; it is looked for now."""
        line = self._lines[reader.line]
        said = line.hints.sharing(line.counters, elapsed_s, anew=True)
        return said and self.which(reader.line) + said

    def wall_ns(self) -> int:
        """Return the present time of the line's clock: a virtual bus may have its own."""
        if self._last is None:
            first = next(iter(self._lines.values())).reader
            return first.now_ns() if isinstance(first, OwnTime) else CLOCK.now_ns()
        return self._last.time_ns + self._clock_ns() - self._assembler.arrived_ns(self._last.line)

    def _new_hints(self, reader: Reader) -> Hints:
        reports = drivers.reports(reader.timing)
        return Hints(reader.settings, self._assembler.cut.framing, errors_reported=bool(reports), port=reader.name)

    def _lines_of(self, reader: Reader) -> Iterable[int]:
        return [number for number, line in self._lines.items() if line.reader is reader]

    def _event(self, number: int, code: Event, text: str, time_ns: int | None = None) -> Record:
        return event(time_ns or self.wall_ns(), number, self._assembler.settings(number), code, text)

    def _write_due(self) -> None:
        for record in self._assembler.due(self._clock_ns()):
            if record.type == Type.EVENT:
                self._sink.write(record)
                continue
            counters, only, count = self._counters, self._only, self._count
            passes = only is None or record.type != Type.FRAME or only.matches(record.data)
            passes = passes and (count is None or counters.written < count)
            # Count after writing: that can end a file, whose statistics exclude this record.
            counters.add_record(record, written=passes and self._sink.write(record))
            if self._several:
                self._lines[record.line].counters.add_record(record)
