# SPDX-License-Identifier: GPL-2.0-or-later
"""sis.lua dissects bad input like the C plugin, and never with "Lua Error"."""

from __future__ import annotations

import random
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

import pytest

import bad_input
import mutate
import parity
from make import HERE, Scenario
from sistap.dissected.captures import reading
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng

T = TypeVar("T")

SEED = 1
ALL = 10**9
FEW = 400  # packets; enough for most faults


def some(packets: Sequence[T], count: int) -> list[T]:
    """Return that many packets, chosen with a seed, in order."""
    chosen = random.Random(SEED).sample(range(len(packets)), min(count, len(packets)))
    return [packets[place] for place in sorted(chosen)]


sizes = pytest.mark.parametrize("count", [FEW, pytest.param(ALL, marks=pytest.mark.thorough)], ids=["some", "all"])


@pytest.mark.thorough
@sizes
@pytest.mark.parametrize(
    "reaction", [False, pytest.param(True, marks=pytest.mark.thorough)], ids=["commands", "reactions"]
)
def test_useful_data(count: int, reaction: bool, plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """Useful data of every service and every example, too short and too long."""
    capture = tmp_path / "bad.pcapng"
    bad_input.write(capture, some(list(bad_input.with_all_bodies(reaction)), count))
    parity.check(plugin, script, capture)


@pytest.mark.thorough
@sizes
def test_lengths(count: int, plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """Telegrams that the capture has cut, and lengths that differ."""
    capture = tmp_path / "bad.pcapng"
    packets = [packet for example in bad_input.examples() for packet in bad_input.snapped(example)]
    differing = [data for example in bad_input.examples() for data in bad_input.with_other_repetition(example)]
    bad_input.write(capture, some([*packets, *differing], count))
    parity.check(plugin, script, capture)


@pytest.mark.thorough
@sizes
def test_every_beginning_of_every_record(count: int, plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    records = [item.record(None) for item in Scenario(HERE / "records.txt").items]
    beginnings = [pcapng.upper_pdu("sertap", record[:end]) for record in records for end in range(len(record))]
    interface = pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, "cut")
    blocks = [pcapng.section_header("", ""), pcapng.interface_description(interface)]
    blocks += [pcapng.enhanced_packet(0, number, packet) for number, packet in enumerate(some(beginnings, count))]
    capture = tmp_path / "cut.pcapng"
    capture.write_bytes(b"".join(blocks))
    parity.check(plugin, script, capture)


@pytest.mark.thorough
@sizes
@pytest.mark.parametrize(
    ("name", "dissector"),
    [
        ("records", "sertap"),
        ("3964r", "sertap"),
        pytest.param("3964r", "rk512i", marks=pytest.mark.thorough),
        pytest.param("arcnet7f", "arcnet7f", marks=pytest.mark.thorough),
        pytest.param("synaxpk", "synaxpk", marks=pytest.mark.thorough),
    ],
)
def test_what_the_capture_has_cut(  # noqa: PLR0913, PLR0917
    name: str, dissector: str, count: int, plugin: Tshark, script: Tshark, tmp_path: Path
) -> None:
    """Each packet whole, and then its beginnings: so what is under way when the capture cuts a packet is known."""
    items = Scenario(HERE / f"{name}.txt").items
    whole = [item.data if dissector == "rk512i" else item.record(None) for item in items]
    ends = [(data, end) for data in whole for end in (len(data), *range(1, len(data)))]
    bad_input.write(
        tmp_path / "cut.pcapng", some([bad_input.Packet(data[:end], len(data)) for data, end in ends], count), dissector
    )
    parity.check(plugin, script, tmp_path / "cut.pcapng", "-o", "sis.tza_ms:5")


@pytest.mark.thorough
@sizes
def test_lines_of_the_ascii_protocol(count: int, plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """1,000 random lines: each whole, then every beginning of it as a line, and as what the capture has cut."""
    packets: list[bad_input.Packet | bytes] = []
    for line in bad_input.ascii_lines(random.Random(SEED), 1000):
        packets.append(line)
        packets += [line[:end] for end in range(1, len(line))]
        packets += [bad_input.Packet(line[:end], len(line)) for end in range(1, len(line))]
    bad_input.write(tmp_path / "lines.pcapng", some(packets, count), "sisascii")
    parity.check(plugin, script, tmp_path / "lines.pcapng")


@pytest.mark.thorough
def test_no_character_of_3964r(plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    bad_input.write(tmp_path / "empty.pcapng", [b""], "3964r")
    parity.check(plugin, script, tmp_path / "empty.pcapng")


@pytest.mark.thorough
def test_more_pieces_than_are_joined(plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    packets = [struct.pack(">HI6x", 0x044B if number == 8193 else 0x004B, number) for number in range(8194)]
    bad_input.write(tmp_path / "many.pcapng", packets, "synaxpk")
    parity.check(plugin, script, tmp_path / "many.pcapng")


@pytest.mark.thorough
@sizes
@pytest.mark.parametrize("name", ["synaxobj", "synaxpcp"])
def test_objects(name: str, count: int, plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """Objects and PCP: every beginning, every cut of the capture, and bytes that are changed."""
    chance = random.Random(SEED)
    whole = [item.data for item in Scenario(HERE / f"{name}.txt").items]
    ends = [(data, end) for data in whole for end in range(1, min(len(data), 64))]
    packets: list[bad_input.Packet | bytes] = [data[:end] for data, end in ends]
    packets += [bad_input.Packet(data[:end], len(data)) for data, end in ends]
    packets += [mutate.mutant(chance, b"", data) or b"\0" for data in whole for _ in range(40)]
    bad_input.write(tmp_path / "bad.pcapng", some(packets, count), name)
    parity.check(plugin, script, tmp_path / "bad.pcapng")


@pytest.mark.thorough
@sizes
def test_process_data(count: int, plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    data = bytes(range(40))
    packets: list[bad_input.Packet | bytes] = [data[:end] for end in range(1, 40)]
    packets += [bad_input.Packet(data[:end], len(data)) for end in range(1, 40)]
    bad_input.write(tmp_path / "bad.pcapng", some(packets, count), "synaxpd")
    parity.check(plugin, script, tmp_path / "bad.pcapng", "-o", "synaxpd.swap_bytes:true")


def mutants(link_type: int, count: int, *, far: bool) -> bytes:
    """Make a capture of packets with bytes changed, added and missing."""
    packets = [packet for path in sorted(HERE.glob("*.pcapng")) for packet in reading.packets(path)]
    originals = [packet.data for packet in packets if packet.link_type == link_type]
    return mutate.round_capture(SEED, link_type, originals, count, far=far)


@pytest.mark.parametrize(
    "count",
    [FEW, pytest.param(mutate.MUTANTS_PER_ROUND, marks=pytest.mark.thorough)],
    ids=["some", "all"],
)
@pytest.mark.parametrize(
    ("link_type", "options"),
    [
        pytest.param(link_type, options, marks=[] if number == 0 else pytest.mark.thorough)
        for number, (link_type, options) in enumerate(
            (link_type, options) for link_type, ways in mutate.OPTIONS.items() for options in ways
        )
    ],
    ids=lambda value: "_".join(value) or "none" if isinstance(value, list) else None,
)
def test_mutants(  # noqa: PLR0913, PLR0917
    count: int, link_type: int, options: list[str], plugin: Tshark, script: Tshark, tmp_path: Path
) -> None:
    capture = tmp_path / "mutants.pcapng"
    capture.write_bytes(mutants(link_type, count, far=False))
    parity.check(plugin, script, capture, *options)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "passes", [(), pytest.param(("-2",), marks=pytest.mark.thorough)], ids=["one_pass", "two_passes"]
)
def test_far_times(passes: tuple[str, ...], script: Tshark, tmp_path: Path) -> None:
    """Lua's numbers are exact for weeks only, so the texts of such times may differ."""
    capture = tmp_path / "far.pcapng"
    capture.write_bytes(mutants(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, FEW, far=True))
    options = (*passes, "-o", "sis.tza_ms:3", "-o", "sis.trs_ms:30")
    for view in (parity.packets, parity.listed):
        assert len(view(script, capture, *options)) == FEW
