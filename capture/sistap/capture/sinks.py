# SPDX-License-Identifier: GPL-2.0-or-later
"""The sinks of a capture: a file, a recorder, or text, with or without tshark's explanations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager

from sistap.capture import live
from sistap.capture.options import CaptureOptions
from sistap.capture.tap import Sink
from sistap.files.output import Output
from sistap.files.pcapng import Interface
from sistap.files.writer import PcapngWriter
from sistap.line import priority
from sistap.recorder.recorder import Recorder
from sistap.records.counters import Counters
from sistap.records.record import Record, Type
from sistap.records.text import lines
from sistap.terminal.console import Audience
from sistap.wireshark.tshark import Tshark, TsharkError


class PlainText:
    """Prints records as text, where there is no tshark."""

    def __init__(self, output: Output) -> None:
        """Print to `output`."""
        self._output = output

    def begin(self, *started: Record) -> None:
        """Print nothing: standard error has it."""

    def write(self, record: Record) -> bool:
        """Print a record at once, except an event, which goes to standard error."""
        if record.type == Type.EVENT:
            return False
        self._output.write(lines(record).encode())
        return True

    def look(self, time_ns: int) -> None:
        """Do nothing: there is only one output."""

    def end(self, time_ns: int) -> None:
        """Print nothing."""


def check(options: CaptureOptions) -> None:
    """Check the options of keeping before a port is opened. May raise UsageError or TsharkError."""
    if options.keep:
        with Tshark() as tshark:
            options.wanted.reasons.check(tshark)


@contextmanager
def opened(
    options: CaptureOptions,
    interfaces: Mapping[int, Interface],
    output: Output,
    counters: Counters,
    console: Audience,
) -> Iterator[Sink]:
    """Return the sink that the options demand. A recorder may raise TsharkError."""
    with ExitStack() as stack:
        if options.keep:
            tshark = stack.enter_context(Tshark())
            ring = PcapngWriter(output, interfaces, counters) if options.ring else None
            recorder = Recorder(options.wanted, tshark, interfaces, console.say, ring=ring)
            stack.callback(recorder.close)
            yield recorder
        elif options.file:
            yield PcapngWriter(output, interfaces, counters)
        else:
            yield _text(interfaces, output, console, stack)


def _text(interfaces: Mapping[int, Interface], output: Output, console: Audience, stack: ExitStack) -> Sink:
    try:
        with priority.ordinary_children():
            tshark = stack.enter_context(Tshark())
            text = live.LiveText(output, tshark, interfaces, console.say, live.colours())
    except (TsharkError, OSError) as error:
        console.say(f"{error}. Until then telegrams are not explained")
        return PlainText(output)
    stack.callback(text.close)
    return text
