# SPDX-License-Identifier: GPL-2.0-or-later
"""Several telegrams in a packet, as TCP packs them: each has its own fields, as if it were alone."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from commands import run

from sistap.dissected.captures.portions import Portion
from sistap.dissected.explain.fields import Fields
from sistap.dissected.packets.dissection import FIELDS, Dissection, Telegram, packet_of
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from sistap.tap.sis.telegram import build

START_NS, MS = 1_700_000_000_000_000_000, 1_000_000
ROUNDS, DIES = 60, 20  # from that round on, station 4 answers no more
REFUSED = {3, 10, 17}  # rounds in which it refuses
IPV4 = 228  # link type
READ_3, READ_4 = (build(0x10, 16, station, bytes.fromhex("3C 05 00 24 00")) for station in (3, 4))
VALUE_3, VALUE_4 = (build(0x10, 16, station, bytes.fromhex("00 3C 05 E8 03"), reaction=True) for station in (3, 4))
# Status 0x01: error; its code 0x1001: this parameter does not exist (chapter 6).
REFUSAL_4 = build(0x10, 16, 4, bytes.fromhex("01 3C 05 01 10"), reaction=True)


def segment(from_master: bool, sequence: int, acknowledged: int, payload: bytes) -> bytes:
    """Make an IPv4 packet with one TCP segment; its checksums are 0, which Wireshark does not judge."""
    ports = (50000, 4200) if from_master else (4200, 50000)
    addresses = (b"\n\0\0\1", b"\n\0\0\2") if from_master else (b"\n\0\0\2", b"\n\0\0\1")
    tcp = struct.pack(">HHIIBBHHH", *ports, sequence, acknowledged, 0x50, 0x18, 8192, 0, 0) + payload
    return struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(tcp), 0, 0, 64, 6, 0, *addresses) + tcp


def answers(number: int) -> Sequence[bytes]:
    """Return the reactions of a round."""
    of_4 = [] if number >= DIES else [REFUSAL_4 if number in REFUSED else VALUE_4]
    return [VALUE_3, *of_4]


def captured(path: Path, is_joined: bool) -> Path:
    """Write the same bus: both commands and both reactions in a packet, or each alone, as until the first refusal."""
    blocks = [pcapng.section_header("", ""), pcapng.interface_description(pcapng.Interface(IPV4, "tcp"))]
    sent, time_ns = {True: 1, False: 1}, START_NS
    for number in range(ROUNDS):
        for from_master, telegrams in ((True, [READ_3, READ_4]), (False, answers(number))):
            for payload in [b"".join(telegrams)] if is_joined and number >= min(REFUSED) else telegrams:
                packet = segment(from_master, sent[from_master], sent[not from_master], payload)
                blocks.append(pcapng.enhanced_packet(0, time_ns, packet))
                sent[from_master] += len(payload)
            time_ns += 10 * MS
        time_ns += 80 * MS
    path.write_bytes(b"".join(blocks))
    return path


def said(telegram: Telegram) -> tuple[object, ...]:
    """Return what does not depend on its packet."""
    faults = [fault.name for fault in telegram.faults]
    parameter = telegram.columns.get("sis.parameter")
    who = telegram.good, telegram.service, telegram.talker, telegram.listener, telegram.is_reaction
    what = telegram.status, telegram.is_refusal, telegram.is_repeat, telegram.unanswered, telegram.phase
    times = telegram.reaction and telegram.reaction.time_s, telegram.cycle, telegram.pause, bool(telegram.command_in)
    return (*who, *what, *times, parameter, faults)


def dissected(path: Path) -> list[tuple[object, ...]]:
    """Return what the dissector says of each telegram, after two passes."""
    with Tshark() as tshark, Dissection(tshark, [Portion(path)]) as dissection:
        return [said(telegram) for packet in dissection.packets() for telegram in packet.telegrams]


def heard(path: Path) -> list[tuple[object, ...]]:
    """Return what it says while a recorder listens."""
    with Tshark() as tshark:
        fields = Fields(tshark, FIELDS)
        rows = [fields.columns(line) for line in tshark.lines(["-r", str(path), *fields.arguments])]
    return [said(telegram) for row in rows for telegram in packet_of(row).telegrams]


@pytest.mark.usefixtures("dissector")
def test_each_telegram_has_what_it_would_have_alone(tmp_path: Path) -> None:
    joined, each = (captured(tmp_path / f"{name}.pcapng", name == "joined") for name in ("joined", "each"))
    alone = dissected(each)
    assert dissected(joined) == alone
    assert heard(joined) == heard(each)
    unanswered = [one[3] for one in alone if one[8]]
    assert unanswered == [4] * (ROUNDS - DIES - 1)  # the last command: nobody knows yet
    assert [one[2] for one in alone if one[6]] == [4] * len(REFUSED)


@pytest.mark.usefixtures("dissector")
def test_a_report_says_the_same(tmp_path: Path) -> None:
    told: list[dict[str, Any]] = []
    for is_joined in (True, False):
        capture = captured(tmp_path / f"{is_joined}.pcapng", is_joined)
        done = run(tmp_path, "report", capture, "--format", "json", "-o", "-")
        assert (done.returncode, done.stderr) == (0, "")
        told.append(json.loads(done.stdout))
    joined, each = told
    for part in ("faults", "stations", "services", "telegrams", "answer", "not_judged"):
        assert joined[part] == each[part], part
    found = {"unanswered": 39, "repeated": 39, "error_reaction": 3}  # each of these commands is as the one before it
    assert {name: count for name, count in joined["faults"].items() if count} == found
    stations = {one["station"]: one for one in joined["stations"]}
    assert (stations[4]["not_answered"], stations[4]["reactions"], stations[4]["reactions_with_error"]) == (39, 20, 3)
    assert (stations[3]["not_answered"], stations[3]["reactions"], stations[3]["reactions_with_error"]) == (0, 60, 0)
    happened = [[(one["kind"], one["station"], one["count"], one["text"]) for one in side["episodes"]] for side in told]
    assert happened[0] == happened[1]
    assert [(kind, station) for kind, station, _, _ in happened[0] if kind == "silent"] == [("silent", 4)]
