# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap capture`: its options, and what they set up."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from contextlib import ExitStack, closing
from typing import Any, NamedTuple

from sistap.capture.filter import Filter, FilterError
from sistap.capture.remote import Remote
from sistap.capture.scan import FORMATS
from sistap.capture.session import Capture, Conditions, Sink
from sistap.files.output import Limits, Output, OutputRefused
from sistap.files.pcapng import Interface
from sistap.files.writer import LINK_TYPES, UPPER_PDU, PcapngWriter
from sistap.line import ports, priority
from sistap.line.reader import Reader, open_reader
from sistap.line.settings import LineSettings
from sistap.records.counters import Counters
from sistap.records.record import Record, Type
from sistap.records.text import lines
from sistap.sis.rates import RATES
from sistap.terminal.console import Audience, Console
from sistap.terminal.stop import Stop
from sistap.terminal.streams import STANDARD_OUTPUT

LARGEST = 1e12  # of any number in an option: 30,000 years of seconds
LARGEST_RATE = 0xFFFFFFFF  # that a record can hold
ONE_LINE, BOTH_LINES = (0,), (1, 2)  # their numbers: a shared bus, the directions of a full-duplex line

DESCRIPTION = """\
Listen to a serial line and record every character with its time: telegrams of the SIS protocol, and whatever else is on
the line, into a pcapng file for Wireshark, or as lines of text. The port is never written to.
"""

EPILOG = """\
A PORT is a device (/dev/ttyUSB0; `sistap ports` lists them), a virtual bus (bus://HOST:PORT), or a URL of pyserial
(socket://HOST:PORT, rfc2217://HOST:PORT), which knows the times less well.

With --baud auto, all rates from 9600 to 115200 Bd are tried, and 8E1 and 8N1 unless --format says which, until a valid
telegram comes; what is read on the way is kept. A silent line is searched without end. With --follow-baud the rate
changes when the bus is told so (service 0x03), also for the time of a timed test; if then nothing valid comes, a line
says so, and with --baud auto, too, the search begins again.

RS422 and RS232 have a line for each direction: tap both, each with a port of its own, and give -i twice. Line 1 is the
first, line 2 the second. Their records are in one file, in the order in which they began; for that a record waits while
an older telegram is still coming in on the other line, half a second at most.

A capture filter is written as for tcpdump and sees the plain telegram: link[5] is the service, link[6] the sender
address, link[7] the receiver address. Other characters and events always pass.

examples:
  sistap capture -i /dev/ttyUSB0                               a line of text for each telegram
  sistap capture -i /dev/ttyUSB0 -w - | wireshark -k -i -      live in Wireshark
  sistap capture -i /dev/ttyUSB0 --baud auto                   whatever rate the bus has
  sistap capture -i /dev/ttyUSB0 -i /dev/ttyUSB1 -w x.pcapng   both directions of an RS422 line
  sistap capture -i /dev/ttyUSB0 -w day.pcapng -b duration:3600 -b files:24
                                                               the last 24 hours, a file for each
  sistap capture -i /dev/ttyUSB0 -w x.pcapng -f 'link[5] == 0x1f'
                                                               only telegrams that write a parameter

exit status:
  0  done; also when stopped by Ctrl-C, SIGTERM, or the end of the terminal
  1  failed while running (port lost, disk full): what came before is saved
  2  wrong usage, wrong filter, or a FILE that cannot be written
  3  the port cannot be opened
"""


class LineSink:
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


class Refused(Exception):
    """Options that do not go together; str() is the one line to show."""


class _Once(argparse.Action):
    """An option that, given twice, would silently lose one of its values."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, value: Any, option: str | None = None
    ) -> None:
        if not value:
            parser.error(f"{option} needs a {self.metavar}")
        if getattr(namespace, self.dest) is not None:
            parser.error(f"{option} can be given only once: start a capture for each {self.metavar}")
        setattr(namespace, self.dest, value)


class _Ports(argparse.Action):
    """One port, or two for the two directions of a line."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, value: Any, option: str | None = None
    ) -> None:
        if not value:
            parser.error(f"{option} needs a {self.metavar}")
        ports = [*(namespace.ports or []), value]
        if len(ports) > len(BOTH_LINES):
            parser.error(f"{option} can be given once, or twice for the two directions of a line")
        namespace.ports = ports


def _positive(kind: Callable[[str], float], text: str) -> float:
    value = kind(text)
    if not 0 < value <= LARGEST:
        raise ValueError
    return value


def _number(text: str) -> int:
    try:
        return int(_positive(int, text))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number from 1 to {LARGEST:.0f}") from None


def _rate(text: str) -> int | None:
    """Read a rate; None is auto."""
    if text == "auto":
        return None
    try:
        if 0 < (rate := int(text)) <= LARGEST_RATE:
            return rate
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is neither auto nor a rate from 1 to {LARGEST_RATE} Bd")


def _condition(text: str) -> tuple[str, float]:
    name, _, value = text.partition(":")
    try:
        return name, _positive({"duration": float, "filesize": int, "files": int}[name], value)
    except (KeyError, ValueError):
        raise argparse.ArgumentTypeError(f"'{text}' is not duration:SECONDS, filesize:KB or files:NUMBER") from None


def _framing(text: str) -> float | None:
    if text == "sis":
        return None
    name, _, value = text.partition(":")
    try:
        if name == "silence":
            return _positive(float, value)
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is not sis or silence:MILLISECONDS")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    add = parser.add_argument
    add(
        "-i",
        dest="ports",
        action=_Ports,
        metavar="PORT",
        required=True,
        help="the port to listen to; given twice, the two directions of an RS422 or RS232 line, line 1 and line 2",
    )
    add(
        "-w",
        dest="file",
        action=_Once,
        metavar="FILE",
        help="write a pcapng file; - is standard output. Without it, print text",
    )
    add(
        "--baud",
        type=_rate,
        default=9600,
        metavar="RATE|auto",
        help="rate in Bd (9600); auto: look for it, and without --format also whether it is 8E1 or 8N1",
    )
    add("--format", metavar="FORMAT", help="data bits, parity N, E, O, M or S, stop bits (8E1)")
    add("--follow-baud", action="store_true", help="when the bus is told another rate, go with it")
    add(
        "--framing",
        dest="silence_ms",
        type=_framing,
        metavar="sis|silence:MS",
        help="cut SIS telegrams (the default), or, for another protocol, frames with so much silence between them",
    )
    add(
        "--link-type",
        choices=LINK_TYPES,
        default=UPPER_PDU,
        metavar="TYPE",
        help="upper-pdu (the default) has everything; rtac and user0 .. user15 have only telegrams, for other tools",
    )
    add(
        "-c",
        dest="count",
        type=_number,
        metavar="N",
        help="stop after N records; the event that starts a file is not counted",
    )
    add(
        "-a",
        dest="autostop",
        type=_condition,
        action="append",
        default=[],
        metavar="CONDITION",
        help="stop after duration:SECONDS, filesize:KB (1000 bytes) or files:NUMBER",
    )
    add(
        "-b",
        dest="ring",
        type=_condition,
        action="append",
        default=[],
        metavar="CONDITION",
        help="begin a new file after duration:SECONDS or filesize:KB; files:NUMBER: keep only the newest",
    )
    add("-f", dest="filter", metavar="FILTER", help="write only telegrams that pass this capture filter")
    add("-q", dest="quiet", action="store_true", help="do not show progress")


def run(args: argparse.Namespace) -> int:
    """Capture as told; give the exit code. May raise PortError."""
    stop = Stop.current()
    console = Console()
    try:
        plan = checked(args)
        output = Output(args.file or STANDARD_OUTPUT, _limits(args), lambda: stop.asked, console.say)
    except (Refused, FilterError, OutputRefused) as error:
        console.alarm(str(error))
        return 2
    with closing(output):
        return record(args, plan, output, stop, console)


class Plan(NamedTuple):
    """What options come to."""

    settings: LineSettings  # to begin with
    only: Filter | None


def checked(args: argparse.Namespace) -> Plan:
    """Check the options that do not concern the output; may raise Refused or FilterError."""
    settings = _settings(args)
    _check_ports(args)
    return Plan(settings, Filter(args.filter) if args.filter else None)


@priority.real_time()
def record(  # noqa: PLR0913 - it puts the parts together
    args: argparse.Namespace, plan: Plan, output: Output, stop: Stop, console: Audience, remote: Remote | None = None
) -> int:
    """Capture into `output`, perhaps controlled by `remote`; give the exit code. May raise PortError."""
    with ExitStack() as opened:
        readers: list[Reader] = []
        for line, port in zip(BOTH_LINES if len(args.ports) > 1 else ONE_LINE, args.ports, strict=True):
            readers.append(open_reader(port, plan.settings, line))
            opened.callback(readers[-1].close)
        counters = Counters()
        capture = Capture(
            readers,
            _sink(args, readers, output, counters),
            output,
            counters,
            console,
            _conditions(args, plan.only),
            quiet=args.quiet,
            progress=bool(args.file) and not args.quiet and console.shows_progress,
            remote=remote,
        )
        code = capture.run(stop)
    if args.file:
        console.say(_summary(counters, output))
    elif not args.quiet:
        console.say(str(counters))
    return code


def _settings(args: argparse.Namespace) -> LineSettings:
    """Give the settings to begin with."""
    fixed = [port for port in args.ports if port.startswith("socket://")]
    steered = "--baud auto" if args.baud is None else "--follow-baud" if args.follow_baud else ""
    if steered and args.silence_ms is not None:
        raise Refused(f"{steered} needs SIS telegrams: leave out --framing or {steered}")
    if steered and fixed:
        raise Refused(f"{steered} cannot change the rate behind {fixed[0]}: set it there, and leave out {steered}")
    try:
        return LineSettings.parse(args.baud or RATES[0], args.format or FORMATS[0])
    except ValueError as error:
        raise Refused(str(error)) from error


def _limits(args: argparse.Namespace) -> Limits:
    """Check what -w, -a and -b say together; they mean what they mean in dumpcap."""
    autostop, ring = dict(args.autostop), dict(args.ring)
    size = ring.get("filesize", autostop.get("filesize"))
    if args.file is None and (size or ring or args.link_type != UPPER_PDU):
        raise Refused("-a filesize:, -b and --link-type need a file: say it with -w")
    if args.file == STANDARD_OUTPUT and ring:
        raise Refused("-b needs files: standard output is only one")
    if args.file == STANDARD_OUTPUT and os.isatty(1):
        raise Refused("a terminal cannot show a pcapng file: add | wireshark -k -i - or leave out -w")
    if ring and not size and "duration" not in ring:
        raise Refused("-b files: does not say when a file is full: add -b duration:SECONDS or -b filesize:KB")
    if "files" in autostop and not ring:
        raise Refused("-a files: needs several files: add -b duration:SECONDS or -b filesize:KB")
    return Limits(
        size=int(size) * 1000 if size else None,
        duration_s=ring.get("duration"),
        several=bool(ring),
        keep=ring.get("files"),
        files=autostop.get("files"),
    )


def _check_ports(args: argparse.Namespace) -> None:
    """Refuse a port that something would be written to, and one port for both lines."""
    for port in args.ports:
        if args.file and ports.is_same_file(args.file, port):
            raise Refused(f"{args.file} is the port itself, which is never written to: choose a file with -w")
        if ports.is_own_terminal(port):
            raise Refused(f"{port} is the terminal that sistap itself reads or writes: choose another port with -i")
    first, last = args.ports[0], args.ports[-1]
    if len(args.ports) > 1 and (first == last or ports.is_same_file(first, last)):
        raise Refused(f"{last} is the same port again: the second -i is the port of the other direction")


def _sink(args: argparse.Namespace, readers: list[Reader], output: Output, counters: Counters) -> Sink:
    if not args.file:
        return LineSink(output)
    return PcapngWriter(output, {reader.line: _interface(args, reader) for reader in readers}, counters)


def _conditions(args: argparse.Namespace, only: Filter | None) -> Conditions:
    formats = () if args.baud else (args.format,) if args.format else FORMATS
    duration_s = dict(args.autostop).get("duration")
    return Conditions(args.silence_ms, only, args.count, duration_s, formats, args.follow_baud)


def _interface(args: argparse.Namespace, reader: Reader) -> Interface:
    settings = str(reader.settings) if args.baud else "rate by --baud auto"
    return Interface(
        LINK_TYPES[args.link_type],
        reader.name,
        f"{settings}; {reader.timing}",
        args.baud or 0,
        reader.adapter,
        args.filter or "",
    )


def _summary(counters: Counters, output: Output) -> str:
    received = counters.received.total()
    of_received = f" of {received}" if counters.written != received else ""
    return (
        f"{counters.written}{of_received} records ({counters.telegrams} telegrams, {counters.characters} characters, "
        f"{counters.errors}) written to {output.summary}"
    )
