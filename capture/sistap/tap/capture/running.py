# SPDX-License-Identifier: GPL-2.0-or-later
"""One capture, from its options to its exit code: opens the ports, puts the parts together, says what was written."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager, suppress
from typing import Protocol

from sistap.tap.capture.filter import Filter
from sistap.tap.capture.options import CaptureOptions, Plan
from sistap.tap.capture.session import Capture
from sistap.tap.capture.tap import Conditions, Sink
from sistap.tap.files.output import Output, OutputError
from sistap.tap.files.pcapng import LINK_TYPES, UPPER_PDU, Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.line import drivers, priority
from sistap.tap.line.clock import CLOCK
from sistap.tap.line.reader import PortError, Reader, open_reader
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Event, Record, event
from sistap.tap.terminal.console import Audience
from sistap.tap.terminal.stop import Stop

PAUSE_S = 1.0


class Ports:
    """The ports of a capture: opened at its start, and again when they come back, if it waits for them."""

    def __init__(self, options: CaptureOptions) -> None:
        self._options = options
        self._open: list[Reader] = []

    def open(self, settings: LineSettings, say: Callable[[str], None]) -> list[Reader]:
        """Open all ports. May raise PortError; a capture that waits for ports ends only by Stopped."""
        for line, port in zip(self._options.lines, self._options.ports, strict=True):
            said = ""
            while True:
                try:
                    reader = open_reader(port, settings, line)
                    break
                except PortError as error:
                    if not self._options.wait_for_port:
                        raise
                    if str(error) != said:
                        said = str(error)
                        say(f"{said}. Waiting for it")
                time.sleep(PAUSE_S)
            self._open.append(reader)
        return list(self._open)

    def reopen(self, lost: Reader, settings: LineSettings) -> Reader:
        """Open a port again. PortError while it is not back."""
        if lost in self._open:  # its device gets the same name only after the old one is closed
            self._open.remove(lost)
            lost.close()
        reader = open_reader(lost.name, settings, lost.line)
        self._open.append(reader)
        return reader

    def close(self) -> None:
        """Close all ports."""
        while self._open:
            self._open.pop().close()


Interfaces = Mapping[int, Interface]


class Destination(Sink, Protocol):
    """A sink that can say what became of the records."""

    def summary(self, counters: Counters) -> str:
        """Return it in words; `counters` have what was heard."""


Opener = Callable[[Interfaces, Output, Counters, Audience], AbstractContextManager[Destination]]


class _CountingFile(PcapngWriter):
    """A file that counts the records in it."""

    def __init__(self, output: Output, interfaces: Interfaces, counters: Counters) -> None:
        super().__init__(output, interfaces, counters)
        self._written = Counters()
        self._written.errors_reported = counters.errors_reported

    def write(self, record: Record) -> bool:
        written = super().write(record)
        if written:
            self._written.add_read(record)
            self._written.add_record(record)
        return written

    def summary(self, counters: Counters) -> str:
        """Say what is in the file, not what was heard: a filter, or a full disk, keeps some of that out."""
        received, records = counters.received.total(), self._written.received.total()
        of_received = f" of {received}" if records != received else ""
        return f"{records}{of_received} records ({self._written.text}) {self.output.written}"


@contextmanager
def _file(interfaces: Interfaces, output: Output, counters: Counters, _: Audience) -> Iterator[Destination]:
    yield _CountingFile(output, interfaces, counters)


@contextmanager
def _text(interfaces: Interfaces, output: Output, _: Counters, console: Audience) -> Iterator[Destination]:
    # The only import from outside of the tap: a capture into a file needs neither text nor tshark.
    from sistap.dissected.explain.live import explained

    with explained(output, interfaces, console.say) as text:
        yield text


@priority.real_time()
def record(  # noqa: PLR0913 - it puts the parts together
    options: CaptureOptions,
    plan: Plan,
    output: Output,
    stop: Stop,
    console: Audience,
    remote: Callable[[Capture], None] | None = None,
    *,
    opener: Opener | None = None,
) -> int:
    """Capture into `output`, perhaps controlled by `remote`; return the exit code. May raise PortError.

    `opener` opens another destination than a file or text.
    """
    opener = opener or (_file if options.file else _text)
    with ExitStack() as opened:
        ports = opened.enter_context(closing(Ports(options)))
        readers = ports.open(plan.settings, console.say)
        counters = Counters()
        counters.errors_reported = any(drivers.reports(reader.timing) is not False for reader in readers)
        interfaces = {reader.line: _interface(options, reader) for reader in readers}
        sink = opened.enter_context(opener(interfaces, output, counters, console))
        capture = Capture(
            readers,
            sink,
            output,
            counters,
            console,
            conditions(options, plan.only),
            quiet=options.quiet,
            progress=bool(options.file) and not options.quiet,
            remote=remote,
            reopen=ports.reopen if options.wait_for_port else None,
        )
        with output.lasting():
            code = capture.run(stop)
    if options.file or not options.quiet:
        console.say(sink.summary(counters))
    return code


def begin_in_vain(output: Output, name: str, why: str) -> None:
    """Write a capture that only says why there is none: Wireshark would blame the pipe."""
    interface = Interface(LINK_TYPES[UPPER_PDU], name)
    with suppress(OutputError):  # Wireshark may be gone
        PcapngWriter(output, {0: interface}, Counters()).begin(
            event(CLOCK.now_ns(), 0, LineSettings(baud=0), Event.MARKER, why)
        )


def conditions(options: CaptureOptions, only: Filter | None) -> Conditions:
    """Return what a capture with these options accepts, and when it ends."""
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
