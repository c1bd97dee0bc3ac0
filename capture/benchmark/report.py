#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""What do `sistap report` and `sistap tables` cost, compared with tshark that prints five fields?

python3 report.py [--packets 1e6] [--files 30]

The virtual bus plays the morning of the course: three and a half hours, in which stations are read, with faults. Copies
of it, one after the other, are a capture of so many packets, as one file and as several. A cost is core microseconds a
packet, user and system: of sistap with its tshark. The memory is that of sistap alone, at its largest. Exit code 1 if
something broke; a missed goal is only reported.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

from sistap.dissected.wireshark.tshark import Tshark  # noqa: E402

MORNING = HERE.parents[1] / "test-captures" / "course" / "20-a-morning.toml"
LENGTH_S = 12_600
FIVE = ("frame.number", "frame.time_epoch", "sis.service", "sis.talker", "sis.status")
GOAL_MEMORY_MB = 200


class Cost(NamedTuple):
    """What a run has cost."""

    seconds: float
    memory_mb: float


class Trial(NamedTuple):
    """A run of sistap, and its goal: how many times the five fields."""

    name: str
    arguments: Sequence[str | Path]
    captures: Sequence[Path]
    goal: float


def sistap(*arguments: str | Path) -> subprocess.Popen[bytes]:
    """Start sistap."""
    environment = os.environ | {"PYTHONPATH": str(HERE.parent)}
    command = [sys.executable, "-m", "sistap", *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)


def done(process: subprocess.Popen[bytes]) -> None:
    """Wait for its end."""
    if process.wait():
        sys.exit(f"failed: {process.args!r}")


def captures(folder: Path, packets: float, files: int) -> tuple[list[Path], int]:
    """Play the morning and copy it; return so many files, one after the other, and the number of their packets."""
    base = folder / "base.pcapng"
    done(sistap("bus", MORNING, "-w", base))
    with Tshark("capinfos", drop_rights=False) as capinfos:
        count = int(capinfos.output("-TrMc", str(base)).split()[-1])
    copies = max(math.ceil(packets / count / files), 1)
    with Tshark("editcap", drop_rights=False) as editcap, Tshark("mergecap", drop_rights=False) as mergecap:
        made = []
        for number in range(files):
            parts = [folder / f"part-{part}.pcapng" for part in range(copies)]
            for part, path in enumerate(parts):
                editcap.output("-t", str((number * copies + part) * LENGTH_S), str(base), str(path))
            made.append(folder / f"night-{number:03}.pcapng")
            mergecap.output("-a", "-w", str(made[-1]), *map(str, parts))
    return made, count * copies * files


def whole(folder: Path, files: Sequence[Path]) -> Path:
    """Return one capture of all."""
    with Tshark("mergecap", drop_rights=False) as mergecap:
        mergecap.output("-a", "-w", str(folder / "all.pcapng"), *map(str, files))
    return folder / "all.pcapng"


def cost(*arguments: str | Path) -> Cost:
    """Run sistap to its end."""
    before = os.times()
    process = sistap(*arguments)
    peaks = [0.0]
    watching = threading.Thread(target=_watch, args=(process, peaks))
    watching.start()
    watching.join()
    done(process)
    after = os.times()
    spent_s = after.children_user + after.children_system - before.children_user - before.children_system
    return Cost(spent_s, max(peaks))


def _watch(process: subprocess.Popen[bytes], peaks: list[float]) -> None:
    """Note the largest memory of a process, without its children, until it ends."""
    while process.poll() is None:
        status = Path(f"/proc/{process.pid}/status").read_text("ascii")
        peaks += [int(line.split()[1]) / 1e3 for line in status.splitlines() if line.startswith("VmHWM")]
        time.sleep(0.1)


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--packets", type=float, default=1e6)
    parser.add_argument("--files", type=int, default=30)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        files, count = captures(folder, args.packets, args.files)
        one = whole(folder, files)
        with Tshark() as tshark:
            fields = [word for field in FIVE for word in ("-e", field)]
            five_s = tshark.usage(["-r", str(one), "-2", "-T", "fields", *fields]).seconds
        print(f"{count} packets; tshark with five fields: {five_s / count * 1e6:.1f} us a packet", flush=True)
        for trial in (
            Trial("report --format text", ["report", "--format", "text"], [one], 1.5),
            Trial(f"the same of {args.files} files", ["report", "--format", "text"], files, 1.5),
            Trial("tables", ["tables", "-o", folder / "tables"], [one], 2.0),
        ):
            found = cost(*trial.arguments, *trial.captures)
            times = found.seconds / five_s
            goals = times <= trial.goal and found.memory_mb <= GOAL_MEMORY_MB
            print(
                f"{trial.name:28} {found.seconds / count * 1e6:5.1f} us a packet, {times:.2f} times (goal {trial.goal})"
                f", {found.memory_mb:.0f} MB (goal {GOAL_MEMORY_MB}){'' if goals else '  MISSED'}",
                flush=True,
            )


if __name__ == "__main__":
    main()
