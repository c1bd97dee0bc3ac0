# SPDX-License-Identifier: GPL-2.0-or-later
"""The assembler alone: the records made from reads, and the events where settings change."""

from __future__ import annotations

import pytest
from specification import TELEGRAMS

from sistap.tap.line.settings import Flag, LineSettings, Read
from sistap.tap.records.assembler import Assembler
from sistap.tap.records.cut import SIS, Cut
from sistap.tap.records.record import Event, Framing, Record, Type

pytestmark = pytest.mark.tap

SETTINGS, FASTER = LineSettings(9600), LineSettings(19200)
TELEGRAM = TELEGRAMS["8-20"]
MS = 1_000_000


class Assembled:
    """An assembler of two lines, and what it has written."""

    def __init__(self, cut: Cut = SIS) -> None:
        self.written: list[Record] = []
        self.assembler = Assembler(cut)
        for line in (1, 2):
            self.assembler.add_line(line, SETTINGS, 0)

    def take(
        self, time_ns: int, data: bytes, line: int = 1, settings: LineSettings | None = None, why: str = ""
    ) -> list[Record]:
        taken = self.assembler.take(Read(line, time_ns, data, bytes(len(data)), 1000, settings), time_ns, why)
        self.write(time_ns)
        return taken

    def flush(self, line: int, now_ns: int) -> None:
        self.assembler.flush([line], now_ns)
        self.write(now_ns)

    def write(self, now_ns: int) -> None:
        self.written += self.assembler.due(now_ns)

    def idle(self, now_ns: int) -> list[tuple[int, list[Record]]]:
        completed = self.assembler.idle(now_ns)
        self.write(now_ns)
        return completed

    def restart(self, line: int, now_ns: int) -> None:
        self.assembler.restart(line, now_ns)
        self.write(now_ns)

    @property
    def texts(self) -> list[str]:
        return [record.data.decode() for record in self.written if record.type == Type.EVENT]


def test_what_a_read_completes_is_returned_also_while_it_waits() -> None:
    made = Assembled()
    assert made.assembler.lines == (1, 2)
    made.take(1 * MS, TELEGRAM[:4], line=2)
    assert [record.data for record in made.take(2 * MS, TELEGRAM)] == [TELEGRAM]
    assert not made.written  # line 2 began earlier
    made.take(3 * MS, TELEGRAM[4:], line=2)
    assert [record.line for record in made.written] == [2, 1]


def test_settings_that_a_read_brings_are_an_event_before_it() -> None:
    made = Assembled()
    made.take(1 * MS, b"A")
    made.take(2 * MS, b"B", settings=FASTER, why="it is said")
    made.take(3 * MS, b"C", settings=FASTER, why="it is said")
    made.flush(1, 4 * MS)
    assert [(record.event, record.settings, record.data) for record in made.written] == [
        (Event.NONE, SETTINGS, b"A"),
        (Event.SETTINGS_CHANGED, FASTER, b"19200 Bd 8E1: it is said"),
        (Event.NONE, FASTER, b"BC"),
    ]
    assert made.written[1].time_ns == 2 * MS


def test_a_read_without_characters_brings_no_settings() -> None:
    made = Assembled()
    made.take(1 * MS, b"", settings=FASTER)
    assert made.assembler.settings(1) == SETTINGS
    assert not made.written


def test_settings_that_are_told_are_an_event_with_the_next_read() -> None:
    made = Assembled()
    made.assembler.change(1, FASTER, "first", 1 * MS)
    made.assembler.change(1, SETTINGS, "back", 2 * MS)
    assert not made.written
    made.take(3 * MS, b"A")
    assert (made.texts, made.written[0].time_ns) == (["9600 Bd 8E1: back"], 3 * MS)
    assert (made.assembler.settings(1), made.assembler.settings(2)) == (SETTINGS, SETTINGS)


def test_idle_tells_which_line_has_completed_what() -> None:
    made = Assembled()
    made.take(1 * MS, b"\x02A")
    made.take(900 * MS, b"\x02B", line=2)
    completed = made.idle(1001 * MS)
    assert [(line, [record.data for record in records]) for line, records in completed] == [(1, [b"\x02A"]), (2, [])]
    assert not made.assembler.empty


def test_silence_cuts_frames_where_it_is_said() -> None:
    assert Assembled().assembler.cut == SIS
    made = Assembled(Cut(Framing.SILENCE, 5))
    made.take(1 * MS, b"A")
    made.take(6 * MS - 1, b"B")
    assert not made.written
    made.take(12 * MS, b"C")
    (record,) = made.written
    assert (record.type, record.framing, record.data) == (Type.FRAME, Framing.SILENCE, b"AB")


def test_another_clock_begins_without_an_interval() -> None:
    made = Assembled()
    made.take(5000 * MS, TELEGRAM[:4])
    made.restart(1, 5000 * MS)
    made.take(7 * MS, TELEGRAM)
    made.restart(1, 8 * MS)
    made.restart(1, 8 * MS)  # nothing is left
    unfinished, telegram = made.written
    assert (unfinished.time_ns, unfinished.data) == (5000 * MS, TELEGRAM[:4])
    assert (telegram.time_ns, telegram.data, telegram.intervals[0]) == (7 * MS, TELEGRAM, 0)
    assert telegram.flags[0] == Flag.INTERVAL_UNKNOWN
