# SPDX-License-Identifier: GPL-2.0-or-later
"""An IndraDrive of the virtual bus: what a known client asks, its lists, 0x81 in pieces, its statuses and codes.

The bytes are worked out by hand from the facts that the manuals print; see the chapters in the stations' code.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import pytest
from test_stations import ask, octets, station

from sisbus.stations.station import Station


def indradrive(**table: Any) -> Station:
    return station(kind="indradrive", **table)


# -- What a client asks at its start --------------------------------------------------------------------------------


class Asked(NamedTuple):
    """A parameter as the client must find it."""

    ident: str
    name: str
    attribute: str
    minimum: str
    maximum: str
    data: str


# Attribute: factor 1, 00 01; length in bits 16 to 18 (1 two bytes, 2 four), command in bit 19, format in bits 20 to 22
# (1 unsigned, 2 signed), write protection in bits 28 to 30.
COMMAND, STATUS, WORD, UNSIGNED, REGISTER = "01 00 09 00", "01 00 01 70", "01 00 01 00", "01 00 11 00", "01 00 22 00"
ASKED = [
    Asked("00 A4 01", "C0400 Activate parameterization level 1", COMMAND, "00 00", "03 00", "00 00"),  # S-0-0420
    Asked("00 A6 01", "C0200 Exit parameterization level 1", COMMAND, "00 00", "03 00", "00 00"),  # S-0-0422
    Asked("00 73 80", "Device control: Status word", STATUS, "00 00", "FF FF", "00 80"),  # P-0-0115
    Asked("00 B0 84", "Control word of velocity control", WORD, "00 00", "FF FF", "00 00"),  # P-0-1200
    Asked("00 5A 85", "PLC global register G0", REGISTER, "00 00 00 80", "FF FF FF 7F", "00 00 00 00"),  # P-0-1370
    Asked("00 82 85", "PLC status", STATUS, "00 00", "FF FF", "20 00"),  # P-0-1410
    Asked("00 94 00", "C0600 Drive-controlled homing procedure command", COMMAND, "00 00", "03 00", "00 00"),
    Asked("00 09 01", "Language selection", UNSIGNED, "00 00", "04 00", "01 00"),  # S-0-0265: English
]


@pytest.mark.parametrize("service", [0x10, 0x80])
@pytest.mark.parametrize("asked", ASKED, ids=lambda asked: asked.name)
def test_what_a_client_asks_at_its_start_is_all_there(asked: Asked, service: int) -> None:
    slave = indradrive()

    def element(control: str) -> str:
        answer = ask(slave, service, f"{control} 03 {asked.ident}")
        assert answer.startswith(f"00 {control} 03 ")
        return answer[9:]

    length = f"{len(asked.name):02X} 00"
    assert element("14") == f"{length} {length} " + asked.name.encode().hex(" ").upper()
    assert element("1C") == asked.attribute
    assert element("24") == "02 00 02 00 2D 2D"  # --
    assert element("2C") == asked.minimum
    assert element("34") == asked.maximum
    assert element("3C") == asked.data


@pytest.mark.parametrize("service", [0x1F, 0x8F])
def test_what_a_client_writes(service: int) -> None:
    slave = indradrive()
    for ident, data in (("00 09 01", "02 00"), ("00 B0 84", "00 04"), ("00 5A 85", "02 00 00 00")):
        assert ask(slave, service, f"3C 03 {ident} {data}") == "00 3C 03"
        assert ask(slave, 0x10, f"3C 03 {ident}") == f"00 3C 03 {data}"
    assert ask(slave, service, "3C 03 00 09 01 05 00") == "01 3C 03 07 70"  # a language that it does not have
    assert ask(slave, service, "3C 03 00 73 80 00 00") == "01 3C 03 04 70"  # its status word


def status(slave: Station, ident: str, now_ms: float) -> str:
    """Ask for the data status as the client does: the ident number is written, without data."""
    answer = ask(slave, 0x1F, f"0C 03 {ident}", now_ms)
    assert answer.startswith("00 0C 03 ")
    return answer[9:]


def test_parameter_mode_and_back_by_commands() -> None:
    slave = indradrive()
    activate, leave, operation_mode = "00 A4 01", "00 A6 01", "3C 03 00 20 00 3B 00"  # S-0-0032
    assert ask(slave, 0x1F, operation_mode) == "01 3C 03 05 70"
    assert ask(slave, 0x1F, f"3C 03 {activate} 03 00") == "00 3C 03"
    assert status(slave, activate, 399) == "07 00"  # in process, and the way to ask is free
    assert status(slave, activate, 400) == "03 00"
    assert ask(slave, 0x1F, f"3C 03 {activate} 00 00", 410) == "00 3C 03"
    assert status(slave, activate, 420) == "00 00"
    assert ask(slave, 0x12, "", 420) == "00 02"
    assert ask(slave, 0x10, "3C 03 00 73 80", 420) == "00 3C 03 00 00"  # not ready for operation
    assert ask(slave, 0x1F, operation_mode, 420) == "00 3C 03"
    assert ask(slave, 0x1F, f"3C 03 {leave} 03 00", 500) == "00 3C 03"
    assert status(slave, leave, 900) == "03 00"
    assert ask(slave, 0x12, "", 900) == "00 04"
    assert ask(slave, 0x10, "3C 03 00 73 80", 900) == "00 3C 03 00 80"


def test_a_level_that_something_stands_against_is_not_possible() -> None:
    slave = indradrive()
    enable = "3C 03 00 86 00 {}"
    assert ask(slave, 0x1F, enable.format("00 E0")) == "00 3C 03"
    assert ask(slave, 0x1F, "3C 03 00 A4 01 03 00") == "00 3C 03"
    assert status(slave, "00 A4 01", 400) == "0F 00"
    assert ask(slave, 0x12, "", 400) == "00 04"
    for data in ("00 00", "03 00"):  # cleared, the drive is disabled, and again
        assert ask(slave, 0x1F, enable.format("00 00"), 500) == "00 3C 03"
        assert ask(slave, 0x1F, f"3C 03 00 A4 01 {data}", 500) == "00 3C 03"
    assert status(slave, "00 A4 01", 900) == "03 00"
    assert ask(slave, 0x12, "", 900) == "00 02"


def test_the_status_word_tells_torque_halt_and_error() -> None:
    slave = indradrive()
    for body in ("03 03 64 00", "03 FF"):  # Tmas 100 ms
        assert ask(slave, 0x03, body).startswith("00")
    for now_ms, control, expected in ((0, "00 C0", "10 C0"), (10, "00 E0", "00 C0")):  # with halt, and without it
        assert ask(slave, 0x1F, f"3C 03 00 86 00 {control}", now_ms) == "00 3C 03"
        assert ask(slave, 0x10, "3C 03 00 73 80", now_ms) == f"00 3C 03 {expected}"
    assert ask(slave, 0x10, "3C 03 00 73 80", 111) == "00 3C 03 00 20"  # the control word is late


# -- Lists ----------------------------------------------------------------------------------------------------------

LIST = "3C 03 00 A7 8F"  # P-0-4007: empty, with room for 64 elements, 256 bytes


def test_lists_count_from_their_two_lengths() -> None:
    slave = indradrive()
    assert ask(slave, 0x11, f"{LIST} 00 00 04 00") == "00 3C 03 00 00 00 01"
    # As the client fills a list: it makes room for an element, then writes that, and begins anew.
    for place, value in enumerate(("40 42 0F 00", "80 84 1E 00"), start=1):
        offset = f"{4 * place:02X} 00"
        assert ask(slave, 0x1E, f"{LIST} 00 00 04 00 {offset} 00 01") == "00 3C 03"
        assert ask(slave, 0x1E, f"{LIST} {offset} 04 00 {value}") == "00 3C 03"
    assert ask(slave, 0x10, LIST) == "00 3C 03 08 00 00 01 40 42 0F 00 80 84 1E 00"
    assert ask(slave, 0x11, f"{LIST} 00 00 FF 00") == "00 3C 03 08 00 00 01 40 42 0F 00 80 84 1E 00"
    assert ask(slave, 0x11, f"{LIST} 08 00 04 00") == "00 3C 03 80 84 1E 00"
    assert ask(slave, 0x1E, f"{LIST} 00 00 04 00 04 00 00 01") == "00 3C 03"
    assert ask(slave, 0x10, LIST) == "00 3C 03 04 00 00 01 40 42 0F 00"  # what is behind its length is dropped


def test_the_services_of_drives_count_from_the_first_element() -> None:
    slave = indradrive()
    blocks = "3C 03 00 A6 8F"  # P-0-4006: 0, 90, 180 and 270 degrees; 90.0000 is 000DBBA0
    assert ask(slave, 0x11, f"{blocks} 08 00 04 00") == "00 3C 03 A0 BB 0D 00"
    assert ask(slave, 0x81, f"{blocks} 02 00 02 00") == "00 3C 03 A0 BB 0D 00"
    assert ask(slave, 0x8E, f"{blocks} 02 00 02 00 01 02 03 04") == "00 3C 03"
    assert ask(slave, 0x11, f"{blocks} 08 00 04 00") == "00 3C 03 01 02 03 04"


@pytest.mark.parametrize(
    ("service", "body", "code"),
    [
        (0x11, f"{LIST} 02 00 02 00", "0F 70"),  # inside the lengths
        (0x11, "3C 03 00 BB 00 02 00 02 00", "0F 70"),  # inside those of S-0-0187, whose elements have two bytes
        (0x11, f"{LIST} 04 00 04 00", "0F 70"),  # it has no element
        (0x11, "3C 03 00 24 00 00 00 04 00", "0F 70"),  # no list
        (0x1E, f"{LIST} 00 00 02 00 04 00", "02 70"),
        (0x1E, f"{LIST} 00 00 08 00 04 00 00 01 01 00 00 00", "03 70"),
        (0x1E, f"{LIST} 00 00 04 00 04 01 00 01", "03 70"),  # 65 elements
        (0x1E, f"{LIST} 00 00 04 00 06 00 00 01", "08 70"),  # one and a half
        (0x1E, "3C 03 00 BB 00 00 00 04 00 06 00 06 00", "04 70"),  # S-0-0187
    ],
)
def test_wrong_segments(service: int, body: str, code: str) -> None:
    assert ask(indradrive(), service, body) == f"01 3C 03 {code}"


def test_a_list_of_fixed_length_stays_so_long() -> None:
    fixed = {"P-0-4006": {"fixed": True}}
    lengths = "3C 03 00 A6 8F 00 00 04 00 {} 00 00 01"
    assert ask(indradrive(parameters=fixed), 0x1E, lengths.format("0C")) == "01 3C 03 0E 70"
    assert ask(indradrive(parameters=fixed), 0x1E, lengths.format("10")) == "00 3C 03"


# -- 0x81 in sequential telegrams -----------------------------------------------------------------------------------

ELEMENTS = b"".join(number.to_bytes(4, "little") for number in range(1000, 1100))
CAM = {"P-0-0072": {"value": list(range(1000, 1100))}}
READ_CAM = "3C 03 00 48 80 00 00 C8 00"  # 200 words from the first element on


def test_0x81_goes_on_with_the_unchanged_command() -> None:
    for slave in (indradrive(parameters=CAM), station(parameters=CAM)):
        pieces = [octets(ask(slave, 0x81, READ_CAM)) for _ in range(2)]
        assert [piece[:3].hex(" ") for piece in pieces] == ["00 38 03", "00 3c 03"]
        assert b"".join(piece[3:] for piece in pieces) == ELEMENTS
        assert octets(ask(slave, 0x81, READ_CAM)) == pieces[0]  # and again from the beginning


def test_pieces_of_an_indradrive_end_inside_elements() -> None:
    slave = indradrive(parameters=CAM)
    lengths = [len(octets(ask(slave, 0x81, READ_CAM))) - 3 for _ in range(2)]
    assert lengths == [245, 155]
    # 122 words are 244 bytes, and 123 are 246: one byte too many
    assert ask(slave, 0x81, "3C 03 00 48 80 00 00 7A 00").startswith("00 3C 03")
    assert ask(slave, 0x81, "3C 03 00 48 80 00 00 7B 00").startswith("00 38 03")
    assert ask(slave, 0x81, "3C 03 00 48 80 00 00 7B 00") == "00 3C 03 04"  # the second byte of 1061, 0425


def test_another_segment_does_not_continue_it() -> None:
    slave = indradrive(parameters=CAM)
    first = ask(slave, 0x81, READ_CAM)
    assert ask(slave, 0x81, "3C 03 00 48 80 02 00 C8 00") == "F8 3C 03"
    second = ask(slave, 0x81, READ_CAM)
    assert octets(first)[3:] + octets(second)[3:] == ELEMENTS


def test_0x11_and_0x8e_are_one_telegram() -> None:
    slave = indradrive(parameters=CAM)
    for _ in range(2):
        answer = octets(ask(slave, 0x11, "3C 03 00 48 80 04 00 90 01"))
        assert answer == b"\x00\x3c\x03" + ELEMENTS[:245]
    for value in ("01", "02"):
        assert ask(slave, 0x8E, f"3C 03 00 48 80 00 00 02 00 {value} 00 00 00") == "00 3C 03"
        assert ask(slave, 0x81, "3C 03 00 48 80 00 00 02 00") == f"00 3C 03 {value} 00 00 00"


# -- Statuses and codes ---------------------------------------------------------------------------------------------


def test_the_codes_of_the_channel_come_after_status_1() -> None:
    slave = indradrive(parameters=CAM)
    first = ask(slave, 0x81, READ_CAM)
    assert ask(slave, 0x1F, "3C 03 00 5A 85 01 00 00 00") == "01 3C 03 0C 80"  # another parameter has to wait
    assert ask(slave, 0x10, "3C 03 00 48 80", sender=17) == "01 3C 03 0C 80"  # and another master
    assert octets(first)[3:] + octets(ask(slave, 0x81, READ_CAM))[3:] == ELEMENTS  # the transfer goes on
    ask(slave, 0x81, READ_CAM)
    assert ask(slave, 0x1D, "02") == "00"
    assert ask(slave, 0x81, READ_CAM, 1000) == "01 3C 03 0B 80"  # the phase switch had priority
    assert ask(slave, 0x81, READ_CAM, 1000) == first


def test_a_checksum_is_the_crc32_of_the_block() -> None:
    slave = indradrive(phase=2)
    digits = b"123456789"  # whose CRC32 every description gives: CBF43926
    assert ask(slave, 0x02, f"03 96 00 00 80 00 02 {digits.hex()}") == "00 03 96"
    assert ask(slave, 0x02, "03 97 00 00 80 00 09 00 00 00") == "00 03 97 26 39 F4 CB"
    assert ask(slave, 0x02, "03 97 00 00 70 00 09 00 00 00") == "FC 03 97"  # no memory there
    assert ask(slave, 0x02, "03 97 00 00 80 00") == "FA 03 97"


@pytest.mark.parametrize(
    ("service", "body", "answer"),
    [
        (0x10, "3C 03", "FA 3C 03"),
        (0x81, "3C 03 00 48 80 00 00", "FA 3C 03"),
        (0x8F, "3C", "FA 3C"),
        (0x00, "03", "FA 03"),
        (0x00, "03 09", "FB 03 09"),
        (0x02, "03 98", "FB 03 98"),
        (0x80, "3C 09 00 24 00", "FC 3C 09"),
        (0x90, "3C 03 00 24 00", "F0"),
    ],
)
def test_telegram_errors(service: int, body: str, answer: str) -> None:
    assert ask(indradrive(), service, body) == answer


def test_it_says_that_it_is_an_indradrive_unless_told_otherwise() -> None:
    assert ask(indradrive(), 0x00, "03 02") == "00 03 02 " + b"FWA-INDRV*-MPH-02VRS-D5".hex(" ").upper()
    assert ask(indradrive(), 0x02, "03 90 01 00 00 00 00") == "01 03 90 10"  # its code, in phase 4
    assert ask(indradrive(edition="IF02"), 0x02, "03 90 01 00 00 00 00") == "01 03 90 04"
