# SPDX-License-Identifier: GPL-2.0-or-later
"""Process data over UDP: words, directions and the values of the user's table, worked out by hand."""

from __future__ import annotations

from pathlib import Path

import pytest

import bad_input
from make import HERE, Scenario
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from tables import Table, check

FIELDS = "synaxpd.direction synaxpd.word synaxpd.value sis.value.number synaxpd.raw"
TO, FROM = "direction=1", "direction=2"

WORDS: Table = {
    # High byte first (p. 6-4)
    1: f"{TO}; word=0x0001,0xfffe,0x1234,0x5678",
    2: f"{FROM}; word=0x8000",
    3: f"{FROM}; word=0x0001,0x0002,0x0003,0x0004,0x0005,0x0006,0x0007,0x0008,0x0009",
    4: f"{FROM}; word=0x0001; raw=02",
    5: f"{TO}; raw=aa",
    6: f"{FROM}; word=0x0001",
    7: "word=0x0001",  # by Decode As: the port is in no preference
}

# 0xFFFFD8F0 is -10000, 0x0036EE80 is 3600000, 0xFFF6 is -10
VALUES: Table = {
    1: f"{TO}; word=0x8001,0xffff,0xd8f0,0x1234; value=Control word = 32769,Velocity command value = -1 rpm; "
    "value.number=32769,-1",
    2: f"{FROM}; word=0x0007,0xfff6,0x0036,0xee80; value=Torque = -1 %,Position = 360 deg; value.number=-1,360",
    3: f"{FROM}; word=0x0007,0x000a,0x0036; value=Torque = 1 %; value.number=1",
    4: f"{TO}; word=0x8001,0xffff",
}

SWAPPED: Table = {
    1: f"{TO}; word=0x8001,0xd8f0,0xffff,0x1234; value=Control word = 32769,Velocity command value = -1 rpm; "
    "value.number=32769,-1",
    2: f"{FROM}; word=0x0007,0xfff6,0xee80,0x0036; value=Torque = -1 %,Position = 360 deg; value.number=-1,360",
}


def whole(table: Table) -> Table:
    """Give the fields of a table their whole names: a number is one of SIS."""
    rows = {frame: row.split("; ") for frame, row in table.items()}
    return {
        frame: "; ".join(("sis." if entry.startswith("value.number") else "synaxpd.") + entry for entry in entries)
        for frame, entries in rows.items()
    }


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "table"), [("synaxpd", WORDS), ("synaxpd-table", VALUES), ("synaxpd-swapped", SWAPPED)]
)
def test_values(name: str, table: Table, tshark: Tshark) -> None:
    check(tshark, name, FIELDS, "", whole(table), *Scenario(HERE / f"{name}.txt").options, prefix="")


def test_no_port_is_known_by_itself(tshark: Tshark) -> None:
    assert "SYNAXPD" not in tshark.output("-r", str(HERE / "synaxpd.pcapng"))


@pytest.mark.thorough
@pytest.mark.parametrize(
    "row",
    [
        '"0","to the PPC","1","2","unsigned","x","",""',
        '"7001","to the PPC","0","2","unsigned","x","",""',
        '"7001","to the PPC","1","2","unsigned","","",""',
        '"7001","to the PPC","1","2","unsigned","x","","1,5"',
        '"7001","to the PPC","1","2","unsigned","x","","inf"',
    ],
)
def test_rows_that_are_refused(row: str, tshark: Tshark) -> None:
    done = tshark.run(["-r", str(HERE / "synaxpd.pcapng"), "-o", f"uat:synax_process_data:{row}"])
    assert done.returncode != 0
    assert done.stdout == ""


def test_of_several_rows_for_a_word_the_first_counts(tshark: Tshark) -> None:
    """Rows of another port or direction, and of words that are not there, count for nothing."""
    rows = ("7002 to 1 other", "7001 from 1 other", "7001 to 32767 far", "7001 to 2 second", "7001 to 2 late")
    table = [
        f'"{port}","{direction} the PPC","{word}","2","unsigned","{name}","",""'
        for port, direction, word, name in (row.split() for row in rows)
    ]
    options = [word for row in table for word in ("-o", f"uat:synax_process_data:{row}")]
    options += ["-o", "synaxpd.ports:7001", "-Y", "frame.number == 1", "-T", "fields", "-e", "synaxpd.value"]
    shown = tshark.output("-r", str(HERE / "synaxpd-table.pcapng"), *options)
    assert shown.strip() == f"second = {0xFFFF}"


def test_a_direction_without_ports(tshark: Tshark, tmp_path: Path) -> None:
    """By name there are no ports: what `sistap import --dissector` writes has it in the flags of the packet."""
    interface = pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, "x")
    flags = (pcapng.PacketFlags.OUTBOUND, pcapng.PacketFlags.INBOUND, 0)
    data = pcapng.upper_pdu("synaxpd", b"\0\1")
    blocks = [pcapng.section_header("", ""), pcapng.interface_description(interface)]
    blocks += [pcapng.enhanced_packet(0, 0, data, int(flag)) for flag in flags]
    (tmp_path / "x.pcapng").write_bytes(b"".join(blocks))
    shown = tshark.output("-r", str(tmp_path / "x.pcapng"), "-T", "fields", "-e", "synaxpd.direction")
    assert shown.splitlines() == ["1", "2", ""]


def test_any_length(tshark: Tshark, tmp_path: Path) -> None:
    bad_input.write(tmp_path / "any.pcapng", [bytes(length) for length in range(1, 40)], "synaxpd")
    columns = ("-T", "fields", "-e", "_ws.col.Info")
    lines = tshark.output("-r", str(tmp_path / "any.pcapng"), "-2", "-V", *columns).splitlines()
    assert [line.split(":")[0] for line in lines] == [
        f"Process data, {n // 2} word{'' if n // 2 == 1 else 's'}" for n in range(1, 40)
    ]
