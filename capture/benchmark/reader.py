#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""How exact are the times of `sistap capture`, and what do they cost, beside the plainest reader in C?

    python3 reader.py [--seconds 60]

One writer plays back-to-back SIS telegrams at 115200 Bd 8E1 through two pseudo terminals: into sistap, and into
reader.c. README.md says how to read the table. Exit code 1 if a character was lost or something broke; a goal that is
not met is only said.
"""

from __future__ import annotations

import argparse
import itertools
import os
import pty
import signal
import struct
import subprocess
import sys
import tempfile
import time
import tty
from array import array
from collections.abc import Iterator
from itertools import accumulate
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

from telegrams import telegrams  # noqa: E402

from sistap import pcapng, priority, record  # noqa: E402
from sistap.line import Flag, LineSettings  # noqa: E402

SETTINGS = LineSettings(115200, 8, "E", 2)
QUANTILES = {"p50": 0.5, "p90": 0.9, "p99": 0.99, "p99.9": 0.999, "max": 1.0}
GOAL_QUANTILES = ("p50", "p99")
GOAL_RATIO = 1.5
PATIENCE_S = 20  # for what takes no time


class Broken(Exception):
    """The benchmark cannot be run, or a character is missing; the text is the one line to show."""


class Received(NamedTuple):
    """What a reader made of the stream, one of each a character; the C reader declares no uncertainty."""

    data: bytes
    times_ns: list[int]
    uncertainties_ns: list[int]
    same_read: list[bool]  # came in the same read as the one before


class Measured(NamedTuple):
    """One run: for each character how late its time is, and what sistap declared; shares of one core."""

    elapsed_s: float
    sistap_ns: list[int]
    uncertainties_ns: list[int]
    margins_ns: list[int]  # how late the record says that it can be
    c_ns: list[int]
    sistap_share: float
    c_share: float


def stream(seconds: float) -> bytes:
    """Make as many whole telegrams as fit into the time."""
    size = int(seconds * 1e9 / SETTINGS.character_ns)
    lengths = accumulate(map(len, telegrams()))
    count = sum(1 for _ in itertools.takewhile(lambda length: length <= size, lengths))
    return b"".join(itertools.islice(telegrams(), count))


def compile_into(folder: Path, name: str) -> str:
    """Compile NAME.c; give the program's path."""
    program = str(folder / name)
    subprocess.run(["gcc", "-O2", "-Wall", "-Wextra", "-Werror", "-o", program, str(HERE / f"{name}.c")], check=True)
    return program


def pseudo_terminal() -> tuple[int, int, str]:
    """Give both ends and the path of a pty that changes no character."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    return master, slave, os.ttyname(slave)


def start_sistap(port: str, file: Path) -> subprocess.Popen[str]:
    """Start a capture; it is listening when this returns."""
    command = [sys.executable, "-m", "sistap", "capture", "-i", port, "-w", str(file)]
    command += ["--baud", str(SETTINGS.baud), "--format", SETTINGS.format]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=HERE.parent)
    return listening(process, process.stderr.readline() if process.stderr else "", "capturing on")


def start_c_reader(program: str, port: str, file: Path) -> subprocess.Popen[str]:
    """Start the C reader, with the priority that sistap gives itself; it is listening when this returns."""
    with priority.real_time():
        process = subprocess.Popen([program, port, str(file)], stdout=subprocess.PIPE, text=True)
    return listening(process, process.stdout.readline() if process.stdout else "", "ready")


def listening(process: subprocess.Popen[str], said: str, expected: str) -> subprocess.Popen[str]:
    """Check what a reader says when it listens."""
    if expected not in said:
        process.kill()
        raise Broken(said.strip() or "a reader did not start")
    return process


def cpu_s(process: subprocess.Popen[str]) -> float:
    """How long a running process has had a core, user and system."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def from_sistap(file: Path) -> Received:
    """Take the characters of all records out of a capture."""
    data, times_ns, uncertainties_ns, same_read = bytearray(), list[int](), list[int](), list[bool]()
    for taken in records(file.read_bytes()):
        if taken.type != record.Type.EVENT:
            data += taken.data
            times_ns += accumulate(taken.intervals[1:], initial=taken.time_ns)
            uncertainties_ns += [taken.uncertainty_ns] * len(taken.data)
            same_read += [bool(flag & Flag.SAME_READ) for flag in taken.flags]
    return Received(bytes(data), times_ns, uncertainties_ns, same_read)


def margins_ns(received: Received) -> list[int]:
    """How late each time can be: the uncertainty, and a character time for each that followed in the same read."""
    margins, following, next_is_same = list[int](), 0, False
    for uncertainty_ns, same in zip(reversed(received.uncertainties_ns), reversed(received.same_read), strict=True):
        following = following + 1 if next_is_same else 0
        margins.append(uncertainty_ns + following * SETTINGS.character_ns)
        next_is_same = same
    return margins[::-1]


def records(blocks: bytes) -> Iterator[record.Record]:
    """Read the records in a pcapng file of ours."""
    header = len(pcapng.upper_pdu("sertap", b""))
    at = 0
    while at < len(blocks):
        kind, length, _, high, low, size = struct.unpack_from("<IIIIII", blocks, at)
        if kind == pcapng.ENHANCED_PACKET:
            yield record.unpack(blocks[at + 28 + header : at + 28 + size], high << 32 | low)
        at += length


def pairs(file: Path) -> tuple[list[int], list[int]]:
    """Read pairs of 64-bit numbers."""
    numbers = array("q", file.read_bytes())
    return list(numbers[::2]), list(numbers[1::2])


def errors_ns(name: str, written: bytes, received: Received, instants_ns: list[int]) -> list[int]:
    """How late each character's time is. Broken if not exactly the written characters came."""
    if received.data != written:
        same = len(os.path.commonprefix([received.data, written]))
        raise Broken(
            f"{name}: {len(written)} characters written, {len(received.data)} received, "
            f"the first difference after {same}"
        )
    return [time_ns - instant_ns for time_ns, instant_ns in zip(received.times_ns, instants_ns, strict=True)]


def play(folder: Path, written: bytes) -> Measured:
    """Let the writer play to both readers and measure."""
    (folder / "data").write_bytes(written)
    master_a, slave_a, port_a = pseudo_terminal()
    master_b, slave_b, port_b = pseudo_terminal()
    writer = compile_into(folder, "writer")
    c_reader = start_c_reader(compile_into(folder, "reader"), port_b, folder / "c")
    sistap = start_sistap(port_a, folder / "sistap.pcapng")
    before_s = cpu_s(sistap), cpu_s(c_reader)
    started_s = time.monotonic()
    ends = [str(master_a), str(master_b)]
    command = [writer, str(folder / "data"), str(folder / "instants"), *ends, str(SETTINGS.character_ns)]
    subprocess.run(command, check=True, pass_fds=(master_a, master_b))
    elapsed_s = time.monotonic() - started_s
    after_s = cpu_s(sistap), cpu_s(c_reader)

    sistap.send_signal(signal.SIGINT)
    _, said = sistap.communicate(timeout=PATIENCE_S)
    if sistap.returncode != 0:
        raise Broken(f"sistap ended with exit code {sistap.returncode}: {said.strip()}")
    for descriptor in (slave_a, slave_b, master_a, master_b):
        os.close(descriptor)
    c_reader.wait(PATIENCE_S)

    instants_a, instants_b = pairs(folder / "instants")
    characters, times_ns = pairs(folder / "c")
    received = from_sistap(folder / "sistap.pcapng")
    return Measured(
        elapsed_s,
        errors_ns("sistap", written, received, instants_a),
        received.uncertainties_ns,
        margins_ns(received),
        errors_ns("the C reader", written, Received(bytes(characters), times_ns, [], []), instants_b),
        *((after - before) / elapsed_s for before, after in zip(before_s, after_s, strict=True)),
    )


def report(measured: Measured) -> None:
    """Print the table and whether the goals are met."""
    ours, plain = sorted(measured.sistap_ns), sorted(measured.c_ns)
    count = len(ours)
    print(f"{count} characters in {measured.elapsed_s:.1f} s, 0 lost\n")
    print(f"{'late by, us':<14}{'sistap':>10}{'C reader':>10}{'ratio':>8}")
    for name, quantile in QUANTILES.items():
        at = min(int(quantile * count), count - 1)
        ratio = ours[at] / plain[at]
        goal = f"  goal {GOAL_RATIO}: {'met' if ratio <= GOAL_RATIO else 'NOT MET'}" if name in GOAL_QUANTILES else ""
        print(f"{name:<14}{ours[at] / 1e3:>10.1f}{plain[at] / 1e3:>10.1f}{ratio:>8.2f}{goal}")
    print(f"{'share of core':<14}{measured.sistap_share:>10.1%}{measured.c_share:>10.1%}")
    early = sum(error < 0 for error in ours)
    print(f"\nuncertainty that sistap declared: {sorted(measured.uncertainties_ns)[count // 2] / 1e3:.0f} us (median)")
    print(f"late by more than that                   {exceeding(measured.sistap_ns, measured.uncertainties_ns):>9.3%}")
    print(f"late by more than that, see same read    {exceeding(measured.sistap_ns, measured.margins_ns):>9.3%}")
    print(f"before the true time                     {early / count:>9.3%}")


def exceeding(errors: list[int], bounds: list[int]) -> float:
    """What share of the errors is above its bound."""
    return sum(error > bound for error, bound in zip(errors, bounds, strict=True)) / len(errors)


def main() -> int:
    """Measure once."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60, help="how long to play (default 60)")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="sistap-benchmark-") as folder:
        try:
            report(play(Path(folder), stream(arguments.seconds)))
        except (Broken, OSError, subprocess.SubprocessError) as error:
            print(f"reader.py: {error}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
