# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap import` run in a test, and the records of what it wrote."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import pytest

from sistap import cli
from sistap.captures.reading import packets, record_of
from sistap.records.record import Record, Type
from sistap.wireshark.tshark import Tshark


class Imported(NamedTuple):
    """What an import has left behind."""

    code: int
    records: list[Record]  # without events
    events: list[str]


@contextmanager
def _each_reading_once() -> Iterator[None]:
    """Answer repeated identical queries of a capture from memory: an import reads a USB capture twice."""
    said: dict[tuple[bytes, tuple[str, ...]], list[str]] = {}
    ask = Tshark.lines

    def lines(self: Tshark, arguments: Sequence[str]) -> Generator[str, None, None]:
        key = Path(arguments[arguments.index("-r") + 1]).read_bytes(), tuple(arguments)
        if key not in said:
            rows = []
            for row in ask(self, arguments):
                rows.append(row)
                yield row
            said[key] = rows
        else:
            yield from said[key]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(Tshark, "lines", lines)
        yield


def run(source: Path, *options: str) -> Imported:
    """Import a file."""
    out = source.with_name(source.name + ".imported")
    with _each_reading_once():
        code = cli.main(["import", str(source), "-w", str(out), "--force", *options])
    records = list(filter(None, map(record_of, packets(out)))) if out.exists() else []
    events = [record.data.decode() for record in records if record.type == Type.EVENT]
    return Imported(code, [record for record in records if record.type != Type.EVENT], events)
