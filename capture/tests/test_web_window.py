# SPDX-License-Identifier: GPL-2.0-or-later
"""What a page shows of a live capture: all of it, and the last records, after what the bus had told before them."""

from __future__ import annotations

import io

import pcapng as reader

from sistap.files.pcapng import LINKTYPE_WIRESHARK_UPPER_PDU, Interface
from sistap.line.settings import LineSettings
from sistap.records.record import Event, Record, Type, unpack
from sistap.sis.telegram import build
from sistap.web.play import Play
from sistap.web.window import MOST, Window

MS = 1_000_000
NAME_OF_S36 = (
    build(0x10, 16, 3, bytes.fromhex("14 05 00 24 00")),
    build(0x10, 16, 3, b"\x00\x14\x05Speed", reaction=True),
)


def record(place: int, telegram: bytes) -> Record:
    return Record(place * MS, Type.FRAME, 0, LineSettings(), telegram, [0] * len(telegram), bytes(len(telegram)), 0)


def shown(capture: bytes) -> list[Record]:
    """Read a capture back; the record stands behind the tags of the link type."""
    packets = [b for b in reader.FileScanner(io.BytesIO(capture)) if isinstance(b, reader.blocks.EnhancedPacket)]
    return [unpack(b.packet_data[b.packet_data.index(b"\x01\x14") :]) for b in packets]


def test_the_last_records_come_after_what_was_told_before() -> None:
    window = Window({0: Interface(LINKTYPE_WIRESHARK_UPPER_PDU, "page")}, [])
    for place, telegram in enumerate(NAME_OF_S36):
        window.add(record(place, telegram))
    assert window.before == 0
    for place in range(2, MOST + 1):
        window.add(record(place, NAME_OF_S36[0]))
    assert window.left_out == MOST // 2
    first, *others = shown(window.capture())
    assert first.event == Event.TOLD_BEFORE
    assert first.data.decode() == "3 device 5 S-0-0036 name Speed"
    assert len(others) == MOST + 1 - MOST // 2
    assert window.before == 1


def test_the_bus_plays_into_the_page() -> None:
    played = Play("demo", 1)
    capture = played.step(2.0) + played.end()
    assert [one.type for one in shown(capture)].count(Type.FRAME) > 10
    assert shown(played.window()) == shown(capture)[: len(shown(played.window()))]
