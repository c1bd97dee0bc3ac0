# SPDX-License-Identifier: GPL-2.0-or-later
"""Cuts a capture into the files of a ring, as `sistap capture` does it, and shows what each record is decoded to."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from sistap.dissected.captures import reading
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files.output import Limits, Output
from sistap.tap.files.pcapng import Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Event, Record, Type, event
from sistap.tap.sis.telegram import is_whole

# What explains telegrams, and what follows from it.
FIELDS = (
    *("sertap.type", "sertap.event", "sis.parameter", "sis.parameter.name", "sis.parameter.unit"),
    *("sis.parameter.minimum", "sis.parameter.maximum", "sis.value", "sis.value.number", "sis.error"),
    *("sis.reaction_time", "sis.bus.baud", "sis.tza.limit", "sis.tza.verdict", "sis.trs.limit", "sis.trs.verdict"),
    "sis.access",
)


class _Short(Output):
    """Files of so many blocks."""

    def __init__(self, path: Path, blocks: int) -> None:
        super().__init__(str(path), Limits(several=True))
        self._blocks = blocks
        self._written = 0

    @property
    def full(self) -> bool:
        return self._written >= self._blocks

    def write(self, block: bytes) -> None:
        self._written += 1
        super().write(block)

    def go_on(self) -> None:
        super().go_on()
        self._written = 0


def records_of(capture: Path) -> list[Record]:
    """Return the records of a capture; damaged telegrams are marked, as the framer marks them."""
    return [
        record._replace(checksum_bad=record.type == Type.FRAME and not is_whole(record.data))
        for record in reading.records(capture)
    ]


def ring(records: Sequence[Record], folder: Path, blocks: int) -> list[Path]:
    """Write records into files of so many blocks."""
    folder.mkdir()
    lines = sorted({record.line for record in records})
    output = _Short(folder / "x.pcapng", blocks)
    writer = PcapngWriter(output, {line: Interface(252, f"line {line}") for line in lines}, Counters())
    writer.begin(event(records[0].time_ns, lines[0], records[0].settings, Event.CAPTURE_STARTED, "from a test"))
    for record in records:
        writer.write(record)
    output.close()
    return sorted(folder.iterdir())


def as_sections(files: Sequence[Path], capture: Path) -> Path:
    """Put files into one, a section each: no section knows anything of another."""
    capture.write_bytes(b"".join(file.read_bytes() for file in files))
    return capture


def shown(tshark: Tshark, capture: Path) -> list[list[str]]:
    """Return the fields of each record, without those that a file begins with."""
    fields = [word for name in FIELDS for word in ("-e", name)]
    rows = [line.split("\t") for line in tshark.lines(["-r", str(capture), "-T", "fields", *fields])]
    return [row for row in rows if row[0] != str(int(Type.BEFORE)) and row[1] != str(int(Event.CAPTURE_STARTED))]
