# SPDX-License-Identifier: GPL-2.0-or-later
"""What a page shows of a live capture: all of it, and the last records, after what the bus had told before them."""

from __future__ import annotations

import io
from pathlib import Path

import pcapng as reader
import pytest

from sisbus.scenarios import scenario
from sistap.cli import main
from sistap.commands.web.play import Play
from sistap.commands.web.window import MOST, Window
from sistap.tap.files.pcapng import LINKTYPE_WIRESHARK_UPPER_PDU, Interface
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.record import Record, Type, unpack
from sistap.tap.sis.telegram import build

MS = 1_000_000
MOST_AT_THE_END = 2000  # bytes of the last telegrams, and of the counters
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
    command, reaction, *others = shown(window.capture())
    assert [(one.type, one.data) for one in (command, reaction)] == [(Type.BEFORE, one) for one in NAME_OF_S36]
    assert len(others) == MOST + 1 - MOST // 2
    assert window.before == 2


@pytest.mark.parametrize("name", [name for name in scenario.names() if scenario.load(name).is_complete])
def test_live_plays_the_bytes_of_the_command(name: str, tmp_path: Path) -> None:
    """The command also plays what begins before the end."""
    file = tmp_path / "bus.pcapng"
    assert main(["bus", name, "-w", str(file), "--seed", "7", "--duration", "4"]) == 0
    written, played = file.read_bytes(), Play(name, 7)
    live = b"".join(played.step(place / 5) for place in range(21))
    assert written.startswith(live)
    assert len(written) - len(live) < MOST_AT_THE_END


def test_the_bus_plays_into_the_page() -> None:
    played = Play("demo", 1)
    capture = played.step(2.0) + played.end()
    assert [one.type for one in shown(capture)].count(Type.FRAME) > 10
    assert shown(played.window()) == shown(capture)[: len(shown(played.window()))]
