# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap serve`: its options, and how it runs."""

from __future__ import annotations

import argparse
import ipaddress
import os
from collections.abc import Sequence
from contextlib import closing

from sistap.commands.serve.listeners import EventSink, Listeners, PublishedReader
from sistap.tap.capture.options import CaptureOptions, checked, rate
from sistap.tap.capture.session import Capture
from sistap.tap.capture.tap import Conditions
from sistap.tap.files.output import Output
from sistap.tap.line import ports, priority
from sistap.tap.line.clock import CLOCK
from sistap.tap.line.reader import PortError, open_reader
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.counters import Counters
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.exits import USAGE, UsageError, argument
from sistap.tap.terminal.stop import Stop
from sistap.tap.wire.protocol import Hello, Kind
from sistap.tap.wire.server import Network, host_port, plain_ip

LISTEN = "127.0.0.1:5000"

DESCRIPTION = """\
Listen to a bus here and share it with other computers. There, `sistap capture -i bus://ADDRESS:PORT` receives every
character with its time, its errors, and rate and format. sistap never writes to the port, and no listener can change
anything here.
"""

EPILOG = """\
Programs of this computer may always listen. To admit others, choose another address with --listen and name them with
--allow. The network traffic is neither encrypted nor signed: use ssh or WireGuard.

Times come from this computer's clock. If a listener is too slow, or away for a while, sistap tells it how many
characters it missed. A slow listener never delays the tap.

examples:
  sistap serve -i /dev/ttyUSB0                             for this computer, and for others through ssh
  ssh -N -L 5000:127.0.0.1:5000 pi                         on the laptop: the bus is then at bus://127.0.0.1:5000
  sistap serve -i /dev/ttyUSB0 --listen 192.168.7.1:5000 --allow 192.168.7.0/24
                                                           for a private network
  sistap serve -i /dev/ttyUSB0 --baud auto --follow-baud   find the rate, and follow its changes

exit status:
  0  done: stopped by Ctrl-C, SIGTERM, or the end of the terminal
  1  the port was lost
  2  wrong usage
  3  the port cannot be opened, or sistap cannot listen at the address
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    add = parser.add_argument
    add_line(parser, is_needed=True)
    add("--listen", metavar="ADDRESS:PORT|PATH", default=LISTEN, help=f"where to wait for listeners ({LISTEN})")
    add(
        "--allow",
        dest="allowed",
        type=_network,
        action="append",
        default=[],
        metavar="ADDRESS/BITS",
        help="other computers that may listen, such as 192.168.7.0/24; may be given several times",
    )


def add_line(parser: argparse.ArgumentParser, *, is_needed: bool) -> None:
    """Declare the arguments that say which line is shared."""
    add = parser.add_argument
    add(
        "-i",
        dest="port",
        metavar="PORT",
        type=ports.short,
        required=is_needed,
        help="the port to listen to, written as for capture",
    )
    add("--baud", type=argument(rate), default=9600, metavar="RATE|auto", help="as capture's --baud (9600)")
    add("--format", metavar="FORMAT", help="as capture's --format (8E1)")
    add("--follow-baud", action="store_true", help="follow rate changes on the bus")
    add("-q", dest="quiet", action="store_true", help="do not show progress")


def line_of(args: argparse.Namespace) -> tuple[CaptureOptions, LineSettings]:
    """Return what these arguments say. May raise UsageError or ValueError."""
    options = CaptureOptions(
        ports=(args.port,), baud=args.baud, format=args.format, follow_baud=args.follow_baud, quiet=args.quiet
    )
    if args.port.startswith("bus://"):
        raise UsageError(f"{args.port} is already shared: pass it to `sistap capture`")
    return options, checked(options).settings


def run(args: argparse.Namespace) -> int:
    """Serve until a signal comes or the port is lost; return the exit code. May raise PortError."""
    console = Console()
    try:
        options, settings = line_of(args)
        _check_address(args.listen, args.allowed)
        listeners = Listeners(args.listen, args.allowed, console.say)
    except (UsageError, ValueError) as error:
        console.alarm(str(error))
        return USAGE
    except OSError as error:
        why = error.strerror or error
        raise PortError(f"cannot listen at {args.listen}: {why}; choose another address with --listen") from error
    with closing(listeners):
        return serve(options, settings, listeners, console)


@priority.real_time()
def serve(
    options: CaptureOptions, settings: LineSettings, listeners: Listeners, console: Console, name: str = ""
) -> int:
    """Serve a line until a signal comes or the port is lost; print `name`, or where the listeners are, when it begins.
    Return the exit code. May raise PortError.
    """
    with closing(open_reader(options.ports[0], settings)) as reader, closing(Output(os.devnull)) as output:
        about = (reader.name, reader.adapter, reader.timing, reader.notes)
        listeners.begin(Hello(Kind.TAP, 0, CLOCK.now_ns(), 0, *about), reader.settings)
        capture = Capture(
            [PublishedReader(reader, listeners)],
            EventSink(listeners),
            output,
            Counters(),
            console,
            Conditions(formats=options.formats, follow=options.follow_baud),
            quiet=options.quiet,
            progress=not options.quiet and console.shows_progress,
        )
        print(name or listeners.name, flush=True)
        return capture.run(Stop.current())


def _network(text: str) -> Network:
    try:
        return ipaddress.ip_network(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not ADDRESS/BITS, such as 192.168.7.0/24 for a network or 192.168.7.9/32 for one computer"
        ) from None


def _check_address(address: str, allowed: Sequence[Network]) -> None:
    """Refuse an address that others can reach if nobody is allowed to listen. Raise UsageError or ValueError."""
    if "/" in address:
        return
    host, _ = host_port(address)
    try:
        reachable = host != "localhost" and not plain_ip(host).is_loopback
    except ValueError:
        raise UsageError(f"--listen {address}: give an address of this computer, not a name") from None
    if reachable and not allowed:
        raise UsageError(
            f"--listen {address} can be reached from other computers: say which may listen with --allow ADDRESS/BITS"
        )
