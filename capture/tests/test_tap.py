# SPDX-License-Identifier: GPL-2.0-or-later
"""The lines of a capture alone: what reaches the sink, the counters, and the messages about a line."""

from __future__ import annotations

from typing import NamedTuple

import pytest

from sistap.tap.capture.tap import Tapping
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Event, Record

pytestmark = pytest.mark.tap

SECOND = 1_000_000_000
EPOCH = 1_700_000_000 * SECOND
HALF = b"\x02\x00\xff\xff"  # what may become a telegram


class Port:
    """A reader of which only the settings are asked for."""

    name = adapter = timing = "port of a test"
    notes: tuple[str, ...] = ()

    def __init__(self, line: int) -> None:
        self.line = line
        self.settings = LineSettings()

    def read(self, timeout_s: float) -> Read | None:
        raise NotImplementedError

    def change(self, settings: LineSettings) -> None:
        self.settings = settings

    def close(self) -> None:
        pass


class Sink:
    """Remembers what it was given."""

    def __init__(self) -> None:
        self.started: list[Record] = []
        self.records: list[Record] = []
        self.ended_ns = 0

    def begin(self, *started: Record) -> None:
        self.started += started

    def write(self, record: Record) -> bool:
        self.records.append(record)
        return True

    def look(self, time_ns: int) -> None:
        pass

    def end(self, time_ns: int) -> None:
        self.ended_ns = time_ns


class Tapped(NamedTuple):
    tap: Tapping
    ports: list[Port]
    sink: Sink
    counters: Counters

    def take(self, at_ns: int, data: bytes, line: int) -> None:
        self.tap.take(Read(line, EPOCH + at_ns, data, bytes(len(data)), 1000), at_ns, "")

    @property
    def written(self) -> list[tuple[int, bytes]]:
        return [(record.line, record.data) for record in self.sink.records if record.event == Event.NONE]


class WallClock:
    step = 3 * SECOND // 2

    def now_ns(self) -> int:
        return EPOCH

    def step_ns(self) -> int:
        return self.step


@pytest.fixture
def both(monkeypatch: pytest.MonkeyPatch) -> Tapped:
    """Both directions of a line."""
    monkeypatch.setattr("sistap.tap.capture.tap.CLOCK", WallClock())
    ports, sink, counters = [Port(1), Port(2)], Sink(), Counters()
    return Tapped(Tapping(ports, sink, counters, lambda: 10), ports, sink, counters)


def test_a_sink_begins_with_how_each_line_is_taken(both: Tapped) -> None:
    both.tap.begin({1: "one", 2: "two"})
    assert [(record.line, record.event, record.data) for record in both.sink.started] == [
        (1, Event.CAPTURE_STARTED, b"one"),
        (2, Event.CAPTURE_STARTED, b"two"),
    ]


def test_limits_that_the_user_told_stand_behind_the_beginning_of_each_line(both: Tapped) -> None:
    both.tap.begin({1: "one", 2: "two"}, "TzA = 8 ms")
    assert [(record.line, record.event, record.data) for record in both.sink.started[2:]] == [
        (1, Event.LIMITS_TOLD, b"TzA = 8 ms"),
        (2, Event.LIMITS_TOLD, b"TzA = 8 ms"),
    ]


def test_a_port_that_comes_back_with_other_settings(both: Tapped) -> None:
    again = Port(1)
    again.settings = LineSettings(19200)
    both.tap.replace(both.ports[0], again)
    both.take(20, HALF, 1)
    both.tap.end()
    (changed,) = (record for record in both.sink.records if record.event == Event.SETTINGS_CHANGED)
    assert (changed.line, changed.settings.baud) == (1, 19200)
    assert changed.data == b"19200 Bd 8E1: set when the port came back"


def test_the_end_writes_what_is_left(both: Tapped) -> None:
    both.take(1, HALF, 1)
    both.take(2, b"\x02", 2)
    assert not both.written
    both.tap.end()
    assert both.written == [(1, HALF), (2, b"\x02")]
    assert both.sink.ended_ns == EPOCH + 10


def test_a_port_that_is_lost_gives_what_is_left_of_it_alone(both: Tapped) -> None:
    both.take(1, HALF, 1)
    both.take(2, HALF, 2)
    both.tap.lose(both.ports[0], 1, "gone")
    assert both.written == [(1, HALF)]
    both.tap.end()
    assert [record.data for record in both.sink.records] == [HALF, HALF, b"gone"]  # in order of time


def test_a_clock_that_was_set_is_said_and_written(both: Tapped, monkeypatch: pytest.MonkeyPatch) -> None:
    said = both.tap.note_clock_step(1)
    assert said.startswith("the wall clock moved by +1.500 s (it was set, or the computer slept); ")
    assert [(record.event, record.data.decode()) for record in both.sink.records] == [(Event.MARKER, said)]
    monkeypatch.setattr(WallClock, "step", 0)
    assert both.tap.note_clock_step(1) == ""
    assert len(both.sink.records) == 1


def test_hints_are_of_the_settings_of_now_and_name_the_line(both: Tapped) -> None:
    wrong = Read(1, EPOCH, b"x" * 20, bytes([2]) * 20, 1000)  # parity or framing errors
    both.tap.take(wrong, 0, "")
    (hint,) = both.tap.hints(both.ports[0], 1.0, None)
    assert hint.startswith("line 1: every character has an error with 8E1: try --format 8N1")
    assert not list(both.tap.hints(both.ports[0], 2.0, None))
    assert not list(both.tap.hints(both.ports[1], 1.0, None))
    both.ports[0].change(LineSettings(parity="N"))
    both.tap.renew_hints(both.ports[0])
    (hint,) = both.tap.hints(both.ports[0], 3.0, None)
    assert "with 8N1: try --format 8E1" in hint


def test_characters_are_counted_for_all_lines_and_for_each(both: Tapped) -> None:
    both.take(1, b"abc", 1)
    both.take(2, b"d", 2)
    both.tap.end()
    assert (both.counters.characters, both.counters.written) == (4, 2)
    assert (both.counters.accepted[1], both.counters.accepted[2]) == (1, 1)


class Bus(Port):
    """A virtual bus with a clock that is a day behind."""

    def now_ns(self) -> int:
        return EPOCH - 86_400 * SECOND


def test_a_bus_has_its_own_time_from_the_first_event_on() -> None:
    sink = Sink()
    tap = Tapping([Bus(0)], sink, Counters(), lambda: 10)
    tap.begin({0: "begun"})
    assert sink.started[0].time_ns == EPOCH - 86_400 * SECOND
    tap.note(0, Event.MARKER, "then", EPOCH - 5)
    assert [(record.time_ns, record.data) for record in sink.records] == [(EPOCH - 5, b"then")]
