#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Can the recorder run for months? Its memory during simulated traffic without pauses, row by row.

A virtual bus plays as fast as the tap reads; a full ring is written beside the kept files. Exit code 1 if the memory of
sistap grows, if a record was not tested with the filter, or if a capture failed.
"""

from __future__ import annotations

import argparse
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

GROWTH = 1.1  # from a quarter of the time to its end; up to this the memory counts as constant


class Row(NamedTuple):
    """A measurement."""

    seconds: float
    sistap_mb: float
    tshark_mb: float  # of all tsharks together
    tsharks: int
    kept: int  # files


def main() -> int:
    """Play, measure, judge."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--telegrams", type=float, default=1e6, help="number of telegrams (1e6); 4 busy days have 1e7")
    parser.add_argument("--keep", default="faults", help="as record's --keep (faults)")
    parser.add_argument("--faults", default="checksum=0.0005", help="as bus's --faults (checksum=0.0005)")
    parser.add_argument("--rows", type=float, default=10, metavar="SECONDS", help="between two rows (10)")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        said, rows, code = _measure(args, Path(folder))
    print(said, end="")
    late = rows[len(rows) // 4 :]
    grows = max(row.sistap_mb for row in late[-3:]) > GROWTH * late[0].sistap_mb
    print("the memory of sistap", "GROWS" if grows else "is constant")
    return int(bool(code) or grows or "not tested with the filter" in said)


def _measure(args: argparse.Namespace, folder: Path) -> tuple[str, list[Row], int]:
    kept, said = folder / "kept", folder / "said"
    bus = Bus(folder / "bus", args.faults)
    with said.open("w") as errors:
        recorder = ("--keep", args.keep, "-w", str(kept), "-b", "filesize:20000", "-b", "files:3", "--wait-for-port")
        capture = _start("record", "-q", "-i", bus.port, "-c", str(int(args.telegrams)), *recorder, stderr=errors)
        rows = list(_rows(capture, bus, kept, args.rows))
    bus.end()
    return said.read_text(), rows, capture.returncode


class Bus:
    """The virtual bus; if somebody ends it, another one begins, as when an adapter is unplugged."""

    def __init__(self, path: Path, faults: str) -> None:
        """Begin."""
        self.port = f"bus://{path}"
        self._arguments = ("bus", "demo", "--listen", str(path), "--fast", "--reads", "64", "--faults", faults)
        self._begin()

    def _begin(self) -> None:
        self._process = _start(*self._arguments)
        assert self._process.stdout
        self._process.stdout.readline()

    def look(self) -> None:
        """Start again if it has ended."""
        if self._process.poll() is not None:
            print("another bus")
            self._begin()

    def end(self) -> None:
        """End it."""
        self._process.send_signal(signal.SIGTERM)
        self._process.wait()


def _start(*arguments: str, stderr: object = None) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "sistap", *arguments]
    folder = Path(__file__).parent.parent
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=stderr, text=True, cwd=folder)  # type: ignore[call-overload, no-any-return]


def _rows(capture: subprocess.Popen[str], bus: Bus, kept: Path, pause_s: float) -> Iterator[Row]:
    started_s = time.monotonic()
    print(f"{'s':>7}  {'sistap MB':>9}  {'tshark MB':>9}  {'tsharks':>7}  {'kept':>5}")
    while True:
        try:
            capture.wait(pause_s)
            return
        except subprocess.TimeoutExpired:
            bus.look()
        tsharks = [_mb(child) for child in _children(capture.pid)]
        files = len(list(kept.glob("kept_*")))
        row = Row(time.monotonic() - started_s, _mb(capture.pid), sum(tsharks), len(tsharks), files)
        print(
            f"{row.seconds:7.0f}  {row.sistap_mb:9.1f}  {row.tshark_mb:9.1f}  {row.tsharks:7}  {row.kept:5}", flush=True
        )
        yield row


def _children(pid: int) -> list[int]:
    return [
        int(child) for task in Path(f"/proc/{pid}/task").iterdir() for child in (task / "children").read_text().split()
    ]


def _mb(pid: int) -> float:
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0.0
    return next((int(line.split()[1]) / 1000 for line in status.splitlines() if line.startswith("VmRSS")), 0.0)


if __name__ == "__main__":
    sys.exit(main())
