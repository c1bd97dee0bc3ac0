# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap capture`: its options."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NoReturn

from sistap.tap.capture.options import BOTH_LINES, CaptureOptions, checked, rate
from sistap.tap.files.output import Output, OutputRefused
from sistap.tap.files.pcapng import LINK_TYPES, UPPER_PDU
from sistap.tap.line import ports
from sistap.tap.records.cut import HELP, SIS, WORDS, Cut
from sistap.tap.sis.limits import milliseconds
from sistap.tap.terminal.advice import advice
from sistap.tap.terminal.console import STANDARD_OUTPUT, Console
from sistap.tap.terminal.exits import USAGE, Refusal, argument
from sistap.tap.terminal.stop import Stop
from sistap.tap.terminal.writing import FORCE

if TYPE_CHECKING:
    from sistap.tap.capture.running import Opener

LARGEST = 1e12  # of any number in an option: 30,000 years of seconds

DESCRIPTION = """\
Listen to a bus and record every character with its time. Write a pcapng file for Wireshark, or lines of text. sistap
never writes to the port.
"""

EPILOG = """\
A PORT is one of these:
  /dev/ttyUSB0, COM5            a device; `sistap ports` lists them
  bus://HOST:PORT               a virtual bus (`sistap bus`)
  sigrok:fx2lafw?rx=D0          a logic analyser that sigrok-cli can read, with times exact to a microsecond
  socket://HOST:PORT            a URL of pyserial, also rfc2217://HOST:PORT; its times are less exact

Connect the bus to channel D0 of a logic analyser. Add &tx=D1 if the other direction is at D1. Add &samplerate=8m for 8
million samples a second (default 4). Add &invert=rx, tx or both if the signal is low while nothing is sent. If there
are several analysers, choose one with fx2lafw:conn=BUS.ADDRESS (from `sistap ports`).

--baud auto tries all rates from 9600 to 115200 Bd until a valid telegram comes. Without --format, it tries 8E1 and 8N1
at each rate. It records what it reads during the search. On a silent bus the search does not end.

--follow-baud changes the rate of the tap when the bus changes its rate (service 0x03), also for a timed test. If no
valid telegram follows, a message says so. With --baud auto as well, the search then begins again.

RS422 and RS232 have wires for each direction. Connect a port to each direction, and give -i twice. In the capture, line
1 is the first port and line 2 the second. Both are in one file, in the order in which their telegrams began. A record
may wait up to half a second for an older telegram of the other direction.

A capture filter has the syntax of tcpdump. It sees the bytes of the telegram: link[5] is the service, link[6] the
sender address, link[7] the receiver address. Other characters (outside of telegrams) and events are always written.

A master sets the limits TzA and TrS when it starts the bus. A tap that joins later does not hear them, and without
limits Wireshark cannot judge times. Give the limits with --tza and --trs. The capture stores them. They apply until the
bus itself sets others.

With --framing 3964r the tap records procedure 3964R: each handshake character (STX, DLE, NAK), and blocks with their
BCC (check character). A filter then sees the block. --baud auto and --follow-baud do not work then.

Without -w, each record is shown as `sistap log` shows it: time, bytes, and their meaning. The meaning comes from tshark
with Wireshark's dissector. Without tshark, there is one line of text for each telegram. A terminal shows colours,
unless NO_COLOR is set.

examples:
  sistap capture -i /dev/ttyUSB0                               each telegram with its meaning
  sistap capture -i /dev/ttyUSB0 -w - | wireshark -C SIS -k -i -
                                                               live in Wireshark
  sistap capture -i bus://127.0.0.1:5000 -w x.pcapng           a virtual bus
  sistap capture -i /dev/ttyUSB0 --baud auto                   find the rate
  sistap capture -i /dev/ttyUSB0 -i /dev/ttyUSB1 -w x.pcapng   both directions of RS422
  sistap capture -i /dev/ttyUSB0 -i /dev/ttyUSB1 --framing 3964r -w x.pcapng
                                                               an S5 and a PPC over 3964R, both directions
  sistap capture -i /dev/ttyUSB0 -w day.pcapng -b duration:3600 -b files:24
                                                               the last 24 hours, one file for each hour
  sistap capture -i 'sigrok:fx2lafw?rx=D0' -w x.pcapng         a logic analyser
  sistap capture -i /dev/ttyUSB0 -w x.pcapng -f 'link[5] == 0x1f'
                                                               only telegrams that write a parameter

exit status:
  0  done; also when stopped by Ctrl-C, SIGTERM, or the end of the terminal
  1  failed while running (port lost, disk full): what came before is saved
  2  wrong usage, wrong filter, or a FILE that cannot be written
  3  the port cannot be opened
"""


class Once(argparse.Action):
    """An option that may be given only once: argparse would silently drop the first value."""

    def __call__(  # noqa: D102 - as argparse demands
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
        named = [*(namespace.ports or []), ports.short(value)]
        if len(named) > len(BOTH_LINES):
            parser.error(f"{option} can be given once, or twice for the two directions of RS422 or RS232")
        namespace.ports = named


def _positive(kind: Callable[[str], float], text: str) -> float:
    value = kind(text)
    if not 0 < value <= LARGEST:
        raise ValueError
    return value


def number(text: str) -> int:
    """Read a whole number above 0 as an argument."""
    try:
        return int(_positive(int, text))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number from 1 to {LARGEST:.0f}") from None


def _condition(text: str) -> tuple[str, float]:
    if text.isdigit() or text == "auto":
        raise argparse.ArgumentTypeError(f"for the rate, write --baud {text}; -b says when the next file begins")
    name, _, value = text.partition(":")
    try:
        return name, _positive({"duration": float, "filesize": int, "files": int}[name], value)
    except (KeyError, ValueError):
        raise argparse.ArgumentTypeError(f"'{text}' is not duration:SECONDS, filesize:KB or files:NUMBER") from None


class _Moved(argparse.Action):
    """An option of the recorder."""

    def __call__(self, parser: argparse.ArgumentParser, _: object, __: object, option: str | None = None) -> NoReturn:
        parser.exit(USAGE, f"sistap: {option} is for `sistap record`: write that for `sistap capture`\n")


def add_line_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments that say what to listen to."""
    add = parser.add_argument
    add(
        "-i",
        dest="ports",
        action=_Ports,
        metavar="PORT",
        help="the port to listen to (default: the only one there is); give it twice for the two directions of RS422 or "
        "RS232",
    )
    add(
        "--baud",
        type=argument(rate),
        default=9600,
        metavar="RATE|auto",
        help="rate in Bd (default 9600); auto finds it, and without --format also whether it is 8E1 or 8N1",
    )
    add("--format", metavar="FORMAT", help="data bits, parity N, E, O, M or S, stop bits (default 8E1)")
    add("--follow-baud", action="store_true", help="follow rate changes on the bus")
    add("--framing", type=argument(Cut.parse), default=SIS, metavar=WORDS, help=HELP)
    add("--wait-for-port", action="store_true", help="wait for a port that is missing, at the start and later")
    for limit, text in (
        ("tza", "TzA of this bus: longest interval allowed between two characters of a telegram"),
        ("trs", "TrS of this bus: longest reaction time allowed"),
    ):
        add(f"--{limit}", dest=f"{limit}_ms", type=argument(milliseconds), metavar="MS", help=text)


def add_end_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments that say what is written, and when a file or the capture ends."""
    add = parser.add_argument
    add(
        "-c",
        dest="count",
        type=number,
        metavar="N",
        help="stop after N records; the event that starts a file is not counted",
    )
    for option, name, text in (
        ("-a", "autostop", "stop after duration:SECONDS, filesize:KB (1000 bytes) or files:NUMBER"),
        ("-b", "ring", "begin a new file after duration:SECONDS or filesize:KB; files:NUMBER: keep only the newest"),
    ):
        add(option, dest=name, type=_condition, action="append", default=[], metavar="CONDITION", help=text)
    add("-f", dest="filter", metavar="FILTER", help="write only telegrams that pass this capture filter")
    add("-q", dest="quiet", action="store_true", help="do not show progress")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add_line_arguments(parser)
    add(
        "-w",
        dest="file",
        action=Once,
        metavar="FILE",
        help="write a pcapng file; - is standard output (default: print text)",
    )
    add("--force", action="store_true", help=FORCE)
    add(
        "--link-type",
        choices=LINK_TYPES,
        default=UPPER_PDU,
        metavar="TYPE",
        help="upper-pdu (default) keeps everything; rtac and user0 to user15 keep only telegrams, for other tools",
    )
    add("--keep", action=_Moved, help=argparse.SUPPRESS)
    add("--compress", action=_Moved, nargs=0, help=argparse.SUPPRESS)
    add_end_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Capture; return the exit code."""
    with _told_in_pipe(args.file):
        options = replace(options_of(args, args.file), link_type=args.link_type)
        return started(options, Console(), force=args.force)


@contextmanager
def _told_in_pipe(file: str | None) -> Iterator[None]:
    """Tell whoever reads standard output why there is no capture, too."""
    try:
        yield
    except Refusal as refusal:
        if file == STANDARD_OUTPUT:
            from sistap.tap.capture.running import begin_in_vain

            with suppress(OutputRefused), closing(Output(file)) as output:
                begin_in_vain(output, "sistap", str(refusal))
        raise


def started(options: CaptureOptions, console: Console, opener: Opener | None = None, *, force: bool = False) -> int:
    """Capture into the file of the options, or where `opener` says; return the exit code."""
    from sistap.tap.capture.running import record  # late: help needs none of it

    stop = Stop.current()
    plan, limits = checked(options), options.limits
    with closing(Output(options.output, limits, lambda: stop.asked, console.say, force=force)) as output:
        return record(options, plan, output, stop, console, opener=opener)


def _only_port() -> list[str]:
    """Return the port if there is exactly one. Otherwise raise Refusal."""
    found = [port for port, _ in ports.found()]
    if len(found) == 1:
        return found
    if found:
        raise Refusal(f"there are {len(found)} ports: name one with -i ({', '.join(found)})")
    raise Refusal(f"no serial port found: plug the adapter in, or name a PORT with -i; {advice().no_port}")


def options_of(args: argparse.Namespace, file: str | None) -> CaptureOptions:
    """Return the options of a capture into a file. May raise Refusal."""
    return CaptureOptions(
        ports=tuple(args.ports or _only_port()),
        file=file,
        baud=args.baud,
        format=args.format,
        follow_baud=args.follow_baud,
        framing=args.framing,
        count=args.count,
        autostop=dict(args.autostop),
        ring=dict(args.ring),
        filter=args.filter,
        tza_ms=args.tza_ms,
        trs_ms=args.trs_ms,
        wait_for_port=args.wait_for_port,
        quiet=args.quiet,
    )
