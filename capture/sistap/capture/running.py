# SPDX-License-Identifier: GPL-2.0-or-later
"""One capture, from its options to its exit code: opens the ports, puts the parts together, says what was written."""

from __future__ import annotations

from contextlib import ExitStack, closing

from sistap.capture import sinks
from sistap.capture.filter import Filter
from sistap.capture.options import CaptureOptions, Plan
from sistap.capture.ports import Ports
from sistap.capture.remote import Remote
from sistap.capture.session import Capture, Conditions
from sistap.capture.tap import Sink
from sistap.files.output import Output
from sistap.files.pcapng import Interface
from sistap.files.writer import LINK_TYPES
from sistap.line import priority
from sistap.line.reader import Reader
from sistap.recorder.recorder import Recorder
from sistap.records.counters import Counters
from sistap.records.record import Record, Type
from sistap.terminal.console import Audience
from sistap.terminal.stop import Stop


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
        ports = opened.enter_context(closing(Ports(options)))
        readers = ports.open(plan.settings, console.say)
        counters = Counters()
        interfaces = {reader.line: _interface(options, reader) for reader in readers}
        sink = opened.enter_context(sinks.opened(options, interfaces, output, counters, console))
        tally = Tally(sink)
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
            reopen=ports.reopen if options.wait_for_port else None,
        )
        with output.lasting():
            code = capture.run(stop)
    if isinstance(sink, Recorder):
        console.say(f"{counters}; {sink.summary}")
    elif options.file:
        console.say(_summary(tally.written, counters.received.total(), output))
    elif not options.quiet:
        console.say(str(counters))
    return code


def _conditions(options: CaptureOptions, only: Filter | None) -> Conditions:
    duration_s = options.autostop.get("duration")
    return Conditions(
        options.framing, only, options.count, duration_s, options.formats, options.follow_baud, options.limits_told
    )


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
    return f"{records}{of_received} records ({written.text}) {output.written}"
