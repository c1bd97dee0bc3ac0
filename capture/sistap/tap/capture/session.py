# SPDX-License-Identifier: GPL-2.0-or-later
"""One running capture: the loop that reads, and what ends it or changes the settings, all in one thread."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace

import sistap
from sistap.tap.capture.hints import Exactness
from sistap.tap.capture.rate import FORMATS, Steering, Step
from sistap.tap.capture.tap import EVERYTHING, Conditions, Sink, Tapping
from sistap.tap.files.output import Output, OutputError, ReaderGone
from sistap.tap.line.clock import monotonic_ns
from sistap.tap.line.reader import Exact, Measuring, PortError, PortLost, Reader, Several, Source, together
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.counters import Counters
from sistap.tap.records.cut import SIS
from sistap.tap.records.record import Event
from sistap.tap.sis.rates import RATES
from sistap.tap.terminal.console import Audience
from sistap.tap.terminal.exits import DONE, FAILED
from sistap.tap.terminal.stop import Stop

READ_TIMEOUT_S = 0.1  # upper bound on the time to stop
TICK_NS = 1_000_000_000  # how often hints and progress are updated


class Capture:
    """Reads from one or several readers into a sink whose blocks go to `output`. The clock is the monotonic one, in
    ns.
    """

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
        remote: Callable[[Capture], None] | None = None,
        reopen: Callable[[Reader, LineSettings], Reader] | None = None,
        clock_ns: Callable[[], int] = monotonic_ns,
        source: Source | None = None,
    ) -> None:
        """`quiet`: do not report that it runs; `progress`: show the counters every second.

        `remote` controls it: it is called at every turn. Whoever reads the capture ends it by no longer reading.
        `reopen` opens a lost port again, or raises PortError while it is not back. Without it, a lost port stays lost.
        `source` is the readers as one, where nobody can wait for them: then `reading` is not called.
        """
        self._output = output
        self.counters = counters
        self._conditions = conditions
        self._quiet = quiet
        self._progress = progress
        self._remote = remote
        self._clock_ns = clock_ns
        self._console = console
        self._readers = list(readers)  # those whose ports are not lost
        self._reopen = reopen
        self._lost: dict[Reader, int] = {}  # they may come back; the time of each loss
        self._tap = Tapping(readers, sink, counters, clock_ns, conditions)
        self._exactness: dict[int, Exactness] = {}  # of each line
        self._steering = self._steering_of(readers[0].settings)
        self._steps: list[Step] = []  # not done yet
        self._why = ""  # the reason for new settings
        self._port_lost = False
        self._refused: set[str] = set()  # settings that a port does not support, reported once
        self._started_ns = self._tick_ns = 0
        if source:
            self._source = source

    def run(self, stop: Stop) -> int:
        """Capture until something ends it; return the exit code."""
        # The program makes no reference cycles here: the garbage collector would only delay characters.
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
        self.begin()
        stop.at_once = False
        self.announce()
        with self.reading():
            self._loop(stop)
        for reader in self._readers:
            if sharing := self._tap.sharing(reader, self._elapsed_s()):
                self._console.say(sharing)
        self.end()

    @contextmanager
    def reading(self) -> Iterator[None]:
        """Read all ports at the same time."""
        with together(self._readers, may_change=self._reopen is not None) as self._source:
            yield

    def begin(self) -> None:
        """Begin the file."""
        said = f"sistap {sistap.__version__}; "
        started = {reader.line: said + self._description(reader) for reader in self._readers}
        self._tap.begin(started, self._conditions.limits)
        self._started_ns = self._clock_ns()
        self._tick_ns = self._started_ns + TICK_NS
        for reader in self._readers:
            self._watch(reader)

    def announce(self) -> None:
        """Say what is captured."""
        if not self._quiet:
            for reader in self._readers:
                self._console.say(f"capturing on {self._tap.which(reader.line)}{self._description(reader)}")
        for reader in self._readers:
            for note in reader.notes:
                self._console.say(self._tap.which(reader.line) + note)

    def end(self) -> None:
        """Write what is left."""
        self._tap.end()

    def _description(self, reader: Reader) -> str:
        framing = self._conditions.cut.said
        search = "; looking for the rate" if self._conditions.formats else ""
        follow = "; following changes of the rate" if self._conditions.follow else ""
        return f"{reader.name} ({reader.adapter}); {reader.settings}{search}{follow}; {reader.timing}{framing}"

    def _loop(self, stop: Stop) -> None:
        while not (stop.asked or self.is_over):
            self.turn()
        if stop.asked:
            for _ in self._readers:
                with suppress(PortLost):  # at the same time, by the same Ctrl-C
                    self._take_waiting(self._source.read)

    @property
    def is_over(self) -> bool:
        """Tell whether it has ended by itself."""
        count, duration_s = self._conditions.count, self._conditions.duration_s
        return (
            self._output.done
            or not (self._readers or self._lost)
            or (count is not None and self.counters.written >= count)
            or (duration_s is not None and self._clock_ns() >= self._started_ns + duration_s * 1e9)
        )

    def turn(self, most_s: float = READ_TIMEOUT_S) -> bool:
        """Take one read, or act on the time while nothing comes for so long; tell whether anything came."""
        read = self._read(min(self._timeout_s(self._steering), most_s) if self._steering else most_s)
        now = self._clock_ns()
        if read is not None:
            self._take(read, now)
        else:
            self._output.check()
            self._idle(now)
        if now >= self._tick_ns:
            self._tick_ns = now + TICK_NS
            self._take_back()
            self._idle(now)  # one line can be silent while another is not
            self._look(self._elapsed_s())
        if self._steering and self._readers:
            self._steer(self._steering)
        if self._remote:
            self._remote(self)
        return read is not None

    def _elapsed_s(self) -> float:
        return (self._clock_ns() - self._started_ns) / 1e9

    def _read(self, timeout_s: float) -> Read | None:
        try:
            return self._source.read(timeout_s)
        except PortLost as lost:
            self._lose(lost)
            return None

    def _lose(self, lost: PortLost) -> None:
        """Note that a port is gone; other ports continue."""
        reader = self._tap.reader(lost.line)
        self._readers.remove(reader)
        self._tap.lose(reader, lost.line, str(lost))
        if self._reopen:
            self._lost[reader] = self._clock_ns()
            self._console.say(f"{self._tap.which(lost.line)}{lost}. Waiting until it is back")
            return
        self._port_lost = True
        goes_on = "; the other line goes on" if self._readers else ""
        self._console.alarm(f"{self._tap.which(lost.line)}{lost}{goes_on}")

    def _take_back(self) -> None:
        """Continue with ports that are back."""
        for lost, since_ns in list(self._lost.items()):
            assert self._reopen and isinstance(self._source, Several)
            try:
                reader = self._reopen(lost, (self._readers or [lost])[0].settings)
            except PortError:
                continue
            del self._lost[lost]
            self._readers.append(reader)
            self._tap.replace(lost, reader)
            self._watch(reader)
            away_s = (self._clock_ns() - since_ns) / 1e9
            text = f"{reader.name} is back after {away_s:.1f} s; what came meanwhile is missing"
            self._tap.note(reader.line, Event.CHARACTERS_LOST, text)
            self._console.say(self._tap.which(reader.line) + text)
            self._source.add(reader)

    def _steering_of(self, settings: LineSettings) -> Steering | None:
        formats, follow = self._conditions.formats, self._conditions.follow
        return Steering(settings, formats, follow=follow, measure=self._measured) if formats or follow else None

    def _measured(self) -> float | None:
        """Return the rate of the line, if a port measures it."""
        rates = (reader.measured_baud() for reader in self._readers if isinstance(reader, Measuring))
        return next((rate for rate in rates if rate), None)

    def _timeout_s(self, steering: Steering) -> float:
        due_ns = steering.due_ns
        return READ_TIMEOUT_S if due_ns is None else min(READ_TIMEOUT_S, max(0, due_ns - self._tap.wall_ns()) / 1e9)

    def _steer(self, steering: Steering) -> None:
        """Change the line settings if steering demands it."""
        self._steps.extend(steering.look(self._tap.wall_ns()))
        steps, self._steps = self._steps, []
        for step in steps:
            if any(reader.settings != step.settings for reader in self._readers):
                self._change(step)
            else:
                self._settle(f"{step.settings}: {step.why}")

    @property
    def settings(self) -> LineSettings | None:
        """Return the settings with which the line is read now; None if its port is lost."""
        return self._readers[0].settings if self._readers else None

    def mark(self, text: str) -> None:
        """Write a marker."""
        if self._readers:
            self._tap.note(self._readers[0].line, Event.MARKER, text)

    def set_rate(self, baud: int | None) -> None:
        """Continue at a rate, or search for it (None)."""
        if not self._readers:
            return
        if not baud and self._conditions.cut != SIS:
            self._console.say("sistap can search for the rate of SIS telegrams only: choose a rate")
            return
        formats = () if baud else self._conditions.formats or FORMATS
        self._conditions = replace(self._conditions, formats=formats)
        settings = self._readers[0].settings._replace(baud=baud or RATES[0])
        if formats:
            settings = LineSettings.parse(settings.baud, formats[0])
        self._steering = self._steering_of(settings)
        self._change(Step(settings, "set by hand" if baud else "looking for the rate"))
        for reader in self._readers:
            self._tap.renew_hints(reader)

    def _settle(self, text: str) -> None:
        """Note that the present settings are right."""
        self._console.say(text)
        for reader in self._readers:
            self._tap.renew_hints(reader)
            self._tap.note(reader.line, Event.SETTINGS_CHANGED, text)

    def _change(self, step: Step) -> None:
        """Change the line settings, after reading what came with the old ones."""
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
        if not self._tap.has(read.line):
            self._tap.add_line(read.line, self._readers[0])
            if self._conditions.limits:
                self._tap.note(read.line, Event.LIMITS_TOLD, self._conditions.limits)
        for notice in read.notices:
            self._tap.note(read.line, Event.MARKER, notice, read.time_ns)
            self._console.say(self._tap.which(read.line) + notice)
        completed = self._tap.take(read, now, self._why)
        if self._steering:
            if completed and completed[0].event == Event.SETTINGS_CHANGED and not self._steering.searching:
                self._console.say(self._tap.which(read.line) + completed[0].data.decode())
            self._steps.extend(self._steering.take(read, completed))

    def _idle(self, now: int) -> None:
        for number, records in self._tap.idle(now):
            if self._steering:
                nothing = Read(number, self._tap.wall_ns(), b"", b"")
                self._steps.extend(self._steering.take(nothing, records))

    def _look(self, elapsed_s: float) -> None:
        if self._readers and (moved := self._tap.note_clock_step(self._readers[0].line)):
            self._console.say(moved)
        searching = self._steering.searching if self._steering else None
        for reader in self._readers:
            for hint in self._tap.hints(reader, elapsed_s, searching):
                self._advise(reader, hint)
            if isinstance(reader, Exact) and (
                changed := self._exactness[reader.line].look(reader.uncertainty_ns, elapsed_s)
            ):
                self._advise(reader, changed)
        if self._readers and self._steering and (doubt := self._steering.take_hint()):
            self._advise(self._readers[0], doubt)
        if self._progress:
            self._console.progress(str(self.counters))

    def _watch(self, reader: Reader) -> None:
        """Watch how exact the times of a port are from now on."""
        if isinstance(reader, Exact):
            self._exactness[reader.line] = Exactness(reader.name, reader.uncertainty_ns, self._elapsed_s())

    def _advise(self, reader: Reader, hint: str) -> None:
        """Report a hint, also in the capture: whoever reads that later sees no messages."""
        self._console.say(hint)
        self._tap.note(reader.line, Event.MARKER, hint)
