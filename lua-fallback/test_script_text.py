# SPDX-License-Identifier: GPL-2.0-or-later
"""sis.lua shows text from elsewhere like the C plugin: nothing in it moves the text beside it."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

import parity
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.record import Event, Framing, Record, Type
from sistap.tap.sis.telegram import build

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


# Pieces of the ASCII protocol, good and bad.
PIECES = (
    *(b"BCD:", b"21", b"255", b"256", b"E", b":>", b"S-0-0051", b"P-0-4095", b"S-0-4096", b"S-0-0390.0.136"),
    *(b"A-0-0004", b"C-7-0001", b",", b"7", b"1", b"8", b"R", b"W", b"W,", b">", b"?", b"<", b"#", b"-", b".", b"12"),
    *(b"\0", b"\xe4", b"%", b"\\"),
)


def test_lines_of_the_ascii_protocol(plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """1,000 random lines, and every cut of some good ones."""
    chance = random.Random(2)
    lines = [b"".join(chance.choices(PIECES, k=chance.randint(1, 6))) + b"\r\n" for _ in range(1000)]
    for whole in (b"BCD:21\r\n", b"E21:>", b"S-0-0390.0.136,7,R\r\n", b"P-0-4006,7,W,-12.5000\r\n", b"?1.0\r\n"):
        lines += [whole[:length] for length in range(1, len(whole) + 1)]
    records = [
        Record(0, Type.FRAME, 0, LineSettings(), line, [0] * len(line), bytes(len(line)), framing=Framing.ASCII)
        for line in lines
    ]
    write(tmp_path / "lines.pcapng", records)
    parity.check(plugin, script, tmp_path / "lines.pcapng")
    assert len(plugin.output("-r", str(tmp_path / "lines.pcapng"), "-Y", "sisascii.kind").splitlines()) == len(lines)
