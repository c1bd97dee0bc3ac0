# SPDX-License-Identifier: GPL-2.0-or-later
"""Several tsharks in turn say about each record what a single one would, wherever the seams are."""

from __future__ import annotations

import itertools
import os
import signal
import time
from collections.abc import Iterator
from queue import SimpleQueue
from typing import cast

import pytest
from portable import signals

from sistap import cli
from sistap.commands.recorder.reasons import ByFilter
from sistap.dissected.captures.reading import records
from sistap.dissected.explain.relay import Entry, JudgedEntry, Relay, Seams
from sistap.dissected.explain.running import Running
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files.pcapng import Interface
from sistap.tap.files.writer import Blocks
from sistap.tap.records.before import heard
from sistap.tap.records.record import Record
from sistap.tap.terminal.console import visible

PATIENCE_S = 60
SECOND = 1_000_000_000
SEAMS = Seams(packets=101, context_ns=SECOND)
# Only of a reaction whose command is known, and a limit, TrS, that only the first telegrams have told.
FILTER = "sis.trs.verdict"

LINE = Interface(252, "a line of a test")


@pytest.fixture(scope="module")
def traffic(tmp_path_factory: pytest.TempPathFactory) -> list[Record]:
    """Limits that are told once, then commands and reactions, some of them late."""
    path = tmp_path_factory.mktemp("traffic") / "x.pcapng"
    assert cli.main(["bus", "late-reaction", "--cycles", "15", "-w", str(path)]) == 0
    return [record for number, record in enumerate(records(path)) if number < 20 or not is_about_limits(record)]


def is_about_limits(record: Record) -> bool:
    return record.data[5:6] == b"\x03"


@pytest.fixture(scope="module")
def expected(tshark: Tshark, traffic: list[Record], tmp_path_factory: pytest.TempPathFactory) -> list[int]:
    """Return what a single tshark finds, as numbers of records."""
    path = tmp_path_factory.mktemp("expected") / "x.pcapng"
    blocks = Blocks({0: LINE})
    path.write_bytes(blocks.section() + b"".join(map(blocks.packet, traffic)))
    found = tshark.output("-r", str(path), "-Y", FILTER, "-T", "fields", "-e", "frame.number").split()
    numbers = [int(number) - 1 for number in found]
    assert len(numbers) > 100
    return numbers


class Watched:
    """A relay with its records, and its results."""

    def __init__(self, tshark: Tshark, seams: Seams = SEAMS, filter_: str = FILTER) -> None:
        self.judge = ByFilter(tshark, filter_)
        self.tshark = tshark
        self.running: list[Running] = []
        self.said: list[str] = []
        self.judged: list[JudgedEntry] = []
        self.relay = Relay(self.start, self.judge.columns, self.said.append, finds=True, seams=seams, clock_s=self.tick)
        self._seconds = itertools.count()
        self._blocks = Blocks({0: LINE})

    def start(self, token: bytes | None) -> Running:
        self.running.append(Running(self.tshark, self.judge.arguments(token)))
        return self.running[-1]

    def tick(self) -> float:
        """Let a second pass at every look, so that a mark follows every record."""
        return next(self._seconds)

    def play(self, traffic: list[Record]) -> None:
        self.relay.begin(self._blocks, self._blocks.section(), traffic[:1])
        self.put(traffic[1:])

    def put(self, traffic: list[Record]) -> None:
        for record in traffic:
            self.relay.put(Entry(record.time_ns, self._blocks.packet(record), heard(record)))
            self.look()

    def look(self) -> None:
        self.judged.extend(self.relay.look())

    def wait(self, count: int) -> None:
        end_s = time.monotonic() + PATIENCE_S
        while len(self.judged) < count:
            assert time.monotonic() < end_s, (len(self.judged), self.said)
            time.sleep(0.01)
            self.look()

    def end(self) -> list[int]:
        self.judged.extend(self.relay.finish(1_000_000))
        assert self.relay.empty
        return self.found

    @property
    def found(self) -> list[int]:
        return [number for number, judged in enumerate(self.judged, 1) if judged.columns]


@pytest.fixture
def tested(tshark: Tshark) -> Iterator[Watched]:
    tested = Watched(tshark)
    yield tested
    tested.relay.close()


@pytest.mark.thorough
def test_at_seams_nothing_is_unjudged_nor_judged_twice(
    tested: Watched, traffic: list[Record], expected: list[int]
) -> None:
    tested.play(traffic[:1])
    for first in range(1, len(traffic), 60):  # what is not judged is told to the next one, too: let it be little
        tested.put(traffic[first : first + 60])
        tested.wait(first)
    assert tested.end() == expected
    assert len(tested.judged) == len(traffic) - 1
    assert [judged.entry.time_ns for judged in tested.judged] == [record.time_ns for record in traffic[1:]]
    assert tested.relay.successions >= 3 and len(tested.running) >= 4
    assert not tested.said and not tested.relay.unjudged


@pytest.mark.thorough
@signals
def test_a_tshark_that_ends_is_replaced_and_nothing_is_lost(
    tested: Watched, traffic: list[Record], expected: list[int]
) -> None:
    half = len(traffic) // 2
    tested.play(traffic[:half])
    tested.wait(1)
    os.kill(tested.running[-1].pid, signal.SIGKILL)
    tested.put(traffic[half:])
    assert tested.end() == expected
    (said,) = tested.said
    assert "tshark has ended" in said and not tested.relay.unjudged


def test_what_ends_every_tshark_is_left_out_at_last(tshark: Tshark, traffic: list[Record]) -> None:
    tested = Watched(tshark)

    def start(token: bytes | None) -> Running:
        return Running(tshark, ["--no-such-option"])

    tested.relay = Relay(start, tested.judge.columns, tested.said.append, finds=True)
    tested.play(traffic[:50])
    tested.wait(49)
    assert all(judged.is_unjudged for judged in tested.judged)
    assert "ends again and again: 49 records were not tested with the filter" in tested.said[-1]
    tested.relay.close()


@signals
def test_one_that_is_too_slow_is_told_and_the_next_goes_on(tshark: Tshark, traffic: list[Record]) -> None:
    tested = Watched(tshark, SEAMS._replace(behind=20_000))
    try:
        tested.play(traffic[:10])
        os.kill(tested.running[0].pid, signal.SIGSTOP)
        tested.put(traffic[10:200])
        (said,) = tested.said
        assert "tshark is too slow for this bus" in said and "records were not tested with the filter" in said
        assert tested.relay.unjudged == sum(judged.is_unjudged for judged in tested.judged) > 0
        tested.put(traffic[200:])
        tested.end()
        assert len(tested.judged) == len(traffic) - 1
    finally:
        tested.relay.close()


class Lying:
    """A tshark that prints a line which nobody has asked for, and then nothing."""

    def __init__(self, line: str) -> None:
        self.lines: SimpleQueue[str | None] = SimpleQueue()
        self.lines.put(line)
        self.ended_well = False

    def put(self, data: bytes) -> None:
        pass

    end = kill = lambda self: None


@pytest.mark.parametrize("line", ["", "nonsense", "-3\t", "99999\t", "12345678901234567890\t", "²\t", "0\t"])
@pytest.mark.attack("tshark prints lines that are none of its answers", "another one goes on; nothing is lost")
def test_a_tshark_that_prints_nonsense_is_replaced(
    tshark: Tshark, traffic: list[Record], expected: list[int], line: str
) -> None:
    tested = Watched(tshark, SEAMS._replace(packets=len(traffic)))
    tsharks = [cast(Running, Lying(line))]
    tested.relay._start = lambda token: tsharks.pop() if tsharks else tested.start(token)
    tested.play(traffic)
    assert tested.end() == expected
    (said,) = tested.said
    assert said == f"tshark has printed what was not asked for: {visible(line)}; another one goes on"
    assert not tested.relay.unjudged
    tested.relay.close()
