#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""What do `sistap report` and `sistap tables` cost, compared with tshark that prints five fields in two passes?

python3 report.py            instructions a packet, of sistap and of its tshark; two minutes
python3 report.py --night    a million packets: seconds on the wall, seconds of a core, memory of sistap alone
python3 report.py --month    the same for a report of 30 files of a million packets each; needs 5 GB of disk

The virtual bus plays the morning of the course: three and a half hours, in which stations are read, with faults. The
instructions are those for its first 2001 packets less those for 101: no start is in them, and they hold on a busy
machine. A night is so many copies of it, one after the other. Exit code 1 if something broke; a missed goal is only
reported.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from subprocess import DEVNULL
from typing import NamedTuple

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

from instructions import FEW, MANY, Instructions  # noqa: E402

from sistap.dissected.wireshark.rows import printing  # noqa: E402
from sistap.dissected.wireshark.tshark import Tshark, TsharkError  # noqa: E402

MORNING = HERE.parents[1] / "test-captures" / "course" / "14-a-morning.toml"
LENGTH_S = 12_600
FIVE = ("frame.number", "frame.time_epoch", "sis.service", "sis.talker", "sis.status")
PACKETS = 1_000_000  # of a night, at least
NIGHTS = 30
GOALS = {"tshark, rows": 0.32, "report": 1.2, "tables": 1.6}  # times the five fields
GOAL_NIGHT_S, GOAL_MONTH_S = 20, 600
GOAL_MEMORY_MB = 200

ENVIRONMENT = os.environ | {"PYTHONPATH": str(HERE.parent), "PYTHONHASHSEED": "0"}


class Cost(NamedTuple):
    """What a run has cost."""

    wall_s: float
    cores_s: float  # user and system, with its tshark
    memory_mb: float  # of Python alone, at its largest


def five_fields(capture: Path) -> list[str]:
    """Return the arguments of Python for the measure of all others."""
    return ["-m", "sistap.dissected.wireshark", "-r", str(capture), "-2", *printing(FIVE)]


def report(*captures: Path) -> list[str]:
    """Return those for a report."""
    return ["-m", "sistap", "report", "--format", "text", *map(str, captures)]


def tables(capture: Path) -> list[str]:
    """Return those for tables."""
    return ["-m", "sistap", "tables", "-o", str(capture.with_suffix(".tables")), str(capture)]


def morning(folder: Path) -> Path:
    """Play the morning; return its capture."""
    capture = folder / "morning.pcapng"
    bus = [sys.executable, "-m", "sistap", "bus", str(MORNING), "-w", str(capture)]
    subprocess.run(bus, check=True, stderr=DEVNULL, env=ENVIRONMENT)
    return capture


def nights(folder: Path, count: int) -> tuple[list[Path], int]:
    """Return so many captures, one after the other, and the number of packets in one."""
    base = morning(folder)
    with Tshark("capinfos", drop_rights=False) as capinfos:
        packets = int(capinfos.output("-TrMc", str(base)).split()[-1])
    copies = math.ceil(PACKETS / packets)
    parts = [str(folder / f"part-{part}.pcapng") for part in range(copies)]
    made = [folder / f"night-{number:02}.pcapng" for number in range(count)]
    with Tshark("editcap", drop_rights=False) as editcap, Tshark("mergecap", drop_rights=False) as mergecap:
        for number, night in enumerate(made):
            for copy, part in enumerate(parts, number * copies):
                editcap.output("-t", str(copy * LENGTH_S), str(base), part)
            mergecap.output("-a", "-w", str(night), *parts)
    return made, packets * copies


def cost(arguments: Sequence[str]) -> Cost:
    """Run Python to its end."""
    before, began_s, memory_mb = os.times(), time.monotonic(), 0.0
    process = subprocess.Popen([sys.executable, *arguments], stdout=DEVNULL, env=ENVIRONMENT)
    while process.poll() is None:
        status = Path(f"/proc/{process.pid}/status").read_text("ascii")
        memory_mb = next((int(line.split()[1]) / 1e3 for line in status.splitlines() if "VmHWM" in line), memory_mb)
        time.sleep(0.1)
    wall_s, after = time.monotonic() - began_s, os.times()
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, arguments)
    cores_s = after.children_user + after.children_system - before.children_user - before.children_system
    return Cost(wall_s, cores_s, memory_mb)


def goal(figure: float, most: float) -> str:
    """Return the words about a goal."""
    return f"goal {most:g}: {'met' if figure <= most else 'NOT MET'}"


def count(folder: Path) -> None:
    """Print the instructions of a packet."""
    base, instructions = morning(folder), Instructions(folder)
    few, many = (folder / f"{packets}.pcapng" for packets in (FEW, MANY))
    with Tshark("editcap", drop_rights=False) as editcap:
        for packets, capture in ((FEW, few), (MANY, many)):
            editcap.output("-r", str(base), str(capture), f"1-{packets}")
    environment = ENVIRONMENT | {"PATH": f"{folder}{os.pathsep}{os.environ['PATH']}"}

    def taken(arguments: Sequence[str]) -> Counter[str]:
        subprocess.run([*instructions.python, *arguments], check=True, stdout=DEVNULL, env=environment)
        return instructions.taken()

    def a_packet(arguments: Callable[[Path], list[str]]) -> tuple[float, float]:
        """Return the instructions of tshark, and with those of Python."""
        spent = taken(arguments(many))
        spent.subtract(taken(arguments(few)))
        return spent["tshark"] / (MANY - FEW), spent.total() / (MANY - FEW)

    fields, _ = a_packet(five_fields)
    rows, reported = a_packet(report)
    _, tabled = a_packet(tables)
    print(f"{'instructions a packet':<24}{'':>12}{'ratio':>8}")
    print(f"{'tshark, five fields':<24}{fields:>12,.0f}")
    for name, figure in (("tshark, rows", rows), ("report", reported), ("tables", tabled)):
        ratio = figure / fields
        print(f"{name:<24}{figure:>12,.0f}{ratio:>8.2f}  {goal(ratio, GOALS[name])}")


def night(folder: Path) -> None:
    """Print what a million packets cost."""
    (capture,), packets = nights(folder, 1)
    fields = cost(five_fields(capture))
    print(f"{f'{packets:,} packets':<24}{'wall':>8}{'cores':>8}{'ratio':>8}{'memory':>8}")
    print(f"{'tshark, five fields':<24}{fields.wall_s:>6.1f} s{fields.cores_s:>6.1f} s")
    for name, arguments in (("report", report), ("tables", tables)):
        spent = cost(arguments(capture))
        ratio = spent.cores_s / fields.cores_s
        goals = f"  {goal(ratio, GOALS[name])}, memory {goal(spent.memory_mb, GOAL_MEMORY_MB)}"
        goals += f", wall {goal(spent.wall_s, GOAL_NIGHT_S)}" if arguments is report else ""
        print(f"{name:<24}{spent.wall_s:>6.1f} s{spent.cores_s:>6.1f} s{ratio:>8.2f}{spent.memory_mb:>5.0f} MB{goals}")


def month(folder: Path) -> None:
    """Print what a report of a month costs."""
    captures, packets = nights(folder, NIGHTS)
    spent = cost(report(*captures))
    print(
        f"report of {NIGHTS} files of {packets:,} packets: {spent.wall_s:.0f} s ({goal(spent.wall_s, GOAL_MONTH_S)}), "
        f"{spent.cores_s:.0f} s of cores, {spent.memory_mb:.0f} MB ({goal(spent.memory_mb, GOAL_MEMORY_MB)})"
    )


def main() -> int:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.set_defaults(measure=count)
    parser.add_argument("--night", dest="measure", action="store_const", const=night, help="time a million packets")
    parser.add_argument("--month", dest="measure", action="store_const", const=month, help="time 30 such files")
    with tempfile.TemporaryDirectory(prefix="sistap-benchmark-") as folder:
        try:
            parser.parse_args().measure(Path(folder))
        except (TsharkError, OSError, subprocess.SubprocessError) as error:
            print(f"report.py: {error}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
