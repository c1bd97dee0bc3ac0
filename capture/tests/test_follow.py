# SPDX-License-Identifier: GPL-2.0-or-later
"""The effect of service 0x03 on the rate of a bus (IF02 chapter 6), and on a capture."""

from __future__ import annotations

import pytest
from specification import TELEGRAMS

from sistap.tap.capture.rate import Steering
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.framer import SisFramer
from sistap.tap.sis.initialization import Follow
from sistap.tap.sis.telegram import build

pytestmark = pytest.mark.tap

MS = 1_000_000
SECOND = 1_000_000_000
MASTER, LEVEL, ALL = 16, 254, 255
MASKS = {9600: 0, 19200: 1, 38400: 2, 57600: 4, 115200: 8}  # fig. 6-11
ACCEPT_ALL = TELEGRAMS["6-24"]


def command(station: int, subservice: int, data: bytes = b"", *, sender: int = MASTER, routed: bytes = b"") -> bytes:
    return build(0x03, sender, station, bytes([station, subservice]) + data, subaddresses=routed)


def reaction(station: int, subservice: int, status: int = 0, *, sender: int = MASTER) -> bytes:
    return build(0x03, sender, station, bytes([status, station, subservice]), reaction=True)


def tell(station: int, baud: int) -> list[bytes]:
    answer = [] if station == ALL else [reaction(station, 0x07)]
    return [command(station, 0x07, bytes([MASKS[baud]])), *answer]


def timed_test(station: int, ms: int, baud: int) -> bytes:
    return command(station, 0x08, ms.to_bytes(2, "little") + bytes([MASKS[baud]]))


def rates(*telegrams: bytes, follow: Follow | None = None) -> list[int]:
    """Return the rates of the bus, one after the other."""
    follow = follow or Follow(9600)
    changes = [follow.take(telegram, 0) for telegram in telegrams]
    return [change.baud for change in changes if change]


def test_set_for_one_then_accepted_by_all() -> None:
    # Fig. 6-15 sets 115200 Bd; the facts have its reaction: status, address, subservice.
    answer = build(0x03, MASTER, 3, b"\x00\x04\x07", reaction=True)
    assert rates(TELEGRAMS["6-15"], answer, ACCEPT_ALL) == [115200]
    assert rates(TELEGRAMS["6-14"], answer, ACCEPT_ALL) == [9600]


def test_set_for_all_counts_without_a_reaction() -> None:
    assert rates(*tell(ALL, 38400), ACCEPT_ALL) == [38400]


def test_all_on_this_level_are_all_on_the_line() -> None:
    """Chapter 2.2: 254 goes to all stations of one level; nobody answers."""
    told = command(LEVEL, 0x07, bytes([MASKS[38400]]))
    assert rates(told, ACCEPT_ALL) == [38400]
    assert rates(told, command(LEVEL, 0xFF)) == [38400]
    assert rates(*tell(3, 19200), command(LEVEL, 0xFF)) == [19200]
    assert rates(timed_test(LEVEL, 500, 57600)) == [57600]


def test_a_group_changes_nothing() -> None:
    """The stations in a group are unknown."""
    assert rates(command(200, 0x07, bytes([MASKS[38400]])), command(200, 0xFF), timed_test(200, 500, 57600)) == []


@pytest.mark.parametrize(
    "answer",
    [
        [],
        [reaction(3, 0x07, status=1)],
        [reaction(4, 0x07)],
        [reaction(3, 0x02)],
        [reaction(3, 0x07, sender=17)],
        [build(0x10, MASTER, 3, b"\x3c\x03\x00\x2c\x00"), reaction(3, 0x07)],  # something else came between
    ],
)
def test_what_was_not_taken_is_not_valid(answer: list[bytes]) -> None:
    assert rates(command(3, 0x07, b"\x01"), *answer, ACCEPT_ALL) == []


def test_one_that_accepts_answers_at_the_new_rate() -> None:
    assert rates(*tell(3, 19200), command(3, 0xFF)) == [19200]
    assert rates(*tell(ALL, 19200), command(3, 0xFF)) == [19200]


def test_one_that_was_told_nothing_accepts_nothing() -> None:
    assert rates(*tell(3, 19200), command(4, 0xFF)) == []
    assert rates(ACCEPT_ALL) == []


def test_accepted_is_accepted_once() -> None:
    assert rates(*tell(3, 19200), ACCEPT_ALL, ACCEPT_ALL) == [19200]


def test_the_last_that_was_told_counts() -> None:
    assert rates(*tell(3, 19200), *tell(4, 38400), ACCEPT_ALL) == [38400]
    assert rates(*tell(3, 19200), *tell(4, 38400), command(3, 0xFF)) == [19200]
    assert rates(*tell(3, 19200), *tell(ALL, 57600), command(3, 0xFF)) == [57600]
    assert rates(*tell(4, 19200), *tell(3, 38400), *tell(4, 57600), ACCEPT_ALL) == [57600]


@pytest.mark.parametrize(
    "telegram",
    [
        command(ALL, 0x07, b"\x03"),  # two rates at once are not defined
        command(ALL, 0x07, b"\x10"),
        command(ALL, 0x07),
        command(ALL, 0x08, b"\xf4\x01"),
        command(ALL, 0x08, b"\x00\x00\x01"),
        build(0x03, MASTER, ALL),
        build(0x1F, MASTER, ALL, b"\xff\x07\x01"),
    ],
)
def test_what_says_nothing_changes_nothing(telegram: bytes) -> None:
    assert rates(telegram, ACCEPT_ALL) == []


def test_a_bus_behind_a_router_is_another_one() -> None:
    body = bytes([8, 0x07])
    told = build(0x03, MASTER, 3, body + b"\x01", subaddresses=b"\x08")
    done = build(0x03, MASTER, 3, b"\0" + body, subaddresses=b"\x08", reaction=True)
    assert rates(told, done, ACCEPT_ALL) == []


def test_a_timed_test_begins_after_the_reaction_and_ends_by_itself() -> None:
    follow = Follow(9600)
    assert follow.take(timed_test(3, 500, 115200), 1 * SECOND) is None
    assert follow.due_ns is None
    change = follow.take(reaction(3, 0x08), 2 * SECOND)
    assert change and change.baud == 115200
    assert change.why == "16 lets 3 test 115200 Bd for 500 ms"
    assert follow.due_ns == 2 * SECOND + 500 * MS
    assert follow.due(2 * SECOND + 500 * MS - 1) is None
    change = follow.due(2 * SECOND + 500 * MS)
    assert change and change.baud == 9600
    assert follow.due(9 * SECOND) is None


def test_a_test_that_is_refused_is_none() -> None:
    assert rates(timed_test(3, 500, 115200), reaction(3, 0x08, status=1)) == []


def test_a_test_for_all_has_no_reaction() -> None:
    assert rates(timed_test(ALL, 500, 115200)) == [115200]


def test_what_is_accepted_during_a_test_ends_it() -> None:
    follow = Follow(9600)
    assert rates(timed_test(3, 500, 115200), reaction(3, 0x08), *tell(ALL, 38400), ACCEPT_ALL, follow=follow) == [
        115200,
        38400,
    ]
    assert follow.due_ns is None


# -- What a capture does with it ------------------------------------------------------------------------------------

LINE = LineSettings(9600)


class Heard:
    """A bus that a Steering hears, at any rate, with the steps that it takes."""

    def __init__(self, steering: Steering) -> None:
        self.steering = steering
        self.now = SECOND
        self.settings = LINE

    def say(self, *telegrams: bytes) -> list[LineSettings]:
        taken: list[LineSettings] = []
        for telegram in telegrams:
            self.now += 10 * MS
            read = Read(0, self.now, telegram, bytes(len(telegram)), 0, self.settings)
            framer = SisFramer(0, self.settings)
            records = framer.feed(read) + framer.flush()
            taken += [step.settings for step in self.steering.take(read, records)] + self.wait(0)
        return taken

    def wait(self, seconds: float) -> list[LineSettings]:
        self.now += int(seconds * SECOND)
        taken = [step.settings for step in self.steering.look(self.now)]
        self.settings = taken[-1] if taken else self.settings
        return taken


def test_the_rate_that_it_has_is_no_change() -> None:
    bus = Heard(Steering(LINE, follow=True))
    assert bus.say(*tell(ALL, 9600), ACCEPT_ALL) == []
    assert bus.say(*tell(ALL, 19200), ACCEPT_ALL) == [LINE._replace(baud=19200)]


def test_nothing_is_followed_that_nobody_asked_to_follow() -> None:
    bus = Heard(Steering(LINE, ["8E1"]))
    bus.say(ACCEPT_ALL)
    assert bus.say(*tell(ALL, 19200), ACCEPT_ALL) == []


def test_a_change_that_brings_nothing_valid_is_said_once() -> None:
    bus = Heard(Steering(LINE, follow=True))
    bus.say(*tell(ALL, 19200), ACCEPT_ALL)
    assert bus.wait(4.9) == []
    assert bus.steering.take_hint() is None
    bus.wait(0.2)
    hint = bus.steering.take_hint()
    assert hint and hint.startswith("nothing received since the rate changed (16 let all accept 19200 Bd)")
    assert bus.steering.take_hint() is None
    assert bus.wait(100) == []


def test_a_change_that_brings_a_telegram_is_well() -> None:
    bus = Heard(Steering(LINE, follow=True))
    bus.say(*tell(ALL, 19200), ACCEPT_ALL)
    bus.say(b"xxx", ACCEPT_ALL)
    assert bus.wait(10) == []
    assert bus.steering.take_hint() is None


def test_with_auto_it_searches_again_and_follows_again() -> None:
    bus = Heard(Steering(LINE, ["8E1", "8N1"], follow=True))
    bus.say(ACCEPT_ALL)
    assert bus.steering.searching is None
    assert bus.say(*tell(ALL, 19200), ACCEPT_ALL) == [LINE._replace(baud=19200)]
    assert bus.wait(100) == []  # a bus may be silent
    hint = bus.steering.take_hint()
    assert hint and hint.startswith("nothing received since the rate changed")
    assert bus.say(b"xxx") == [LINE]  # but not speak so
    hint = bus.steering.take_hint()
    assert hint == "no valid telegram since the rate changed (16 let all accept 19200 Bd): looking for it again"
    assert bus.steering.searching
    bus.settings = LINE
    bus.say(ACCEPT_ALL)
    assert bus.steering.searching is None
    assert bus.say(*tell(ALL, 115200), ACCEPT_ALL) == [LINE._replace(baud=115200)]


def several(*, each: bool) -> bytes:
    """38400 Bd, TzA 5 ms and acceptance in one telegram to station 3 (chapter 6.1), the address once or each time."""
    return build(0x03, MASTER, 3, bytes.fromhex("03 07 02 03 02 05 00 03 FF" if each else "03 07 02 02 05 00 FF"))


@pytest.mark.parametrize("each", [False, True])
def test_set_and_accepted_in_one_telegram(each: bool) -> None:
    assert rates(several(each=each)) == [38400]


def test_of_what_no_layout_fits_the_first_counts() -> None:
    """Subservice 06 follows 38400 Bd, and its length is not documented."""
    told = build(0x03, MASTER, 3, bytes.fromhex("03 07 02 06 01"))
    assert rates(told, reaction(3, 0x07), ACCEPT_ALL) == [38400]
