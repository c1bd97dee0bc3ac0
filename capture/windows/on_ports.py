# SPDX-License-Identifier: GPL-2.0-or-later
"""Captures from COM5 and COM15: every character and its time, a search for the rate, a followed rate change."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from wine import TIMEOUT_S, Wine, drive, until

from sistap.dissected.captures.reading import records
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag
from sistap.tap.records.record import Record, Type

sys.path.append(str(Path(__file__).resolve().parents[1] / "benchmark"))
from beside import latest_times  # noqa: E402

SENT = bytes(range(256)) * 2
PAUSE_S = 0.002  # longer than a character
SOME = 30  # telegrams

# An uncertainty is a p99.9: 1 character in 1000 may have waited for longer (docs/times.md). Characters of the same read
# waited for the same reason, so they count once. By chance, more than 4 of 512 did so in one check of 5000.
MOST_EARLIER = 4

# A pseudo terminal carries no parity, and wine refuses 8E1 there after the first time.
FORMAT = ("--format", "8N1", "--force")


class Sending(NamedTuple):
    """The bounds of the time when a character was sent, in ns."""

    begun_ns: int
    done_ns: int


class Told(NamedTuple):
    """What its record says of a character: when it came, in ns, and with which read."""

    read: int
    earliest_ns: int
    latest_ns: int


def capture(wine: Wine, port: str) -> str:
    """Send characters one by one: the capture has exactly these, at their times."""
    file = wine.folder / "out.pcapng"
    with wine.terminal(port) as ours:
        command = ["-m", "sistap", "capture", "-i", port, *FORMAT, "-w", drive(file), "-a", "duration:6"]
        process = wine.start(wine.python, *command)
        said = until(process, "capturing on")
        sent = [_send(ours, bytes([value])) for value in SENT]
        said += process.communicate(timeout=TIMEOUT_S)[0]
    assert process.returncode == 0, said
    heard = [record for record in records(file) if record.type != Type.EVENT]
    received = b"".join(record.data for record in heard)
    assert received == SENT, f"{len(received)} of {len(SENT)} characters\n{said}"
    return f"{len(received)} characters" + _timed(heard, sent)


def _send(ours: int, character: bytes) -> Sending:
    time.sleep(PAUSE_S)
    begun_ns = time.time_ns()
    os.write(ours, character)
    return Sending(begun_ns, time.time_ns())


def _timed(heard: Sequence[Record], sent: Sequence[Sending]) -> str:
    """Check when each character came, by its record, against the time when it was sent."""
    if all(record.uncertainty_ns == UNCERTAINTY_UNKNOWN for record in heard):
        return ", times of unknown uncertainty"
    judged = list(zip(_told(heard), sent, strict=True))
    unsent = [sending.begun_ns - told.latest_ns for told, sending in judged if told.latest_ns < sending.begun_ns]
    assert not unsent, f"{len(unsent)} characters have a time before they were sent, up to {max(unsent)} ns"
    early = [(told.read, told.earliest_ns - sending.done_ns) for told, sending in judged]
    early = [(read, ns) for read, ns in early if ns > 0]
    reads = len({read for read, _ in early})
    assert reads <= MOST_EARLIER, f"{reads} reads came earlier than told, up to {max(ns for _, ns in early)} ns"
    widest_ms = max(record.uncertainty_ns for record in heard) / 1e6
    return f", times within {widest_ms:.1f} ms" + (f", but {reads} earlier" if reads else "")


def _told(heard: Sequence[Record]) -> Iterator[Told]:
    """Yield what the records say of each character."""
    read = 0
    for record, times in zip(heard, latest_times(heard), strict=True):
        for flags, latest_ns in zip(record.flags, times, strict=True):
            read += not flags & Flag.SAME_READ
            yield Told(read, latest_ns - record.uncertainty_ns, latest_ns)


def looked_for(wine: Wine) -> str:
    """Find the rate of a bus without --baud."""
    file = wine.folder / "auto.pcapng"
    with wine.bus("COM15", "--baud", "19200", "--format", "8N1"):
        said = wine.sistap(
            "capture", "-i", "COM15", "--baud", "auto", *FORMAT, "-w", drive(file), "-c", str(SOME), "-a", "duration:60"
        )
    rates = _rates(file)
    assert rates[-SOME // 2 :] == [19200] * (SOME // 2), f"{rates}\n{said}"
    return f"19200 Bd, {rates.count(19200)} telegrams"


def followed(wine: Wine) -> str:
    """Follow a rate change of the bus."""
    file = wine.folder / "follow.pcapng"
    with wine.bus("COM5", "--rates", "38400,9600", "--format", "8N1"):
        said = wine.sistap(
            "capture", "-i", "COM5", "--follow-baud", *FORMAT, "-w", drive(file), "-c", "100", "-a", "duration:60"
        )
    rates = _rates(file)
    assert set(rates) == {9600, 38400}, f"{rates}\n{said}"
    return f"9600 and 38400 Bd, {len(rates)} telegrams"


def _rates(file: Path) -> list[int]:
    """Return the rates of the good telegrams."""
    return [record.settings.baud for record in records(file) if record.type == Type.FRAME and not record.checksum_bad]
