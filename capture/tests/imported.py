# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap import` run in a test, and the records of what it wrote."""

from __future__ import annotations

import struct
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import pytest
from usb_captures import USBMON, USBMON_SHORT, USBPCAP

from sistap import cli
from sistap.dissected.captures.reading import packets, record_of
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.records.record import Record, Type


class Imported(NamedTuple):
    """What an import has left behind."""

    code: int
    records: list[Record]  # without events
    events: list[str]


# The beginnings of captures that usb_captures makes, and what tshark says of the protocols of their packets.
_LINK_TYPES = (USBMON_SHORT, USBMON, USBPCAP)
USB = {struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 262144, link_type) for link_type in _LINK_TYPES}
USB_PROTOCOLS = ["usb"]


@contextmanager
def _each_reading_once() -> Iterator[None]:
    """Answer what is known without another tshark: a capture is read twice, and what was made here is USB.

    Real captures, which test_import_real.py reads, are recognised by tshark.
    """
    said: dict[tuple[bytes, tuple[str, ...]], list[str]] = {}
    ask = Tshark.lines

    def lines(self: Tshark, arguments: Sequence[str]) -> Generator[str, None, None]:
        capture = Path(arguments[arguments.index("-r") + 1]).read_bytes()
        key = capture, tuple(arguments)
        if arguments[-1] == "frame.protocols" and capture[:24] in USB:
            said.setdefault(key, USB_PROTOCOLS)
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
