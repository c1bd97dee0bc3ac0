# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads capture files with an independent reader (python-pcapng), which does not share the faults of ours."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from pcapng import FileScanner
from pcapng.blocks import EnhancedPacket

from sistap.tap.records.record import Record, unpack

# An exported PDU: tag 12 with the dissector's name (6, padded to 8), the end tag, then the record.
_WRAPPER = bytes.fromhex("000C0008") + b"sertap\0\0" + bytes(4)


class Packet(NamedTuple):
    """A packet of sistap."""

    record: Record
    interface: int
    flags: int


def blocks(path: Path) -> list[Any]:
    """Return all blocks of a file; an error if it does not end with a whole one."""
    with path.open("rb") as stream:
        return list(FileScanner(stream))


def packets(path: Path) -> list[Packet]:
    """Return all packets of a file, which must be records."""
    return [_packet(block) for block in blocks(path) if isinstance(block, EnhancedPacket)]


def records(path: Path) -> list[Record]:
    """Return all records of a file."""
    return [packet.record for packet in packets(path)]


def record_of(block: Any) -> Record:
    """Return the record in a packet block."""
    assert block.packet_data.startswith(_WRAPPER)
    return unpack(block.packet_data.removeprefix(_WRAPPER), block.timestamp_high << 32 | block.timestamp_low)


def _packet(block: Any) -> Packet:
    flags = block.options.get_raw("epb_flags") if "epb_flags" in block.options else b""
    return Packet(record_of(block), block.interface_id, int.from_bytes(flags, "little"))
