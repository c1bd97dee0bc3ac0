# SPDX-License-Identifier: GPL-2.0-or-later
"""One running capture: takes what the readers give through assembler and filter to a sink, in one thread."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Protocol

import sistap
from sistap.capture.filter import Filter
from sistap.capture.hints import Hints
from sistap.capture.remote import Marker, Remote
from sistap.capture.scan import FORMATS
from sistap.capture.steering import Steering, Step
from sistap.files.output import Output, OutputError, ReaderGone
from sistap.line.clock import CLOCK
from sistap.line.reader import PortError, PortLost, Reader, together
from sistap.line.settings import LineSettings, Read
from sistap.records.assembler import Assembler
from sistap.records.counters import Counters
from sistap.records.record import Event, Record, Type, event
from sistap.sis.rates import RATES
from sistap.terminal.console import Audience
from sistap.terminal.exits import DONE, FAILED
from sistap.terminal.stop import Stop

READ_TIMEOUT_S = 0.1  # so long, at most, does a stop take
TICK_NS = 1_000_000_000  # how often hints and progress are looked at


class Sink(Protocol):
    """Where records go."""

    def begin(self, *started: Record) -> None:
        """Begin, with an event for each port that says how the capture is taken."""

    def write(self, record: Record) -> bool:
        """Take a record; tell whether it was written."""

    def look(self, time_ns: int) -> None:
        """Look, while nothing comes, whether the time for something has come."""

    def end(self, time_ns: int) -> None:
        """End."""


@dataclass(frozen=True)
class Conditions:
    """What a capture takes and when it ends by itself; None: does not apply."""

    silence_ms: float | None = None  # frames are cut by silence, not as SIS
    only: Filter | None = None  # frames that it does not let pass are left out
    count: int | None = None  # records written
    duration_s: float | None = None
    formats: Sequence[str] = ()  # rate and format are looked for: one of these
    follow: bool = False  # the rate changes with what the bus is told


EVERYTHING = Conditions()


@dataclass
class _Line:
    """One line: the port it comes from, what has come on it, and what was said of that."""

    reader: Reader
    counters: Counters
    hints: Hints


class Capture:
    """From one reader or several to a sink whose blocks go to `output`. The clock is the monotonic one, in ns."""

    def __init__(  # noqa: PLR0913 - it puts the parts together
        self,
        readers: Sequence[Reader],
        sink: Sink,
        output: Output,
        counters: Counters,
        console: Audience,
        conditions: Conditions = EVERYTHING,
        *,
        quiet: bool = False,
        progress: bool = False,
        remote: Remote | None = None,
        clock_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        """`quiet`: do not say that it runs; `progress`: show the counters every second; `remote`: who controls it."""
        self._sink = sink
        self._output = output
        self._counters = counters
        self._conditions = conditions
        self._quiet = quiet
        self._progress = progress
        self._remote = remote
        self._clock_ns = clock_ns
        self._console = console
        self._readers = list(readers)  # whose ports are not lost
        self._several = len(readers) > 1
        self._assembler = Assembler(self._write, conditions.silence_ms)
        self._lines: dict[int, _Line] = {}
        for reader in readers:
            self._add_line(reader.line, reader)
        self._steering = self._steering_of(readers[0].settings)
        self._steps: list[Step] = []  # not yet done
        self._why = ""  # the settings were changed
        self._last: Read | None = None
        self._port_lost = False
        self._refused: set[str] = set()  # settings that a port cannot do, said once

    def run(self, stop: Stop) -> int:
        """Capture until something ends it; give the exit code."""
        # Nothing here makes reference cycles: the collector would only make a character wait now and then.
        gc.freeze()
        gc.disable()
        try:
            self._run(stop)
        except OutputError as error:
            if self._remote and isinstance(error, ReaderGone):
                return DONE
            self._console.alarm(str(error))
            return FAILED
        finally:
            gc.enable()
            gc.unfreeze()
        return FAILED if self._port_lost or self._output.failed else DONE

    def _run(self, stop: Stop) -> None:
        descriptions = {number: self._description(line) for number, line in self._lines.items()}
        said = f"sistap {sistap.__version__}; "
        self._sink.begin(*(self._event(n, Event.CAPTURE_STARTED, said + text) for n, text in descriptions.items()))
        stop.at_once = False
        if not self._quiet:
            for number, text in descriptions.items():
                self._console.say(f"capturing on {self._which(number)}{text}")
        for reader in self._readers:
            for note in reader.notes:
                self._console.say(self._which(reader.line) + note)
        with together(self._readers) as self._source:
            self._loop(stop)
        self._assembler.flush(self._lines, self._clock_ns())
        self._sink.end(self._wall_ns())

    def _description(self, line: _Line) -> str:
        reader, silence_ms = line.reader, self._conditions.silence_ms
        framing = "" if silence_ms is None else f"; frames cut by {silence_ms:g} ms of silence"
        search = "; looking for the rate" if self._conditions.formats else ""
        follow = "; following changes of the rate" if self._conditions.follow else ""
        return f"{reader.name} ({reader.adapter}); {reader.settings}{search}{follow}; {reader.timing}{framing}"

    def _which(self, number: int) -> str:
        return f"line {number}: " if self._several else ""

    def _loop(self, stop: Stop) -> None:
        counters, count, duration_s = self._counters, self._conditions.count, self._conditions.duration_s
        started = now = self._clock_ns()
        tick = started + TICK_NS
        end = started + duration_s * 1e9 if duration_s is not None else None
        while not (
            stop.asked
            or self._output.done
            or not self._readers
            or (count is not None and counters.written >= count)
            or (end is not None and now >= end)
        ):
            read = self._read(self._timeout_s())
            now = self._clock_ns()
            if read is not None:
                self._take(read, now)
            else:
                self._output.check()
                self._idle(now)
            if now >= tick:
                tick = now + TICK_NS
                self._idle(now)  # one line can be silent while another is not
                self._look((now - started) / 1e9)
            if self._steering:
                self._steer(self._steering)
            if self._remote:
                self._serve(self._remote)
        if stop.asked:
            for _ in self._readers:
                with suppress(PortLost):  # at the same time, by the same Ctrl-C
                    self._take_waiting(self._source.read)

    def _read(self, timeout_s: float) -> Read | None:
        try:
            return self._source.read(timeout_s)
        except PortLost as lost:
            self._lose(lost)
            return None

    def _lose(self, lost: PortLost) -> None:
        """Note that a port is gone; if there is another, that one goes on."""
        reader = self._lines[lost.line].reader
        self._port_lost = True
        self._readers.remove(reader)
        lines = [number for number, line in self._lines.items() if line.reader is reader]
        self._assembler.flush(lines, self._clock_ns())
        self._emit(lost.line, Event.ADAPTER_LOST, str(lost))
        goes_on = "; the other line goes on" if self._readers else ""
        self._console.alarm(f"{self._which(lost.line)}{lost}{goes_on}")

    def _steering_of(self, settings: LineSettings) -> Steering | None:
        formats, follow = self._conditions.formats, self._conditions.follow
        return Steering(settings, formats, follow=follow) if formats or follow else None

    def _timeout_s(self) -> float:
        due_ns = self._steering.due_ns if self._steering else None
        return READ_TIMEOUT_S if due_ns is None else min(READ_TIMEOUT_S, max(0, due_ns - self._wall_ns()) / 1e9)

    def _steer(self, steering: Steering) -> None:
        """Do what is to be done about the line settings."""
        self._steps.extend(steering.look(self._wall_ns()))
        steps, self._steps = self._steps, []
        for step in steps:
            if any(reader.settings != step.settings for reader in self._readers):
                self._change(step)
            else:
                self._settle(f"{step.settings}: {step.why}")

    def _serve(self, remote: Remote) -> None:
        """Do what was asked for from outside."""
        for request in remote.requests():
            if not self._readers:  # lost while the rate was changed
                return
            if isinstance(request, Marker):
                self._emit(self._readers[0].line, Event.MARKER, request.text)
            else:
                self._set_rate(request.baud)

    def _set_rate(self, baud: int | None) -> None:
        """Go on at a rate, or look for it."""
        formats = () if baud else self._conditions.formats or FORMATS
        self._conditions = replace(self._conditions, formats=formats)
        settings = self._readers[0].settings._replace(baud=baud or RATES[0])
        if formats:
            settings = LineSettings.parse(settings.baud, formats[0])
        self._steering = self._steering_of(settings)
        self._change(Step(settings, "set by hand" if baud else "looking for the rate"))
        for reader in self._readers:
            self._lines[reader.line].hints = self._hints_of(reader)

    def _settle(self, text: str) -> None:
        """Note that the settings of now are right."""
        self._console.say(text)
        for reader in self._readers:
            self._lines[reader.line].hints = self._hints_of(reader)
            self._emit(reader.line, Event.SETTINGS_CHANGED, text)

    def _change(self, step: Step) -> None:
        """Change the line settings, after what has come with the old ones."""
        self._take_waiting(self._read)
        self._why = step.why
        for reader in self._readers:
            try:
                reader.change(step.settings)
            except PortError as error:
                if str(error) not in self._refused:
                    self._refused.add(str(error))
                    self._console.say(str(error))

    def _take_waiting(self, reading: Callable[[float], Read | None]) -> None:
        """Take what has arrived."""
        end = self._clock_ns() + int(READ_TIMEOUT_S * 1e9)
        while (now := self._clock_ns()) < end and (read := reading(0)):
            self._take(read, now)

    def _take(self, read: Read, now: int) -> None:
        if read.line not in self._lines:  # one port, a virtual bus, can bring several
            self._add_line(read.line, self._readers[0])
        self._last = read
        self._counters.add_read(read)
        if self._several:
            self._lines[read.line].counters.add_read(read)
        brings_settings = self._assembler.brings_settings(read)
        records = self._assembler.take(read, now, self._why)
        if self._steering:
            if brings_settings and not self._steering.searching:
                self._console.say(f"{self._which(read.line)}{read.settings}: {self._why}")
            self._steps.extend(self._steering.take(read, records))

    def _add_line(self, number: int, reader: Reader) -> None:
        self._assembler.add_line(number, reader.settings, self._clock_ns())
        counters = Counters() if self._several else self._counters
        self._lines[number] = _Line(reader, counters, self._hints_of(reader))

    def _hints_of(self, reader: Reader) -> Hints:
        return Hints(reader.settings, self._assembler.framing)

    def _idle(self, now: int) -> None:
        for number, records in self._assembler.idle(now):
            if self._steering:
                nothing = Read(number, self._wall_ns(), b"", b"")
                self._steps.extend(self._steering.take(nothing, records))
        # What a framer holds is older than now, and a new file begins with the time now. Without it no record waits.
        if self._assembler.empty:
            self._sink.look(self._wall_ns())

    def _emit(self, number: int, code: Event, text: str) -> None:
        """Write an event that has nothing to do with what was read."""
        self._assembler.emit([self._event(number, code, text)], self._clock_ns())

    def _write(self, record: Record) -> None:
        if record.type == Type.EVENT:
            self._sink.write(record)
            return
        counters, only, count = self._counters, self._conditions.only, self._conditions.count
        passes = only is None or record.type != Type.FRAME or only.matches(record.data)
        if passes and (count is None or counters.written < count):
            counters.accepted[record.line] += self._sink.write(record)
        counters.add_record(record)  # after writing: that can end a file, whose statistics are without this one
        if self._several:
            self._lines[record.line].counters.add_record(record)

    def _look(self, elapsed_s: float) -> None:
        if step_ns := CLOCK.step_ns():
            text = (
                f"the wall clock moved by {step_ns / 1e9:+.3f} s (it was set, or the computer slept); "
                "times in this capture go on without the step"
            )
            self._emit(self._readers[0].line, Event.MARKER, text)
            self._console.say(text)
        for reader in self._readers:
            line = self._lines[reader.line]
            searching = self._steering.searching if self._steering else None
            for hint in line.hints.look(line.counters, elapsed_s, searching):
                self._console.say(self._which(reader.line) + hint)
        if self._steering and (doubt := self._steering.take_hint()):
            self._console.say(doubt)
        if self._progress:
            self._console.progress(str(self._counters))
        if self._remote and self._readers:
            self._remote.show(self._counters, self._readers[0].settings)

    def _event(self, number: int, code: Event, text: str) -> Record:
        return event(self._wall_ns(), number, self._assembler.settings(number), code, text)

    def _wall_ns(self) -> int:
        """Give the time now by the clock of the line: a virtual bus may have its own."""
        if self._last is None:
            return CLOCK.now_ns()
        return self._last.time_ns + self._clock_ns() - self._assembler.arrived_ns(self._last.line)
