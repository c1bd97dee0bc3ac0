#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""How exact are the times of `sistap capture`, and what do they cost, compared with a minimal reader in C?

python3 reader.py [--seconds 60] [--lines 2]

One writer plays back-to-back SIS telegrams at 115200 Bd 8E1 through pseudo terminals, into sistap and into reader.c;
with two lines, into both at once. README.md explains the table. Exit code 1 if a character was lost or something broke;
a missed goal is only reported.
"""

from __future__ import annotations

import argparse
import itertools
import os
import subprocess
import sys
import tempfile
from bisect import bisect
from itertools import accumulate, pairwise
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

from playing import (  # noqa: E402
    PATIENCE_S,
    SETTINGS,
    Broken,
    Look,
    Program,
    columns,
    compile_into,
    listening,
    play,
    start_sistap,
    stop_sistap,
    terminals,
)
from telegrams import telegrams  # noqa: E402

from sistap.dissected.captures.reading import records  # noqa: E402
from sistap.tap.line import priority  # noqa: E402
from sistap.tap.line.settings import Flag  # noqa: E402
from sistap.tap.records.record import Type  # noqa: E402

LINE_NUMBERS = {1: (0,), 2: (1, 2)}  # line numbers in a capture of that many lines
QUANTILES = {"p50": 0.5, "p90": 0.9, "p99": 0.99, "p99.9": 0.999, "max": 1.0}
GOAL_QUANTILES = ("p50", "p99")
GOAL_RATIO = 1.5
FEWEST_READS = 100  # in a second that counts
GOAL_SHARE = 0.18  # of a core at full speed, one character a read


class Received(NamedTuple):
    """What a reader received on a line, one entry for each character; the C reader declares no uncertainty."""

    data: bytes
    times_ns: list[int]
    uncertainties_ns: list[int]
    same_read: list[bool]  # came in the same read as the one before


class Line(NamedTuple):
    """The results for a line: for each character its delay, and what sistap declared, in ns."""

    sistap_ns: list[int]
    uncertainties_ns: list[int]
    margins_ns: list[int]  # the delay that the record allows
    c_ns: list[int]
    reads_ns: list[int]  # of sistap
    c_reads_ns: list[int]


class Measured(NamedTuple):
    """One run: its lines, sistap's description of its times, and how much of a core both had used each second."""

    timing: str
    lines: list[Line]
    looks: list[Look]

    @property
    def elapsed_s(self) -> float:
        """Return how long it took."""
        return (self.looks[-1].time_ns - self.looks[0].time_ns) / 1e9


class Cost(NamedTuple):
    """What reading cost a program: its reads, and the processor time of each, in us."""

    reads: int
    mean_us: float
    quickest_us: float  # in the second in which it was least: in the others, this computer did more than that


def stream(seconds: float) -> bytes:
    """Return as many whole telegrams as fit into the time."""
    size = int(seconds * 1e9 / SETTINGS.character_ns)
    lengths = accumulate(map(len, telegrams()))
    count = sum(1 for _ in itertools.takewhile(lambda length: length <= size, lengths))
    return b"".join(itertools.islice(telegrams(), count))


def start_c_reader(folder: Path, file: Path, ports: list[str]) -> Program:
    """Start the C reader with the priority of sistap; return when it listens."""
    program = compile_into(folder, "reader")
    with priority.real_time():
        process = subprocess.Popen([program, str(file), *ports], stdout=subprocess.PIPE, text=True)
    listening(process, process.stdout, "ready")
    return process


def from_sistap(file: Path, line: int) -> Received:
    """Return the characters of a line in a capture."""
    data, times_ns, uncertainties_ns, same_read = bytearray(), list[int](), list[int](), list[bool]()
    for taken in records(file):
        if taken.line == line and taken.type != Type.EVENT:
            data += taken.data
            times_ns += accumulate(taken.intervals[1:], initial=taken.time_ns)
            uncertainties_ns += [taken.uncertainty_ns] * len(taken.data)
            same_read += [bool(flag & Flag.SAME_READ) for flag in taken.flags]
    return Received(bytes(data), times_ns, uncertainties_ns, same_read)


def from_c_reader(file: Path, port: int) -> Received:
    """Return the characters of a port in the C reader's output."""
    rows = [(character, time_ns) for of, character, time_ns in zip(*columns(file, 3), strict=True) if of == port]
    return Received(bytes(character for character, _ in rows), [time_ns for _, time_ns in rows], [], [])


def margins_ns(received: Received) -> list[int]:
    """Return the largest delay of each time: the uncertainty, plus a character time for each later one of the same
    read.
    """
    margins, following, next_is_same = list[int](), 0, False
    for uncertainty_ns, same in zip(reversed(received.uncertainties_ns), reversed(received.same_read), strict=True):
        following = following + 1 if next_is_same else 0
        margins.append(uncertainty_ns + following * SETTINGS.character_ns)
        next_is_same = same
    return margins[::-1]


def errors_ns(name: str, written: bytes, received: Received, instants_ns: list[int]) -> list[int]:
    """Return the delay of each character's time. Broken unless exactly the written characters came."""
    if received.data != written:
        same = len(os.path.commonprefix([received.data, written]))
        raise Broken(
            f"{name}: {len(written)} characters written, {len(received.data)} received, "
            f"the first difference after {same}"
        )
    return [time_ns - instant_ns for time_ns, instant_ns in zip(received.times_ns, instants_ns, strict=True)]


def measure(folder: Path, written: bytes, numbers: tuple[int, ...]) -> Measured:
    """Play to both readers and measure; `numbers` are those of sistap's lines."""
    with terminals(2 * len(numbers)) as ends:
        paths = [end.path for end in ends]  # sistap's and the C reader's take turns
        c_reader = start_c_reader(folder, folder / "c", paths[1::2])
        sistap, timing = start_sistap(folder / "sistap.tap.files.pcapng", paths[::2])
        played = play(folder, written, ends, [sistap, c_reader])
        stop_sistap(sistap)
    c_reader.wait(PATIENCE_S)

    lines = []
    for i, number in enumerate(numbers):
        received = from_sistap(folder / "sistap.tap.files.pcapng", number)
        instants_ns, c_instants_ns = played.instants_ns[2 * i : 2 * i + 2]
        late_ns = errors_ns("sistap", written, received, instants_ns)
        c_received = from_c_reader(folder / "c", i)
        c_late_ns = errors_ns("the C reader", written, c_received, c_instants_ns)
        reads_ns = [time_ns for time_ns, same in zip(received.times_ns, received.same_read, strict=True) if not same]
        reads = reads_ns, sorted(set(c_received.times_ns))
        lines.append(Line(late_ns, received.uncertainties_ns, margins_ns(received), c_late_ns, *reads))
    return Measured(timing, lines, played.looks)


def cost(looks: list[Look], program: int, reads_ns: list[int]) -> Cost:
    """Return what the reads of a program cost: 0 is sistap, 1 the C reader."""
    spent = [(look.used_ns[program] / 1e3, bisect(reads_ns, look.time_ns)) for look in looks]
    seconds = [(later - us, after - before) for (us, before), (later, after) in pairwise(spent)]
    mean_us = (spent[-1][0] - spent[0][0]) / len(reads_ns)
    return Cost(
        len(reads_ns), mean_us, min((us / reads for us, reads in seconds if reads >= FEWEST_READS), default=mean_us)
    )


def quantiles(values: list[int]) -> dict[str, int]:
    """Return each of QUANTILES."""
    ordered = sorted(values)
    return {name: ordered[min(int(share * len(ordered)), len(ordered) - 1)] for name, share in QUANTILES.items()}


def report(measured: Measured) -> None:
    """Print the tables and whether the goals are met."""
    print(f"sistap: {measured.timing}")
    for line in measured.lines:
        report_line(line, measured.elapsed_s)
    ours = cost(measured.looks, 0, sorted(time_ns for line in measured.lines for time_ns in line.reads_ns))
    theirs = cost(measured.looks, 1, sorted(time_ns for line in measured.lines for time_ns in line.c_reads_ns))
    full = 1e9 / SETTINGS.character_ns * len(measured.lines) / 1e6  # reads in a us, if each character comes alone
    share, c_share = (of.reads * of.mean_us / measured.elapsed_s / 1e6 for of in (ours, theirs))
    print(f"\n{'reads':<18}{ours.reads:>10}{theirs.reads:>10}")
    print(f"{'share of core':<18}{share:>10.1%}{c_share:>10.1%}")
    print(f"{'us a read':<18}{ours.mean_us:>10.1f}{theirs.mean_us:>10.1f}")
    print(f"{'... at best':<18}{ours.quickest_us:>10.1f}{theirs.quickest_us:>10.1f}")
    worst = ours.quickest_us * full
    goal = f"  goal {GOAL_SHARE:.0%} a line: {'met' if worst <= GOAL_SHARE * len(measured.lines) else 'NOT MET'}"
    print(f"{'each alone, share':<18}{worst:>10.1%}{theirs.quickest_us * full:>10.1%}{goal}")


def report_line(line: Line, elapsed_s: float) -> None:
    """Print the table of one line."""
    count = len(line.sistap_ns)
    pace = count * SETTINGS.character_ns / 1e9 / elapsed_s  # a writer that must wait is slower than the line
    print(f"\n{count} characters in {elapsed_s:.1f} s ({pace:.0%} of a busy line), 0 lost\n")
    print(f"{'late by, us':<14}{'sistap':>10}{'C reader':>10}{'ratio':>8}")
    plain = quantiles(line.c_ns)
    for name, ours in quantiles(line.sistap_ns).items():
        ratio = ours / plain[name]
        goal = f"  goal {GOAL_RATIO}: {'met' if ratio <= GOAL_RATIO else 'NOT MET'}" if name in GOAL_QUANTILES else ""
        print(f"{name:<14}{ours / 1e3:>10.1f}{plain[name] / 1e3:>10.1f}{ratio:>8.2f}{goal}")
    early = sum(error < 0 for error in line.sistap_ns)
    print(f"uncertainty that sistap declared: {sorted(line.uncertainties_ns)[count // 2] / 1e3:.0f} us (median)")
    print(f"late by more than that                   {exceeding(line.sistap_ns, line.uncertainties_ns):>9.3%}")
    print(f"late by more than that, see same read    {exceeding(line.sistap_ns, line.margins_ns):>9.3%}")
    print(f"before the true time                     {early / count:>9.3%}")


def exceeding(errors: list[int], bounds: list[int]) -> float:
    """Return the share of the errors that exceed their bounds."""
    return sum(error > bound for error, bound in zip(errors, bounds, strict=True)) / len(errors)


def main() -> int:
    """Measure once."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60, help="how long to play (default 60)")
    parser.add_argument("--lines", type=int, choices=LINE_NUMBERS, default=1, help="lines captured at once (default 1)")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="sistap-benchmark-") as folder:
        try:
            report(measure(Path(folder), stream(arguments.seconds), LINE_NUMBERS[arguments.lines]))
        except (Broken, OSError, subprocess.SubprocessError) as error:
            print(f"reader.py: {error}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
