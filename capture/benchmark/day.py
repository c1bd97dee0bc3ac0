#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Does a recorder that runs for months lose anything? A day of a busy line, in as little time as this machine takes.

    python3 day.py --characters 1e8 --seed 1

Telegrams, some of them damaged, and noise go into a pseudo terminal, three times as fast as the fastest bus, while
`sistap record` reads it. At random moments the adapter is unplugged, or the recorder is ended or killed and
starts again. Then all files are compared with what was sent: each character is in exactly one file of the ring, or
behind the last one before an unplugging, which an event names, or before a kill. Everything damaged is in exactly one
kept file, less what the recorder says was not tested with the filter. The same seed sends the same characters.

Exit code 1 if anything is missing elsewhere, is there twice or changed, or if memory or descriptors grow.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from plugged import Adapter  # noqa: E402
from telegrams import telegrams  # noqa: E402

from sistap.dissected.captures import reading  # noqa: E402
from sistap.tap.records.record import Event, Record, Type  # noqa: E402
from sistap.tap.sis.telegram import build  # noqa: E402
from sistap.tap.terminal.exits import NotCaptured  # noqa: E402

PATIENCE_S = 120
UNPLUG, END, KILL = "unplugged", "ended", "killed"
SKIPPED = "records not tested"
_SKIPPED = re.compile(r": (\d+) records were not tested with the filter$", re.MULTILINE)
BETWEEN = 300_000  # characters from one unplugging to the next, on average; in a short day there are four
LASTS = 50_000_000  # characters, in which a recorder is once ended and once killed
ON_THE_WAY = 20_000  # characters: a kernel holds 12,288, sistap those of a read and a telegram that is not complete
DAMAGED = 1 / 1000  # of the telegrams
PIECE = 2_000  # characters that are sent at once
PER_SECOND = 30_000  # characters at most: 115200 Bd carries 10,473. As fast as possible, tshark would be too slow
LOOK = 20_000  # characters between two looks at what a recorder takes of the machine
FEWEST = 600  # looks; before, what it remembers has not reached its bounds, and nobody sees growth
RECEIVED = (Type.FRAME, Type.OTHER)  # a file of a ring begins with other records
BEFORE_NS = 50_000_000
KEEP = ("--keep", "faults", "--keep", "sertap.type == 1", "--before", "0.05", "--after", "0.05")
RECORDER = ("--wait-for-port", *KEEP, "--at-most", "1000000", "-b", "filesize:200")


def traffic(chance: random.Random) -> Iterator[bytes]:
    """Yield telegrams without end: others each time, some damaged, and noise between some."""
    for number, telegram in enumerate(telegrams()):
        yield build(0x1F, 16, 5, b"\x3c\x05\x00\x24\x00" + number.to_bytes(4, "little"))
        yield build(0x1F, 16, 5, b"\x00\x3c\x05", reaction=True)
        yield chance.choice(_DAMAGES)(chance, telegram) if chance.random() < DAMAGED else telegram


def _changed(chance: random.Random, telegram: bytes) -> bytes:
    place = chance.randrange(len(telegram))
    return telegram[:place] + chance.randbytes(1) + telegram[place + 1 :]


def _cut(chance: random.Random, telegram: bytes) -> bytes:
    return telegram[: chance.randrange(len(telegram))]


def _noise(chance: random.Random, telegram: bytes) -> bytes:
    return chance.randbytes(chance.randrange(1, 600)) + telegram


_DAMAGES: Sequence[Callable[[random.Random, bytes], bytes]] = (_changed, _cut, _noise)


class Look(NamedTuple):
    """What a process has at one time."""

    memory_mb: float
    descriptors: int


class Recorder:
    """A recorder that runs, and what it said until now."""

    def __init__(self, adapter: Adapter, folder: Path) -> None:
        """Start. TimeoutError, now and later, if it does not do what it has to."""
        self._said = folder / "said"
        self.looks: list[Look] = []
        command = [sys.executable, "-m", "sistap", "record", "-i", str(adapter.name), "-w", str(folder / "kept")]
        with self._said.open("wb") as errors:
            self._process = subprocess.Popen([*command, *RECORDER], stderr=errors, cwd=HERE.parent)

    @property
    def said(self) -> str:
        """What it has said."""
        return self._said.read_text(errors="replace")

    def wait_for(self, happens: Callable[[], bool]) -> None:
        """Wait until something happens. TimeoutError if it does not, or the recorder has ended."""
        end_s = time.monotonic() + PATIENCE_S
        while not happens():
            if time.monotonic() > end_s or self._process.poll() is not None:
                raise TimeoutError(f"the recorder does not go on: {self.said}")
            time.sleep(0.01)

    def wait_until_said(self, text: str, times: int = 1) -> None:
        """Wait for a line of standard error."""
        self.wait_for(lambda: self.said.count(text) >= times)

    def look(self) -> None:
        """Note what it takes of the machine."""
        process = Path(f"/proc/{self._process.pid}")
        memory = next(line for line in (process / "status").read_text().splitlines() if line.startswith("VmRSS"))
        self.looks.append(Look(int(memory.split()[1]) / 1000, len(list((process / "fd").iterdir()))))

    def hold(self) -> None:
        """Let it do nothing until its end."""
        self._process.send_signal(signal.SIGSTOP)
        os.waitid(os.P_PID, self._process.pid, os.WSTOPPED | os.WEXITED | os.WNOWAIT)

    def end(self, number: signal.Signals) -> int:
        """End it; return its exit code."""
        self._process.send_signal(number)
        self._process.send_signal(signal.SIGCONT)
        return self._process.wait(PATIENCE_S)


class Shelved(NamedTuple):
    """A record of the ring."""

    time_ns: int
    is_damaged: bool
    is_kept: bool


class Run:
    """From the start of a recorder to its end: what was sent, and what has to be in its files."""

    def __init__(self, adapter: Adapter, folder: Path) -> None:
        """Plug the adapter in, and start."""
        self._adapter = adapter
        self._folder = folder / "kept"
        self._sent = [bytearray()]  # from one unplugging to the next
        adapter.plug()
        self.recorder = Recorder(adapter, folder)
        self.how = ""  # it ended
        self.lost: Counter[str] = Counter()  # characters, by why
        self.damaged = self.kept = 0  # records
        self.faults: list[str] = []

    def send(self, data: bytes) -> None:
        """Send it, and keep it for the judge."""
        self._sent[-1] += data
        self._adapter.send(data)

    def unplug(self) -> None:
        """Unplug the adapter, and plug it in again."""
        self._adapter.unplug()
        self._adapter.plug()
        self.recorder.wait_until_said(" is back after ", len(self._sent))
        self._sent.append(bytearray())

    def end(self, how: str) -> None:
        """End it one way or the other, and judge."""
        self.how = how
        code = self._stop_with_something_unread() if how == END else self.recorder.end(signal.SIGKILL)
        self._adapter.unplug()
        if code != (0 if how == END else -signal.SIGKILL):
            self.faults.append(f"exit code {code}: {self.recorder.said}")
        try:
            self._judge()
        except NotCaptured as error:
            self.faults.append(str(error))

    def close(self) -> None:
        """Leave nothing running."""
        self.recorder.end(signal.SIGKILL)
        self._adapter.unplug()

    def _stop_with_something_unread(self) -> int:
        """End it by SIGTERM while characters wait that have arrived; return its exit code."""
        last = build(0x1F, 16, 6, b"\x3c\x06\x00\x24\x00" + len(self._sent[-1]).to_bytes(4, "little"))
        self.send(b"\0" + last)
        self.recorder.wait_for(lambda: any(last in tail for tail in self._tails()))
        self.recorder.hold()
        self.send(last + last[:7])
        self.recorder.wait_for(lambda: self._adapter.waiting >= len(last) + 7)  # FF counts twice
        return self.recorder.end(signal.SIGTERM)

    def _tails(self) -> Iterator[bytes]:
        """Yield the ends of the newest file and of the one before: it may just have been full."""
        return (file.read_bytes()[-4 * PIECE :] for file in _ring(self._folder)[-2:])

    def _judge(self) -> None:
        """Compare the files with what was sent, and remove them."""
        kept = Counter(
            record for file in self._folder.glob("kept_*") for record in _records(file) if record.type in RECEIVED
        )
        arrived = [bytearray()]
        seen: Counter[Record] = Counter()  # those of them that are kept
        shelved = []
        for record in (record for file in _ring(self._folder) for record in _records(file)):
            if record.type in RECEIVED:
                arrived[-1] += record.data
                shelved.append(Shelved(record.time_ns, record.type == Type.OTHER, record in kept))
                if record in kept:
                    seen[record] += 1
            elif record.event == Event.ADAPTER_LOST:
                arrived.append(bytearray())
        self._judge_characters(arrived)
        if alone := kept - seen:
            self.faults.append(f"{alone.total()} kept records are not in the ring, or more often than there")
        self._judge_kept(shelved)
        for file in self._folder.iterdir():
            file.unlink()

    def _judge_characters(self, arrived: list[bytearray]) -> None:
        if len(arrived) != len(self._sent):
            self.faults.append(f"{len(arrived) - 1} unpluggings are named, and there were {len(self._sent) - 1}")
        for number, (sent, came) in enumerate(zip(self._sent, arrived, strict=False), 1):
            why = UNPLUG if number < len(self._sent) else self.how
            missing = len(sent) - len(came)
            if not sent.startswith(came):
                same = (place for place, pair in enumerate(zip(sent, came, strict=False)) if pair[0] != pair[1])
                self.faults.append(f"character {next(same, len(sent))} of {len(sent)} is another one, or is missing")
            elif missing > (0 if why == END else ON_THE_WAY):
                self.faults.append(f"{missing} characters are missing before it was {why}")
            self.lost[why] += missing

    def _judge_kept(self, ring: list[Shelved]) -> None:
        damaged = [number for number, record in enumerate(ring) if record.is_damaged]
        self.damaged, self.kept = len(damaged), sum(ring[number].is_kept for number in damaged)
        # What was not yet judged when the recorder was killed is all at the end of the ring.
        due = damaged if self.how == END else damaged[: self.kept]
        wanted = {place for number in due for place in _just_before(ring, number)}
        missing = sum(not ring[place].is_kept for place in wanted)
        self.lost[SKIPPED] += (skipped := sum(map(int, _SKIPPED.findall(self.recorder.said))))
        if missing > skipped:
            last = self.recorder.said.splitlines()[-1:]
            self.faults.append(f"{missing} records of {len(wanted)} are not kept, {skipped} of them named: {last}")

    def grown(self) -> str:
        """Say what has grown with the time."""
        if len(self.recorder.looks) < FEWEST:
            return ""
        quarter = len(self.recorder.looks) // 4
        early, late = self.recorder.looks[quarter : 2 * quarter], self.recorder.looks[-quarter:]
        memory = min(look.memory_mb for look in late) > 1.1 * max(look.memory_mb for look in early)
        descriptors = min(look.descriptors for look in late) > max(look.descriptors for look in early)
        return " and ".join(["memory"] * memory + ["descriptors"] * descriptors)


def _ring(folder: Path) -> list[Path]:
    return sorted(folder.glob("ring_*"))


def _records(file: Path) -> Iterator[Record]:
    """Read a file; a recorder that was killed can leave one that has nothing in it."""
    return (record for packet in reading.packets(file) if (record := reading.record_of(packet)))


def _just_before(ring: list[Shelved], number: int) -> Iterator[int]:
    """Yield the places of a record and of those before it that are to be in the same file."""
    since_ns = ring[number].time_ns - BEFORE_NS
    while number >= 0 and ring[number].time_ns >= since_ns:
        yield number
        number -= 1


def plan(chance: random.Random, characters: int) -> Iterator[tuple[int, str]]:
    """Yield what happens, each with the number of characters before it; the end of the day is the last."""
    ends = 1 + characters // LASTS
    incidents = [UNPLUG] * max(4, characters // BETWEEN) + [END, KILL] * ends
    chance.shuffle(incidents)
    places = sorted(chance.randrange(characters) for _ in incidents)
    now = 0
    for place, incident in [*zip(places, incidents, strict=True), (characters, END)]:
        yield place - now, incident
        now = place


def day(characters: int, seed: int, folder: Path) -> Iterator[Run]:
    """Yield each run, judged. TimeoutError says that a recorder did not do what it has to."""
    telegram = traffic(random.Random(seed))
    run: Run | None = None
    with Adapter(folder / "adapter") as adapter:
        try:
            for count, incident in plan(random.Random(seed), characters):
                run = run or Run(adapter, folder)
                run.recorder.wait_until_said("capturing on ")
                _send(run, telegram, count)
                run.recorder.look()
                if incident == UNPLUG:
                    run.unplug()
                else:
                    run.end(incident)
                    yield run
                    run = None
        finally:
            if run:
                run.close()


def _send(run: Run, telegram: Iterator[bytes], characters: int) -> int:
    """Send so many characters or a little more; return how many."""
    sent = 0
    while sent < characters:
        piece = bytearray()
        while len(piece) < min(PIECE, characters - sent):
            piece += next(telegram)
        time.sleep(len(piece) / PER_SECOND)
        run.send(bytes(piece))
        sent += len(piece)
        if sent % LOOK < len(piece):
            run.recorder.look()
    return sent


def main(arguments: Sequence[str] | None = None) -> int:
    """Send, judge, print; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--characters", type=float, default=1e6, help="so many are sent (1e6); a day at 9600 Bd: 7.5e7")
    parser.add_argument("--seed", type=int, default=1, help="of everything random (1)")
    args = parser.parse_args(arguments)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that no recorder stays behind
    started_s = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="day-") as folder:
        try:
            lost, faults = _tell(day(int(args.characters), args.seed, Path(folder)))
        except TimeoutError as error:
            sys.exit(f"day.py: {error}")
    named = ", ".join(f"{count} {why}" for why, count in sorted(lost.items()) if count) or "none"
    print(f"{args.characters:.3g} characters in {time.monotonic() - started_s:.0f} s; lost and named: {named}")
    print("NOT everything is where it has to be" if faults else "everything else is in exactly one file")
    return int(faults > 0)


def _tell(runs: Iterator[Run]) -> tuple[Counter[str], int]:
    """Print a line for each run; return which characters were lost, and how many faults there are."""
    lost: Counter[str] = Counter()
    faults = 0
    print("    run  how     damaged   kept  lost by unplugging, by the end  memory, MB  descriptors", flush=True)
    for number, run in enumerate(runs, 1):
        first, last = run.recorder.looks[0], run.recorder.looks[-1]
        print(
            f"{number:7}  {run.how:6}  {run.damaged:7}  {run.kept:5}  {run.lost[UNPLUG]:18}  {run.lost[run.how]:10}  "
            f"{first.memory_mb:4.0f} to {last.memory_mb:3.0f}  {first.descriptors:4} to {last.descriptors}",
            flush=True,
        )
        if grown := run.grown():
            run.faults.append(f"{grown} grew")
        for fault in run.faults:
            print(f"FAULT: {fault}", flush=True)
        lost += run.lost
        faults += len(run.faults)
    return lost, faults


if __name__ == "__main__":
    sys.exit(main())
