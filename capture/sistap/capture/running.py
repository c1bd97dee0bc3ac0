# SPDX-License-Identifier: GPL-2.0-or-later
"""One capture, from its options to its exit code: opens the ports, puts the parts together, says what was written."""

from __future__ import annotations

from contextlib import ExitStack

from sistap.capture.filter import Filter
from sistap.capture.options import CaptureOptions, Plan
from sistap.capture.remote import Remote
from sistap.capture.session import Capture, Conditions
from sistap.capture.tap import Sink
from sistap.files.output import Output
from sistap.files.pcapng import Interface
from sistap.files.writer import LINK_TYPES, PcapngWriter
from sistap.line import priority
from sistap.line.reader import Distant, PortError, Reader, open_reader
from sistap.records.counters import Counters
from sistap.records.record import Record, Type
from sistap.records.text import lines
from sistap.terminal.console import Audience
from sistap.terminal.stop import Stop


class TextSink:
    """Prints records as text."""

    def __init__(self, output: Output) -> None:
        """Print to `output`."""
        self._output = output

    def begin(self, *started: Record) -> None:
        """Print nothing: standard error says it."""

    def write(self, record: Record) -> bool:
        """Print a record at once; not an event, that standard error tells."""
        if record.type == Type.EVENT:
            return False
        self._output.write(lines(record).encode())
        return True

    def look(self, time_ns: int) -> None:
        """Do nothing: it is one output only."""

    def end(self, time_ns: int) -> None:
        """Print nothing."""


class Tally:
    """Hands records on to a sink, and counts those that it has written."""

    def __init__(self, sink: Sink) -> None:
        """Begin at zero."""
        self._sink = sink
        self.written = Counters()
        self.begin, self.look, self.end = sink.begin, sink.look, sink.end

    def write(self, record: Record) -> bool:
        """Hand it on; count it if it was written and is no event."""
        written = self._sink.write(record)
        if written and record.type != Type.EVENT:
            self.written.add_read(record)
            self.written.add_record(record)
        return written


@priority.real_time()
def record(  # noqa: PLR0913 - it puts the parts together
    options: CaptureOptions, plan: Plan, output: Output, stop: Stop, console: Audience, remote: Remote | None = None
) -> int:
    """Capture into `output`, perhaps controlled by `remote`; return the exit code. May raise PortError."""
    with ExitStack() as opened:
        readers: list[Reader] = []
        for line, port in zip(options.lines, options.ports, strict=True):
            readers.append(open_reader(port, plan.settings, line))
            opened.callback(readers[-1].close)
            _check_steering(options, readers[-1])
        counters = Counters()
        tally = Tally(_sink(options, readers, output, counters))
        capture = Capture(
            readers,
            tally,
            output,
            counters,
            console,
            _conditions(options, plan.only),
            quiet=options.quiet,
            progress=bool(options.file) and not options.quiet and console.shows_progress,
            remote=remote,
        )
        with output.lasting():
            code = capture.run(stop)
    if options.file:
        console.say(_summary(tally.written, counters.received.total(), output))
    elif not options.quiet:
        console.say(str(counters))
    return code


def _check_steering(options: CaptureOptions, reader: Reader) -> None:
    steered = "--follow-baud" if options.follow_baud else "--baud auto" if options.formats else ""
    if steered and isinstance(reader, Distant):
        raise PortError(f"{reader.name}: the rate is set there: give {steered} to `sistap serve`, not here")


def _sink(options: CaptureOptions, readers: list[Reader], output: Output, counters: Counters) -> Sink:
    if not options.file:
        return TextSink(output)
    return PcapngWriter(output, {reader.line: _interface(options, reader) for reader in readers}, counters)


def _conditions(options: CaptureOptions, only: Filter | None) -> Conditions:
    duration_s = options.autostop.get("duration")
    return Conditions(options.framing, only, options.count, duration_s, options.formats, options.follow_baud)


def _interface(options: CaptureOptions, reader: Reader) -> Interface:
    settings = str(reader.settings) if options.baud else "rate by --baud auto"
    return Interface(
        LINK_TYPES[options.link_type],
        reader.name,
        f"{settings}; {reader.timing}",
        reader.settings.baud if options.baud else 0,
        reader.adapter,
        options.filter or "",
    )


def _summary(written: Counters, received: int, output: Output) -> str:
    """Say what is in the file, not what was heard: a filter, or a full disk, keeps some of that out."""
    records = written.received.total()
    of_received = f" of {received}" if records != received else ""
    return (
        f"{records}{of_received} records ({written.telegrams} telegrams, {written.characters} characters, "
        f"{written.errors}) written to {output.summary}"
    )
