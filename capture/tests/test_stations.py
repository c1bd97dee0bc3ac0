# SPDX-License-Identifier: GPL-2.0-or-later
"""Stations: their answers to commands, compared with the specification's figures and tables."""

from __future__ import annotations

import re
import tomllib
import zlib
from collections.abc import Mapping
from importlib import resources
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sisbus import service
from sisbus.devices.parameter_sets import PARAMETER_MODE_ONLY, built_in
from sisbus.devices.parameters import AccessError, Element, Parameter, ident, text
from sisbus.stations import making
from sisbus.stations.flash import module
from sisbus.stations.making import make
from sisbus.stations.station import Station
from sistap.dissected.telegrams.attribute import PROCEDURE_COMMAND, READ_ONLY, Attribute, Format
from sistap.tap.sis.codes import LAYOUTS, Item, Layout
from sistap.tap.sis.telegram import build, parse

MS = 1_000_000


def octets(figure: str) -> bytes:
    return bytes.fromhex(figure)


def station(**table: Any) -> Station:
    return make([{"address": 3, **table}], 1)[0]


def drive(address: int = 3, **table: Any) -> Station:
    return station(address=address, **table)


def ask(asked: Station, service: int, body: str = "", now_ms: float = 0, **header: Any) -> str:
    """Send a command from 16, with a body in hex; return the body of the reaction in hex, "none" if there is none."""
    receiver = header.pop("receiver", asked.address)
    sender = header.pop("sender", 16)
    reaction = asked.react(build(service, sender, receiver, octets(body), **header), int(now_ms * MS))
    return "none" if reaction is None else parse(reaction).body.hex(" ").upper()


# -- Who is answered (chapter 2) ------------------------------------------------------------------------------------


def test_who_is_not_answered() -> None:
    slave = drive()
    command = build(0x12, 16, 3)
    assert slave.react(command, 0) is not None
    assert slave.react(build(0x12, 16, 4), 0) is None  # somebody else
    for receiver in (200, 253, 254, 255):
        assert slave.react(build(0x12, 16, receiver), 0) is None
    assert slave.react(build(0x12, 16, 3, b"\x00\x04", reaction=True), 0) is None  # its own reaction
    for place in range(len(command)):  # damaged: on RS485 no answer
        damaged = bytearray(command)
        damaged[place] ^= 0x40
        assert slave.react(bytes(damaged), 0) is None
    assert slave.react(command[:5], 0) is None
    # 02 D9 00 00 00 12 10 03 with other lengths: 01 and FF add up to the same
    assert slave.react(octets("02 D9 01 FF 00 12 10 03"), 0) is None


def test_point_to_point_everybody_answers_with_128_and_what_is_damaged_too() -> None:
    slave = drive()
    # phase 4; checksums by hand
    assert slave.react(octets("02 5C 00 00 00 12 10 80"), 0) == octets("02 44 02 02 10 12 10 80 00 04")
    # the same with a wrong checksum, two lengths, without a start character, and a reaction: F4, F2, F1, F1
    assert slave.react(octets("02 5D 00 00 00 12 10 80"), 0) == octets("02 56 01 01 10 12 10 80 F4")
    assert slave.react(octets("02 5B 01 00 00 12 10 80"), 0) == octets("02 58 01 01 10 12 10 80 F2")
    assert slave.react(octets("03 5B 00 00 00 12 10 80"), 0) == octets("02 59 01 01 10 12 10 80 F1")
    assert slave.react(octets("02 4C 00 00 10 12 10 80"), 0) == octets("02 59 01 01 10 12 10 80 F1")
    assert slave.react(octets("02 5B 01 01 00 12 10 80"), 0) == octets("02 58 01 01 10 12 10 80 F2")  # cut off


VELOCITY = "3C 00 00 24 00 E8 03 00 00"  # S-0-0036 = 0.1 rpm, 1000 of 0.0001
READ_VELOCITY = "3C 00 00 24 00"


def test_what_is_for_all_is_obeyed_and_what_is_for_a_group_by_its_members() -> None:
    for receiver, obeyed in ((255, True), (254, True), (200, True), (201, False), (129, False)):
        slave = drive(groups=[200])
        assert ask(slave, 0x1F, VELOCITY, receiver=receiver) == "none"
        assert ask(slave, 0x10, READ_VELOCITY) == "00 3C 00 " + ("E8 03 00 00" if obeyed else "00 00 00 00")


def test_telegram_errors_have_the_useful_data_header_and_no_data() -> None:
    slave = drive()
    assert ask(slave, 0x05, "03 01") == "F0"  # service without a definition
    assert ask(slave, 0x90, "3C 03 00 24 00") == "F0"  # SYNAX, and this is a drive
    assert ask(slave, 0x00, "03 09") == "FB 03 09"
    assert ask(slave, 0x03, "03 06 01") == "FB 03 06"
    assert ask(slave, 0x03, "03 01 32") == "FA 03 01"
    assert ask(slave, 0x10, "3C") == "FA 3C"
    assert ask(slave, 0x10, "3C 09 00 24 00") == "FC 3C 09"  # no such device
    assert ask(slave, 0x12, subaddresses=b"\x02\x08") == "F9"


def test_the_same_telegram_number_again_is_answered_but_not_obeyed() -> None:
    slave = drive()
    write, read = "3C 03 00 64 00 {} 00", "3C 03 00 64 00"  # S-0-0100
    assert ask(slave, 0x1F, write.format("01"), number=7) == "00 3C 03"
    assert ask(slave, 0x1F, write.format("02")) == "00 3C 03"  # without a number: always
    assert ask(slave, 0x1F, write.format("01"), number=7) == "00 3C 03"
    assert ask(slave, 0x10, read) == "00 3C 03 02 00"
    # One more in the number, one less in the data: the eight bytes of the static header are the same.
    assert ask(slave, 0x1F, write.format("00"), number=8) == "00 3C 03"
    assert ask(slave, 0x10, read) == "00 3C 03 00 00"
    assert ask(slave, 0x1F, write.format("05"), number=0) == "00 3C 03"
    assert ask(slave, 0x1F, write.format("06")) == "00 3C 03"
    assert ask(slave, 0x1F, write.format("05"), number=0) == "00 3C 03"  # 0: always
    assert ask(slave, 0x10, read) == "00 3C 03 05 00"
    assert ask(slave, 0x1F, write.format("07"), number=9) == "00 3C 03"
    assert ask(slave, 0x12, number=0) == "00 04"  # and what was kept is forgotten
    assert ask(slave, 0x1F, write.format("08")) == "00 3C 03"
    assert ask(slave, 0x1F, write.format("07"), number=9) == "00 3C 03"
    assert ask(slave, 0x10, read) == "00 3C 03 07 00"


def test_a_system_error_shows_in_the_telegram_control_of_if02() -> None:
    slave = drive()
    assert ask(slave, 0x02, "03 92 00 00 00 FF 10") == "01 03 92 00"  # no memory there
    reaction = slave.react(build(0x12, 16, 3), 0)
    assert reaction is not None and reaction[4] == 0x90
    assert ask(slave, 0x02, "03 9F") == "00 03 9F"
    reaction = slave.react(build(0x12, 16, 3), 0)
    assert reaction is not None and reaction[4] == 0x10


def test_ecodrive03_has_the_state_of_the_request_there_and_other_groups_and_no_lists() -> None:
    slave = drive(edition="ECODRIVE03")

    def control(body: str, now_ms: int = 0) -> int:
        reaction = slave.react(build(0x10, 16, 3, octets(body)), now_ms * MS)
        assert reaction is not None
        return reaction[4]

    assert control("3C 03 00 24 00") == 0x10
    assert control("3C 03 00 E7 03") == 0x10 | 0b110 << 5
    assert ask(slave, 0x1D, "02") == "00"
    assert control("3C 03 00 24 00") == 0x10 | 0b001 << 5  # busy with the switching
    assert ask(slave, 0x12, receiver=128) == "none"  # a group
    assert ask(slave, 0x04, "01 12") == "F0"


def test_a_service_that_is_only_described_is_answered_with_zeros(monkeypatch: pytest.MonkeyPatch) -> None:
    """So a service that is new in services.toml is on the bus, too."""
    lamp = {0x01: Layout((Item("colour", 2),), (Item("bits", 1), Item("hours", 2))), 0x02: Layout((), ())}
    plain = {0: Layout((Item("colour", 2),), (Item("bits", 1), Item("more", 1, True)))}
    for file in (service, making):
        monkeypatch.setattr(file, "LAYOUTS", {**LAYOUTS, 0x05: lamp, 0x06: plain})
    monkeypatch.setattr(service, "WITHOUT_SUBSERVICES", {0x06})
    slave = drive()
    assert ask(slave, 0x05, "03 01 2C 01") == "00 03 01 00 00 00"
    assert ask(slave, 0x05, "03 01 2C") == "FA 03 01"  # useful data missing (fig. 2-18)
    assert ask(slave, 0x05, "03 02") == "00 03 02"
    assert ask(slave, 0x05, "03 03") == "FB 03 03"  # subservice not supported
    assert ask(slave, 0x06, "2C 01") == "00 00"
    assert ask(slave, 0x06, "2C") == "FA"


# -- 0x00, 0x01 and 0x04 (chapters 3, 4 and 7) ----------------------------------------------------------------------


def test_identification() -> None:
    slave = drive(type_key="CLC-D02,3M-FW", rates=[9600, 19200])
    assert slave.react(octets("02 E3 02 02 00 00 10 03 03 01"), 0) == octets(
        "02 AF 08 08 10 00 10 03 00 03 01 30 31 56 30 31"  # fig. 3-4: 01V01
    )
    # fig. 3-8: the device type key
    assert ask(slave, 0x00, "03 03") == "00 03 03 43 4C 43 2D 44 30 32 2C 33 4D 2D 46 57"
    assert ask(slave, 0x00, "03 04") == "00 03 04 01"  # fig. 3-11
    assert ask(drive(), 0x00, "03 04") == "00 03 04 0F"  # all masks ORed


def test_a_list_of_services_as_in_fig_7_1_and_7_2() -> None:
    slave = drive(type_key="CLC-D02,3M-FW")
    assert slave.react(octets("02 8E 0C 0C 00 04 10 03 03 00 10 01 03 00 10 03 03 00 10 04"), 0) == octets(
        "02 F8 23 23 10 04 10 03 00 09 00 00 10 01 30 31 56 30 31 11 00 00 10 03 43 4C 43 2D 44 30 32 2C 33 4D 2D "
        "46 57 05 00 00 10 04 0F"
    )


def test_a_list_in_a_list_is_refused_and_the_rest_of_it_executed() -> None:
    # itself, an unknown subservice, and the phase: overall status 1
    assert ask(drive(), 0x04, "03 04 01 12 03 00 03 09 01 12") == "01 02 04 F0 04 00 FB 03 09 03 12 00 04"
    assert ask(drive(), 0x04, "05 12") == "FA"  # longer than the telegram
    assert ask(drive(), 0x04, "00") == "FA"


def test_a_list_whose_answers_do_not_fit_is_not_good() -> None:
    answer = ask(drive(), 0x04, "03 00 03 03 " * 15)
    assert answer.startswith("01 14 00 00 03 03 44 4B 43")
    assert len(octets(answer)) == 1 + 11 * 21  # of 247 bytes; the type key has 16 characters


# -- 0x03 (chapter 6) -----------------------------------------------------------------------------------------------


def test_what_is_set_holds_when_it_is_accepted() -> None:
    slave = drive()
    for body in ("03 01 32 00", "03 02 05 00", "03 03 F4 01", "03 07 02"):
        assert ask(slave, 0x03, body) == f"00 {body[:5]}"
    timing = slave.initialization.timing(0)
    assert timing == (9600, None, None, None)
    assert ask(slave, 0x03, "00 FF", receiver=255) == "none"
    assert slave.initialization.timing(0) == (38400, 50, 5, 500)


def test_a_test_of_a_rate_begins_after_its_reaction_and_ends() -> None:
    slave = drive()
    # fig. 6-21: 115200 Bd for 800 ms
    assert slave.react(octets("02 AB 05 05 00 03 10 03 00 08 20 03 08"), 10 * MS) is not None
    assert slave.initialization.timing(10 * MS).baud == 9600
    assert slave.initialization.timing(10 * MS + 1).baud == 115200
    assert slave.initialization.timing(810 * MS - 1).baud == 115200
    assert slave.initialization.timing(810 * MS).baud == 9600


def test_a_new_rate_ends_a_test() -> None:
    slave = drive()
    for body in ("03 07 02", "03 08 20 03 08", "03 FF"):
        assert ask(slave, 0x03, body) == f"00 {body[:5]}"
    assert slave.initialization.timing(100 * MS).baud == 38400
    assert slave.initialization.timing(900 * MS).baud == 38400


@pytest.mark.parametrize(
    ("body", "answer"),
    [
        ("03 07 03", "01 03 07 00"),  # two rates ORed: not defined
        ("03 07 08", "01 03 07 00"),  # 115200, which this station does not have
        ("03 08 F4 01 08", "01 03 08 00"),
        ("03 08 FF FF 01", "01 03 08 01"),  # 65535 ms
        ("03 08 F4 01 01", "00 03 08"),
    ],
)
def test_rates_that_are_refused(body: str, answer: str) -> None:
    assert ask(drive(rates=[9600, 19200]), 0x03, body) == answer


# -- 0x02 (chapter 5) -----------------------------------------------------------------------------------------------

START, LENGTH = "00 10 00 00", "00 30 00 00"  # of the firmware


def loader(**table: Any) -> Station:
    slave = drive(phase=2, **table)
    assert ask(slave, 0x02, "03 90 01 00 00 00 00") == "00 03 90"
    return slave


def test_a_firmware_is_downloaded() -> None:
    slave = loader()
    assert ask(slave, 0x12) == "F0"  # no firmware runs
    assert ask(slave, 0x00, "03 01") == "00 03 01 30 31 56 30 31"
    assert ask(slave, 0x02, "03 93") == f"00 03 93 {START}"
    assert ask(slave, 0x02, "03 94" + " FF" * 8) == "00 03 94"
    assert ask(slave, 0x02, f"03 92 {START} 04") == "00 03 92 FF FF FF FF"
    assert ask(slave, 0x02, "03 90 00 00 00 00 00") == "01 03 90 02"  # it is deleted
    assert ask(slave, 0x02, "03 91 00 00 00 00") == "01 03 91 02"
    firmware = module(bytes(range(250)) * 49 + bytes(32))  # 0x3000 bytes with the checksums
    for place in range(0, len(firmware), 240):
        address = (0x1000 + place).to_bytes(4, "little").hex(" ")
        piece = firmware[place : place + 240].hex(" ")
        assert ask(slave, 0x02, f"03 96 {address} 04 {piece}") == "00 03 96"
    assert ask(slave, 0x02, f"03 97 {START} {LENGTH}") == "00 03 97"
    assert ask(slave, 0x02, f"03 92 {START} F4") == "00 03 92 " + firmware[:244].hex(" ").upper()
    assert ask(slave, 0x02, "03 91 00 00 00 00") == "00 03 91"
    assert ask(slave, 0x12) == "00 02"


def test_in_the_loader_there_are_no_phases_that_stand_against_a_reboot() -> None:
    slave = drive(phase=2)
    assert ask(slave, 0x1D, "04") == "00"
    assert ask(slave, 0x02, "03 90 01 00 00 00 00", 1) == "00 03 90"  # still in phase 2
    assert ask(slave, 0x02, "03 91 00 00 00 00", 1000) == "00 03 91"
    assert ask(slave, 0x12, "", 1000) == "00 02"


def test_checksums_of_a_module() -> None:
    payload = b"\x01\x02\x03\x04"
    whole = module(payload)
    assert whole[:8] == payload + zlib.crc32(payload).to_bytes(4, "little")
    words = [int.from_bytes(whole[place : place + 2], "little") for place in range(0, 10, 2)]
    assert sum(words) & 0xFFFF == 0
    slave = drive(phase=2)
    wrong_sum, wrong_crc = bytearray(whole), bytearray(whole)
    wrong_sum[0] ^= 1
    wrong_crc[4] ^= 1  # a bit more or less in the CRC, and in the sum that makes up for it
    wrong_crc[8] = wrong_crc[8] - 1 if wrong_crc[4] > whole[4] else wrong_crc[8] + 1
    for contents, answer in ((whole, "00 03 97"), (wrong_sum, "01 03 97 01"), (wrong_crc, "01 03 97 02")):
        assert ask(slave, 0x02, f"03 96 00 00 80 00 02 {contents.hex()}") == "00 03 96"
        assert ask(slave, 0x02, "03 97 00 00 80 00 0A 00 00 00") == answer


FLASH_ERRORS: list[tuple[Mapping[str, Any], str, str]] = [
    ({"phase": 4}, "03 90 01 00 00 00 00", "01 03 90 04"),
    ({"phase": 3}, "03 90 01 00 00 00 00", "01 03 90 03"),
    ({"phase": 4}, "03 91 00 00 00 00", "01 03 91 04"),
    ({"phase": 3}, "03 91 00 00 00 00", "01 03 91 03"),
    ({"edition": "IndraDrive"}, "03 90 01 00 00 00 00", "01 03 90 10"),
    ({"edition": "IndraDrive"}, "03 91 00 00 00 00", "01 03 91 10"),
    ({"phase": 2}, "03 90 02 00 00 00 00", "FC 03 90"),  # neither firmware nor loader
    ({"phase": 2}, "03 92 F0 FF FF 7F 10", "01 03 92 00"),
    ({"phase": 2}, f"03 92 {START} F5", "01 03 92 0B"),  # 245 bytes
    ({"phase": 2}, "03 94" + " FF" * 8, "01 03 94 0A"),
    ({"phase": 2}, "03 96 00 10 80 00 02 55", "01 03 96 FF"),  # behind the RAM
    ({"phase": 2}, "03 96 00 04 90 00 03 55", "01 03 96 FF"),  # behind the dual-port RAM
    ({"phase": 2}, "03 96 00 00 00 00 04 55", "01 03 96 E0"),  # the loader cannot be programmed
    ({"phase": 2}, "03 96 00 00 80 00 01 55", "FC 03 96"),  # ROM: not supported
    ({"phase": 2, "worn": True}, f"03 96 {START} 04 55", "01 03 96 E1"),
    ({"phase": 2}, "03 98", "FB 03 98"),
    ({"phase": 2}, "03 92 00 10 00 00", "FA 03 92"),
]


@pytest.mark.parametrize(("table", "body", "answer"), FLASH_ERRORS)
def test_flash_errors(table: Mapping[str, Any], body: str, answer: str) -> None:
    assert ask(drive(**table), 0x02, body) == answer


def test_a_worn_flash_is_not_erased_in_time_and_what_is_not_erased_not_programmed() -> None:
    assert ask(loader(worn=True), 0x02, "03 94" + " FF" * 8) == "01 03 94 00"
    slave = loader()
    sector = "03 94 00 20 00 00 00 10 00 00"
    assert ask(slave, 0x02, sector) == "00 03 94"
    assert ask(slave, 0x02, "03 96 00 20 00 00 04 F0 F0") == "00 03 96"
    assert ask(slave, 0x02, "03 96 00 20 00 00 04 0F F0") == "01 03 96 E0"  # no bit becomes 1 again
    assert ask(slave, 0x02, "03 94 00 00 00 00 00 10 00 00") == "FC 03 94"  # the loader


# -- Parameters (chapter 8) -----------------------------------------------------------------------------------------


def test_parameters_are_named_as_in_the_documents() -> None:
    assert ident("S-0-0044") == octets("00 2C 00")
    assert ident("P-0-0012") == octets("00 0C 80")  # fig. 8-42
    assert ident("P-2-0012") == octets("00 0C A0")  # parameter set 2 in bits 12 to 14
    assert ident("A-0-0004") == octets("01 04 00")
    assert ident("C-0-0066") == octets("02 42 00")
    for wrong in ("S-0-44", "X-0-0001", "S-8-0001", "S-0-4096"):
        with pytest.raises(ValueError, match="is not a parameter"):
            ident(wrong)


def test_attribute_bits() -> None:
    # factor 1; four bytes: 2 << 16; signed: 2 << 20; four decimals: 4 << 24; protected in phases 2 to 4: bits 28 to 30
    assert Attribute.of(4, Format.SIGNED, more=4 << 24 | READ_ONLY).bits == 0x74220001
    assert Attribute.of(1, Format.TEXT, is_list=True).bits == 0x00440001
    assert Attribute.of(2, Format.BINARY, more=PROCEDURE_COMMAND).bits == 0x00090001
    assert text("rpm") == octets("03 00 03 00 72 70 6D")


def test_the_elements_of_a_parameter() -> None:
    slave = drive()
    velocity = "{} 03 00 24 00"
    assert ask(slave, 0x10, velocity.format("0C")) == "00 0C 03 24 00"
    assert (
        ask(slave, 0x10, velocity.format("14")) == "00 14 03 16 00 16 00 " + b"Velocity command value".hex(" ").upper()
    )
    assert ask(slave, 0x10, velocity.format("1C")) == "00 1C 03 01 00 22 04"  # 4 bytes, signed, four decimals
    assert ask(slave, 0x10, velocity.format("24")) == "00 24 03 03 00 03 00 72 70 6D"
    assert ask(slave, 0x10, velocity.format("2C")) == "00 2C 03 80 3C 36 FE"  # -3000.0000
    assert ask(slave, 0x10, velocity.format("34")) == "00 34 03 80 C3 C9 01"
    assert ask(slave, 0x10, velocity.format("3C")) == "00 3C 03 00 00 00 00"
    assert ask(slave, 0x80, velocity.format("3C")) == "00 3C 03 00 00 00 00"


COMMAND: dict[str, dict[str, object]] = {"S-0-0099": {}}
WRITES: list[tuple[str, str, str]] = [
    ("04 03 00 24 00", "", "0009"),
    ("0C 03 00 24 00", "25 00", "1009"),
    ("14 03 00 24 00", "58", "2004"),
    ("1C 03 00 24 00", "58", "3004"),
    ("24 03 00 24 00", "58", "4004"),
    ("2C 03 00 24 00", "58", "5004"),
    ("34 03 00 24 00", "58", "6004"),
    ("3C 03 00 24 00", "00 00 00", "7002"),
    ("3C 03 00 24 00", "00 00 00 00 00", "7003"),
    ("3C 03 00 28 00", "00 00 00 00", "7004"),  # S-0-0040: feedback
    ("3C 03 00 2C 00", "02 00", "7005"),  # S-0-0044 in phase 4
    ("3C 03 00 24 00", "7F 3C 36 FE", "7006"),  # -3000.0001
    ("3C 03 00 24 00", "81 C3 C9 01", "7007"),
    ("3C 03 00 63 00", "04 00", "7008"),  # a command knows 0, 1 and 3
    ("3C 03 00 2F 00", "FF FF FF FF", "700C"),  # S-0-0047 below zero
    ("3C 03 00 2F 00", "81 EE 36 00", "700C"),  # 360.0001 degrees
    ("3C 03 00 48 80", "04 00 00 10 01 00 00 00", "700D"),  # P-0-0072: another length, phase 4
    ("3C 03 00 A6 8F", "04 00 10 00 01 00 00 00", "700E"),  # P-0-4006: always four
    ("3C 03 00 A6 8F", "10 00 10 00 01 00 00 00", "7002"),
    ("3C 03 00 A6 8F", "14 00 10 00" + " 00" * 20, "7003"),
    ("3C 03 00 E7 03", "00 00", "1001"),
]


@pytest.mark.parametrize(("header", "data", "code"), WRITES)
def test_wrong_writes_get_the_codes_of_fig_8_48(header: str, data: str, code: str) -> None:
    slave = drive()
    before = ask(slave, 0x10, "3C" + header[2:])
    assert ask(slave, 0x1F, f"{header} {data}") == f"01 {header[:5]} {code[2:]} {code[:2]}"
    assert ask(slave, 0x10, "3C" + header[2:]) == before


def test_write_protection() -> None:
    def write(protection: int, phase: int) -> None:
        attribute = Attribute.of(2, Format.UNSIGNED, more=protection)
        Parameter("S-0-0001", "", attribute, b"\0\0").write(Element.DATA, b"\1\0", phase)

    with pytest.raises(AccessError) as never:
        write(READ_ONLY, 2)
    assert never.value.code == 0x7004
    with pytest.raises(AccessError) as not_now:
        write(PARAMETER_MODE_ONLY, 4)
    assert not_now.value.code == 0x7005
    write(PARAMETER_MODE_ONLY, 2)


def test_missing_elements_are_said_to_be_missing() -> None:
    slave = drive()
    # P-0-0004 has neither name nor unit nor limits
    for header, code in (("04", "09 00"), ("14", "01 20"), ("24", "01 40"), ("2C", "01 50"), ("34", "01 60")):
        assert ask(slave, 0x10, f"{header} 03 00 04 80") == f"01 {header} 03 {code}"


def test_the_lists_of_ident_numbers() -> None:
    slave = drive()

    def idents(number: str) -> list[str]:
        said, control = b"", "38"
        while control == "38":
            answer = ask(slave, 0x10, f"3C 03 00 {number}")
            status, control, _, data = answer.split(" ", 3)
            assert status == "00"
            said += octets(data)
        assert int.from_bytes(said[:2], "little") == len(said) - 4
        return [said[place : place + 2].hex(" ").upper() for place in range(4, len(said), 2)]

    everything, commands, backup = idents("11 00"), idents("19 00"), idents("C0 00")
    assert len(everything) == len(set(everything)) > 50
    assert "0C 80" in commands and "24 00" not in commands  # C300 and S-0-0036
    assert "24 00" in backup and "28 00" not in backup and "0C 80" not in backup
    assert set(commands) | set(backup) < set(everything)
    assert idents("BB 00") == ["28 00", "33 00", "54 00"]
    assert idents("15 00") == []
    for number in everything:  # all are there, with an attribute and data or a way to them
        assert ask(slave, 0x10, f"1C 03 00 {number}").startswith("00")
        answer = ask(slave, 0x10, f"3C 03 00 {number}")
        assert answer.startswith("00 3")
        while answer.startswith("00 38"):
            answer = ask(slave, 0x10, f"3C 03 00 {number}")


def test_a_command_and_its_data_status() -> None:
    """Fig. 8-42 to 8-44: the ident number of P-0-0012 is written, the data status comes back."""
    slave = drive(1, parameters={"P-0-0012": {"takes": 100}})
    status, write = "0C 01 00 0C 80 0C 80", "3C 01 00 0C 80 {} 00"
    for now_ms, written, expected in (
        (0, None, "00 00"),
        (0, "03", "07 00"),  # in process
        (60, None, "07 00"),
        (60, "01", "05 00"),  # interrupted
        (500, None, "05 00"),
        (500, "03", "07 00"),  # goes on: 40 ms are left
        (539, None, "07 00"),
        (540, None, "03 00"),  # done
        (550, "00", "00 00"),  # cleared
        (560, "03", "07 00"),
        (660, None, "03 00"),
    ):
        if written is not None:
            assert ask(slave, 0x1F, write.format(written), now_ms) == "00 3C 01"
        assert ask(slave, 0x1F, status, now_ms) == f"00 0C 01 {expected}"
    assert ask(slave, 0x1F, status[:14], 660) == "00 0C 01 03 00"  # without data


def test_a_command_that_is_not_possible_and_invalid_data() -> None:
    slave = drive(phase=2, parameters={"S-0-0100": {"valid": False}})
    assert ask(slave, 0x1F, "3C 03 00 A2 80 03 00") == "00 3C 03"  # P-0-0162
    assert ask(slave, 0x1F, "0C 03 00 A2 80", 2999) == "00 0C 03 07 00"
    assert ask(slave, 0x1F, "0C 03 00 A2 80", 3000) == "00 0C 03 0F 00"
    assert ask(slave, 0x1F, "0C 03 00 64 00") == "00 0C 03 00 01"  # bit 8
    assert ask(slave, 0x10, "3C 03 00 15 00") == "00 3C 03 02 00 02 00 64 00"  # S-0-0021
    assert ask(slave, 0x1F, "3C 03 00 64 00 01 00") == "00 3C 03"
    assert ask(slave, 0x1F, "0C 03 00 64 00") == "00 0C 03 00 00"


def test_basic_load() -> None:
    slave = drive(phase=2)
    for name, value in (("64 00", "01 00"), ("2C 00", "01 00")):  # S-0-0100, S-0-0044
        assert ask(slave, 0x1F, f"3C 03 00 {name} {value}") == "00 3C 03"
    assert ask(slave, 0x1F, "3C 03 00 06 01 03 00") == "00 3C 03"  # S-0-0262
    assert ask(slave, 0x10, "3C 03 00 64 00", 200) == "00 3C 03 2C 01"  # 0.300
    assert ask(slave, 0x10, "3C 03 00 2C 00", 200) == "00 3C 03 02 00"


# -- List segments and sequential telegrams -------------------------------------------------------------------------


def test_list_segments_count_bytes_and_those_of_ecodrive_words() -> None:
    slave = drive()
    # P-0-4006 is 0, 90, 180, 270 degrees: 900000 is 0x000DBBA0, 1800000 is 0x001B7740
    assert ask(slave, 0x11, "3C 03 00 A6 8F 04 00 04 00") == "00 3C 03 A0 BB 0D 00"
    assert ask(slave, 0x81, "3C 03 00 A6 8F 04 00 02 00") == "00 3C 03 40 77 1B 00"
    assert ask(slave, 0x1E, "3C 03 00 A6 8F 08 00 04 00 01 02 03 04") == "00 3C 03"
    assert ask(slave, 0x8E, "3C 03 00 A6 8F 06 00 02 00 05 06 07 08") == "00 3C 03"
    assert ask(slave, 0x11, "3C 03 00 A6 8F 08 00 FF FF") == "00 3C 03 01 02 03 04 05 06 07 08"
    assert ask(slave, 0x10, "3C 03 00 A6 8F") == (
        "00 3C 03 10 00 10 00 00 00 00 00 A0 BB 0D 00 01 02 03 04 05 06 07 08"
    )


@pytest.mark.parametrize(
    ("service", "body", "code"),
    [
        (0x11, "3C 03 00 A6 8F 10 00 04 00", "0F 70"),  # behind the last element
        (0x11, "3C 03 00 A6 8F 02 00 04 00", "0F 70"),  # inside one
        (0x11, "3C 03 00 24 00 00 00 04 00", "0F 70"),  # no list
        (0x81, "3C 03 00 A6 8F 01 00 02 00", "0F 70"),
        (0x1E, "3C 03 00 A6 8F 02 00 04 00 00 00 00 00", "0F 70"),
        (0x1E, "3C 03 00 A6 8F 0C 00 08 00" + " 00" * 8, "03 70"),
        (0x1E, "3C 03 00 A6 8F 00 00 03 00 00 00 00", "02 70"),
        (0x1E, "3C 03 00 BB 00 00 00 02 00 28 00", "04 70"),  # S-0-0187
        (0x11, "14 03 00 A6 8F 00 00 04 00", "09 20"),
    ],
)
def test_wrong_list_segments(service: int, body: str, code: str) -> None:
    assert ask(drive(), service, body) == f"01 {body[:5]} {code}"


CAM = bytes(range(256)) * 2  # 128 elements of four bytes
CAM_LIST = octets("00 02 00 10") + CAM  # with its lengths, 0x200 and 0x1000 bytes
READ_CAM, PIECE = "3C 03 00 48 80", "{} 03 00 48 80 {}"


def with_cam(**table: Any) -> Station:
    slave = drive(phase=2, **table)
    for place in range(0, len(CAM_LIST), 200):
        last = place + 200 >= len(CAM_LIST)
        piece = PIECE.format("3C" if last else "38", CAM_LIST[place : place + 200].hex(" "))
        assert ask(slave, 0x1F, piece) == ("00 3C 03" if last else "00 38 03")
    return slave


def test_long_data_go_in_pieces_both_ways() -> None:
    slave = with_cam()
    pieces = [ask(slave, 0x10, READ_CAM) for _ in range(3)]
    assert [piece[:8] for piece in pieces] == ["00 38 03", "00 38 03", "00 3C 03"]
    assert [len(octets(piece)) - 3 for piece in pieces] == [236, 236, 516 - 472]
    assert b"".join(octets(piece)[3:] for piece in pieces) == CAM_LIST
    assert ask(slave, 0x10, READ_CAM) == pieces[0]  # and again from the beginning


def test_an_indradrive_sends_more_at_once() -> None:
    assert len(octets(ask(with_cam(edition="IndraDrive"), 0x10, READ_CAM))) - 3 == 245


def test_what_does_not_continue_a_transfer() -> None:
    slave = with_cam()
    first = ask(slave, 0x10, READ_CAM)
    assert ask(slave, 0x10, "3C 03 00 24 00") == "F8 3C 03"  # another parameter
    assert ask(slave, 0x10, "14 03 00 48 80") == "F8 14 03"  # another element
    assert ask(slave, 0x10, READ_CAM, sender=17) == "F8 3C 03"
    assert ask(slave, 0x80, READ_CAM) == "F8 3C 03"
    # two are other: something else that has to wait, by fig. 2-19, or for this parameter by IndraDrive
    assert ask(slave, 0x1F, VELOCITY.replace("3C 00", "3C 03")) == "02 3C 03 0C 80"
    assert ask(slave, 0x1F, f"{READ_CAM} 00", sender=17) == "01 3C 03 0C 80"
    assert ask(slave, 0x12) == "00 02"  # the phase is nobody's business here
    rest = [ask(slave, 0x10, READ_CAM) for _ in range(2)]
    assert b"".join(octets(piece)[3:] for piece in (first, *rest)) == CAM_LIST


@pytest.mark.parametrize(
    ("body", "answer", "ends"),
    [
        ("", "00", True),
        ("03", "00 03", True),
        ("03 10", "00 03", True),
        ("03 1F", "00 03", False),
        ("07", "FC 07", False),
    ],
)
def test_a_transfer_is_cancelled(body: str, answer: str, ends: bool) -> None:
    slave = with_cam()
    first = ask(slave, 0x10, READ_CAM)
    assert ask(slave, 0x01, body) == answer
    assert (ask(slave, 0x10, READ_CAM) == first) is ends


def test_a_cancelled_writing_leaves_everything_as_it_was() -> None:
    slave = drive(phase=2)
    assert ask(slave, 0x1F, PIECE.format("38", "04 00 00 10")) == "00 38 03"
    assert ask(slave, 0x01) == "00"
    assert ask(slave, 0x10, READ_CAM) == "00 3C 03 00 00 00 10"


def test_a_phase_switch_breaks_a_transfer_and_its_master_is_told_once() -> None:
    slave = with_cam()
    ask(slave, 0x10, READ_CAM)
    assert ask(slave, 0x1D, "04") == "00"
    assert ask(slave, 0x10, READ_CAM, 1000) == "02 3C 03 0B 80"
    assert ask(slave, 0x10, READ_CAM, 1000).startswith("00 38 03 00 02 00 10")


def test_a_transfer_that_nobody_goes_on_with_ends() -> None:
    slave = with_cam()
    ask(slave, 0x10, READ_CAM)
    assert ask(slave, 0x10, "3C 03 00 24 00", 9_999) == "F8 3C 03"
    assert ask(slave, 0x10, "3C 03 00 24 00", 10_001) == "00 3C 03 00 00 00 00"


# -- Phases ---------------------------------------------------------------------------------------------------------


def test_switching_takes_time_and_is_asked_for() -> None:
    slave = drive()
    assert ask(slave, 0x12) == "00 04"
    assert ask(slave, 0x1D, "02", 100) == "00"  # fig. 8-26: acknowledged
    assert ask(slave, 0x12, "", 101) == "00 04"
    assert ask(slave, 0x10, "3C 03 00 24 00", 101) == "01 3C 03 01 80"  # the service channel is busy
    assert ask(slave, 0x1D, "04", 200) == "02 04 05 D0"  # fig. 8-49: still active
    assert ask(slave, 0x01, "", 200) == "00"  # this cannot be cancelled
    assert ask(slave, 0x12, "", 1000) == "00 02"
    assert ask(slave, 0x1F, "3C 03 00 2C 00 02 00", 1000) == "00 3C 03"  # S-0-0044, in phase 2
    assert ask(slave, 0x1D, "04", 2000) == "00"
    phases = [ask(slave, 0x12, "", 2000 + ms) for ms in range(0, 1000, 10)]
    assert list(dict.fromkeys(phases)) == ["00 02", "00 03", "00 04"]


@pytest.mark.parametrize("phase", ["05", "FF", "00", "01", "03"])
def test_a_wrong_phase(phase: str) -> None:
    assert ask(drive(), 0x1D, phase) == "02 04 04 80"  # fig. 8-27
    assert ask(drive(), 0x1D) == "FA"


def test_what_drives_have_against_a_phase_is_told_when_asked_for() -> None:
    enabled = drive()
    assert ask(enabled, 0x1F, "3C 03 00 86 00 00 E0") == "00 3C 03"  # S-0-0134
    assert ask(enabled, 0x1D, "02") == "00"
    assert ask(enabled, 0x12, "", 1000) == "02 04 06 D0"
    assert ask(enabled, 0x12, "", 1000) == "02 04 06 D0"
    assert ask(enabled, 0x1F, "3C 03 00 86 00 00 00", 1000) == "00 3C 03"
    assert ask(enabled, 0x1D, "02", 1000) == "00"
    assert ask(enabled, 0x12, "", 2000) == "00 02"

    invalid = drive(phase=2, parameters={"S-0-0100": {"valid": False}})
    assert ask(invalid, 0x1D, "04") == "00"
    assert ask(invalid, 0x12, "", 1000) == "02 02 04 80"

    turning = station(kind="synax", turning=True)
    assert ask(turning, 0x9D, "02") == "00"
    assert ask(turning, 0x92, "", 1000) == "02 04 07 D0"  # fig. 8-22


def test_tmas_stops_a_drive_and_the_error_memory_has_it() -> None:
    slave = drive()
    for body in ("03 03 64 00", "03 FF"):  # 100 ms
        assert ask(slave, 0x03, body).startswith("00")
    word, read = "3C 03 00 86 00 00 E0", "3C 03 00 86 00"
    for now_ms in (0, 90, 180):
        assert ask(slave, 0x1F, word, now_ms) == "00 3C 03"
    assert ask(slave, 0x10, read, 280) == "00 3C 03 00 E0"
    assert ask(slave, 0x10, read, 281) == "00 3C 03 00 00"
    assert ask(slave, 0x10, "3C 03 00 0B 00", 281) != "00 3C 03 00 00"  # class 1 diagnostics
    memory = ask(slave, 0x10, "3C 03 00 C0 80", 281)
    assert memory == "00 3C 03 20 00 20 00 01 F4 00 00" + " 00" * 28
    reaction = slave.react(build(0x12, 16, 3), 300 * MS)
    assert reaction is not None and reaction[4] == 0x90
    assert ask(slave, 0x1F, "3C 03 00 63 00 03 00", 300) == "00 3C 03"  # reset
    assert ask(slave, 0x10, "3C 03 00 0B 00", 300) == "00 3C 03 00 00"


# -- Controls -------------------------------------------------------------------------------------------------------


def control(kind: str = "synax", **table: Any) -> Station:
    return station(kind=kind, devices=[{"address": 1}, {"address": 7, "off": True}], **table)


def test_a_control_has_its_own_parameters_and_the_way_to_its_drives() -> None:
    ppc = control()
    assert ask(ppc, 0x90, "3C 00 02 01 00") == "00 3C 00 A0 0F"  # C-0-0001: 4000 ms
    # fig. 8-45 and 8-46: C-0-0066 cannot be changed
    assert ask(ppc, 0x9F, "3C 00 02 42 00 00 00 00 00") == "01 3C 00 04 70"
    assert ask(ppc, 0x10, "3C 01 00 24 00") == "00 3C 01 00 00 00 00"  # S-0-0036 of drive 1
    assert ask(ppc, 0x90, "3C 01 01 0B 00") == "00 3C 01 01 00"  # A-0-0011
    assert ask(ppc, 0x9F, "3C 01 01 0B 00 E9 03") == "01 3C 01 07 70"  # 1001 is too much
    assert ask(ppc, 0x90, "3C 00 00 24 00") == "01 3C 00 01 10"  # the control is no drive
    assert ask(ppc, 0x90, "3C 02 00 24 00") == "FC 3C 02"
    assert ask(ppc, 0x90, "3C 07 00 24 00") == "02 3C 07 02 80"  # switched off: fault in the channel
    assert ask(ppc, 0x90, "3C 07 01 0B 00") == "00 3C 07 01 00"  # the control has that itself
    assert ask(ppc, 0x9F, "14 00 02 01 00 58") == "01 14 00 B0 00"  # SYNAX: element not allowed
    assert ask(control("clc"), 0x1F, "14 00 02 01 00 58") == "01 14 00 04 20"
    assert ask(control("clc"), 0x90, "3C 00 02 01 00") == "F0"


def test_the_way_to_a_drive_is_busy_while_phases_are_switched_and_before_phase_2_there_is_none() -> None:
    ppc = control()
    assert ask(ppc, 0x9D, "02") == "00"
    assert ask(ppc, 0x90, "3C 01 00 24 00", 1) == "02 3C 01 01 80"
    assert ask(ppc, 0x90, "3C 00 02 01 00", 1) == "00 3C 00 A0 0F"
    assert ask(ppc, 0x92, "", 1000) == "00 02"
    assert ask(control("clc", phase=0), 0x10, "3C 01 00 24 00") == "01 3C 01 01 00"
    assert ask(control("synax", phase=0), 0x90, "3C 01 00 24 00") == "01 3C 01 A0 00"


def test_each_drive_has_a_channel_of_its_own() -> None:
    ppc = station(kind="clc", devices=[{"address": 1}, {"address": 2}])
    assert ask(ppc, 0x10, "3C 01 00 11 00").startswith("00 3C 01")
    long = {"P-0-0072": {"value": list(range(200))}}
    ppc = station(kind="clc", devices=[{"address": 1, "parameters": long}, {"address": 2, "parameters": long}])
    first = ask(ppc, 0x10, "3C 01 00 48 80")
    assert first.startswith("00 38 01 20 03 00 10 00 00 00 00 01 00 00 00")
    assert ask(ppc, 0x10, "3C 02 00 48 80").startswith("00 38 02 20 03 00 10 00 00 00 00 01 00 00 00")
    assert ask(ppc, 0x10, "3C 01 00 48 80")[9:20] != first[9:20]
    assert ask(ppc, 0x01, "01") == "00 01"
    assert ask(ppc, 0x10, "3C 01 00 48 80") == first


# -- Routing (chapter 2.2) ------------------------------------------------------------------------------------------


class EndStation(Station):
    """Station 8 of fig. 2-12 and 2-13, whose bodies are dummies."""

    def __init__(self) -> None:
        self.heard: list[bytes] = []

    def react(self, command: bytes, now_ns: int) -> bytes | None:
        self.heard.append(command)
        return octets("02 E9 03 03 10 03 02 08 00 01 F1")


class Passing(Station):
    """Notes what passes a station."""

    def __init__(self, station: Station) -> None:
        self.heard: list[bytes] = []
        self.said: list[bytes | None] = []
        self._station = station

    def react(self, command: bytes, now_ns: int) -> bytes | None:
        self.heard.append(command)
        self.said.append(self._station.react(command, now_ns))
        return self.said[-1]


def router(address: int, behind: Station) -> Station:
    router = drive(address)
    router._behind = [behind]
    return router


def test_routing_as_in_fig_2_10_to_2_15() -> None:
    end = EndStation()
    middle = Passing(router(2, end))
    answer = router(3, middle).react(octets("02 E1 05 05 02 03 10 03 02 08 F0 01 00"), 0)
    assert middle.heard == [octets("02 F4 04 04 01 03 03 02 08 F0 01 00")]
    assert end.heard == [octets("02 FA 03 03 00 03 02 08 F0 01 00")]
    assert middle.said == [octets("02 E3 04 04 11 03 03 02 08 00 01 F1")]
    assert answer == octets("02 D0 05 05 12 03 10 03 02 08 00 01 F1")


def test_nobody_below_answers() -> None:
    router = station(behind=[{"address": 2}])
    assert ask(router, 0x12, subaddresses=b"\x05") == "none"
    assert ask(router, 0x12) == "00 04"  # but itself it does


def test_a_point_to_point_connection_to_a_router() -> None:
    router = station(behind=[{"address": 2, "phase": 2}])
    reaction = router.react(build(0x12, 16, 128, subaddresses=b"\x02"), 0)
    assert reaction == build(0x12, 16, 128, b"\x00\x02", reaction=True, subaddresses=b"\x02")


def test_broadcasts_reach_a_level_or_all_of_them() -> None:
    def velocities(receiver: int, subaddresses: bytes) -> list[bool]:
        router = station(behind=[{"address": 2, "behind": [{"address": 8}]}, {"address": 5}])
        assert ask(router, 0x1F, VELOCITY, receiver=receiver, subaddresses=subaddresses) == "none"
        routes = [b"", b"\x02", b"\x05", b"\x02\x08"]
        return [ask(router, 0x10, READ_VELOCITY, subaddresses=route).endswith("E8 03 00 00") for route in routes]

    assert velocities(255, b"") == [True, True, True, True]
    assert velocities(254, b"") == [True, False, False, False]
    assert velocities(3, b"\xfe") == [False, True, True, False]
    assert velocities(3, b"\x02\xfe") == [False, False, False, True]


# -- Whatever comes --------------------------------------------------------------------------------------------------

ALL_KINDS = [
    drive(),
    station(kind="indradrive", phase=2, worn=True),
    drive(edition="ECODRIVE03"),
    control(behind=[{"address": 2}]),
]


@given(
    st.sampled_from(ALL_KINDS),
    st.one_of(st.integers(0, 255), st.sampled_from([0x01, 0x02, 0x03, 0x04, 0x10, 0x11, 0x1E, 0x1F, 0x81, 0x8E])),
    st.sampled_from([3, 128, 255]),
    st.one_of(
        st.binary(max_size=240), st.builds(bytes.__add__, st.just(octets("3C 03 00 48 80")), st.binary(max_size=20))
    ),
)
def test_whatever_is_asked_the_answer_is_a_whole_telegram(
    asked: Station, service: int, receiver: int, body: bytes
) -> None:
    reaction = asked.react(build(service, 16, receiver, body), 0)
    if reaction is not None:
        assert sum(reaction) % 256 == 0
        assert reaction[2] == reaction[3] == len(reaction) - 8
        assert reaction[5:8] == bytes([service, 16, receiver])


@given(st.sampled_from(ALL_KINDS), st.binary(max_size=40))
def test_noise_raises_nothing(asked: Station, noise: bytes) -> None:
    asked.react(noise, 0)
    asked.react(noise[:7] + b"\x80" + noise[7:], 0)


# -- Tables ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({}, "station 1: address is missing"),
        ({"address": 127}, "station 1: address = 127: use a whole number from 0 to 126"),
        ({"address": 3, "kind": "pump"}, 'station 1: kind = "pump": use one of drive, indradrive, clc, synax'),
        ({"address": 3, "kinds": 1}, "station 1: unknown key kinds; the keys are address, kind, "),
        ({"address": 3, "rates": [4800]}, "use one of 9600, 19200, 38400, 57600, 115200"),
        ({"address": 3, "type_key": "x" * 41}, "use a text of up to 40 ASCII characters"),
        ({"address": 3, "refuse": {"0x100": 1}}, "use a table of services and status bytes"),
        ({"address": 3, "refuse": {"0x10": 0}}, "use a table of services and status bytes"),
        ({"address": 3, "groups": [4]}, "use a whole number from 200 to 253"),
        ({"address": 3, "devices": []}, "unknown key devices"),  # a drive has none
        ({"address": 3, "kind": "clc", "devices": [{"address": 0}]}, "station 1, device 1: address = 0: use a whole"),
        (
            {"address": 3, "kind": "clc", "devices": [{"address": 1}, {"address": 1}]},
            "station 1, device 2: address = 1 is taken: use another",
        ),
        ({"address": 3, "behind": [{"address": "x"}]}, 'station 1, behind 1: address = "x": use a whole number'),
        ({"address": 3, "parameters": {"S-0-36": {}}}, "station 1: 'S-0-36' is not a parameter such as S-0-0044"),
        ({"address": 3, "parameters": {"S-0-0999": {}}}, "station 1: S-0-0999: type is missing"),
        ({"address": 3, "parameters": {"S-0-0036": {"value": "x"}}}, 'S-0-0036: value = "x": use a number'),
        ({"address": 3, "parameters": {"S-0-0036": {"value": 1e9}}}, "a number that fits into 4 bytes"),
        ({"address": 3, "parameters": {"S-0-0036": {"takes": 5}}}, "S-0-0036: unknown key takes"),
        ({"address": 3, "parameters": 5}, "station 1: parameters = 5: use a table of tables"),
    ],
)
def test_what_is_wrong_with_a_table_is_said_with_the_cure(table: Mapping[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match="^station 1") as wrong:
        make([table], 1)
    assert message in str(wrong.value)
    assert "\n" not in str(wrong.value)


def test_the_example_of_the_readme() -> None:
    page = resources.files("sisbus.devices").joinpath("sets/README.md").read_text("utf-8")
    example = page.split("```toml\n")[1].split("```")[0]
    first, ppc, third = make(tomllib.loads(example)["station"], 1)
    assert ask(first, 0x12) == "00 02"
    assert ask(first, 0x12, subaddresses=b"\x02\x08") == "00 04"
    assert ask(first, 0x10, "3C 03 00 F4 81") == "00 3C 03 D4 30 00 00"  # 12.500
    assert ask(ppc, 0x90, "3C 02 00 24 00") == "02 3C 02 02 80"
    assert ask(third, 0x80, "3C 06 00 24 00") == "F0 3C 06"


@pytest.mark.parametrize("name", ["drive", "indradrive", "control", "axis"])
def test_the_keys_of_the_sets_are_in_the_readme(name: str) -> None:
    page = resources.files("sisbus.devices").joinpath("sets/README.md").read_text("utf-8")
    known = set(re.findall(r"`(\w[\w ]*)`", page))
    for row in built_in(name).values():
        assert set(row) <= known
        assert row["type"] in known


def test_two_stations_with_one_address() -> None:
    with pytest.raises(ValueError, match="station 2: address = 3 is taken"):
        make([{"address": 3}, {"address": 3}], 1)


def test_a_scenario_changes_and_adds_parameters() -> None:
    slave = drive(parameters={"S-0-0036": {"unit": "1/min"}, "P-0-0500": {"type": "float", "value": 1.5}})
    assert ask(slave, 0x10, "24 03 00 24 00") == "00 24 03 05 00 05 00 31 2F 6D 69 6E"
    assert ask(slave, 0x10, "2C 03 00 24 00") == "00 2C 03 80 3C 36 FE"  # what is not changed stays
    assert ask(slave, 0x10, "3C 03 00 F4 81") == "00 3C 03 00 00 C0 3F"  # IEEE 754
    assert ask(drive(), 0x10, "24 03 00 24 00") == "00 24 03 03 00 03 00 72 70 6D"
