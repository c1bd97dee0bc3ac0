# SPDX-License-Identifier: GPL-2.0-or-later
"""Every error code of codes.toml: provoked at a station of the virtual bus, and shown by tshark with its text.

A new code without a way to provoke it here fails.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import pytest

from sisbus.stations.making import make
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from sistap.tap.sis.telegram import build, parse
from test_codes import DESCRIBED, PHASE_SERVICES, described

MS = 1_000_000
SEND_NS = 50 * MS  # from one telegram to the next

Step = tuple[int, str]  # service, body in hex
LATER = (0x00, "03 01")  # any command at a later time: half a second passes before each step


class Way(NamedTuple):
    """How to provoke a code: a station, and what to send to it; the last reaction has the code."""

    table: dict[str, Any]
    steps: tuple[Step, ...]
    receiver: int = 3
    damage: int | None = None  # place in the last telegram where a byte is another


READ_VELOCITY = (0x10, "3C 03 00 24 00")
READ_CAM = (0x10, "3C 03 00 48 80")
CAM = {"parameters": {"P-0-0072": {"value": [1] * 100}}}
SYNAX = {"kind": "synax", "devices": [{"address": 1}, {"address": 2, "off": True}]}
CLC = {"kind": "clc", "devices": [{"address": 1}]}
ENABLED, INVALID = (0x1F, "3C 03 00 86 00 00 E0"), {"S-0-0100": {"valid": False}}
TO_LOADER, ERASE = (0x02, "03 90 01 00 00 00 00"), (0x02, "03 94" + " FF" * 8)
START = "00 10 00 00"  # of the firmware
MODULE = "03 97 00 00 80 00 08 00 00 00"  # eight bytes of RAM


def drive(*steps: Step, **table: Any) -> Way:
    return Way(table, steps)


def write(header: str, data: str) -> Way:
    return drive((0x1F, f"{header} {data}"))


# Nothing on this bus causes it: a scenario requests the code (the key `refuse` of a station or a parameter).
ASKED_STATUS = (0x03, 0xEF, 0xF3, 0xF5, 0xF7, 0xFD, 0xFF)
ASKED_PARAMETER = (
    0x0000,
    *(element << 12 | what for element in (2, 3, 4, 5, 6) for what in (2, 3, 5)),
)
# The codes with "not available" need a parameter that lacks the element: P-0-0004.
LACKING = "{} 03 00 04 80"

WAYS: dict[str, dict[int, Way]] = {
    "status": {
        0x00: drive(READ_VELOCITY),
        0x01: drive((0x10, "3C 03 00 E7 03")),
        0x02: Way(SYNAX, ((0x90, "3C 02 00 24 00"),)),
        0xF0: drive((0x05, "")),
        0xF1: Way({}, ((0x10, "3C 03 00 24 00"),), 128, damage=4),  # a reaction
        0xF2: Way({}, (READ_VELOCITY,), 128, damage=2),
        0xF4: Way({}, (READ_VELOCITY,), 128, damage=1),
        0xF8: drive(READ_CAM, READ_VELOCITY, **CAM),
        0xF9: Way({}, (READ_VELOCITY,)),  # with a subaddress, see telegrams()
        0xFA: drive((0x10, "3C")),
        0xFB: drive((0x00, "03 09")),
        0xFC: drive((0x10, "3C 09 00 24 00")),
        **{status: drive(READ_VELOCITY, refuse={"0x10": status}) for status in ASKED_STATUS},
    },
    "status_phase": {
        0x01: drive((0x12, ""), refuse={"0x12": 0x01}),
        0x02: drive((0x1D, "05")),
    },
    "errors_channel": {
        0x8001: Way(SYNAX, ((0x9D, "02"), (0x90, "3C 01 00 24 00"))),
        0x8002: Way(SYNAX, ((0x90, "3C 02 00 24 00"),)),
        0x800B: drive(READ_CAM, (0x1D, "02"), LATER, READ_CAM, **CAM),
        0x800C: drive(READ_CAM, ENABLED, **CAM),
    },
    "errors_parameter": {
        0x0001: Way({**CLC, "phase": 1}, ((0x10, "3C 01 00 24 00"),)),
        0x0009: drive((0x10, "04 03 00 24 00")),
        0x00A0: Way({**SYNAX, "phase": 1}, ((0x90, "3C 01 00 24 00"),)),
        0x00B0: Way(SYNAX, ((0x9F, "14 00 02 01 00 58"),)),
        0x1001: drive((0x10, "3C 03 00 E7 03")),
        0x1009: write("0C 03 00 24 00", "25 00"),
        0x2001: drive((0x10, LACKING.format("14"))),
        0x4001: drive((0x10, LACKING.format("24"))),
        0x5001: drive((0x10, LACKING.format("2C"))),
        0x6001: drive((0x10, LACKING.format("34"))),
        **{element << 12 | 4: write(f"{element << 3 | 4:02X} 03 00 24 00", "58") for element in (2, 3, 4, 5, 6)},
        0x7002: write("3C 03 00 24 00", "00 00 00"),
        0x7003: write("3C 03 00 24 00", "00 00 00 00 00"),
        0x7004: write("3C 03 00 28 00", "00 00 00 00"),
        0x7005: write("3C 03 00 2C 00", "02 00"),
        0x7006: write("3C 03 00 24 00", "7F 3C 36 FE"),
        0x7007: write("3C 03 00 24 00", "81 C3 C9 01"),
        0x7008: write("3C 03 00 63 00", "04 00"),
        0x700C: write("3C 03 00 2F 00", "FF FF FF FF"),
        0x700D: write("3C 03 00 48 80", "04 00 00 10 01 00 00 00"),
        0x700E: write("3C 03 00 A6 8F", "04 00 10 00 01 00 00 00"),
        0x700F: drive((0x11, "3C 03 00 A6 8F 02 00 04 00")),
        0x8001: drive((0x1D, "02"), READ_VELOCITY),
        **{code: drive(READ_VELOCITY, parameters={"S-0-0036": {"refuse": code}}) for code in (0x8002, 0x800B)},
        # somebody else writes what is being read
        0x800C: drive(READ_CAM, (0x1F, "3C 03 00 48 80 04 00 00 10"), **CAM),
        **{
            code: drive((0x1F, f"{code >> 12 << 3 | 4:02X} 03 00 24 00 58"), parameters={"S-0-0036": {"refuse": code}})
            for code in ASKED_PARAMETER
        },
    },
    "errors_phase": {
        0x8004: drive((0x1D, "05")),
        0xD005: drive((0x1D, "02"), (0x1D, "04")),
        0xD006: drive(ENABLED, (0x1D, "02"), LATER, (0x12, "")),
        0xD007: Way({**SYNAX, "turning": True}, ((0x9D, "02"), LATER, (0x92, ""))),
    },
    "errors_flash": {
        0x9002: drive(TO_LOADER, ERASE, (0x02, "03 90 00 00 00 00 00"), phase=2),
        0x9003: drive(TO_LOADER, phase=3),
        0x9004: drive(TO_LOADER),
        0x9010: drive(TO_LOADER, edition="IndraDrive"),
        0x9102: drive(TO_LOADER, ERASE, (0x02, "03 91 00 00 00 00"), phase=2),
        0x9103: drive((0x02, "03 91 00 00 00 00"), phase=3),
        0x9104: drive((0x02, "03 91 00 00 00 00")),
        0x9110: drive((0x02, "03 91 00 00 00 00"), edition="IndraDrive"),
        0x9200: drive((0x02, "03 92 00 00 00 FF 10")),
        0x920B: drive((0x02, f"03 92 {START} F5")),
        0x9400: drive(TO_LOADER, ERASE, phase=2, worn=True),
        0x940A: drive(ERASE),
        0x96E0: drive((0x02, "03 96 00 00 00 00 04 55")),
        0x96E1: drive((0x02, f"03 96 {START} 04 55"), worn=True),
        0x96FF: drive((0x02, "03 96 00 10 80 00 02 55")),
        0x9701: drive((0x02, "03 96 00 00 80 00 02 01 00 00 00 00 00 00 00"), (0x02, MODULE)),
        # the words add up to zero, the CRC is not that of 01 00
        0x9702: drive((0x02, "03 96 00 00 80 00 02 01 00 00 00 00 00 FF FF"), (0x02, MODULE)),
    },
    "errors_initialization": {
        0x0700: drive((0x03, "03 07 03")),
        0x0800: drive((0x03, "03 08 F4 01 03")),
        0x0801: drive((0x03, "03 08 FF FF 01")),
    },
}

PROVOKED = [(name, code) for name, ways in WAYS.items() for code in ways]
SUBADDRESSES = {("status", 0xF9): b"\x08"}
OTHER_MASTER = {("errors_parameter", 0x800C)}  # sends the last telegram


@pytest.mark.parametrize("name", WAYS)
def test_every_code_of_the_description_is_provoked(name: str) -> None:
    provoked = set(WAYS[name])
    texts = described(name)
    assert provoked <= set(texts)
    if name == "status":  # ranges: the first and the last of each
        missing = set(texts.values()) - {texts[code] for code in provoked}
    else:
        missing = {texts[code] for code in set(texts) - provoked}
    assert not missing


def test_every_table_of_errors_is_here() -> None:
    """The errors of the ASCII protocol are provoked in capture/tests/test_terminal.py."""
    tables = {name for name in DESCRIBED if name.startswith(("errors", "status"))}
    assert tables - {"errors_ascii"} == set(WAYS)


def exchanges(name: str, code: int) -> list[bytes]:
    """Make the telegrams: commands and reactions in turn."""
    way = WAYS[name][code]
    (station,) = make([{"address": 3, **way.table}], 1)
    telegrams: list[bytes] = []
    for place, (service, body) in enumerate(way.steps, 1):
        last = place == len(way.steps)
        sender = 17 if last and (name, code) in OTHER_MASTER else 16
        route = SUBADDRESSES.get((name, code), b"")
        command = bytearray(build(service, sender, way.receiver, bytes.fromhex(body), subaddresses=route))
        if last and way.damage is not None:
            command[way.damage] ^= 0x10
        if last and way.damage == 4:  # still a good telegram
            command[1] = (command[1] - 0x10) & 0xFF
        wait_ms = 500 if LATER in way.steps[:place] else 1
        reaction = station.react(bytes(command), (place * wait_ms) * MS)
        assert reaction is not None, f"{name} 0x{code:04X}: no reaction to {command.hex(' ')}"
        telegrams += [bytes(command), reaction]
    return telegrams


def capture(telegrams: list[bytes]) -> bytes:
    """Make a capture of bare telegrams."""
    packets = (
        pcapng.enhanced_packet(0, place * SEND_NS, pcapng.upper_pdu("sis", telegram), 0)
        for place, telegram in enumerate(telegrams)
    )
    interface = pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, "bus")
    return b"".join([pcapng.section_header("bus", ""), pcapng.interface_description(interface), *packets])


@cache
def labels(tshark: Tshark, folder: Path) -> dict[tuple[str, int], list[str]]:
    """Return tshark's status and error code of the last reaction of each provocation."""
    path = folder / "provoked.pcapng"
    runs = [exchanges(*provoked) for provoked in PROVOKED]
    path.write_bytes(capture([telegram for run in runs for telegram in run]))
    packets = list(ElementTree.fromstring(tshark.output("-r", str(path), "-T", "pdml")))
    shown, end = {}, 0
    for provoked, run in zip(PROVOKED, runs, strict=True):
        end += len(run)
        shown[provoked] = [
            field.get("showname", "").rpartition(" = ")[2]
            for field in packets[end - 1].iter("field")
            if field.get("name") in ("sis.status", "sis.error")
        ]
    assert end == len(packets)
    return shown


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "code"), PROVOKED, ids=lambda value: value if isinstance(value, str) else f"{value:04X}"
)
def test_tshark_shows_it(name: str, code: int, tshark: Tshark, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.getbasetemp()
    reaction = parse(exchanges(name, code)[-1])
    is_phase = reaction.service in PHASE_SERVICES
    text = described(name)[code]
    if name.startswith("status"):
        assert reaction.body[0] == code
        assert is_phase == (name == "status_phase")
        expected = f"Status: {text} (0x{code:02x})"
    else:
        expected = f"Error code: {text} (0x{code:04x})"  # what to do may follow
    assert any(label.startswith(expected) for label in labels(tshark, folder)[(name, code)])
