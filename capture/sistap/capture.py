# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap capture`: its options, and what they set up."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from typing import Any

from sistap import ports, priority
from sistap.bpf import Filter, FilterError
from sistap.console import Console
from sistap.counters import Counters
from sistap.line import LineSettings
from sistap.lines import lines
from sistap.output import STANDARD_OUTPUT, Limits, Output, OutputRefused
from sistap.pcapng import Interface
from sistap.reader import Reader, open_reader
from sistap.record import Record, Type
from sistap.session import Capture, Conditions, Sink, Stop
from sistap.writer import LINK_TYPES, UPPER_PDU, PcapngWriter

LARGEST = 1e12  # of any number in an option: 30,000 years of seconds
LARGEST_RATE = 0xFFFFFFFF

DESCRIPTION = """\
Listen to a serial line and record every character with its time: telegrams of the SIS protocol, and whatever else is on
the line, into a pcapng file for Wireshark, or as lines of text. The port is never written to.
"""

EPILOG = """\
A PORT is a device (/dev/ttyUSB0; `sistap ports` lists them), a virtual bus (bus://HOST:PORT), or a URL of pyserial
(socket://HOST:PORT, rfc2217://HOST:PORT), which knows the times less well.

A capture filter is written as for tcpdump and sees the plain telegram: link[5] is the service, link[6] the sender
address, link[7] the receiver address. Other characters and events always pass.

examples:
  sistap capture -i /dev/ttyUSB0                               a line of text for each telegram
  sistap capture -i /dev/ttyUSB0 -w - | wireshark -k -i -      live in Wireshark
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

    def begin(self, started: Record) -> None:
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


def _rate(text: str) -> int:
    rate = _number(text)
    if rate > LARGEST_RATE:
        raise argparse.ArgumentTypeError(f"{text} Bd are more than a record can hold ({LARGEST_RATE})")
    return rate


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
    add("-i", dest="port", action=_Once, metavar="PORT", required=True, help="the port to listen to")
    add(
        "-w",
        dest="file",
        action=_Once,
        metavar="FILE",
        help="write a pcapng file; - is standard output. Without it, print text",
    )
    add("--baud", type=_rate, default=9600, metavar="RATE", help="rate in Bd (9600)")
    add("--format", default="8E1", metavar="FORMAT", help="data bits, parity N, E, O, M or S, stop bits (8E1)")
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


@priority.real_time()
def run(args: argparse.Namespace) -> int:
    """Capture as told; give the exit code. May raise PortError."""
    stop = Stop()
    console = Console()
    try:
        settings = _settings(args)
        limits = _limits(args)
        only = Filter(args.filter) if args.filter else None
        _check_port(args)
        output = Output(args.file or STANDARD_OUTPUT, limits, lambda: stop.requested, console.say)
    except (Refused, FilterError, OutputRefused) as error:
        console.say(str(error))
        return 2
    try:
        reader = open_reader(args.port, settings)
    except BaseException:
        output.close()
        raise
    return _capture(args, reader, output, only, stop, console)


def _settings(args: argparse.Namespace) -> LineSettings:
    try:
        return LineSettings.parse(args.baud, args.format)
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


def _check_port(args: argparse.Namespace) -> None:
    """Refuse a port that something would be written to."""
    if args.file and ports.is_same_file(args.file, args.port):
        raise Refused(f"{args.file} is the port itself, which is never written to: choose a file with -w")
    if ports.is_own_terminal(args.port):
        raise Refused(f"{args.port} is the terminal that sistap itself reads or writes: choose another port with -i")


def _capture(  # noqa: PLR0913 - it puts the parts together
    args: argparse.Namespace, reader: Reader, output: Output, only: Filter | None, stop: Stop, console: Console
) -> int:
    counters = Counters()
    sink: Sink = LineSink(output)
    if args.file:
        sink = PcapngWriter(output, _interface(args, reader), counters)
    conditions = Conditions(args.silence_ms, only, args.count, dict(args.autostop).get("duration"))
    progress = bool(args.file) and not args.quiet and console.shows_progress
    try:
        capture = Capture(reader, sink, output, counters, console, conditions, quiet=args.quiet, progress=progress)
        code = capture.run(stop)
    finally:
        reader.close()
        output.close()
    if args.file:
        console.say(_summary(counters, output))
    elif not args.quiet:
        console.say(str(counters))
    return code


def _interface(args: argparse.Namespace, reader: Reader) -> Interface:
    settings = reader.settings
    return Interface(
        LINK_TYPES[args.link_type],
        reader.name,
        f"{settings.baud} Bd {settings.format}; {reader.timing}",
        settings.baud,
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
