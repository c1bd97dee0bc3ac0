# SPDX-License-Identifier: GPL-2.0-or-later
"""The place where a bus is played: a pseudo terminal, a socket or, if allowed, a port. Options, opening, playing."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from sisbus.playing.characters import Played
from sisbus.wires.port import PortWire, TransmittingPort
from sisbus.wires.wire import Log, Pace, Wire
from sistap.tap.line import ports
from sistap.tap.line.reader import PortError, PortLost
from sistap.tap.line.settings import LineSettings
from sistap.tap.terminal.advice import advice, shell_word
from sistap.tap.terminal.console import visible
from sistap.tap.terminal.exits import DONE, FAILED, PORT, Refusal

if TYPE_CHECKING:
    from sisbus.wires.pseudo_terminal import PseudoTerminalPort

ALL = 0xFFFF  # largest number of characters in a read
ANY_LOCAL = "127.0.0.1:0"  # any free port; only programs of this computer reach it


def add_arguments(parser: argparse.ArgumentParser) -> argparse._MutuallyExclusiveGroup:
    """Declare the options of the place; return the group for more such options."""
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--pty", action="store_true", help="play at a pseudo terminal and print its name (default)")
    where.add_argument(
        "--listen",
        metavar="HOST:PORT|PATH",
        help="play at a socket, for `sistap capture -i bus://...` (default on Windows)",
    )
    where.add_argument("--port", metavar="PORT", help="play at a real port; needs --transmit")
    parser.add_argument(
        "--transmit", action="store_true", help="allow sending on PORT; without it, sistap sends nothing there"
    )
    parser.add_argument("--fast", action="store_true", help="play as fast as the listener reads (with --listen)")
    return where


def settle(args: argparse.Namespace, *, has_ptys: bool = sys.platform != "win32") -> None:
    """Choose a socket if no place is given and there are no pseudo terminals. ValueError if one is requested."""
    if has_ptys:
        return
    if args.pty:
        raise ValueError("this system has no pseudo terminals: omit --pty")
    if not (args.listen or args.port or getattr(args, "file", None)):
        args.listen = ANY_LOCAL


def check(args: argparse.Namespace) -> None:
    """Check these options. ValueError says what is wrong and what to do."""
    if args.fast and not args.listen:
        raise ValueError("--fast needs --listen: a pseudo terminal and a port know only real time")
    if args.port and not args.transmit:
        raise ValueError(
            f"this would send on {args.port}, and could disturb a bus or move a machine: "
            "add --transmit if that is what you want"
        )
    if args.transmit and not args.port:
        raise ValueError("--transmit needs the port to send on: name it with --port")
    if args.port and ports.is_own_terminal(args.port):
        raise ValueError(f"{args.port} is the terminal that sistap itself reads or writes: choose another with --port")


def opened(args: argparse.Namespace, settings: LineSettings, pace: Pace, seed: int = 0, most: int = ALL) -> Wire:
    """Open the place that the options name; reads at a socket have `most` characters. May raise Refusal."""
    # Imported here: Windows has no pseudo terminals, and a pty needs no sockets.
    try:
        if args.listen:
            from sisbus.wires.taps import Taps

            return Taps(pace, args.listen, seed, most)
        if args.port:
            return PortWire(pace, args.port, settings)
        return _pseudo_terminal(pace, settings, seed)
    except ValueError as error:
        raise Refusal(f"--listen {error}") from error
    except OSError as error:
        cure = "choose another port (0: any free one) or PATH" if args.listen else advice().no_pseudo_terminal
        where = args.listen or "a pseudo terminal"
        raise Refusal(f"cannot listen at {where}: {error.strerror or error}; {cure}", PORT) from error


def port(args: argparse.Namespace, settings: LineSettings, seed: int) -> TransmittingPort | PseudoTerminalPort:
    """Open the connection for a real master. May raise Refusal."""
    if args.port:
        return TransmittingPort(args.port, settings)
    try:
        from sisbus.wires.pseudo_terminal import PseudoTerminalPort

        return PseudoTerminalPort(settings, seed)
    except ImportError as error:
        raise Refusal("this system has no pseudo terminals: use --port PORT --transmit", PORT) from error
    except OSError as error:
        raise Refusal(
            f"cannot open a pseudo terminal: {error.strerror}; {advice().no_pseudo_terminal}", PORT
        ) from error


def _pseudo_terminal(pace: Pace, settings: LineSettings, seed: int) -> Wire:
    try:
        from sisbus.wires.pseudo_terminal import PseudoTerminal
    except ImportError:
        raise OSError(0, "this system has none") from None
    return PseudoTerminal(pace, settings.baud, seed)


# -- Playing ---------------------------------------------------------------------------------------------------------


def play(wire: Wire, pace: Pace, telegrams: Iterable[Played], log: Log | None = None, about: str = "") -> None:
    """Play everything once somebody listens; `about` begins the log. May raise Refusal."""
    try:
        try:
            if wire.name:
                print(wire.name, flush=True)
                if not isinstance(wire, PortWire):
                    _say_what_to_type(wire.name)
            wire.wait_for_listener()
            if log:
                log.begin(f"{about}, time 0 is {pace.wall_ns()} ns since 1970")
            serve(wire, telegrams, log)
        finally:
            wire.close()
    except OSError as error:
        saved = "; the log has what was played before" if log else ""
        raise Refusal(f"the bus stopped: {error.strerror or error}{saved}", FAILED) from error


def _say_what_to_type(name: str) -> None:
    """Tell a person how to capture it; a program that reads standard output wants the name alone."""
    if sys.stdout.isatty():
        print(f"listen to it in another terminal: sistap capture -i {shell_word(name)}", file=sys.stderr)


def serve(wire: Wire, telegrams: Iterable[Played], log: Log | None) -> None:
    """Deliver everything to a wire whose bus has started. May raise OSError."""
    for played in telegrams:
        marks = wire.deliver(played)
        if log:
            log.add(played, marks)
        if wire.deserted:
            break


def refusing(command: str, play: Callable[[], None]) -> int:
    """Play; return the exit code. What the command refuses has its name; `sistap` says what is wrong with a port."""
    try:
        play()
    except (PortError, PortLost):
        raise
    except Refusal as refusal:
        print(f"sistap {command}: {visible(str(refusal))}", file=sys.stderr)
        return refusal.code
    return DONE
