# SPDX-License-Identifier: GPL-2.0-or-later
"""Plays characters into pseudo terminals with writer.c, and manages the programs that listen there."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
import time
import tty
from array import array
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from sistap.tap.line.settings import LineSettings

HERE = Path(__file__).parent
SETTINGS = LineSettings(115200, 8, "E", 2)
PATIENCE_S = 20  # for actions that take no time

Program = subprocess.Popen[str]


class Broken(Exception):
    """The benchmark cannot run, or a character is missing; the text is the line to show."""


class Terminal(NamedTuple):
    """A pseudo terminal that changes no character."""

    master: int
    slave: int
    path: str


class Played(NamedTuple):
    """When each terminal got each character (wall clock, ns), and each listener's share of a core."""

    elapsed_s: float
    instants_ns: list[list[int]]
    shares: list[float]


@contextmanager
def terminals(count: int) -> Iterator[list[Terminal]]:
    """Open that many; when they close, a remaining listener sees the end of the line."""
    opened = [pty.openpty() for _ in range(count)]
    try:
        for _, slave in opened:
            tty.setraw(slave)
        yield [Terminal(master, slave, os.ttyname(slave)) for master, slave in opened]
    finally:
        for descriptor in (descriptor for both in opened for descriptor in both):
            os.close(descriptor)


def compile_into(folder: Path, name: str) -> str:
    """Compile NAME.c; return the program's path."""
    program = str(folder / name)
    subprocess.run(["gcc", "-O2", "-Wall", "-Wextra", "-Werror", "-o", program, str(HERE / f"{name}.c")], check=True)
    return program


def start_sistap(file: Path, ports: Sequence[str], *options: str) -> tuple[Program, str]:
    """Start a capture of these ports; return, when it listens, the process and its description of the times."""
    command = [sys.executable, "-m", "sistap", "capture", "-w", str(file), *options]
    command += ["--baud", str(SETTINGS.baud), "--format", SETTINGS.format]
    for port in ports:
        command += ["-i", port]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=HERE.parent)
    said = [listening(process, process.stderr, "capturing on") for _ in ports]
    return process, said[0].partition(f"{SETTINGS}; ")[2]


def listening(process: Program, says: Iterable[str] | None, expected: str) -> str:
    """Return the line in which a program says that it listens; Broken if it says something else."""
    said = next(iter(says or ()), "").strip()
    if expected not in said:
        process.kill()
        raise Broken(said or "a program that was to listen ended at once")
    return said


def stop_sistap(process: Program) -> None:
    """End a capture. Raise Broken if it failed."""
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=PATIENCE_S)
    if process.returncode != 0:
        raise Broken(f"sistap ended with exit code {process.returncode}: {said.strip()}")


def play(folder: Path, characters: bytes, ends: Sequence[Terminal], listeners: list[Program]) -> Played:
    """Play without a pause to all terminals, to each a little later than to the one before."""
    (folder / "characters").write_bytes(characters)
    times_ns = map(str, (SETTINGS.character_ns, SETTINGS.character_ns // len(ends)))
    masters = [end.master for end in ends]
    files = str(folder / "characters"), str(folder / "instants")
    command = [compile_into(folder, "writer"), *files, *times_ns, *map(str, masters)]
    before_s = [_cpu_s(listener) for listener in listeners]
    started_s = time.monotonic()
    subprocess.run(command, check=True, pass_fds=masters)
    elapsed_s = time.monotonic() - started_s
    shares = [(_cpu_s(listener) - before) / elapsed_s for listener, before in zip(listeners, before_s, strict=True)]
    return Played(elapsed_s, columns(folder / "instants", len(ends)), shares)


def columns(file: Path, count: int) -> list[list[int]]:
    """Read rows of that many 64-bit numbers."""
    numbers = array("q", file.read_bytes())
    return [list(numbers[i::count]) for i in range(count)]


def _cpu_s(process: Program) -> float:
    """Return the processor time of a running process, user and system."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
