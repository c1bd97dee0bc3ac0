# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap bus`: the command line of the virtual bus."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from sistap.bus.drive import Drive, Station, drive_parameters
from sistap.bus.master import DRIVES, ROUTE, commands
from sistap.bus.playing import NO_FAULTS, Faults, Played, Player, play
from sistap.bus.routing import Router
from sistap.bus.serve import Log, Pace, Wire, serve
from sistap.line import LineSettings
from sistap.rates import RATES

_DONE, _FAILED, _USAGE, _PORT = 0, 1, 2, 3


class _Stopped(Exception):
    """SIGINT or SIGTERM came."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `sistap bus`."""
    parser.description = "Play a SIS bus, a master (16) and two drives (3 and 4), when somebody starts to listen."
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--pty", action="store_true", help="at a pseudo terminal; its name is printed (default)")
    where.add_argument("--listen", metavar="HOST:PORT|PATH", help="at a socket, for `sistap capture -i bus://...`")
    parser.add_argument("--baud", type=int, default=9600, help="rate of the line (default 9600)")
    parser.add_argument("--format", default="8E1", help="character format (default 8E1)")
    parser.add_argument(
        "--rates",
        metavar="RATE,...",
        help="after each loop the master tests the next of these rates with a drive, then tells it to all of them; "
        "9600, 19200, 38400, 57600 or 115200",
    )
    parser.add_argument("--seed", type=int, default=1, help="same seed, same bus (default 1)")
    parser.add_argument(
        "--cycles", type=int, default=0, help="play the loop so often, then end (default: until stopped)"
    )
    parser.add_argument("--fast", action="store_true", help="do not wait for real time (with --listen)")
    parser.add_argument(
        "--reads", type=int, default=1, help="up to so many characters a read (with --listen; default 1)"
    )
    parser.add_argument(
        "--faults",
        metavar="NAME=P,...",
        help="probabilities: parity, break, loss and pause of a character, checksum of a telegram",
    )
    parser.add_argument("--log", type=Path, metavar="FILE", help="write a line for each telegram: time, bytes, faults")


def run(args: argparse.Namespace) -> int:
    """Play the bus until its end or a signal; gives the exit code."""
    try:
        settings, faults, rates = _checked(args)
    except ValueError as error:
        return _fail(_USAGE, str(error))
    try:
        log = Log(args.log) if args.log else None
    except OSError as error:
        return _fail(_USAGE, f"cannot write the log {args.log}: {error.strerror}; name another file with --log")
    with _stoppable():
        try:
            return _serve(args, settings, bus(settings, args.seed, args.cycles, faults, rates), log)
        except _Stopped:
            return _DONE
        finally:
            if log:
                log.close()


def bus(
    settings: LineSettings, seed: int = 1, cycles: int = 0, faults: Faults = NO_FAULTS, rates: Sequence[int] = ()
) -> Iterator[Played]:
    """Make the whole bus: everything that is sent on it, in order."""
    far_away = Drive(ROUTE[-1], "DKC01.3-040-7-FW", "FWA-ECODR3-SMT-02VRS-MS", drive_parameters(), seed)
    between = Router(Drive(ROUTE[0], "CLC-D02.3M-FW", "FWA-CLC*DP-SY*-06VRS-MS", []), [far_away])
    stations: list[Station] = [
        Drive(address, "DKC02.3-040-7-FW", "FWA-ECODR3-SMT-02VRS-MS", drive_parameters(), seed) for address in DRIVES
    ]
    stations[0] = Router(stations[0], [between])
    return play(Player(settings, faults, seed), commands(settings, seed, cycles, rates), stations)


def _checked(args: argparse.Namespace) -> tuple[LineSettings, Faults, list[int]]:
    """Check the options; ValueError says what is wrong and what to do."""
    if args.baud <= 0:
        raise ValueError(f"--baud {args.baud} is no rate (for example 9600)")
    settings = LineSettings.parse(args.baud, args.format)
    if settings.data_bits != 8:
        raise ValueError(f"--format {args.format}: SIS needs 8 data bits (for example 8E1)")
    if args.cycles < 0:
        raise ValueError(f"--cycles {args.cycles} is negative; 0 plays until stopped")
    if not 1 <= args.reads <= 0xFFFF:
        raise ValueError(f"--reads {args.reads} is not a number of characters from 1 to 65535")
    faults = Faults.parse(args.faults) if args.faults else NO_FAULTS
    if not args.listen:
        if args.fast or args.reads > 1:
            raise ValueError("--fast and --reads need --listen: a pseudo terminal knows only real time")
        if faults.parity or faults.break_:
            raise ValueError("a pseudo terminal cannot carry parity errors and breaks: use --listen")
    return settings, faults, _rates(args)


def _rates(args: argparse.Namespace) -> list[int]:
    """Read --rates; ValueError says what is wrong."""
    names = args.rates.split(",") if args.rates else []
    if wrong := [name for name in names if name not in map(str, RATES)]:
        raise ValueError(f"--rates: '{wrong[0]}' is not one of {', '.join(map(str, RATES))}")
    return [int(name) for name in names]


def _serve(args: argparse.Namespace, settings: LineSettings, telegrams: Iterable[Played], log: Log | None) -> int:
    pace = Pace(simulated=args.fast)
    try:
        wire = _wire(args, settings, pace)
    except ValueError as error:
        return _fail(_USAGE, f"--listen {error}")
    except OSError as error:
        cure = "choose another port (0: any free one) or PATH" if args.listen else "close some terminals"
        return _fail(_PORT, f"cannot listen at {args.listen or 'a pseudo terminal'}: {error.strerror or error}; {cure}")
    try:
        print(wire.name, flush=True)
        wire.wait_for_listener()
        if log:
            log.begin(f"{settings.baud} {settings.format}, seed {args.seed}, time 0 is {pace.wall_ns()} ns since 1970")
        serve(wire, telegrams, log)
    except OSError as error:
        saved = "; the log has what was played before" if log else ""
        return _fail(_FAILED, f"the bus stopped: {error.strerror or error}{saved}")
    finally:
        wire.close()
    return _DONE


def _wire(args: argparse.Namespace, settings: LineSettings, pace: Pace) -> Wire:
    # Imported here: Windows has no pseudo terminals, and a pty needs no sockets.
    if args.listen:
        from sistap.bus.taps import Taps

        return Taps(pace, args.listen, args.seed, args.reads)
    try:
        from sistap.bus.pseudo_terminal import PseudoTerminal
    except ImportError:
        raise OSError(0, "this system has none") from None
    return PseudoTerminal(pace, settings.baud, args.seed)


@contextmanager
def _stoppable() -> Iterator[None]:
    """Let SIGINT and SIGTERM end the bus, even where a script started it in the background with SIGINT ignored."""

    def stop(signum: int, frame: FrameType | None) -> None:
        raise _Stopped

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _fail(code: int, text: str) -> int:
    print(f"sistap bus: {text}", file=sys.stderr)
    return code
