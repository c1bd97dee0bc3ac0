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
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from sistap.tap.line.settings import LineSettings

HERE = Path(__file__).parent
SETTINGS = LineSettings(115200, 8, "E", 2)
LOOK_S = 1.0
PATIENCE_S = 20  # for actions that take no time

Program = subprocess.Popen[str]


class Broken(Exception):
    """The benchmark cannot run, or a character is missing; the text is the line to show."""


class Terminal(NamedTuple):
    """A pseudo terminal that changes no character."""

    master: int
    slave: int
    path: str


class Look(NamedTuple):
    """The processor time that each listener had used by then (wall clock), in ns."""

    time_ns: int
    used_ns: list[int]


class Played(NamedTuple):
    """When each terminal got each character (wall clock, ns), and a look each second."""

    instants_ns: list[list[int]]
    looks: list[Look]


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
    looks = [_look(listeners)]
    with subprocess.Popen(command, pass_fds=masters) as writer:
        while writer.poll() is None:
            with suppress(subprocess.TimeoutExpired):
                writer.wait(LOOK_S)
            looks.append(_look(listeners))
    if writer.returncode:
        raise Broken(f"writer.c ended with exit code {writer.returncode}")
    return Played(columns(folder / "instants", len(ends)), looks)


def columns(file: Path, count: int) -> list[list[int]]:
    """Read rows of that many 64-bit numbers."""
    numbers = array("q", file.read_bytes())
    return [list(numbers[i::count]) for i in range(count)]


def _look(listeners: Iterable[Program]) -> Look:
    return Look(time.time_ns(), [_used_ns(listener) for listener in listeners])


def _used_ns(process: Program) -> int:
    """Return the processor time of a running process, user and system, of all its threads."""
    threads = Path(f"/proc/{process.pid}/task").glob("*/schedstat")
    return sum(int(thread.read_text().split()[0]) for thread in threads)
