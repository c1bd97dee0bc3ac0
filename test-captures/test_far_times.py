# SPDX-License-Identifier: GPL-2.0-or-later
"""A capture may claim any time: everything is dissected, and too far a time counts as the nearest valid one."""

from __future__ import annotations

import itertools
import re
import struct
from pathlib import Path

import pytest

import mutate
from make import START_NS
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.record import Record, Type
from sistap.tap.sis.telegram import build
from tables import shown

S = 1_000_000_000
CLOCK_BACK = Path(__file__).with_name("clock-back.pcapng")
LATEST_NS = 9_150_000_000 * S  # plugin/docs/verdicts.md
FAR_NS = (0, 1, START_NS, LATEST_NS - 1, LATEST_NS, 2**63 - 1, 2**63, 2**63 + 1, 2**64 - 1)
FAR_S = (0, START_NS // S, 2**31, 2**33, 2**34, 2**53, 2**62, 2**63 - 1, 2**63, 2**64 - 1)

SETTINGS = LineSettings(115200)


def packet(telegram: bytes) -> bytes:
    """Make the record of a telegram whose characters came one by one."""
    count = len(telegram)
    made = Record(0, Type.FRAME, 0, SETTINGS, telegram, [SETTINGS.character_ns] * count, bytes(count), 0)
    return pcapng.upper_pdu("sertap", made.pack())


COMMAND, REACTION = build(0x12, 16, 3), build(0x12, 16, 3, b"\x00\x04", reaction=True)
DURATION_NS = (len(COMMAND) - 1) * SETTINGS.character_ns


def exchanges(pairs: list[tuple[int, ...]], resolution: int) -> bytes:
    """Make a capture of commands and reactions with these pairs of times, in units of 10 ** -resolution s."""
    link_type = struct.pack("<HHI", pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, 0, 0)
    blocks = [
        pcapng.section_header("", ""),
        mutate.block(pcapng.INTERFACE_DESCRIPTION, link_type, {9: bytes([resolution])}),
    ]
    for times in pairs:
        for time, telegram in zip(times, (COMMAND, REACTION), strict=True):
            blocks.append(pcapng.enhanced_packet(0, time, packet(telegram)))
    return b"".join(blocks)


def elapsed(command_ns: int, reaction_ns: int) -> int:
    """Work out the reaction time, in ns; if it is not above 0, there is none."""
    command_ns, reaction_ns = min(command_ns, LATEST_NS), min(reaction_ns, LATEST_NS)
    return min(reaction_ns - command_ns - DURATION_NS, LATEST_NS)


def seconds(ns: int) -> str:
    """Write it as tshark does."""
    return f"{ns // S}.{ns % S:09d}"


def test_reaction_times(tshark: Tshark, tmp_path: Path) -> None:
    pairs = list(itertools.product(FAR_NS, repeat=2))
    capture = tmp_path / "far.pcapng"
    capture.write_bytes(exchanges(pairs, 9))
    found = [cells["reaction_time"] for cells in shown(tshark, capture, "reaction_time").values() if cells]
    assert found == [seconds(ns) for pair in pairs if (ns := elapsed(*pair)) > 0] != []


def test_a_clock_that_is_set_back_makes_no_duration(tshark: Tshark) -> None:
    protocols = "sis,3964r,rk512i,sisascii,synaxobj,synaxpcp,arcnet7f"
    options = ("-o", "sis.trs_ms:40", "-o", "3964r.qvz_ms:100", "-O", protocols)
    text = tshark.output("-r", str(CLOCK_BACK), *options)
    assert text.count(": 599") == 0 and not re.findall(r"^.*-\d[\d.]* m?s\b.*$", text, re.MULTILINE)
    assert text.count("whose end has a later time: the reaction time is not known]") == 2  # by SIS, and in an object
    assert text.count("Read phase: phase 4 (operating mode), reached\n") == 1
    verdicts = re.findall(r"\[Verdict on (\w+): (\w+)", text)
    assert verdicts.count(("Tmas", "unresolved")) == 2 and ("TrS", "unresolved") in verdicts
    assert ("QVZ", "Unresolved") in verdicts


@pytest.mark.thorough
@pytest.mark.parametrize("times", [FAR_NS, FAR_S], ids=["nanoseconds", "seconds"])
@pytest.mark.parametrize("layers", [["-V"], ["-2"], mutate.STATISTICS], ids=["trees", "two_passes", "statistics"])
def test_every_packet_is_dissected(times: tuple[int, ...], layers: list[str], tshark: Tshark, tmp_path: Path) -> None:
    pairs = list(itertools.product(times, repeat=2))
    capture = tmp_path / "far.pcapng"
    capture.write_bytes(exchanges(pairs, 9 if times is FAR_NS else 0))
    text = tshark.output("-r", str(capture), "-o", "sis.tza_ms:3", "-o", "sis.trs_ms:30", *layers)
    if layers == ["-2"]:
        assert len(text.splitlines()) == len(pairs) * 2
    assert "Dissector bug" not in text
    assert "Malformed" not in text
