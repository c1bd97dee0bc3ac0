# SPDX-License-Identifier: GPL-2.0-or-later
"""Stations at a line: what they accept as a command, when they answer, and at which rate. All times are simulated."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sisbus.stations.making import make
from sisbus.wires.answering import Answering, serve
from sisbus.wires.receiver import Receiver
from sisbus.wires.wire import Pace
from sistap.tap.line.settings import LineSettings
from sistap.tap.sis.telegram import build, checksum_good

MS = 1_000_000
TZA_NS = 5 * MS
READ_PHASE = build(0x12, 16, 3)
LINE = LineSettings()  # 9600 8E1: a character takes 1.1458 ms


def octets(figure: str) -> bytes:
    return bytes.fromhex(figure)


# -- What is taken for a command (chapters 10.3 and 10.5) ------------------------------------------------------------


class Ear:
    """A receiver that hears characters 1 ms apart, except for pauses."""

    def __init__(self) -> None:
        self.receiver = Receiver()
        self.now_ns = 0

    def hear(self, *parts: bytes | int) -> list[bytes]:
        """Hear bytes, and pauses in ms; return what was taken."""
        taken = []
        for part in parts:
            if isinstance(part, int):
                self.now_ns += part * MS
                continue
            for value in part:
                self.now_ns += MS
                telegram = self.receiver.hear(value, self.now_ns, TZA_NS)
                taken += [] if telegram is None else [telegram]
        return taken


def test_a_start_is_recognised_only_after_a_silence_longer_than_tza() -> None:
    ear = Ear()
    assert ear.hear(READ_PHASE) == [READ_PHASE]
    assert ear.hear(READ_PHASE) == []  # 1 ms
    assert ear.hear(4, READ_PHASE) == []  # 5 ms: not longer
    assert ear.hear(5, READ_PHASE) == [READ_PHASE]  # 6 ms


def test_a_pause_in_a_telegram_ends_nothing() -> None:
    assert Ear().hear(READ_PHASE[:3], 500, READ_PHASE[3:]) == [READ_PHASE]


def test_a_telegram_after_a_pause_takes_the_place_of_one_that_was_cut_off() -> None:
    for place in range(1, len(READ_PHASE)):
        assert Ear().hear(READ_PHASE[:place], 5, READ_PHASE) == [READ_PHASE], place


def test_a_start_character_after_a_pause_that_begins_no_telegram_is_a_byte_of_the_one_before() -> None:
    command = build(0x1F, 16, 3, octets("3C 03 00 24 00 02 01 02 03"))
    place = command.index(b"\x02\x01\x02\x03")
    assert Ear().hear(command[:place], 500, command[place:]) == [command]


def test_a_start_character_after_a_pause_that_ends_a_good_telegram_is_its_last_byte() -> None:
    command = build(0x1F, 16, 3, octets("3C 03 00 24 00 02"))
    assert Ear().hear(command[:-1], 500, command[-1:]) == [command]


def test_a_start_character_after_a_pause_that_ends_a_damaged_telegram_begins_the_next() -> None:
    damaged = build(0x1F, 16, 3, octets("3C 03 00 24 00 03"))[:-1] + READ_PHASE[:1]
    assert Ear().hear(damaged[:-1], 500, READ_PHASE) == [READ_PHASE]


def test_what_cannot_become_a_telegram_is_over_with_the_silence() -> None:
    ear = Ear()
    wrong = octets("02 5C 00 01 00 12 10 80")
    assert ear.hear(wrong) == []
    assert ear.receiver.silence_ends_ns(TZA_NS) == 8 * MS + TZA_NS
    assert ear.receiver.silence(8 * MS + TZA_NS - 1, TZA_NS) is None
    assert ear.receiver.silence(8 * MS + TZA_NS, TZA_NS) == wrong
    assert ear.receiver.silence_ends_ns(TZA_NS) is None
    assert ear.hear(6, b"ASCII", 6, READ_PHASE) == [b"ASCII", READ_PHASE]


@given(st.binary(max_size=300), st.lists(st.integers(0, 20), max_size=5))
def test_whatever_was_before_a_good_telegram_after_a_silence_is_taken(noise: bytes, pauses: list[int]) -> None:
    ear = Ear()
    size = len(noise) // (len(pauses) + 1) + 1
    before: list[bytes] = []
    for place, pause in enumerate([*pauses, 0]):
        before += ear.hear(noise[place * size : (place + 1) * size], pause)
    taken = ear.hear(6, READ_PHASE)
    chance = taken and checksum_good(taken[0]) and taken[0] != READ_PHASE  # the noise became one by chance
    assert chance or taken[-1] == READ_PHASE


# -- When, and with which rate ---------------------------------------------------------------------------------------


def line(*tables: dict[str, Any], settings: LineSettings = LINE) -> Answering:
    return Answering(make(tables or ({"address": 3}, {"address": 4}), 1), settings)


def initialized(answering: Answering, tza_ms: int, trs_ms: int) -> None:
    for subservice, ms in ((1, trs_ms), (2, tza_ms)):
        command = build(0x03, 16, 255, bytes([0, subservice]) + ms.to_bytes(2, "little"))
        assert answering.hear(command, 100 * subservice * MS) == []
    assert answering.hear(build(0x03, 16, 255, b"\x00\xff"), 300 * MS) == []


@pytest.mark.parametrize(("tza_ms", "trs_ms"), [(5, 50), (20, 21), (3, 4)])
def test_a_reaction_begins_after_tza_of_silence_and_within_trs(tza_ms: int, trs_ms: int) -> None:
    answering = line()
    initialized(answering, tza_ms, trs_ms)
    ((time_ns, reaction),) = answering.hear(READ_PHASE, 1000 * MS)
    assert reaction == build(0x12, 16, 3, b"\x00\x04", reaction=True)
    assert tza_ms * MS < time_ns - 1000 * MS <= trs_ms * MS


def test_a_damaged_command_is_answered_point_to_point_after_a_silence_and_on_a_bus_not_at_all() -> None:
    alone = line({"address": 3})
    assert alone.hear(octets("02 5B 01 00 00 12 10 80"), 0) == []
    silence_ns = alone.wake_ns(0)
    assert silence_ns == 4 * LINE.character_ns
    assert alone.wait(silence_ns - 1) == []
    ((time_ns, reaction),) = alone.wait(silence_ns)
    assert reaction[8:] == b"\xf2"
    assert time_ns > silence_ns
    bus = line()
    assert bus.hear(octets("02 D9 01 00 00 12 10 03"), 0) == []
    assert bus.wait(1000 * MS) == []


def bauds(answering: Answering, times_ms: Iterable[float]) -> list[int]:
    found = []
    for ms in times_ms:
        answering.wait(int(ms * MS))
        found.append(answering.settings.baud)
    return found


def test_who_accepts_alone_answers_with_the_new_rate() -> None:
    answering = line()
    assert len(answering.hear(build(0x03, 16, 3, b"\x03\x07\x02"), 0)) == 1
    assert answering.settings == LINE
    assert len(answering.hear(build(0x03, 16, 3, b"\x03\xff"), 100 * MS)) == 1
    assert answering.settings == LINE._replace(baud=38400)
    assert answering.hear(build(0x12, 16, 4), 200 * MS) == []  # nobody has told it
    assert len(answering.hear(READ_PHASE, 300 * MS)) == 1


def test_a_broadcast_changes_the_rate_of_all() -> None:
    answering = line()
    answering.hear(build(0x03, 16, 255, b"\x00\x07\x08"), 0)
    answering.hear(build(0x03, 16, 255, b"\x00\xff"), 100 * MS)
    assert answering.settings.baud == 115200
    for place, address in enumerate((3, 4), 2):
        assert len(answering.hear(build(0x12, 16, address), 100 * place * MS)) == 1


def test_a_test_of_a_rate_begins_after_the_reaction_and_falls_back() -> None:
    answering = line()
    assert len(answering.hear(octets("02 E0 05 05 00 03 10 03 00 08 F4 01 01"), 0)) == 1  # 19200 Bd for 500 ms
    assert answering.settings.baud == 9600
    assert bauds(answering, (20, 499)) == [19200, 19200]
    assert answering.wake_ns(499 * MS) == 500 * MS
    assert bauds(answering, (500,)) == [9600]
    assert len(answering.hear(READ_PHASE, 600 * MS)) == 1


def test_the_line_begins_with_its_own_rate() -> None:
    answering = line(settings=LINE._replace(baud=115200))
    assert len(answering.hear(READ_PHASE, 0)) == 1
    assert answering.settings.baud == 115200


# -- At a port -------------------------------------------------------------------------------------------------------


class Over(Exception):
    """The script has ended."""


class Script(Pace):
    """A port and the time: characters arrive by a script; the events are logged."""

    def __init__(self, *arrivals: tuple[float, bytes]) -> None:
        super().__init__()
        self.settings = LINE
        self.noted: list[str] = []
        self._now_ns = 0
        self._arrivals = list(arrivals)

    def now_ns(self) -> int:
        return self._now_ns

    def left_s(self, time_ns: int) -> float:
        return max(0, time_ns - self._now_ns) / 1e9

    def wait_until(self, time_ns: int) -> None:
        self._now_ns = max(self._now_ns, time_ns)

    def read(self, timeout_s: float) -> bytes:
        if not self._arrivals:
            raise Over
        end_ns, arrives_ns = self._now_ns + round(timeout_s * 1e9), int(self._arrivals[0][0] * MS)
        self._now_ns = min(end_ns, max(self._now_ns, arrives_ns))
        if arrives_ns > self._now_ns:
            return b""
        self.noted.append(f"read at {self.settings.baud}")
        return self._arrivals.pop(0)[1]

    def write(self, data: bytes) -> None:
        self.noted.append(f"{data[8:].hex(' ')} at {self.settings.baud}")

    def drain(self) -> None:
        self._now_ns += 10 * LINE.character_ns
        self.noted.append("sent")

    def change(self, settings: LineSettings) -> None:
        self.settings = settings
        self.noted.append(f"{settings.baud} Bd")


def test_a_port_gets_the_reaction_and_then_the_rate_or_the_other_way_round() -> None:
    script = Script(
        (100, octets("02 E0 05 05 00 03 10 03 00 08 F4 01 01")),  # a test of 19200 Bd for 500 ms
        (300, READ_PHASE),
        (900, READ_PHASE),
        (1000, build(0x03, 16, 3, b"\x03\x07\x08")),
        (1100, build(0x03, 16, 3, b"\x03\xff")),
        (1200, READ_PHASE),
        (1300, b""),
    )
    with pytest.raises(Over):
        serve(script, make([{"address": 3}], 1), script)
    assert [note for note in script.noted if note != "sent"] == [
        "read at 9600",
        "00 00 08 at 9600",
        "19200 Bd",
        "read at 19200",
        "00 04 at 19200",
        "9600 Bd",
        "read at 9600",
        "00 04 at 9600",
        "read at 9600",
        "00 03 07 at 9600",
        "read at 9600",
        "115200 Bd",
        "00 03 ff at 115200",
        "read at 115200",
        "00 04 at 115200",
        "read at 115200",
    ]
