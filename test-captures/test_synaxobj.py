# SPDX-License-Identifier: GPL-2.0-or-later
"""Objects of SYNAX200: what belongs together and what their bits say, worked out by hand from the facts."""

from __future__ import annotations

from pathlib import Path

import pytest

import bad_input
from make import HERE, Scenario
from sistap.dissected.wireshark.tshark import Tshark
from tables import Table, check

FIELDS = (
    "synax.request_in synax.answer_in synax.answer_time synaxobj.index synaxobj.operation synaxobj.raw "
    "synaxobj.open_bit synaxobj.diagnosis.interface synaxobj.diagnosis.fault synaxobj.status.bus "
    "synaxobj.status.memory synaxobj.fault.process_data synaxobj.fault.communication sis.service"
)
EXPERTS = "synax.note synax.short synax.unexpected synax.error synax.failed synax.unanswered"

WRITE, READ, ASK = "synaxobj.operation=1", "synaxobj.operation=0", "synaxobj.operation=2"
WRITTEN = "synaxobj.operation=3"


def of(index: str, operation: str, *rest: str) -> str:
    return "; ".join([f"synaxobj.index=0x{index}", operation, *rest])


OBJECTS: Table = {
    # A write request, its answer without a telegram, and two reads of the same object
    1: of("5e73", WRITE, "synax.answer_in=4; sis.service=0x9d"),
    2: of("5e73", WRITTEN),
    3: of("5e73", ASK),
    4: of("5e73", READ, "synax.request_in=1; synax.answer_time=0.237604115; sis.service=0x9d"),
    # Another object has a request of its own, and may be read twice
    5: of("5e71", WRITE, "synax.answer_in=7; sis.service=0x9f"),
    6: of("5e71", ASK),
    7: of("5e71", READ, "synax.request_in=5; synax.answer_time=0.097291650; sis.service=0x9f"),
    8: of("5e71", ASK),
    9: of("5e71", READ, "synax.request_in=5; synax.answer_time=0.194583300; sis.service=0x9f"),
    10: of("5e73", ASK),
    11: of("5e73", READ, "synax.request_in=1; synax.answer_time=0.706458186; sis.service=0x9d"),
    # Written again before anybody has read
    12: of("5e71", WRITE, "synax.unanswered; sis.service=0x90"),
    13: of("5e71", WRITE, "synax.answer_in=15; sis.service=0x90"),
    14: of("5e71", ASK),
    15: of("5e71", READ, "synax.request_in=13; synax.answer_time=0.097291650; sis.service=0x90"),
    # Without a request; empty; no telegram; damaged ones are SIS' own concern; 17 bytes of 16; no content
    16: of("5e72", ASK),
    17: of("5e72", READ, "sis.service=0x90"),
    18: of("5e72", ASK),
    19: of("5e72", READ, "synaxobj.raw=0000000000000000"),
    20: of("5e72", ASK),
    21: of("5e72", READ, "synaxobj.raw=313233; synax.note"),
    22: of("5e72", ASK),
    23: of("5e72", READ, "sis.service=0x90"),
    24: of("5e70", ASK),
    25: of("5e70", READ, "synax.unexpected; sis.service=0x90"),
    26: of("5e70", ASK),
    27: of("5e70", READ, "sis.service=0x90"),
    28: of("5e70", ASK),
    29: of("5e70", READ),
    30: of("5e70", ASK),
    31: of("5e70", READ, "synax.short"),
    # 0x0201: bits 0-7 process data channel, 8-15 communication channel (L149)
    32: of("5ff6", ASK),
    33: of(
        "5ff6",
        READ,
        "synaxobj.open_bit=0,9; synaxobj.fault.process_data=0x0001; synaxobj.fault.communication=0x0002",
        "synax.note; synax.error",
    ),
    34: of("5ff6", ASK),
    35: of("5ff6", READ, "synaxobj.fault.process_data=0x0000; synaxobj.fault.communication=0x0000"),
    # 0x2005: bits 12-15 interface, 0-7 fault code (L156)
    36: of("5ff0", ASK),
    37: of(
        "5ff0",
        READ,
        "synaxobj.open_bit=13; synaxobj.diagnosis.interface=2; synaxobj.diagnosis.fault=0x0005",
        "synax.note; synax.error",
    ),
    38: of("5ff0", ASK),
    39: of("5ff0", READ, "synaxobj.diagnosis.interface=0; synaxobj.diagnosis.fault=0x0000"),
    # 0x000A, 0x8001: bit 3 is 0 after a bus failure (L238), bits 0-1 state of the dual-port RAM, not said which (L153)
    40: of("5ff2", ASK),
    41: of("5ff2", READ, "synaxobj.open_bit=1; synaxobj.status.bus=1; synaxobj.status.memory=2; synax.note"),
    42: of("5ff2", ASK),
    43: of(
        "5ff2",
        READ,
        "synaxobj.open_bit=0,15; synaxobj.status.bus=0; synaxobj.status.memory=1; synax.note; synax.failed",
    ),
    # All bits open; a byte less and a byte more
    44: of("5ff5", ASK),
    45: of("5ff5", READ, "synaxobj.open_bit=0,4; synax.note"),
    46: of("5ff5", ASK),
    47: of("5ff5", READ, "synaxobj.raw=00; synax.short"),
    48: of("5ff5", ASK),
    49: of("5ff5", READ, "synaxobj.open_bit=0,4; synaxobj.raw=22; synax.note; synax.unexpected"),
    # Objects of which only the index is known, and one that is not
    50: of("5ffc", ASK),
    51: of("5ffc", READ, "synaxobj.raw=0001; synax.note"),
    52: of("5ffe", WRITE, "synaxobj.raw=00010000; synax.note"),
    54: "synax.note",
}


def test_objects(tshark: Tshark) -> None:
    check(tshark, "synaxobj", FIELDS, EXPERTS, OBJECTS, prefix="")


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["synaxobj", "synaxpcp"])
def test_every_beginning(name: str, tshark: Tshark, tmp_path: Path) -> None:
    whole = [item.data for item in Scenario(HERE / f"{name}.txt").items]
    beginnings = sorted({data[:end] for data in whole for end in range(1, min(len(data), 64))})
    bad_input.write(tmp_path / "cut.pcapng", beginnings, "synaxpcp")
    columns = ("-T", "fields", "-e", "_ws.col.Protocol", "-e", "_ws.col.Info")
    lines = tshark.output("-r", str(tmp_path / "cut.pcapng"), "-2", "-V", *columns).splitlines()
    assert len(lines) == len(beginnings)
    assert all(line.startswith(("SYNAX", "SIS")) for line in lines)
    assert [line for line in lines if "Malformed" in line or "bug" in line] == []


WRITE_REQUEST = "0082 0004 0002 5FF6 0002 0102"


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["synaxpcp", "synaxpd"])
def test_every_cut_of_the_capture(name: str, tshark: Tshark, tmp_path: Path) -> None:
    """Wireshark says that the capture is cut, and nothing is said to be missing that was on the line."""
    data = bytes.fromhex(WRITE_REQUEST)
    cut = [bad_input.Packet(data[:end], len(data)) for end in range(1, len(data))]
    bad_input.write(tmp_path / "snapped.pcapng", cut, name)
    columns = ("-T", "fields", "-e", "_ws.short", "-e", "synax.short", "-e", "synax.unexpected")
    rows = [row.split("\t") for row in tshark.output("-r", str(tmp_path / "snapped.pcapng"), *columns).splitlines()]
    assert len(rows) == len(cut)
    assert [row for row in rows if not row[0] or row[1:] != ["", ""]] == []
