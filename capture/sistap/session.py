# SPDX-License-Identifier: GPL-2.0-or-later
"""One running capture: takes what the reader gives through framer and filter to a sink, in one thread."""

from __future__ import annotations

import gc
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from types import FrameType
from typing import Protocol

import sistap
from sistap.bpf import Filter
from sistap.clock import CLOCK
from sistap.console import Console
from sistap.counters import Counters
from sistap.framer import Framer, SilenceFramer, SisFramer
from sistap.hints import Hints
from sistap.line import Read
from sistap.output import Output, OutputError
from sistap.reader import PortLost, Reader
from sistap.record import Event, Framing, Record, Type, event

READ_TIMEOUT_S = 0.1  # so long, at most, does a stop take
TICK_NS = 1_000_000_000  # how often hints and progress are looked at


class Stop:
    """Ends a capture on SIGINT, on SIGTERM, and on SIGHUP (the terminal is gone) unless nohup had it ignored.

    The handlers are our own because a job that a script starts with & inherits SIGINT ignored, and Python leaves it so.
    Until the capture runs (opening a fifo waits for its reader) they end the program as Ctrl-C does.
    """

    def __init__(self) -> None:
        """Install the handlers."""
        self.requested = False
        self.running = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._handle)
        if sys.platform != "win32" and signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
            signal.signal(signal.SIGHUP, self._handle)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        self.requested = True
        if not self.running:
            raise KeyboardInterrupt


class Sink(Protocol):
    """Where records go."""

    def begin(self, started: Record) -> None:
        """Begin, with the event that says how the capture is taken."""

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


EVERYTHING = Conditions()


class Capture:
    """From a reader to a sink whose blocks go to `output`. The clock is the monotonic one, in ns."""

    def __init__(  # noqa: PLR0913 - it puts the parts together
        self,
        reader: Reader,
        sink: Sink,
        output: Output,
        counters: Counters,
        console: Console,
        conditions: Conditions = EVERYTHING,
        *,
        quiet: bool = False,
        progress: bool = False,
        clock_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        """`quiet`: do not say that it runs; `progress`: show the counters every second."""
        self._reader = reader
        self._sink = sink
        self._output = output
        self._counters = counters
        self._conditions = conditions
        self._quiet = quiet
        self._progress = progress
        self._clock_ns = clock_ns
        self._console = console
        framing = Framing.SIS if conditions.silence_ms is None else Framing.SILENCE
        self._hints = Hints(reader.settings, framing)
        self._framers: dict[int, Framer] = {}  # by line, as each comes up
        self._arrived_ns: dict[int, int] = {}  # by line, when something last came
        self._last: Read | None = None

    def run(self, stop: Stop) -> int:
        """Capture until something ends it; give the exit code."""
        # Nothing here makes reference cycles: the collector would only make a character wait now and then.
        gc.freeze()
        gc.disable()
        try:
            lost = self._run(stop)
        except OutputError as error:
            self._console.say(str(error))
            return 1
        finally:
            gc.enable()
            gc.unfreeze()
        if lost:
            self._console.say(str(lost))
        return 1 if lost or self._output.failed else 0

    def _run(self, stop: Stop) -> PortLost | None:
        lost: PortLost | None = None
        self._sink.begin(self._event(Event.CAPTURE_STARTED, f"sistap {sistap.__version__}; {self._description}"))
        stop.running = True
        if not self._quiet:
            self._console.say(f"capturing on {self._description}")
        for note in self._reader.notes:
            self._console.say(note)
        try:
            self._loop(stop)
        except PortLost as error:
            lost = error
        for framer in self._framers.values():
            self._emit(framer.flush())
        if lost:
            self._sink.write(self._event(Event.ADAPTER_LOST, str(lost)))
        self._sink.end(self._wall_ns())
        return lost

    @property
    def _description(self) -> str:
        reader, silence_ms = self._reader, self._conditions.silence_ms
        framing = "" if silence_ms is None else f"; frames cut by {silence_ms:g} ms of silence"
        settings = reader.settings
        return f"{reader.name} ({reader.adapter}); {settings.baud} Bd {settings.format}; {reader.timing}{framing}"

    def _loop(self, stop: Stop) -> None:
        counters, count, duration_s = self._counters, self._conditions.count, self._conditions.duration_s
        started = now = self._clock_ns()
        tick = started + TICK_NS
        end = started + duration_s * 1e9 if duration_s is not None else None
        while not (
            stop.requested
            or self._output.done
            or (count is not None and counters.written >= count)
            or (end is not None and now >= end)
        ):
            read = self._reader.read(READ_TIMEOUT_S)
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
        if stop.requested:
            self._take_waiting()

    def _take_waiting(self) -> None:
        """Take what had arrived when the stop came; that the port goes at the same time is no loss."""
        end = self._clock_ns() + int(READ_TIMEOUT_S * 1e9)
        with suppress(PortLost):
            while (now := self._clock_ns()) < end and (read := self._reader.read(0)):
                self._take(read, now)

    def _take(self, read: Read, now: int) -> None:
        line = read.line
        framer = self._framers.get(line)
        if framer is None:
            framer = self._framers[line] = self._framer(line)
        self._arrived_ns[line] = now
        self._last = read
        self._counters.add_read(read)
        self._emit(framer.feed(read))

    def _framer(self, line: int) -> Framer:
        silence_ms = self._conditions.silence_ms
        if silence_ms is None:
            return SisFramer(line, self._reader.settings)
        return SilenceFramer(line, self._reader.settings, int(silence_ms * 1e6))

    def _idle(self, now: int) -> None:
        for line, framer in self._framers.items():
            self._emit(framer.idle(now - self._arrived_ns[line]))
        # What a framer holds is older than now, and a new file begins with the time now.
        if all(framer.empty for framer in self._framers.values()):
            self._sink.look(self._wall_ns())

    def _emit(self, records: list[Record]) -> None:
        counters, only, count = self._counters, self._conditions.only, self._conditions.count
        for record in records:
            passes = only is None or record.type != Type.FRAME or only.matches(record.data)
            if passes and (count is None or counters.written < count):
                counters.accepted[record.line] += self._sink.write(record)
            counters.add_record(record)  # after writing: that can end a file, whose statistics are without this one

    def _look(self, elapsed_s: float) -> None:
        if step_ns := CLOCK.step_ns():
            text = (
                f"the wall clock moved by {step_ns / 1e9:+.3f} s (it was set, or the computer slept); "
                "times in this capture go on without the step"
            )
            self._sink.write(self._event(Event.MARKER, text))
            self._console.say(text)
        for hint in self._hints.look(self._counters, elapsed_s):
            self._console.say(hint)
        if self._progress:
            self._console.progress(str(self._counters))

    def _event(self, code: Event, text: str) -> Record:
        return event(self._wall_ns(), self._reader.line, self._reader.settings, code, text)

    def _wall_ns(self) -> int:
        """Give the time now by the clock of the line: a virtual bus may have its own."""
        if self._last is None:
            return CLOCK.now_ns()
        return self._last.time_ns + self._clock_ns() - self._arrived_ns[self._last.line]
