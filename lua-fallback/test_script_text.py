# SPDX-License-Identifier: GPL-2.0-or-later
"""sis.lua shows text from elsewhere like the C plugin: nothing in it moves the text beside it."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

import parity
from sistap.files import pcapng
from sistap.line.settings import LineSettings
from sistap.records.record import Event, Record, Type
from sistap.sis.telegram import build
from sistap.wireshark.tshark import Tshark

# Control characters of ASCII and Latin-1, marks of text direction, invisible characters, line ends. Then bytes that are
# not UTF-8: cut off, too long for their value, surrogates, above the last character.
CHARACTERS = [
    *(chr(code) for code in (*range(0x20), 0x22, 0x5C, *range(0x7F, 0xA2), 0xAD)),
    *"\u061c\u200b\u200e\u200f\u2028\u2029\u202a\u202e\u2066\u2069\ufeff\ufff9\ufffd\ufffe\ue000",
    *"ä€\u0300\U0001f600\U000e0001\U0010ffff",
]
LONG = """
c080 c1bf e08080 e0809f e09fbf eda080 edbfbf f0808080 f08fbfbf f4908080 f5808080 f8808080
bfbf c341 e282 e28241 e2c3a4 f09f98 f09f9841 e282e282ac
"""
NO_UTF_8 = [*(bytes([byte]) for byte in range(0x80, 0x100)), *map(bytes.fromhex, LONG.split())]


def texts() -> list[bytes]:
    chance = random.Random(1)
    pieces = [character.encode() for character in CHARACTERS] + NO_UTF_8
    # Separate: together they could form a character that only some versions of GLib know.
    mixed = [b"-".join(chance.choices(pieces, k=6)) for _ in range(100)]
    return [b"a" + piece + b"z" for piece in pieces] + mixed


def write(capture: Path, records: list[Record]) -> None:
    interface = pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, "hostile")
    blocks = [pcapng.section_header("", ""), pcapng.interface_description(interface)]
    blocks += [
        pcapng.enhanced_packet(0, number, pcapng.upper_pdu("sertap", record.pack()))
        for number, record in enumerate(records)
    ]
    capture.write_bytes(b"".join(blocks))


@pytest.mark.thorough
@pytest.mark.attack("the same in events and telegrams, in Wireshark", "escapes, the same in plugin and script")
def test_of_events(plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """In the packet list and in the expert items."""
    records = [Record(0, Type.EVENT, 0, LineSettings(), text, event=Event.ADAPTER_LOST) for text in texts()]
    write(tmp_path / "events.pcapng", records)
    parity.check(plugin, script, tmp_path / "events.pcapng")


@pytest.mark.thorough
@pytest.mark.attack("the same in events and telegrams, in Wireshark", "escapes, the same in plugin and script")
def test_of_the_line(plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """Beside telegrams, and in them: a drive's description of itself (0x00, identification)."""
    records = []
    for text in texts():
        for kind, data in ((Type.OTHER, text), (Type.FRAME, build(0x00, 16, 3, b"\0\0\x03" + text, reaction=True))):
            records.append(Record(0, kind, 0, LineSettings(), data, [0] * len(data), bytes(len(data))))
    write(tmp_path / "line.pcapng", records)
    parity.check(plugin, script, tmp_path / "line.pcapng")
