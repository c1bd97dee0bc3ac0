# SPDX-License-Identifier: GPL-2.0-or-later
"""Captures from COM5 and COM15: every character and its time, a search for the rate, a followed rate change."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from wine import TIMEOUT_S, Wine, drive, until

from sistap.captures.reading import records
from sistap.line.settings import UNCERTAINTY_UNKNOWN
from sistap.records.record import Record, Type

SENT = bytes(range(256)) * 2
PAUSE_S = 0.002
SOME = 30  # telegrams

# A pseudo terminal carries no parity, and wine refuses 8E1 there after the first time.
FORMAT = ("--format", "8N1", "--force")


class Sending(NamedTuple):
    """The bounds of the time when a character was sent, in ns."""

    begun_ns: int
    done_ns: int


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
    """Check the times of all characters against the bounds in the record."""
    if all(record.uncertainty_ns == UNCERTAINTY_UNKNOWN for record in heard):
        return ", times of unknown uncertainty"
    judged = list(zip(_times(heard), sent, strict=True))
    early = [at_ns - sending.begun_ns for (at_ns, _), sending in judged if at_ns < sending.begun_ns]
    late = [at_ns - bound_ns - sending.done_ns for (at_ns, bound_ns), sending in judged]
    late = [ns for ns in late if ns > 0]
    assert not early, f"{len(early)} characters have a time before they were sent, up to {-min(early)} ns"
    assert not late, f"{len(late)} characters came later than the bound says, up to {max(late)} ns"
    return f", times within {max(bound_ns for (_, bound_ns), _ in judged) / 1e6:.1f} ms"


def _times(heard: Sequence[Record]) -> Iterator[tuple[int, int]]:
    """Yield the time of each character and its uncertainty, in ns."""
    for record in heard:
        now_ns = record.time_ns
        for number in range(len(record.data)):
            now_ns += record.intervals[number] if number else 0
            yield now_ns, record.uncertainty_ns


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
