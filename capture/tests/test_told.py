# SPDX-License-Identifier: GPL-2.0-or-later
"""What a file of a ring begins with: the telegrams that told what explains later ones."""

from __future__ import annotations

import pytest

from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.records.before import Before, heard
from sistap.tap.records.record import Event, Record, Type, event
from sistap.tap.sis.telegram import build
from sistap.tap.sis.told import MOST_PARAMETERS, Told

pytestmark = pytest.mark.tap

MS = 1_000_000
PLENTY = 10**9
S36, P12 = bytes.fromhex("00 24 00"), bytes.fromhex("00 0C 80")
ATTRIBUTE = bytes.fromhex("01 00 22 04")
NAME, ATTRIBUTES, UNIT, MINIMUM, VALUE = 0x14, 0x1C, 0x24, 0x2C, 0x3C  # control bytes, last piece
PIECE = 0x04  # without this bit more pieces follow


class Bus:
    """A bus, and what is told of it."""

    def __init__(self) -> None:
        self.told = Told()

    def say(self, *telegrams: bytes) -> None:
        for telegram in telegrams:
            self.told.take(telegram, 0)

    def read(
        self, control: int, data: bytes, ident: bytes = S36, receiver: int = 3, path: bytes = b""
    ) -> tuple[bytes, bytes]:
        """Read an element of device 5."""
        command = build(0x10, 16, receiver, bytes([control | PIECE, 5]) + ident, subaddresses=path)
        reaction = build(0x10, 16, receiver, bytes([0, control, 5]) + data, subaddresses=path, reaction=True)
        self.say(command, reaction)
        return command, reaction

    def set(self, body: str, station: int = 3, *, status: int = 0) -> list[bytes]:
        """Set something with service 0x03, and answer."""
        command = bytes.fromhex(body)
        telegrams = [build(0x03, 16, station, command)]
        if station < 254:
            telegrams += [build(0x03, 16, station, bytes([status]) + command[:2], reaction=True)]
        self.say(*telegrams)
        return telegrams

    @property
    def facts(self) -> list[bytes]:
        return [said.telegram for said in self.told.telegrams(PLENTY)]


@pytest.fixture
def bus() -> Bus:
    return Bus()


def test_elements_of_parameters(bus: Bus) -> None:
    """Not values. A name may be a list, with two length words."""
    told = [
        *bus.read(NAME, bytes.fromhex("05 00 19 00") + b"Speed"),
        *bus.read(ATTRIBUTES, ATTRIBUTE),
        *bus.read(UNIT, b"1/min"),
        *bus.read(MINIMUM, bytes.fromhex("00 2D 31 01")),
    ]
    bus.read(VALUE, bytes.fromhex("00 00 00 00"))
    told += bus.read(NAME, b"Grad \xb0C\r\x9b", P12, path=b"\x02\x08")
    assert bus.facts == told


@pytest.mark.parametrize("ident", ["01 04 00", "02 42 20", "00 0C A0"])
def test_idents(bus: Bus, ident: str) -> None:
    """A-0-0004, C-2-0066, P-2-0012."""
    assert [*bus.read(NAME, b"N", bytes.fromhex(ident))] == bus.facts


@pytest.mark.parametrize("ident", ["03 04 00", "01 04 80"])
def test_idents_that_no_document_knows(bus: Bus, ident: str) -> None:
    bus.read(NAME, b"N", bytes.fromhex(ident))
    assert bus.facts == []


def test_what_says_nothing(bus: Bus) -> None:
    """No name, an attribute of three bytes, a refusal, a reaction without its command, a name of a thousand letters."""
    bus.read(NAME, b"")
    bus.read(NAME, bytes.fromhex("00 00 14 00"))
    bus.read(ATTRIBUTES, b"\1\2\3")
    bus.say(build(0x10, 16, 3, bytes([NAME, 5]) + S36), build(0x10, 16, 3, b"\1\x14\5\1\x10", reaction=True))
    bus.say(build(0x10, 16, 3, bytes([NAME, 5]) + S36), build(0x10, 16, 3, b"\0\x14\6N", reaction=True))
    for _ in range(5):
        bus.read(NAME & ~PIECE, b"x" * 230)
    bus.read(NAME, b"x")
    assert bus.facts == []


def test_an_empty_unit_says_that_there_is_none(bus: Bus) -> None:
    assert [*bus.read(UNIT, bytes.fromhex("00 00 0C 00"))] == bus.facts


def test_the_newest_value_counts(bus: Bus) -> None:
    """A limit that was read before another attribute belongs to the attribute from before, so it stands before it."""
    bus.read(ATTRIBUTES, ATTRIBUTE)
    told = [*bus.read(MINIMUM, b"\1\2"), *bus.read(ATTRIBUTES, bytes.fromhex("01 00 21 01"))]
    assert bus.facts == told


def test_what_is_read_again_stays_where_it_was(bus: Bus) -> None:
    """The limit is read by that attribute."""
    told = [*bus.read(ATTRIBUTES, ATTRIBUTE), *bus.read(MINIMUM, b"\1\2")]
    bus.read(ATTRIBUTES, ATTRIBUTE)
    assert bus.facts == told


def test_swapped_addresses_and_telegram_numbers(bus: Bus) -> None:
    command = build(0x10, 16, 3, bytes([NAME, 5]) + S36, number=7)
    reaction = build(0x10, 3, 16, b"\0\x14\5N", number=7, reaction=True)
    bus.say(command, reaction)
    assert bus.facts == [command, reaction]


def test_a_name_in_pieces(bus: Bus) -> None:
    told = [*bus.read(NAME & ~PIECE, b"Vel"), *bus.read(NAME & ~PIECE, b"oci")]
    assert bus.told.is_under_way and bus.facts == []
    told += bus.read(NAME, b"ty")
    assert bus.facts == told
    assert not bus.told.is_under_way


def test_after_a_damaged_telegram_pieces_are_not_joined(bus: Bus) -> None:
    bus.read(NAME & ~PIECE, b"Vel")
    bus.told.disturb()
    bus.read(NAME & ~PIECE, b"oci")
    bus.read(NAME, b"ty")
    assert bus.facts == []
    assert [*bus.read(NAME, b"Speed ")] == bus.facts


def test_after_a_damaged_telegram_a_reaction_may_belong_to_it(bus: Bus) -> None:
    command = build(0x10, 16, 3, bytes([NAME, 5]) + S36)
    bus.say(command, build(0x10, 16, 3, b"\2\x14\5\1\x80", reaction=True))
    bus.told.disturb()
    bus.say(build(0x10, 16, 3, b"\0\x14\5N", reaction=True))
    assert bus.facts == []


def test_a_list_of_services(bus: Bus) -> None:
    """Service 0x04: length, service, body."""
    asked = bytes([6, 0x10, NAME, 5]) + S36 + bytes([6, 0x10, UNIT, 5]) + S36
    said = b"\0" + bytes([5, 0x10, 0, NAME, 5]) + b"N" + bytes([5, 0x10, 1, UNIT, 5]) + b"x"
    telegrams = [build(0x04, 16, 3, asked), build(0x04, 16, 3, said, reaction=True)]
    bus.say(*telegrams)
    assert bus.facts == telegrams


def test_settings(bus: Bus) -> None:
    """Set, and accepted, by one or by all; not what was refused, or not answered."""
    told = bus.set("03 02 05 00")  # TzA 5 ms
    bus.set("03 01 28 00", status=1)
    bus.say(build(0x03, 16, 3, bytes.fromhex("03 03 64 00")))
    assert bus.facts == told
    told += bus.set("03 FF")
    assert bus.facts == told
    told += [*bus.set("00 01 32 00", station=255), *bus.set("04 07 01", station=4)]  # TrS 50 ms; 19200 Bd
    assert bus.facts == told
    told += [*bus.set("04 FF", station=4), *bus.set("00 FF", station=255)]
    assert bus.facts == told


def test_of_what_is_set_again_the_last_stays(bus: Bus) -> None:
    """But what was accepted also stays, until the same is accepted again."""
    told = [*bus.set("03 02 05 00"), *bus.set("03 FF")]
    again = bus.set("03 02 05 00")
    assert bus.facts == [*told, *again]
    assert [*again, *bus.set("03 FF")] == bus.facts


def test_settings_behind_a_router_are_of_another_bus(bus: Bus) -> None:
    body = bytes.fromhex("03 02 05 00")
    bus.say(build(0x03, 16, 3, body, subaddresses=b"\2"))
    bus.say(build(0x03, 16, 3, b"\0" + body[:2], subaddresses=b"\2", reaction=True))
    assert bus.facts == []


def test_a_timed_test_of_a_rate(bus: Bus) -> None:
    """No file begins while it goes on, and afterwards nothing is left of it."""
    bus.set("03 08 F4 01 02")  # 38400 Bd for 500 ms
    bus.told.take(build(0x1D, 16, 255, b"\4"), 499 * MS)
    assert bus.told.is_under_way and bus.facts == []
    bus.told.take(build(0x1D, 16, 255, b"\4"), 500 * MS)
    assert not bus.told.is_under_way


def test_what_is_under_way(bus: Bus) -> None:
    """A command waits for its reaction, until its master sends another one or nobody has answered for long."""
    command, broadcast = build(0x12, 16, 3), build(0x1D, 16, 255, b"\4")
    routed = build(0x12, 16, 3, subaddresses=b"\2"), build(0x12, 3, 2), build(0x12, 3, 2, b"\0\4", reaction=True)
    for telegrams, is_under_way in [
        ([], False),
        ([command], True),
        ([build(0x12, 16, 3, b"\0\4", reaction=True)], False),
        ([broadcast], False),
        (routed, True),  # the command to the router
        ([build(0x12, 16, 3, b"\0\4", reaction=True, subaddresses=b"\2")], False),
        ([command, *[broadcast] * 99], False),
        ([build(0x12, 1, 3), *[broadcast] * 98], True),
        ([broadcast] * 2, False),
        ([build(0x1F, 16, 3, b"\x38\5" + S36 + b"A"), build(0x1F, 16, 3, b"\0\x3c\5", reaction=True)], True),
        ([build(0x1F, 16, 3, b"\x3c\5" + S36 + b"B"), build(0x1F, 16, 3, b"\0\x3c\5", reaction=True)], False),
    ]:
        bus.say(*telegrams)
        assert bus.told.is_under_way == is_under_way, telegrams


def test_the_newest_stay(bus: Bus) -> None:
    for number in range(MOST_PARAMETERS + 10):
        bus.read(NAME, b"N", b"\0" + (number % 4096).to_bytes(2, "little"), receiver=3 + number // 4096)
    newest = [*bus.read(NAME, b"N", b"\1\0\0"), *bus.read(NAME, b"N", b"\1\1\0")]
    assert len(bus.facts) == 2 * MOST_PARAMETERS
    most = sum(len(telegram) + 12 for telegram in newest)  # the rest of a record takes as much as 12 characters
    for characters, told in ((most, newest), (most + 1, newest), (most - 1, newest[2:]), (0, [])):
        assert [said.telegram for said in bus.told.telegrams(characters)] == told


def record(telegram: bytes, line: int = 0, time_ns: int = 0) -> Record:
    count = len(telegram)
    return Record(time_ns, Type.FRAME, line, LineSettings(), telegram, [0] * count, bytes(count))


def named(line: int, name: bytes) -> list[Record]:
    asked, said = bytes([NAME, 5]) + S36, b"\0\x14\5" + name
    return [record(build(0x10, 16, 3, asked), line), record(build(0x10, 16, 3, said, reaction=True), 2 if line else 0)]


def test_two_directions_are_one_bus() -> None:
    """Each telegram is on its line, at the time of the file's beginning; when its characters came is not known."""
    before = Before()
    said = named(1, b"N")
    for one in said:
        before.take(heard(one))
    for one, told in zip(said, before.records(7), strict=True):
        count = len(one.data)
        unknown = bytes([Flag.INTERVAL_UNKNOWN] * count)
        assert told == one._replace(time_ns=7, type=Type.BEFORE, intervals=(0,) * count, flags=unknown)


def test_a_file_passes_on_what_it_begins_with() -> None:
    first, second = Before(), Before()
    for one in named(0, b"N"):
        first.take(heard(one))
    for one in first.records(7):
        second.take(heard(one))
    assert [*second.records(7)] == [*first.records(7)] != []


@pytest.mark.parametrize(
    "between",
    [
        record(b"\2\0\0\0\0\0\0\0")._replace(checksum_bad=True),
        Record(0, Type.OTHER, 0, LineSettings(), b"12345678", [0] * 8, bytes(8)),
        Record(0, Type.OTHER, 0, LineSettings(), b"1", [0], bytes([Flag.LOST_BEFORE])),
        event(0, 0, LineSettings(), Event.CHARACTERS_LOST, "gap"),
    ],
    ids=["damaged", "others", "lost", "gap"],
)
def test_what_disturbs(between: Record) -> None:
    """A reaction that comes after the end of its exchange may belong to a command that was lost."""
    before = Before()
    asked, said = named(0, b"N")
    refused = record(build(0x10, 16, 3, b"\2\x14\5\1\x80", reaction=True))
    for one in (asked, refused, between, said):
        before.take(heard(one))
    assert [one.data for one in before.records(0)] == [b""]


def test_where_nothing_was_told_a_file_says_that_it_continues() -> None:
    before = Before()
    before.take(heard(record(build(0x12, 16, 3), line=2)))
    (nothing,) = before.records(7)
    assert (nothing.type, nothing.line, nothing.data, nothing.time_ns) == (Type.BEFORE, 2, b"", 7)


def test_settings_have_no_more_room_than_there_is(bus: Bus) -> None:
    """Each takes a command of 12 or 10 bytes and a reaction of 11; a record takes as much as 12 characters."""
    told = [bus.set("03 02 05 00", station) + bus.set("03 FF", station) for station in range(3, 33)]
    settings = [said.telegram for said in bus.told.telegrams(400)]
    assert 200 < sum(len(telegram) + 12 for telegram in settings) <= 400
    assert settings[-1] == told[-1][-1], "the newest stay"


def test_a_reaction_answers_no_command_from_before_the_file(bus: Bus) -> None:
    asked, said = (one.data for one in named(0, b"N"))
    assert bus.told.take(asked, 0, is_before=True) == b""
    assert bus.told.take(said, 0) == b""
    assert bus.told.take(said, 0, is_before=True) == asked


def test_limits_of_a_line_that_appeared_later() -> None:
    """Whoever captures has told them; each file begins with them."""
    before = Before()
    before.take(heard(event(0, 3, LineSettings(), Event.LIMITS_TOLD, "TzA = 8 ms")))
    limits, _ = before.records(9)
    assert (limits.time_ns, limits.line, limits.event, limits.data) == (9, 3, Event.LIMITS_TOLD, b"TzA = 8 ms")


def test_after_a_second_of_silence_nothing_is_under_way() -> None:
    before = Before()
    before.take(heard(record(build(0x12, 16, 3), time_ns=1000)))
    assert before.is_under_way(1000 + 999 * MS)
    assert not before.is_under_way(1000 + 1000 * MS)
    assert not before.is_under_way(0), "the clock went back"


def test_types_of_devices(bus: Bus) -> None:
    """Type key and firmware (chapter 3); a twin may explain the parameters of a device."""
    told = []
    for subservice, text in ((3, b"DKC02.3-040-7-FW"), (2, b"FWA 1"), (1, b"01V01"), (3, b"")):
        command = build(0x00, 16, 3, bytes([3, subservice]))
        told += [command, build(0x00, 16, 3, bytes([0, 3, subservice]) + text, reaction=True)]
    bus.say(*told)
    bus.say(build(0x00, 16, 3, b"\3\3"), build(0x00, 16, 3, b"\xf1\3\3refused", reaction=True))
    assert bus.facts == told[:4]
