# SPDX-License-Identifier: GPL-2.0-or-later
"""The parameter channel of Profibus: words, error answers, fragments, telegrams of SIS, and IndraDrive's own channel.

The tables are worked out by hand from chapter 3 of DOK-SYNAX*-SY*-08V*2/2-FK01-DE-P and, for the bits of the word,
from chapter 11 of FLP-04VRS.
"""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

import bad_input
from make import Scenario
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from tables import HERE, Table, check, shown

NAMES = ("error", "read", "busy", "last", "bit9", "toggle", "count", "format")

# The words that are printed (SYNAX figures 3-4, 3-8, 3-9, 3-12; FLP pages 11-12 to 11-16), by their first frame: error,
# read, bit 11, last, bit 9, toggle; count; format.
WORDS = {
    1: (0x000F, "000000", 0, 0xF),
    4: (0x2700, "100111", 0, 0x0),
    5: (0x0100, "000001", 0, 0x0),
    8: (0x3781, "110111", 8, 0x1),
    9: (0x1F80, "011111", 8, 0x0),
    11: (0x079B, "000111", 9, 0xB),
    12: (0x010B, "000001", 0, 0xB),
    15: (0x058B, "000101", 8, 0xB),
    16: (0x050B, "000101", 0, 0xB),
    17: (0x140B, "010100", 0, 0xB),
    18: (0x10AB, "010000", 10, 0xB),
    19: (0x150B, "010101", 0, 0xB),
    20: (0x154B, "010101", 4, 0xB),
    21: (0x01AB, "000001", 10, 0xB),
    23: (0x042B, "000100", 2, 0xB),
    24: (0x040B, "000100", 0, 0xB),
    26: (0x152B, "010101", 2, 0xB),
    27: (0x252B, "100101", 2, 0xB),
}

FIELDS = (
    "synaxpk.sender sis.parameter sis.error synaxpk.class synaxpk.class.code synaxpk.code synaxpk.sis.length "
    "synaxpk.sis.service sis.service sis.data sis.raw synaxpk.payload synaxpk.beyond synax.pieces.piece "
    "synax.pieces.whole_in"
)
EXPERTS = "synax.note synax.short synax.unexpected synax.error"

MASTER, SLAVE = "synaxpk.sender=1", "synaxpk.sender=2"
ERROR = "synaxpk.class=0x70; synaxpk.class.code=0x07; sis.error=0x7007; synax.error"
SWITCH = "sis.service=0x9d; synaxpk.beyond=00"
ZEROS = "00" * 10

CHANNEL: Table = {
    **dict.fromkeys((1, 4, 6, 17, 19, 25, 35, 38), MASTER),
    **dict.fromkeys((2, 3, 5, 7, 12, 14, 16, 22, 24), SLAVE),
    # A-0-0011: 0x7007; busy with P-0-0092 (0x805c: bit 15, 0x5c = 92); two bytes "xx xx" follow each
    8: f"{SLAVE}; sis.parameter=A-0-0011; {ERROR}; sis.raw=0000; synax.note",
    9: f"{SLAVE}; sis.parameter=P-0-0092; synaxpk.class=0x00; synaxpk.class.code=0x08; sis.raw=0000; synax.note",
    10: f"{SLAVE}; synaxpk.beyond=000000000000",
    11: f"{MASTER}; {SWITCH}",
    13: f"{MASTER}; synaxpk.sis.length=3; synaxpk.sis.service=0x9d; sis.raw=000104; synax.note",
    # FLP's text is no telegram
    15: f"{MASTER}; sis.raw=3f204e3030303020; synax.note",
    18: f"{SLAVE}; synaxpk.payload=23204e30303030204e4f; synax.pieces.whole_in=20",
    20: (
        f"{SLAVE}; synaxpk.payload=50202020; synax.pieces.piece=18,20; sis.raw=23204e30303030204e4f50202020; "
        "synax.note"
    ),
    21: f"{MASTER}; synaxpk.payload=23204e30303030204e4f; synax.pieces.whole_in=23",
    23: f"{MASTER}; synaxpk.payload=5020; synax.pieces.piece=21,23; sis.raw=23204e30303030204e4f5020; synax.note",
    26: f"{SLAVE}; sis.raw=5920; synax.note",
    27: f"{SLAVE}; synaxpk.code=0x010c; synax.error",
    # A telegram in two fragments, that are there more than once
    28: f"{MASTER}; synaxpk.beyond={ZEROS}",
    29: f"{MASTER}; synaxpk.payload=02fb0505009000013c00; synax.pieces.whole_in=33",
    30: f"{MASTER}; synaxpk.payload=02fb0505009000013c00",
    31: f"{SLAVE}; synaxpk.beyond={ZEROS}",
    32: f"{MASTER}; synaxpk.payload=02fb0505009000013c00",
    33: (
        f"{MASTER}; synaxpk.payload=002c00; synaxpk.beyond=00009000013c00; synax.pieces.piece=29,33; "
        "sis.service=0x90; sis.parameter=S-0-0044"
    ),
    34: f"{MASTER}; synaxpk.payload=002c00; synaxpk.beyond=00009000013c00",
    36: f"{MASTER}; {SWITCH}",
    37: f"{MASTER}; synaxpk.payload=025a0101009d000104; synaxpk.beyond=00",
    39: f"{MASTER}; {SWITCH}",
    # Codes of the channel; 0x7007 is none, so its place is not certain
    40: f"{SLAVE}; synaxpk.code=0x0085; synax.error",
    41: f"{SLAVE}; synaxpk.code=0x009d; synax.error",
    42: f"{SLAVE}; synaxpk.code=0x01ff; synax.error",
    43: f"{SLAVE}; synaxpk.code=0x008b; synax.error; sis.raw=1234; synax.note",
    44: f"{SLAVE}; sis.raw=7007; synax.note",
    45: f"{SLAVE}; sis.raw=00; synax.short",
    # Short format 1
    46: f"{MASTER}; sis.raw=805c0000; synax.note",
    47: f"{SLAVE}; sis.raw=000b; sis.data=010203040506; synax.note",
    48: f"{SLAVE}; sis.raw=000b; synax.note",
    49: (
        f"{SLAVE}; sis.parameter=S-0-0044; synaxpk.class=0x80; synaxpk.class.code=0x01; sis.error=0x8001; synax.error; "
        "sis.raw=00000000; synax.note; synaxpk.beyond=0000"
    ),
    50: (
        f"{SLAVE}; sis.parameter=A-0-0011; synaxpk.class=0x12; synaxpk.class.code=0x34; sis.error=0x1234; synax.error; "
        "sis.raw=0000; synax.note"
    ),
    # Without a direction
    52: f"sis.parameter=A-0-0011; {ERROR}; synax.short",
    53: "sis.raw=3f204e3030303020; synax.note",
    54: "synaxpk.payload=3f204e3030303020",
    56: "sis.raw=3f204e3030303020; synax.note",
    57: "sis.raw=805c0000; synax.note",
    58: "sis.raw=1234; synax.note",
    59: "sis.raw=1234; synax.note",
    60: "sis.raw=1234; synax.note",
    62: "sis.raw=00010203040506070809; synax.note",
    # Cut
    63: "sis.raw=00; synax.short",
    64: f"{SLAVE}; sis.raw=00; synax.short",
    65: f"{SLAVE}; sis.parameter=A-0-0011; sis.raw=70; synax.short",
    66: f"{SLAVE}; sis.parameter=A-0-0011; synax.short",
    67: f"{SLAVE}; sis.raw=00; synax.short",
    68: f"{SLAVE}; sis.raw=805c; sis.data=00; synax.short; synax.note",
    69: f"{SLAVE}; synaxpk.payload=025a01; synax.short",
    70: f"{SLAVE}; sis.raw=5a0101",  # the telegram itself is too short
    71: f"{SLAVE}; sis.raw=02; synax.note",
    72: f"{SLAVE}; synaxpk.sis.length=3",
    73: f"{SLAVE}; synaxpk.payload=02fb05050090; synax.short",
    74: f"{SLAVE}; sis.raw=002c00; synax.note",  # it goes on with nothing
    # More than six words
    75: f"{SLAVE}; synaxpk.beyond={ZEROS}; sis.raw=01; synax.unexpected",
    76: (
        f"{SLAVE}; synaxpk.sis.length=1; synaxpk.sis.service=0x9d; sis.raw=000104000000,1234; synax.note; "
        "synax.unexpected"
    ),
}

DRIVE_FIELDS = (
    "synaxpk.drive.pf synaxpk.drive.error synaxpk.drive.last synaxpk.drive.toggle synaxpk.drive.fragment "
    "synaxpk.drive.length synaxpk.index synaxpk.subindex sis.parameter synaxpk.payload synaxpk.beyond synaxpk.word "
    "sis.raw"
)


def drive(bits: str, fragment: int, length: int) -> str:
    """Write the bits of IndraDrive's word: PF, G or F, L, T; FL, GL."""
    names = ("pf", "error", "last", "toggle")
    flags = "; ".join(f"synaxpk.drive.{name}={bit}" for name, bit in zip(names, bits, strict=True))
    return f"{flags}; synaxpk.drive.fragment={fragment}; synaxpk.drive.length={length}"


S57 = "synaxpk.index=0x2039; synaxpk.subindex=7; sis.parameter=S-0-0057"

INDRADRIVE: Table = {
    1: drive("0110", 0, 0),
    2: f"{drive('0010', 2, 2)}; synaxpk.payload=0100",
    3: f"{drive('0111', 4, 4)}; {S57}",
    4: f"{drive('0011', 4, 4)}; synaxpk.payload=00000064",
    5: f"{drive('0110', 2, 2)}; synaxpk.payload=009d; synax.error",
    6: f"{drive('0000', 4, 8)}; synaxpk.payload=01020304",
    7: f"{drive('0011', 4, 4)}; synaxpk.index=0x1000; synaxpk.subindex=1",
    8: f"{drive('1010', 4, 4)}; synaxpk.payload=20390007; synax.note",
    9: f"{drive('0111', 4, 4)}; synaxpk.payload=20390007",
    10: "sis.raw=74; synax.short",
    11: f"{drive('0111', 4, 4)}; synaxpk.payload=2039; synax.short",
    12: f"{drive('0111', 4, 4)}; {S57}; synaxpk.beyond=0000",
}


def test_words(tshark: Tshark) -> None:
    fields = "synaxpk.word " + " ".join(f"synaxpk.word.{name}" for name in NAMES)
    frames = shown(tshark, HERE / "synaxpk.pcapng", fields, prefix="")
    for number, (word, flags, count, form) in WORDS.items():
        values = [*map(int, flags), count, form]
        expected = {f"synaxpk.word.{name}": value for name, value in zip(NAMES, values, strict=True)}
        found = {name: int(value, 0) for name, value in frames[number].items()}
        assert found == expected | {"synaxpk.word": word}, number


def test_channel(tshark: Tshark) -> None:
    check(tshark, "synaxpk", FIELDS, EXPERTS, CHANNEL, prefix="")


def test_indradrive(tshark: Tshark) -> None:
    options = ("-o", "synaxpk.layout:indradrive")
    check(tshark, "synaxpk-indradrive", DRIVE_FIELDS, EXPERTS, INDRADRIVE, *options, prefix="")


@pytest.mark.parametrize(("direction", "sender"), [("master", "1"), ("slave", "2")])
def test_direction(direction: str, sender: str, tshark: Tshark) -> None:
    """The preference goes before what the packets say."""
    options = ("-o", f"synaxpk.direction:{direction}")
    frames = shown(tshark, HERE / "synaxpk.pcapng", "synaxpk.sender", *options, prefix="")
    assert {frame.get("synaxpk.sender") for number, frame in frames.items() if number != 63} == {sender}


@pytest.mark.thorough
@pytest.mark.parametrize("passes", [(), ("-2",)], ids=["one_pass", "two_passes"])
def test_more_fragments_than_are_joined(passes: tuple[str, ...], tshark: Tshark, tmp_path: Path) -> None:
    """8,192 fragments of 4 bytes are joined; of 8,194 the last two have a note."""
    for count, length, noted in ((8192, "32768", []), (8194, None, [8193, 8194])):
        words = [0x004B] * (count - 1) + [0x044B]
        packets = [struct.pack(">HI6x", word, number) for number, word in enumerate(words)]
        bad_input.write(tmp_path / "many.pcapng", packets, "synaxpk")
        fields = "synax.pieces.length synax.pieces.too_many"
        frames = shown(tshark, tmp_path / "many.pcapng", fields, *passes, prefix="")
        assert frames[count].get("synax.pieces.length") == length
        assert [number for number, frame in frames.items() if "synax.pieces.too_many" in frame] == noted


@pytest.mark.thorough
@pytest.mark.parametrize("layout", ["synax", "indradrive"])
@pytest.mark.parametrize("passes", [(), ("-2",)], ids=["one_pass", "two_passes"])
def test_every_cut(passes: tuple[str, ...], layout: str, tshark: Tshark, tmp_path: Path) -> None:
    """Every packet of the capture, cut after each of its bytes: never an exception."""
    items = Scenario(HERE / "synaxpk.txt").items
    cut = [item.raw[:length] for item in items if item.raw for length in range(1, len(item.raw))]
    capture = tmp_path / "cut.pcapng"
    link = pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, "cut")
    packets = [
        pcapng.enhanced_packet(0, number * 1_000_000, pcapng.upper_pdu("synaxpk", data), number % 3)
        for number, data in enumerate(cut)
    ]
    capture.write_bytes(b"".join([pcapng.section_header("test", ""), pcapng.interface_description(link), *packets]))
    text = tshark.output("-r", str(capture), *passes, "-o", f"synaxpk.layout:{layout}", "-V", "-O", "synaxpk")
    assert text.count("Rexroth SYNAX200 parameter channel") == len(cut)
    assert "[Malformed Packet" not in text
    assert "Dissector bug" not in text
