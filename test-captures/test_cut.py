# SPDX-License-Identifier: GPL-2.0-or-later
"""Telegrams, records and files with any end."""

from __future__ import annotations

from pathlib import Path

import pytest

from make import HERE, Scenario
from sistap.files import pcapng
from sistap.wireshark.tshark import Tshark


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
                "sis.dlt_user:user0",
                "-T",
                "fields",
                "-e",
                "sis.receiver",
            ]
        )
        assert done.stdout.split() == ["3"], end
