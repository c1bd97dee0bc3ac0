# SPDX-License-Identifier: GPL-2.0-or-later
"""What a telegram says without Wireshark: worked out by hand, and compared with the dissector."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import sistap
from sistap.dissected.packets.dissection import Packet, Telegram
from sistap.dissected.telegrams.attribute import Attribute
from sistap.dissected.telegrams.interpreter import Interpreter
from sistap.dissected.telegrams.values import Value, value
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.record import Event, Framing, Record, Type
from sistap.tap.sis.telegram import build

CAPTURES = Path(__file__).parents[2] / "test-captures"
S36, S95 = bytes.fromhex("00 24 00"), bytes.fromhex("00 5F 00")
READ, WRITE, READ_LIST = 0x10, 0x1F, 0x11
NAME, ATTRIBUTE, UNIT, VALUE = 0x14, 0x1C, 0x24, 0x3C  # parameter control, fig. 8-1: element, and bit 2, the last piece


def record(data: bytes, kind: Type = Type.FRAME, line: int = 0, framing: Framing = Framing.SIS) -> Record:
    return Record(0, kind, line, LineSettings(), data, (0,) * len(data), bytes(len(data)), framing=framing)


class Bus:
    """A bus with master 16 and drive 3, whose parameters are in device 5."""

    def __init__(self) -> None:
        self.interpreter = Interpreter()

    def hear(self, data: bytes, **about: object) -> sistap.Telegram | None:
        return self.interpreter.take(record(data, **about)).telegram  # type: ignore[arg-type]

    def say(self, data: bytes) -> sistap.Telegram:
        said = self.hear(data)
        assert said
        return said

    def ask(self, service: int, control: int, ident: bytes, data: bytes = b"", path: bytes = b"") -> sistap.Telegram:
        return self.say(build(service, 16, 3, bytes([control, 5]) + ident + data, subaddresses=path))

    def answer(
        self, service: int, control: int, data: bytes = b"", status: int = 0, path: bytes = b""
    ) -> sistap.Telegram:
        return self.say(build(service, 16, 3, bytes([status, control, 5]) + data, subaddresses=path, reaction=True))

    def read(self, control: int, ident: bytes, data: bytes) -> sistap.Telegram:
        self.ask(READ, control, ident)
        return self.answer(READ, control, data)


@pytest.fixture
def bus() -> Bus:
    return Bus()


def test_a_write(bus: Bus) -> None:
    """Its value is a number once the attribute was read: two bytes with sign, one decimal place."""
    command = bus.ask(WRITE, VALUE, S36, bytes.fromhex("83 FF"))
    assert command[:10] == (16, 3, False, 0x1F, None, "3", 5, "S-0-0036", "value", "Velocity command value")
    assert (command.value, command.unit, command.data, command.command) == (None, "", bytes.fromhex("83 FF"), None)
    assert str(command) == "16 -> 3  Command  Write parameter S-0-0036 (Velocity command value) = 83 ff"
    bus.read(ATTRIBUTE, S36, bytes.fromhex("01 00 21 01"))
    bus.read(UNIT, S36, bytes.fromhex("03 00 0C 00") + b"rpm")
    command = bus.ask(WRITE, VALUE, S36, bytes.fromhex("83 FF"))
    assert (command.value, command.unit) == (-12.5, "rpm")
    assert str(command) == "16 -> 3  Command  Write parameter S-0-0036 (Velocity command value) = -12.5 rpm"
    assert command.is_write and command.service_name == "Write parameter"
    answer = bus.answer(WRITE, VALUE)
    assert (answer.sender, answer.receiver, answer.is_reaction, answer.status) == (3, 16, True, 0)
    assert (answer.parameter, answer.value, answer.data, answer.command) == ("S-0-0036", None, b"", command)
    assert answer.is_write


def test_a_read(bus: Bus) -> None:
    """The reaction does not name the parameter: its command does. A text is a list of characters (0x00440001)."""
    bus.read(ATTRIBUTE, S95, bytes.fromhex("01 00 44 00"))
    clearing = bus.read(VALUE, S95, bytes.fromhex("04 00 3C 00") + b"\x1b[2J")  # a terminal
    assert str(clearing).endswith("= \u241b[2J")
    text = bytes.fromhex("04 00 3C 00") + b"F228"
    reaction = bus.read(VALUE, S95, text)
    assert (reaction.parameter, reaction.value, reaction.data) == ("S-0-0095", "F228", text)
    assert str(reaction) == "3 -> 16  Reaction  Read parameter S-0-0095 (Diagnostic message) = F228"
    name = bus.read(NAME, S95, b"Diagnosis")
    assert (name.element, name.value, name.data, name.name) == ("name", None, b"Diagnosis", "Diagnosis")
    assert str(name).endswith("Read parameter S-0-0095 (Diagnosis) name = 44 69 61 67 6e 6f 73 69 73")


def test_a_refusal(bus: Bus) -> None:
    """Its data are an error code, not a value."""
    bus.read(ATTRIBUTE, S36, bytes.fromhex("01 00 21 01"))
    command = bus.ask(READ, VALUE, S36)
    answer = bus.answer(READ, VALUE, bytes.fromhex("09 70"), status=1)
    assert (answer.status, answer.value, answer.data) == (1, None, bytes.fromhex("09 70"))
    assert answer.command == command
    assert str(answer).endswith("S-0-0036 (Velocity command value) status 0x01 = 09 70")


def test_a_reaction_without_its_command(bus: Bus) -> None:
    """Whose command was not heard, or was another one: which parameter it is, nobody knows."""
    for _ in range(2):
        answer = bus.answer(READ, VALUE, b"\1\0")
        assert (answer.sender, answer.parameter, answer.element, answer.data) == (3, "", "value", b"\1\0")
        assert answer.command is None and answer.value is None
        bus.ask(READ, NAME, S36)


def test_pieces_and_segments_have_no_value(bus: Bus) -> None:
    bus.read(ATTRIBUTE, S95, bytes.fromhex("01 00 44 00"))
    bus.ask(READ, VALUE & ~4, S95)
    assert bus.answer(READ, VALUE & ~4, bytes.fromhex("08 00 3C 00") + b"F228").value is None
    bus.ask(READ, VALUE, S95)
    assert bus.answer(READ, VALUE, b"over").value is None
    bus.ask(READ_LIST, VALUE, S95, b"\0\0\2\0")
    assert bus.answer(READ_LIST, VALUE, b"\0\0\0\0").value is None


def test_behind_routers(bus: Bus) -> None:
    """A drive there has the parameter of the same number, but another attribute."""
    bus.read(ATTRIBUTE, S36, bytes.fromhex("01 00 21 01"))
    assert bus.ask(WRITE, VALUE, S36, b"\1\0", path=b"\2\10").value is None
    answer = bus.answer(WRITE, VALUE, path=b"\2\10")
    assert (answer.station, answer.parameter) == ("3/2/8", "S-0-0036")


def test_swapped_addresses(bus: Bus) -> None:
    """A device swaps them: its command tells."""
    bus.say(build(0x12, 16, 3))
    answer = bus.say(build(0x12, 3, 16, b"\0\2", reaction=True))
    assert (answer.sender, answer.receiver, answer.station, answer.data) == (3, 16, "3", b"\2")


def test_a_token_needs_no_reaction(bus: Bus) -> None:
    """Chapter 9 says of none. So one after the next command answers something else."""
    token, read = build(0x0F, 16, 17), build(0x12, 17, 3)
    reaction = build(0x0F, 16, 17, b"\0", reaction=True)
    bus.say(token)
    assert bus.say(reaction).command is not None
    bus.say(token)
    bus.say(read)
    assert bus.say(reaction).command is None


def test_elements_are_named_as_in_wireshark(bus: Bus) -> None:
    """Fig. 8-1; the useful data is the value."""
    codes = tomllib.loads((CAPTURES.parent / "plugin/protocol/codes.toml").read_text("utf-8"))["elements"]["codes"]
    names = [bus.ask(READ, int(code) << 3 | 4, S36).element for code in codes]
    assert names == [name.lower().replace("operating data", "value") for name in codes.values()]
    assert len(names) == 8


@pytest.mark.parametrize("ident", ["03 04 00", "01 04 80"])
def test_idents_that_no_document_knows(bus: Bus, ident: str) -> None:
    command = bus.ask(READ, VALUE, bytes.fromhex(ident))
    assert (command.parameter, command.name) == ("", "")


def test_short_bodies(bus: Bus) -> None:
    """Nothing is there that could be wrong."""
    for body in (b"", b"\x3c", b"\x3c\5\0"):
        for is_reaction in (False, True):
            said = bus.say(build(READ, 16, 3, body, reaction=is_reaction))
            assert said.parameter == "" and said.value is None


@pytest.mark.parametrize(
    "about",
    [
        {"kind": Type.OTHER},
        {"kind": Type.EVENT},
        {"framing": Framing.PROCEDURE_3964R},
        {"framing": Framing.ASCII},
        {"framing": Framing.SILENCE},
    ],
)
def test_what_is_no_telegram(bus: Bus, about: dict[str, object]) -> None:
    assert bus.hear(build(0x12, 16, 3), **about) is None


def test_a_damaged_telegram_may_have_been_a_command(bus: Bus) -> None:
    bus.say(build(0x12, 16, 3))
    answer = build(0x12, 16, 3, b"\0\2", reaction=True)
    assert bus.say(answer).command
    assert bus.hear(build(0x12, 16, 3)[:-1] + b"\4") is None
    assert bus.say(answer).command is None


def test_a_file_of_a_later_version(bus: Bus) -> None:
    kept = Interpreter().take(record(b"news", Type.EVENT)._replace(event=Event(99)))
    assert kept.telegram is None and kept.event == 99


@given(
    st.lists(
        st.builds(
            build,
            st.sampled_from([*range(0x20), 0x80, 0x8F, 0x90, 0x9F, 0xC0, 0xFF]),
            st.sampled_from([3, 16]),
            st.sampled_from([3, 16, 255]),
            st.binary(max_size=20),
            reaction=st.booleans(),
            subaddresses=st.binary(max_size=2),
            number=st.none() | st.integers(0, 255),
        ),
        max_size=6,
    )
)
def test_telegrams_of_any_bytes(telegrams: list[bytes]) -> None:
    bus = Bus()
    for telegram in telegrams:
        assert str(bus.say(telegram)).isprintable()


@given(st.integers(0, 0xFFFFFFFF), st.binary(max_size=12))
def test_values_of_any_bytes(attribute: int, data: bytes) -> None:
    assert isinstance(value(Attribute(attribute), data), Value | None)


@pytest.mark.parametrize(
    ("attribute", "data", "expected"),
    [
        (0x00110001, "05 80", 0x8005),  # two bytes without sign
        (0x00210001, "05 80", -0x7FFB),
        (0x00210003, "05 00", 15),  # conversion factor 3
        (0x04220001, "80 96 98 00", 1000.0),
        (0x00010001, "05 80", 0x8005),  # binary digits: a number
        (0x00310001, "34 12", 0x1234),
        (0x00620001, "00 00 20 41", 10.0),
        (0x00610001, "34 12", None),  # floating point of two bytes: nobody says how
        (0x00510001, "2C 80", "P-0-0044"),
        (0x00730001, "80 43 6D 38 00 00 00 00", "2000-01-01T00:00:00.000000000Z"),
        (0x00730001, "80 43 6D 38 00 CA 9A 3B", None),  # a second of 1,000,000,000 ns
        (0x00150001, "04 00 08 00 01 00 02 00", "1, 2"),
        (0x00150001, "01 00 02 00", None),  # without its length words, or a piece
        (0x00440001, "02 00 3C 00 46 32", "F2"),
        (0x00210001, "05", None),
        (0x00200001, "05 80", None),  # length code 0 is not defined
    ],
)
def test_values(attribute: int, data: str, expected: object) -> None:
    """By IEC 61491: bits 16 to 18 length, 20 to 22 format, 24 to 27 decimal places, 0 to 15 factor."""
    assert value(Attribute(attribute), bytes.fromhex(data)) == expected


# -- As the dissector says -------------------------------------------------------------------------------------------

# Here it knows more: what several telegrams of a packet, other interfaces and sections of a file are.
_BEYOND = {"clock-back", "documents-synax", "rare", "roads", "routes", "sections", "twins"}
_TO_DAMAGED = {"point-to-point"}  # a reaction to a damaged command, which is no telegram here
_OTHER_SUBSERVICE = {"outside"}


def compared(telegram: sistap.Telegram, said: Telegram, packet: Packet, records: Sequence[sistap.Record]) -> int:
    """Compare with what the dissector says of a telegram; return how many values were compared."""
    head = telegram.sender, telegram.receiver, telegram.service, telegram.is_reaction, telegram.status
    assert head == (said.talker, said.listener, said.service, said.is_reaction, said.status), telegram
    command = records[said.command_in - 1].telegram if said.command_in else None
    if telegram.command or command:
        assert telegram.command and command and telegram.command[:5] == command[:5], telegram
        assert telegram.command.data == command.data
    if len(packet.accesses) != 1 or not telegram.parameter:
        return 0
    access = packet.accesses[0]
    assert (telegram.station, telegram.device, telegram.parameter) == (
        access.parameter.station, access.parameter.device, access.parameter.ident
    )  # fmt: skip
    carrier = telegram.command if telegram.is_write else telegram
    if carrier is None or carrier.value is None or access.error:
        return 0
    assert not access.is_raw
    if access.number is not None:
        assert carrier.value == access.number, access
    elif isinstance(carrier.value, str) and not access.value.startswith("0b"):
        assert carrier.value.rstrip("Z").replace("T", " ") in (access.value, access.value.strip('"'), ""), access
    return 1


@pytest.mark.thorough
def test_it_says_what_the_dissector_says() -> None:
    """Of all captures: stations, status, which command a reaction answers, parameter and value."""
    values = telegrams = 0
    for capture in sorted(CAPTURES.glob("*.pcapng")):
        if capture.stem in _BEYOND | _TO_DAMAGED | _OTHER_SUBSERVICE:
            continue
        try:
            records = list(sistap.read(capture))
        except sistap.NotCaptured:
            continue
        of_traffic = [one for one in records if one.type != Type.BEFORE and one.event != Event.TOLD_BEFORE]
        for record_, packet in zip(of_traffic, sistap.dissect(capture), strict=True):
            good = [one for one in packet.telegrams if one.good and packet.framing == Framing.SIS]
            assert bool(record_.telegram) == bool(good), (capture, packet.number)
            if record_.telegram:
                telegrams += 1
                values += compared(record_.telegram, good[0], packet, records)
    assert telegrams > 2000 and values > 40


def test_it_says_what_the_dissector_says_of_the_demo_bus() -> None:
    records = list(sistap.play("demo", duration_s=20))
    values = 0
    for record_, packet in zip(records, sistap.dissect(records), strict=True):
        assert bool(record_.telegram) == bool(packet.telegrams)
        if record_.telegram:
            values += compared(record_.telegram, packet.telegrams[0], packet, records)
    assert values > 50
