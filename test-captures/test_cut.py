# SPDX-License-Identifier: GPL-2.0-or-later
"""Telegrams, records and files with any end."""

from __future__ import annotations

from pathlib import Path

import pytest

import bad_input
from bad_input import Packet
from make import HERE, Scenario
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng


def dissect(tshark: Tshark, dissector: str, packets: list[bytes], folder: Path) -> list[str]:
    """Return the protocol and info columns of packets handed to a dissector by name."""
    capture = folder / "cut.pcapng"
    interface = pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, "cut")
    blocks = [pcapng.section_header("", ""), pcapng.interface_description(interface)]
    blocks += [
        pcapng.enhanced_packet(0, number, pcapng.upper_pdu(dissector, packet)) for number, packet in enumerate(packets)
    ]
    capture.write_bytes(b"".join(blocks))
    columns = ("-T", "fields", "-e", "_ws.col.Protocol", "-e", "_ws.col.Info")
    return tshark.output("-r", str(capture), "-V", *columns).splitlines()


def test_every_beginning_of_every_telegram(tshark: Tshark, tmp_path: Path) -> None:
    telegrams = [item.data for item in Scenario(HERE / "specification.txt").items]
    beginnings = [(telegram, end) for telegram in telegrams for end in range(1, len(telegram))]
    infos = dissect(tshark, "sis", [telegram[:end] for telegram, end in beginnings], tmp_path)
    assert len(infos) == len(beginnings)
    for (telegram, end), info in zip(beginnings, infos, strict=True):
        mark = f"Cut telegram, {end} of at least 8 bytes" if end < 8 else f"[cut: {end} of {len(telegram)} bytes]"
        assert info.startswith("SIS\t"), info
        assert mark in info


def test_every_beginning_of_every_record(tshark: Tshark, tmp_path: Path) -> None:
    scenario = Scenario(HERE / "records.txt")
    records = [item.record(None) for item in scenario.items if item.raw is None]
    beginnings = [record[:end] for record in records for end in range(len(record))]
    infos = dissect(tshark, "sertap", beginnings, tmp_path)
    assert len(infos) == len(beginnings)
    assert not [info for info in infos if "Malformed" in info or "bug" in info]


# Of the last packet: nothing, half a word, its head, some of its data, and all but a byte.
@pytest.mark.parametrize("ends", [(0, 2, 8, 30, -1), pytest.param(None, marks=pytest.mark.thorough)])
def test_capture_file_cut_in_a_packet(ends: tuple[int, ...] | None, tshark: Tshark, tmp_path: Path) -> None:
    """A capture that is cut off opens up to its last whole packet; `ends` is every byte if None."""
    whole = (HERE / "user0.pcapng").read_bytes()
    blocks = []
    offset = 0
    while offset < len(whole):
        blocks.append(offset)
        offset += int.from_bytes(whole[offset + 4 : offset + 8], "little")
    size = len(whole) - blocks[-1]
    capture = tmp_path / "cut.pcapng"
    for end in range(size) if ends is None else ends:
        capture.write_bytes(whole[: blocks[-1] + end % size])
        done = tshark.run(
            [
                "-r",
                str(capture),
                "-o",
                r'uat:user_dlts:"User 0 (DLT=147)","sis","0","","0",""',
                "-T",
                "fields",
                "-e",
                "sis.receiver",
            ]
        )
        assert done.stdout.split() == ["3"], end


# What a packet is called that is damaged on the wire, by the name of its dissector.
DAMAGED = ("_ws.malformed", "sertap.truncated", "sis.length.short", "3964r.broken", "synax.short")
SNAPPED = {"records": "sertap", "3964r": "sertap"} | {name: name for name in ("arcnet7f", "synaxpk", "rk512i")}


def damages(tshark: Tshark, dissector: str, packets: list[Packet], folder: Path) -> list[tuple[bool, set[str]]]:
    """Tell of each packet whether the capture has cut it, and which damage it is said to have."""
    bad_input.write(folder / "snapped.pcapng", packets, dissector)
    columns = [word for field in ("_ws.short", *DAMAGED) for word in ("-e", field)]
    lines = tshark.output("-r", str(folder / "snapped.pcapng"), "-T", "fields", *columns).splitlines()
    rows = [line.split("\t") for line in lines]
    return [(bool(short), {name for name, cell in zip(DAMAGED, cells, strict=True) if cell}) for short, *cells in rows]


def packets_of(name: str) -> list[bytes]:
    """Return whole packets of a capture; the blocks of 3964R without their last three bytes are RK512."""
    if name == "rk512i":
        return [item.data[:-3] for item in Scenario(HERE / "3964r.txt").items if len(item.data) > 3]
    items = Scenario(HERE / f"{name}.txt").items
    return [item.record(None) for item in items if SNAPPED[name] != "sertap" or item.raw is None]


@pytest.mark.parametrize("name", SNAPPED)
def test_what_the_capture_has_cut_is_not_damaged(name: str, tshark: Tshark, tmp_path: Path) -> None:
    """A packet of which the capture has only the beginning has the damage of the whole packet at most."""
    packets = [Packet(data[:end], len(data)) for data in packets_of(name) for end in range(1, len(data) + 1)]
    found = damages(tshark, SNAPPED[name], packets, tmp_path)
    assert len(found) == len(packets) > 50
    wrong = []
    damage: set[str] = set()
    for packet, (is_short, is_said) in reversed(list(zip(packets, found, strict=True))):
        is_whole = len(packet.data) == packet.original
        if is_whole:
            damage = is_said
        if is_short == is_whole or not is_said <= damage:
            wrong.append(f"{packet.data.hex(' ')}, {len(packet.data)} of {packet.original}: {is_short} {is_said}")
    assert not wrong, "\n".join(wrong)


def shown_of(tshark: Tshark, field: str, dissector: str, packets: list[Packet | bytes], folder: Path) -> list[str]:
    """Return a field of each packet; empty where it is not there."""
    bad_input.write(folder / "some.pcapng", packets, dissector)
    return tshark.output("-r", str(folder / "some.pcapng"), "-T", "fields", "-e", field).splitlines()


def test_list_of_which_the_capture_has_cut_a_piece(tshark: Tshark, tmp_path: Path) -> None:
    """12 bytes and two length words: 4 bytes in the first telegram, 4 in each of its two follow-ups (page 7-20)."""
    first = bytes.fromhex("7F 10 80 00 05 07 00 01 00 02 01 3C 00 0C 00 20 00 01 02 03 04")
    second, third = (bytes.fromhex(f"7F {number} 1C 00 05 02 00 05 06 07 08") for number in ("20", "21"))
    cut = Packet(second[:9], len(second))
    packets: list[Packet | bytes] = [first, second, third, first, cut, third, first, second, third]
    assert shown_of(tshark, "synax.pieces.length", "arcnet7f", packets, tmp_path) == [*[""] * 2, "16", *[""] * 5, "16"]
    notes = shown_of(tshark, "synax.note", "arcnet7f", packets, tmp_path)
    assert [number for number, note in enumerate(notes, 1) if note] == [6]


def test_telegram_of_which_the_capture_has_cut_a_fragment(tshark: Tshark, tmp_path: Path) -> None:
    """A telegram in two fragments of 4 bytes; the cyclic data may repeat the first."""
    first = bytes.fromhex("004B 02D90000 000000000000")
    last = bytes.fromhex("044B 00121003 000000000000")
    cut = Packet(first[:8], len(first))
    packets: list[Packet | bytes] = [first, last, first, first, last, cut, last, first, cut, last, first, last]
    receivers = shown_of(tshark, "sis.receiver", "synaxpk", packets, tmp_path)
    assert [number for number, receiver in enumerate(receivers, 1) if receiver] == [2, 5, 12]


def test_equal_beginnings_of_blocks_are_no_repeat(tshark: Tshark, tmp_path: Path) -> None:
    """The rest, which the capture has cut, may differ."""
    block = bytes.fromhex("00 00 00 00 00 07 10 03 14")
    packets: list[Packet | bytes] = [
        Packet(block[:6], len(block)),
        Packet(block[:6], len(block)),
        block[:6],
        block,
        block,
    ]
    assert shown_of(tshark, "3964r.repeat_of", "3964r", packets, tmp_path) == ["", "", "", "", "4"]


@pytest.mark.parametrize("has_all", [True, False])
def test_limit_that_the_capture_has_cut(has_all: bool, tshark: Tshark, tmp_path: Path) -> None:
    """The beginning of a number is another number: 8 of 80 ms."""
    (tmp_path / "told.txt").write_text("event 6 TzA = 80 ms, TrS = 40 ms\ncommand 16>3 12\n")
    event, telegram = (item.record(None) for item in Scenario(tmp_path / "told.txt").items)
    told = event[: event.index(b"80 ms") + 1]
    packets = [event if has_all else Packet(told, len(event)), telegram]
    limits = shown_of(tshark, "sis.tza.limit", "sertap", packets, tmp_path)
    assert limits == ["", "0.080000000" if has_all else ""]
