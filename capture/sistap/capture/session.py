# SPDX-License-Identifier: GPL-2.0-or-later
"""One running capture: the loop that reads, and what ends it or changes the settings, all in one thread."""

from __future__ import annotations

import gc
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import sistap
from sistap.capture.filter import Filter
from sistap.capture.remote import Marker, Remote
from sistap.capture.scan import FORMATS
from sistap.capture.steering import Steering, Step
from sistap.capture.tap import Sink, Tap
from sistap.files.output import Output, OutputError, ReaderGone
from sistap.line.clocks import monotonic_ns
from sistap.line.reader import Distant, Measuring, PortError, PortLost, Reader, Several, together
from sistap.line.settings import Happening, LineSettings, Notice, Read
from sistap.records.counters import Counters
from sistap.records.cut import SIS, Cut
from sistap.records.record import Event
from sistap.sis.rates import RATES
from sistap.terminal.console import Audience
from sistap.terminal.exits import DONE, FAILED
from sistap.terminal.stop import Stop

READ_TIMEOUT_S = 0.1  # upper bound on the time to stop
TICK_NS = 1_000_000_000  # how often hints and progress are updated

_EVENTS = {
    Happening.MARKER: Event.MARKER,
    Happening.LOST: Event.CHARACTERS_LOST,
    Happening.GONE: Event.ADAPTER_LOST,
    Happening.ANEW: Event.CHARACTERS_LOST,
}


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
        remote: Remote | None = None,
        reopen: Callable[[Reader, LineSettings], Reader] | None = None,
        clock_ns: Callable[[], int] = monotonic_ns,
    ) -> None:
        """`quiet`: do not report that it runs; `progress`: show the counters every second; `remote`: who controls it.

        `reopen` opens a lost port again, or raises PortError while it is not back. Without it, a lost port stays lost.
        """
        self._output = output
        self._counters = counters
        self._conditions = conditions
        self._quiet = quiet
        self._progress = progress
        self._remote = remote
        self._clock_ns = clock_ns
        self._console = console
        self._readers = list(readers)  # those whose ports are not lost
        self._reopen = reopen
        self._lost: dict[Reader, int] = {}  # they may come back; the time of each loss
        self._tap = Tap(
            readers,
            sink,
            counters,
            clock_ns,
            cut=conditions.cut,
            only=conditions.only,
            count=conditions.count,
        )
        self._steering = self._steering_of(readers[0].settings)
        self._steps: list[Step] = []  # not done yet
        # the reason for new settings; without another reason the tap has changed them
        self._why = "set where the tap is"
        self._port_lost = False
        self._refused: set[str] = set()  # settings that a port does not support, reported once

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
        descriptions = {reader.line: self._description(reader) for reader in self._readers}
        said = f"sistap {sistap.__version__}; "
        self._tap.begin({number: said + text for number, text in descriptions.items()}, self._conditions.limits)
        stop.at_once = False
        if not self._quiet:
            for number, text in descriptions.items():
                self._console.say(f"capturing on {self._tap.which(number)}{text}")
        for reader in self._readers:
            for note in reader.notes:
                self._console.say(self._tap.which(reader.line) + note)
        with together(self._readers, may_change=self._reopen is not None) as self._source:
            self._loop(stop)
        self._tap.end()

    def _description(self, reader: Reader) -> str:
        framing = self._conditions.cut.said
        search = "; looking for the rate" if self._conditions.formats else ""
        follow = "; following changes of the rate" if self._conditions.follow else ""
        return f"{reader.name} ({reader.adapter}); {reader.settings}{search}{follow}; {reader.timing}{framing}"

    def _loop(self, stop: Stop) -> None:
        counters, count, duration_s = self._counters, self._conditions.count, self._conditions.duration_s
        started = now = self._clock_ns()
        tick = started + TICK_NS
        end = started + duration_s * 1e9 if duration_s is not None else None
        while not (
            stop.asked
            or self._output.done
            or not (self._readers or self._lost)
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
                self._take_back()
                self._idle(now)  # one line can be silent while another is not
                self._look((now - started) / 1e9)
            if self._steering and self._readers:
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

    def _timeout_s(self) -> float:
        due_ns = self._steering.due_ns if self._steering else None
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

    def _serve(self, remote: Remote) -> None:
        """Act on remote requests."""
        for request in remote.requests():
            if not self._readers:  # lost while the rate was changed
                return
            if isinstance(request, Marker):
                self._tap.note(self._readers[0].line, Event.MARKER, request.text)
            else:
                self._set_rate(request.baud)

    def _set_rate(self, baud: int | None) -> None:
        """Continue at a rate, or search for it."""
        if not baud and self._conditions.cut != SIS:
            self._console.say("sistap can search for the rate of SIS telegrams only: choose a rate")
            return
        if any(isinstance(reader, Distant) for reader in self._readers):
            self._console.say("the rate of a distant tap is set on its computer, with the options of `sistap serve`")
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
            self._hear(notice, read)
        brings_settings = self._tap.brings_settings(read)
        records = self._tap.take(read, now, self._why)
        if self._steering:
            if brings_settings and not self._steering.searching:
                self._console.say(f"{self._tap.which(read.line)}{read.settings}: {self._why}")
            self._steps.extend(self._steering.take(read, records))

    def _hear(self, notice: Notice, read: Read) -> None:
        """Write and report the notices of a read."""
        if notice.happening == Happening.GONE:
            self._tap.flush(self._tap.reader(read.line))
        elif notice.happening == Happening.ANEW:
            self._tap.restart(read.line)
        self._tap.note(read.line, _EVENTS[notice.happening], notice.text, read.time_ns)
        self._console.say(self._tap.which(read.line) + notice.text)

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
                self._console.say(hint)
        if self._steering and (doubt := self._steering.take_hint()):
            self._console.say(doubt)
        if self._progress:
            self._console.progress(str(self._counters))
        if self._remote and self._readers:
            self._remote.show(self._counters, self._readers[0].settings)
