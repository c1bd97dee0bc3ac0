# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap bus`: the command line of the virtual bus."""

from __future__ import annotations

import argparse
import itertools
import math
import os
import sys
from contextlib import AbstractContextManager, closing, nullcontext

from sisbus.playing.characters import NO_FAULTS, Faults
from sisbus.scenarios import scenario
from sisbus.scenarios.scenario import DEFAULT, Playing, Scenario, character_format, load
from sisbus.table import RATE
from sisbus.wires import place
from sisbus.wires.place import play
from sisbus.wires.recording import Recording
from sisbus.wires.wire import Log, Pace
from sistap.tap.common.writing import growing
from sistap.tap.files.output import Output
from sistap.tap.line.clock import CLOCK
from sistap.tap.line.settings import LineSettings
from sistap.tap.sis.rates import RATES
from sistap.tap.terminal.console import STANDARD_OUTPUT, visible
from sistap.tap.terminal.exits import DONE, FAILED, Refusal, why
from sistap.tap.terminal.stop import Stop
from sistap.tap.terminal.writing import FORCE

DESCRIPTION = """\
Play a virtual SIS bus. A scenario says which masters ask, which stations answer, and what goes wrong. The bus begins
when a program listens. It sends on a real port only with --transmit.
"""

EPILOG = """\
A SCENARIO is a built-in one (--list names them) or a FILE.toml. The README beside the built-in ones explains how to
write one (sisbus/scenarios; in the .deb /usr/share/doc/sistap/scenarios.md). A scenario without a master
waits for a real one. A scenario without stations talks to real ones, at a real port only.

The scenarios s5, s5-cam, s5-faults and s5-shared play procedure 3964R. Listen with --framing 3964r. With only an S5 or
only a PPC, the partner is a real one, at a pseudo terminal or a port.

examples:
  sistap bus                                       a master and two drives, at a pseudo terminal
  sistap bus --list                                list the other scenarios
  sistap bus late-reaction -w late.pcapng          into a capture file, at once
  sistap bus noise --listen 127.0.0.1:5000         for `sistap capture -i bus://127.0.0.1:5000`
  sistap bus drives                                drives that wait for your master
  sistap bus indradrive-waits --log master.txt     the same with an IndraDrive, and a log of what your master says
  sistap bus mine.toml --port /dev/ttyUSB0 --transmit
                                                   your script with drives on a real bus

exit status:
  0  done; also when stopped by Ctrl-C or SIGTERM
  1  failed while running (port lost, disk full): what came before is saved
  2  wrong usage, a SCENARIO that cannot be read, or a FILE that cannot be written
  3  the port cannot be opened
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `sistap bus`."""
    add = parser.add_argument
    add("scenario", nargs="?", default=DEFAULT, metavar="SCENARIO", help=f"built-in, or FILE.toml (default {DEFAULT})")
    add("--list", action="store_true", help="list the built-in scenarios")
    where = place.add_arguments(parser)
    where.add_argument("-w", dest="file", metavar="FILE", help="write a capture file, at once; - is standard output")
    add("--force", action="store_true", help=FORCE)
    add("--reads", type=int, default=1, metavar="N", help="read up to N characters at a time (with --listen or -w)")
    add("--baud", type=int, help="rate of the bus (default: the scenario's, usually 9600)")
    add("--format", help="character format (default: the scenario's, usually 8E1)")
    add(
        "--rates",
        metavar="RATE,...",
        help="after each loop, the demo's master tests the next of these rates with a drive, then sets it for all; "
        "9600, 19200, 38400, 57600 or 115200",
    )
    add("--seed", type=int, default=1, help="the same number plays the same bytes (default 1)")
    add(
        "--cycles",
        type=int,
        default=0,
        help="how many times to play the loop (default: until stopped; with -w once)",
    )
    add("--duration", type=float, metavar="SECONDS", help="end after this time of the bus")
    add(
        "--faults",
        metavar="NAME=P,...",
        help="disturb what a tap hears; probabilities of parity, break, loss and pause of a character, and of a wrong "
        "checksum of a telegram",
    )
    add(
        "--log",
        metavar="FILE",
        help="write a line of text for each telegram: time, bytes, faults; also for those of a real master",
    )


def run(args: argparse.Namespace) -> int:
    """Play the bus until its end or a signal; return the exit code. May raise PortError or PortLost."""
    if args.list:
        return _list()
    return place.refusing("bus", lambda: _run(args))


def _run(args: argparse.Namespace) -> None:
    played, settings, how = _checked(args)
    with _log(args.log, force=args.force) as log:
        _play(args, played, settings, how, log, Stop.current())


def _list() -> int:
    names = scenario.names()
    width = max(map(len, names))
    for name in names:
        print(f"{name:{width}}  {load(name).title}")
    return DONE


def _checked(args: argparse.Namespace) -> tuple[Scenario, LineSettings, Playing]:
    """Read the scenario and check the options. Refusal says what is wrong and what to do."""
    try:
        played = load(args.scenario)
        settings = _settings(args, played.settings)
        faults = Faults.parse(args.faults) if args.faults else NO_FAULTS
        if played.is_complete:
            place.settle(args)
        _check_files(args)
        _check_numbers(args)
        place.check(args)
        if (faults.parity or faults.break_) and not (args.listen or args.file):
            raise ValueError("a pseudo terminal cannot carry parity errors and breaks: use --listen")
        _check_place(args, played, faults)
        cycles = args.cycles or (1 if args.file and args.duration is None else 0)
        end_ns = math.inf if args.duration is None else args.duration * 1e9
        return played, settings, Playing(args.seed, cycles, faults, _rates(args), end_ns)
    except ValueError as error:
        raise Refusal(str(error)) from error
    except OSError as error:
        cure = "`sistap bus --list` names what is built in"
        raise Refusal(f"cannot read {args.scenario}: {why(error)}; {cure}") from error


def _settings(args: argparse.Namespace, usual: LineSettings) -> LineSettings:
    try:
        baud = usual.baud if args.baud is None else RATE(args.baud)
    except ValueError as error:
        raise ValueError(f"--baud {args.baud} is no rate (for example 9600): {error}") from None
    try:
        return character_format(baud, usual.format if args.format is None else args.format)
    except ValueError as error:
        raise ValueError(f"--format {args.format}: {error}") from None


def _check_files(args: argparse.Namespace) -> None:
    if "" in (args.file, args.log) or args.log == STANDARD_OUTPUT:
        raise ValueError("-w and --log take the name of a file; only -w can be -, standard output")


def _check_numbers(args: argparse.Namespace) -> None:
    if args.cycles < 0:
        raise ValueError(f"--cycles {args.cycles} is negative; 0 plays until stopped")
    if not 1 <= args.reads <= place.ALL:
        raise ValueError(f"--reads {args.reads} is not a number of characters from 1 to {place.ALL}")
    if args.reads > 1 and not (args.listen or args.file):
        raise ValueError("--reads needs --listen or -w: a pseudo terminal and a port take one after the other")
    if args.duration is not None and not 0 < args.duration < math.inf:
        raise ValueError(f"--duration {args.duration:g} is no time in seconds (for example 60)")


def _check_place(args: argparse.Namespace, played: Scenario, faults: Faults) -> None:
    """Refuse a scenario that cannot be played where it is to be played."""
    name = args.scenario
    if not played.has_stations and not args.port and not played.procedure:
        raise ValueError(f"{name} has no stations, it talks to real ones: add --port PORT --transmit")
    if not played.has_masters and (args.listen or args.file):
        raise ValueError(f"{name} has no master, it waits for a real one: leave out --listen and -w, or use --port")
    if not played.has_stations and (args.listen or args.file):
        raise ValueError(f"{name} has no PPC, it talks to a real one: leave out --listen and -w, or use --port")
    if not played.has_masters and args.duration is not None:
        raise ValueError(f"{name} has no master, it answers a real one until it is stopped: leave out --duration")
    if not played.is_complete and args.faults:
        raise ValueError("--faults disturbs what a tap hears, but sistap does not disturb a real bus: leave it out")
    if played.procedure and (faults.checksum or faults.pause):
        raise ValueError("--faults checksum and pause are for SIS: use parity, break or loss, or [[fault]]")
    if args.rates and name != DEFAULT:
        raise ValueError(f"--rates is for the scenario {DEFAULT}: leave it out")
    if args.file == STANDARD_OUTPUT and os.isatty(1):
        raise ValueError("a terminal cannot show a pcapng file: add | wireshark -C SIS -k -i - or name a file with -w")


def _rates(args: argparse.Namespace) -> list[int]:
    """Read --rates; ValueError says what is wrong."""
    names = args.rates.split(",") if args.rates else []
    if wrong := [name for name in names if name not in map(str, RATES)]:
        raise ValueError(f"--rates: '{wrong[0]}' is not one of {', '.join(map(str, RATES))}")
    return [int(name) for name in names]


def _log(path: str | None, *, force: bool) -> AbstractContextManager[Log | None]:
    return closing(Log(growing(path, force=force, cure="name another file with --log"))) if path else nullcontext()


def _play(  # noqa: PLR0913 - what, how and where, and what goes with it
    args: argparse.Namespace, played: Scenario, settings: LineSettings, how: Playing, log: Log | None, stop: Stop
) -> None:
    """Play it where it is to be played. May raise Refusal."""
    if not played.has_stations and not played.procedure:
        from sisbus.wires.talking import talk

        talk(args.port, settings, played, how, log)
    elif not played.is_complete:
        _meet(args, settings, played, how, log)
    else:
        pace = Pace(args.fast or bool(args.file), played.begin_ns)
        recording = _recording(args, settings, played, stop) if args.file else None
        wire = recording or place.opened(args, settings, pace, args.seed, args.reads)
        telegrams = itertools.takewhile(lambda _: not stop.asked, played.play(settings, how))
        play(wire, pace, telegrams, log, f"{settings.baud} {settings.format}, seed {args.seed}")
        if recording:
            print(f"sistap bus: {visible(recording.written)}", file=sys.stderr)


def _meet(args: argparse.Namespace, settings: LineSettings, played: Scenario, how: Playing, log: Log | None) -> None:
    """Play one half of the bus at a place where the other one is real, until its end or a signal."""
    from sisbus.wires.answering import Noting, meet_partner
    from sisbus.wires.answering import serve as answer

    port = place.port(args, settings, args.seed)
    try:
        pace = Pace()
        noting = None
        if log:
            log.begin(f"{settings.baud} {settings.format}, {port.name}, time 0 is {CLOCK.now_ns()} ns since 1970")
            noting = Noting(log, settings, played.cut)
        print(port.name, flush=True)
        if played.procedure:
            meet_partner(port, played.procedure, how, pace, noting)
        else:
            answer(port, played.stations(args.seed), pace, noting)
    except OSError as error:
        saved = "; the log has what came before" if log else ""
        raise Refusal(f"the bus stopped: {error.strerror or error}{saved}", FAILED) from error
    finally:
        port.close()


def _recording(args: argparse.Namespace, settings: LineSettings, played: Scenario, stop: Stop) -> Recording:
    output = Output(args.file, stopped=lambda: stop.asked, force=args.force)
    stop.at_once = False
    return Recording(output, played, args.scenario, args.seed, settings, args.reads)
