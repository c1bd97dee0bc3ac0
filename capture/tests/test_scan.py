# SPDX-License-Identifier: GPL-2.0-or-later
"""The search for rate and format: where it stays, and why it moves on."""

from __future__ import annotations

import pytest
from specification import TELEGRAMS

from sistap.tap.capture.rate import Scan
from sistap.tap.line.settings import Flag, LineSettings, Read
from sistap.tap.records.framer import SisFramer

pytestmark = pytest.mark.tap

SECOND = 1_000_000_000
# All that SIS has (fig. 6-11), 9600 first: that is what stations have after power-on.
EVERYTHING = [(rate, text) for rate in (9600, 19200, 38400, 57600, 115200) for text in ("8E1", "8N1")]
SHORT = TELEGRAMS["8-20"]  # 8 characters
WRONG, BREAK = int(Flag.CHARACTER_ERROR), int(Flag.BREAK)


class Bus:
    """Sends reads to a search; `now` advances by 1 ms for each character."""

    def __init__(self, scan: Scan) -> None:
        self.scan = scan
        self.now = 1_700_000_000 * SECOND
        assert scan.look(self.now) is None

    def say(self, data: bytes, flags: bytes | None = None, settings: LineSettings | None = None) -> None:
        settings = settings or self.scan.settings
        framer = SisFramer(0, settings)
        for value, flag in zip(data, flags or bytes(len(data)), strict=True):
            self.now += 1_000_000
            read = Read(0, self.now, bytes([value]), bytes([flag]), 0, settings)
            self.scan.take(read, framer.feed(read))

    def wait(self, seconds: float) -> LineSettings | None:
        self.now += int(seconds * SECOND)
        return self.scan.look(self.now)


@pytest.fixture
def bus() -> Bus:
    return Bus(Scan())


def name(settings: LineSettings | None) -> tuple[int, str] | None:
    return settings and (settings.baud, settings.format)


def test_a_valid_telegram_is_enough(bus: Bus) -> None:
    assert name(bus.scan.settings) == (9600, "8E1")
    bus.say(SHORT[3:] + SHORT)  # it began to listen inside a telegram
    assert bus.scan.found
    assert bus.wait(1000) is None


def test_errors_are_left_at_once(bus: Bus) -> None:
    bus.say(b"x" * 7, bytes([WRONG]) * 7)
    assert bus.wait(0) is None
    bus.say(b"\0", bytes([BREAK]))
    assert name(bus.wait(0)) == (9600, "8N1")


def test_one_error_in_a_packet_of_many_characters_is_no_reason_to_leave_nor_to_stay(bus: Bus) -> None:
    somewhere = int(Flag.UNLOCATED_ERROR)
    settings = bus.scan.settings

    def packet(data: bytes, flag: int) -> None:
        bus.now += 1_000_000
        read = Read(0, bus.now, data, bytes([flag]) * len(data), 0, settings)
        bus.scan.take(read, SisFramer(0, settings).feed(read))

    packet(SHORT * 2, somewhere)
    assert bus.wait(0) is None
    packet(SHORT, 0)
    assert not bus.scan.found  # of the 16 before, all may be wrong
    for _ in range(7):
        packet(b"xyz", somewhere)
    assert bus.wait(0)


def test_half_of_the_characters_wrong_is_the_wrong_parity_although_a_telegram_is_without_error(bus: Bus) -> None:
    bus.say(b"x" * 20, bytes([WRONG, 0]) * 10)
    bus.say(SHORT)
    assert not bus.scan.found
    assert bus.wait(0)


def test_a_telegram_with_an_error_in_it_is_not_enough(bus: Bus) -> None:
    bus.say(b"x" * 20 + SHORT, bytes(22) + bytes([WRONG]) + bytes(5))
    assert not bus.scan.found


def test_a_disturbed_line_is_found(bus: Bus) -> None:
    bus.say(SHORT * 2, bytes([WRONG]) + bytes(15))
    assert bus.scan.found


def test_few_errors_among_many_characters_are_no_reason_to_leave(bus: Bus) -> None:
    bus.say(b"x" * 200, (bytes([WRONG]) + bytes(24)) * 8)
    assert bus.wait(0) is None


def test_a_damaged_telegram_is_not_enough(bus: Bus) -> None:
    bus.say(SHORT[:-1] + b"\x55" + b"y")
    assert not bus.scan.found


def test_characters_that_are_no_telegram_are_left(bus: Bus) -> None:
    bus.say(b"x" * 525)  # the rest of the longest telegram, 263, and another one
    assert bus.wait(0) is None
    bus.say(b"x")
    assert name(bus.wait(0)) == (9600, "8N1")


def test_characters_and_a_pause_are_left(bus: Bus) -> None:
    bus.say(b"x")
    assert bus.wait(0.999) is None
    assert bus.wait(0.001)


def test_all_are_tried_in_turn_without_end(bus: Bus) -> None:
    tried = [name(bus.scan.settings)]
    for _ in range(29):
        assert not bus.scan.found
        bus.say(b"x" * 8, bytes([WRONG]) * 8)
        tried.append(name(bus.wait(0)))
    assert tried == EVERYTHING * 3
    assert bus.scan.in_vain


def test_a_search_in_vain_is_one_in_which_all_have_brought_something(bus: Bus) -> None:
    for _ in range(9):
        bus.say(b"x" * 8, bytes([WRONG]) * 8)
        bus.wait(0)
    assert not bus.scan.in_vain
    bus.wait(3)  # nothing came with the tenth
    assert not bus.scan.in_vain


def test_a_silent_line_is_searched_without_end_but_ever_more_slowly(bus: Bus) -> None:
    tried: list[tuple[int, str] | None] = [name(bus.scan.settings)]
    stays: list[int] = []
    for _ in range(69):
        stays.append(1)
        while not (settings := bus.wait(1)):
            stays[-1] += 1
        tried.append(name(settings))
    assert tried == EVERYTHING * 7
    assert stays == [3] * 10 + [6] * 10 + [12] * 10 + [24] * 10 + [48] * 10 + [60] * 19


def test_a_bus_that_speaks_every_ten_seconds_is_found(bus: Bus) -> None:
    right = LineSettings(38400, 8, "N")
    for _ in range(60):
        if bus.scan.found:
            break
        if bus.scan.settings == right:
            bus.say(SHORT)
        else:
            bus.say(b"x" * 3)
        for _ in range(100):
            bus.wait(0.1)
    assert bus.scan.found
    assert bus.scan.settings == right


def test_what_was_read_before_a_change_does_not_count(bus: Bus) -> None:
    before = bus.scan.settings
    bus.say(b"x")
    assert bus.wait(1)
    bus.say(SHORT, settings=before)
    assert not bus.scan.found
    assert bus.wait(2.9) is None  # nothing has come with the new ones


def test_a_telegram_that_silence_completes_counts_for_its_own_settings(bus: Bus) -> None:
    framers = [SisFramer(0, settings) for settings in (LineSettings(115200), bus.scan.settings)]
    for framer, found in zip(framers, (False, True), strict=True):
        waiting = framer.feed(Read(0, bus.now, b"\x02\x00\xff\xff" + SHORT, bytes(12), 0))
        assert waiting == []
        bus.scan.take(Read(0, bus.now, b"", b""), framer.flush())
        assert bus.scan.found is found


def test_one_format(bus: Bus) -> None:
    bus.scan = Scan(["7O2"])
    assert {name(bus.wait(100)) for _ in range(10)} == {(rate, "7O2") for rate, text in EVERYTHING} | {None}


def test_a_rate_that_is_seen_on_the_line_is_tried_next() -> None:
    bus = Bus(Scan(measure=lambda: 56_900.0))
    bus.say(b"x" * 8, bytes([WRONG]) * 8)
    assert name(bus.wait(0)) in ((57600, "8E1"), (57600, "8N1"))
    first = name(bus.scan.settings)
    bus.say(b"x" * 8, bytes([WRONG]) * 8)
    assert {first, name(bus.wait(0))} == {(57600, "8E1"), (57600, "8N1")}


@pytest.mark.parametrize("measured", [None, 0.0, 25_000.0, 1e6])
def test_what_is_no_rate_of_the_bus_changes_nothing(measured: float | None) -> None:
    bus = Bus(Scan(measure=lambda: measured))
    bus.say(b"x" * 8, bytes([WRONG]) * 8)
    assert name(bus.wait(0)) == (9600, "8N1")
