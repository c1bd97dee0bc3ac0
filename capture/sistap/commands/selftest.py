# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap selftest`: measures how exact the times of this computer or of a port are."""

from __future__ import annotations

import argparse
import gc
import math
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path

from sistap.tap.analyser.probe import is_analyser
from sistap.tap.common.quantiles import quantile
from sistap.tap.line import measurement, ports, priority
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, LineSettings
from sistap.tap.sis.rates import RATES
from sistap.tap.terminal import state
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.exits import DONE, FAILED, USAGE

DESCRIPTION = """\
Measure how late sistap sees characters. It uses a pseudo terminal of its own (a socket on Windows), or a port whose
transmit and receive wires are joined. sistap stores the result, and later captures use it as their uncertainty.
"""

EPILOG = """\
The result is p99.9: one character in a thousand is later. A capture uses it for sertap.uncertainty as long as computer,
kernel and priority are the same. For a port, its adapter, tuning, rate and format must be the same, too. A measurement
at a port also includes the sending. So its result can be too large, but never too small.

With -i (not on Windows), sistap SENDS characters (@ to ~, one by one). Take the port off the bus first, then join its
transmit and receive wires (RS232: pins 2 and 3; RS422: TxD+ to RxD+, TxD- to RxD-).

examples:
  sistap selftest                                       this computer, 5 seconds
  sistap selftest --duration 60                         a minute; finds rare long delays, too
  sistap selftest -i /dev/ttyUSB0 --transmit --baud 115200
                                                        an adapter whose wires are joined

exit status:
  0  measured and stored; or stopped by Ctrl-C or SIGTERM, with nothing stored
  1  what was sent did not come back, or the result cannot be stored
  2  wrong usage, such as -i without --transmit
  3  the port cannot be opened
"""

LONGEST_S = 3600
OWN = "a socket" if sys.platform == "win32" else "a pseudo terminal"
ENOUGH = 1000  # characters; with fewer, p99.9 is only the longest delay
QUANTILES = {"p50": 0.5, "p90": 0.9, "p99": 0.99, "p99.9": 0.999, "longest": 1.0}

# The upper bounds of the rows of the histogram, in ms.
_ROWS_MS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, math.inf)
_BAR = 40


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add(
        "-i",
        dest="port",
        metavar="PORT",
        type=ports.short,
        help="measure this port; join its transmit and receive wires first",
    )
    add("--transmit", action="store_true", help="allow sending characters on PORT; without it, sistap sends nothing")
    add("--baud", type=int, default=9600, metavar="RATE", help="rate of PORT in Bd (9600)")
    add("--format", default="8E1", metavar="FORMAT", help="data bits, parity and stop bits of PORT (8E1)")
    add("--duration", type=float, default=5, metavar="SECONDS", help="how long to measure (5)")


@priority.real_time()
def run(args: argparse.Namespace) -> int:
    """Measure, print and keep the result; return the exit code. May raise PortError."""
    console = Console()
    try:
        settings = _checked(args)
    except ValueError as error:
        console.say(str(error))
        return USAGE
    where = f"{args.port}, {settings.baud} Bd {settings.format}" if args.port else OWN
    print(f"measuring for {args.duration:g} s through {where}, with {priority.words()}", flush=True)
    try:
        place, conditions, measured = _measure(args, settings, console)
    except OSError as error:
        cure = f": join the transmit and receive lines of {args.port}, and nothing else to them" if args.port else ""
        console.say(f"no result: {error}{cure}")
        return FAILED
    delays = sorted(measured)
    print("\n".join(report(delays)))
    return _keep(place, conditions, delays, console)


def _checked(args: argparse.Namespace) -> LineSettings:
    """Check the options. Raise ValueError with the fault and its cure."""
    if not 1 <= args.duration <= LONGEST_S:
        raise ValueError(f"--duration {args.duration:g} is not a number of seconds from 1 to {LONGEST_S}")
    if sys.platform == "win32" and args.port:
        raise ValueError("on Windows a self-test is of this computer, not of a port: leave out -i and --transmit")
    if args.transmit and not args.port:
        raise ValueError("--transmit needs the port to send on: say it with -i")
    if args.port and not args.transmit:
        raise ValueError(
            f"a self-test of {args.port} sends characters, which on a bus would disturb it: take it off the bus, "
            "join its transmit and receive lines, and add --transmit"
        )
    if args.port and ("://" in args.port or is_analyser(args.port)):
        raise ValueError(f"{args.port} is no device: a self-test needs one, such as /dev/ttyUSB0")
    if args.port and ports.is_own_terminal(args.port):
        raise ValueError(f"{args.port} is the terminal that sistap itself reads or writes: choose another port with -i")
    if args.baud <= 0:
        raise ValueError(f"--baud {args.baud} is no rate (for example 9600)")
    return LineSettings.parse(args.baud, args.format)


def _measure(
    args: argparse.Namespace, settings: LineSettings, console: Console
) -> tuple[str, measurement.Conditions, Sequence[int]]:
    """Return what was measured, the conditions, and the delays in ns. May raise PortError or OSError."""
    duration_ns = int(args.duration * 1e9)
    if sys.platform == "win32":
        from sistap.tap.line.reader import computer

        with _undisturbed():
            return measurement.MACHINE, measurement.conditions(), computer.through_socket(duration_ns)
    from sistap.tap.line.reader import delay  # imported here: Windows has no such modules
    from sistap.tap.line.reader.latency import port_conditions
    from sistap.tap.line.reader.opening import open_device
    from sistap.tap.line.reader.tuning import Tuning

    if not args.port:
        with _undisturbed():
            return measurement.MACHINE, measurement.conditions(), delay.through_pty(duration_ns)
    pseudo_terminal = ports.adapter(args.port).pseudo_terminal
    with closing(open_device(args.port, settings, pseudo_terminal)) as device:
        tuning = Tuning(args.port, device.fileno(), settings)
        try:
            for line in tuning.missed:
                console.say(line)
            behind = ports.adapter(args.port)
            with _undisturbed():
                delays = delay.through(device.fileno(), device.fileno(), duration_ns, settings.character_ns)
            return ports.identity(args.port, behind), port_conditions(behind, settings), delays
        finally:
            tuning.undo()


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Switch the garbage collector off, as a capture does."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def _keep(place: str, conditions: measurement.Conditions, delays: Sequence[int], console: Console) -> int:
    """Keep the result (of sorted delays) for later captures; return the exit code."""
    if len(delays) < ENOUGH:
        console.say(f"not kept: {len(delays)} characters are too few for p99.9: measure longer with --duration")
        return FAILED
    if delays[-1] >= UNCERTAINTY_UNKNOWN:
        console.say(f"not kept: for {delays[-1] / 1e9:.0f} s sistap was stopped: measure again")
        return FAILED
    bound_ns, longest_ns = (max(1, int(quantile(delays, QUANTILES[name]))) for name in ("p99.9", "longest"))
    result = measurement.Result(place, time.strftime("%Y-%m-%d"), len(delays), bound_ns, longest_ns, conditions)
    try:
        path = measurement.store(result)
    except (OSError, RuntimeError) as error:
        cure = "" if state.is_root() else ": name a folder of your own with XDG_STATE_HOME"
        console.say(f"the result cannot be kept: {error}{cure}")
        return FAILED
    print(f"\nkept in {_short(path)}: captures under these conditions ({', '.join(conditions.values())}) use it")
    return DONE


def _short(path: Path) -> str:
    try:
        return f"~/{path.relative_to(Path.home())}"
    except (ValueError, RuntimeError):
        return str(path)


def report(delays: Sequence[int]) -> list[str]:
    """Describe how late the characters were seen (sorted, in ns), and what that means on a line."""
    lines = [f"{len(delays)} characters; how late they were seen:", ""]
    lines += [f"  {name:8} {quantile(delays, share) / 1e6:8.3f} ms" for name, share in QUANTILES.items()]
    lines += ["", *histogram(delays), ""]
    bound_ns = quantile(delays, QUANTILES["p99.9"])
    lines.append("p99.9 in character times of 8E1; an interval closer to its limit stays unresolved:")
    lines.append("")
    for rate in RATES:
        character_ns = LineSettings(rate).character_ns
        lines.append(f"  {rate:6} Bd {bound_ns / character_ns:8.2f}   (a character takes {character_ns / 1e6:.3f} ms)")
    return lines


def histogram(delays: Sequence[int]) -> list[str]:
    """Draw how often each delay occurred, without the empty rows at both ends."""
    counts = [0] * len(_ROWS_MS)
    for value in delays:
        counts[next(row for row, end_ms in enumerate(_ROWS_MS) if value <= end_ms * 1e6)] += 1
    seen = [row for row, count in enumerate(counts) if count]
    return [
        f"  {_row(row):>10}  {counts[row]:8}  {'#' * math.ceil(_BAR * counts[row] / max(counts))}".rstrip()
        for row in range(seen[0], seen[-1] + 1)
    ]


def _row(row: int) -> str:
    end_ms = _ROWS_MS[row]
    return f"<= {end_ms:g} ms" if math.isfinite(end_ms) else f"> {_ROWS_MS[row - 1]:g} ms"
