# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap import` run in a test, and the records of what it wrote."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from sistap import cli, pcapng
from sistap.record import Record, Type, unpack


class Imported(NamedTuple):
    """What an import has left behind."""

    code: int
    records: list[Record]  # without events
    events: list[str]


def run(source: Path, *options: str) -> Imported:
    """Import a file."""
    out = source.with_name(source.name + ".imported")
    code = cli.main(["import", str(source), "-w", str(out), *options])
    records = list(_records(out.read_bytes())) if out.exists() else []
    events = [record.data.decode() for record in records if record.type == Type.EVENT]
    return Imported(code, [record for record in records if record.type != Type.EVENT], events)


def _records(data: bytes) -> Iterator[Record]:
    at = 0
    while at < len(data):
        kind, length = struct.unpack_from("<II", data, at)
        if kind == pcapng.ENHANCED_PACKET:
            high, low, size = struct.unpack_from("<III", data, at + 12)
            packet = data[at + 28 : at + 28 + size]
            yield unpack(packet.removeprefix(pcapng.upper_pdu("sertap", b"")), (high << 32) + low)
        at += length
