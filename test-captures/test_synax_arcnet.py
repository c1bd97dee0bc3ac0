# SPDX-License-Identifier: GPL-2.0-or-later
"""The protocol 0x7F on ARCNET: heads, data blocks, requests with their answers, lists in follow-ups.

The tables are worked out by hand from chapter 7 of DOK-SYNAX*-SY*-08V*2/2-FK01-DE-P.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from make import Scenario
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from tables import HERE, Table, check, shown

FIELDS = (
    "arcnet7f.message arcnet7f.command arcnet7f.length arcnet7f.block arcnet7f.word synax.info synax.axis "
    "sis.parameter arcnet7f.list.actual arcnet7f.list.maximum sis.data sis.raw"
)
EXPERTS = "synax.note synax.short synax.unexpected"

FIRST = "arcnet7f.message=0x8010"
TO = f"{FIRST}; arcnet7f.command=0"
FETCH = f"{FIRST}; arcnet7f.command=1"
FINE = "sis.parameter=A-0-0060"
LIST = "synax.info=0x0001; synax.axis=0; sis.parameter=C-0-0013"

TELEGRAMS: Table = {
    # Page 7-14, as printed: 5 words from offset 7 on are 6 bytes of head and 4 of data
    1: f"{TO}; arcnet7f.length=5; arcnet7f.block=99; arcnet7f.word=0x5aa5,0x3412; synax.info=0x0043; sis.data=a55a1234",
    2: f"{TO}; arcnet7f.length=4; synax.info=0x0003; synax.axis=2; {FINE}; sis.data=1000",
    3: f"{FETCH}; arcnet7f.length=3; synax.info=0x0042; arcnet7f.block=101",
    4: f"{TO}; arcnet7f.length=5; synax.info=0x0042; arcnet7f.block=101; sis.data=01000000",
    5: f"{FETCH}; arcnet7f.length=3; synax.info=0x0042; arcnet7f.block=100",
    6: (
        f"{TO}; arcnet7f.length=4; synax.info=0x0042; arcnet7f.block=100; arcnet7f.word=0x0002; sis.data=0200; "
        "synax.note"
    ),
    7: f"{TO}; arcnet7f.length=3; synax.info=0x0043; arcnet7f.block=98",
    8: f"{TO}; arcnet7f.length=4; synax.info=0x0043; arcnet7f.block=116; sis.data=0102",
    9: f"{TO}; arcnet7f.length=4; synax.info=0x0043; arcnet7f.block=117; sis.data=0102; synax.note",
    10: f"{TO}; arcnet7f.length=4; synax.info=0x0043; arcnet7f.block=101; sis.raw=010203; sis.data=0102; synax.note",
    # Not defined: two bits of the info access, 0x0180
    11: f"{TO}; arcnet7f.length=4; synax.info=0x0183; sis.raw=02013c00,1000; synax.note",
    12: f"{FIRST}; arcnet7f.command=2; arcnet7f.length=4; sis.raw=030002013c001000; synax.note",
    13: "arcnet7f.message=0x8011; arcnet7f.command=0; arcnet7f.length=4; sis.raw=030002013c001000; synax.note",
    14: "arcnet7f.message=0x1c1f; arcnet7f.command=0; arcnet7f.length=1; sis.raw=1000; synax.note",
    15: f"{FETCH}; arcnet7f.length=3; sis.raw=020002013c00; synax.note",
    16: f"{TO}; arcnet7f.length=4; sis.raw=030002013c001000; synax.note",
    # Actual length 5, maximum 4; actual length 2 with its 2 bytes; an empty list; nothing at all
    17: f"{TO}; arcnet7f.length=5; {LIST}; sis.data=05000400; synax.note",
    18: f"{TO}; arcnet7f.length=6; {LIST}; arcnet7f.list.actual=2; arcnet7f.list.maximum=16; sis.data=0102",
    19: f"{TO}; arcnet7f.length=5; {LIST}; arcnet7f.list.actual=0; arcnet7f.list.maximum=16",
    20: f"{TO}; arcnet7f.length=3; {LIST}; synax.note",
    21: "arcnet7f.message=0x1c20; arcnet7f.command=0; arcnet7f.length=1; sis.data=1234; synax.note",
    22: "arcnet7f.message=0x1cff; arcnet7f.command=1; arcnet7f.length=0",
    # Cut: what is whole of the head, the other bytes raw
    23: "synax.short",
    24: "sis.raw=10; synax.short",
    25: f"{FIRST}; synax.short",
    26: f"{TO}; synax.short",
    27: f"{TO}; synax.short",
    28: f"{TO}; sis.raw=05; synax.short",
    29: f"{TO}; arcnet7f.length=5; synax.short",
    30: f"{TO}; arcnet7f.length=5; sis.raw=4300630000; synax.short",
    31: f"{TO}; arcnet7f.length=5; arcnet7f.block=99; synax.info=0x0043; sis.data=a5; synax.short",
    # Wrong lengths: 65535 words; 4 for 5; none; 2 words of which no head is made
    32: (
        f"{TO}; arcnet7f.length=65535; arcnet7f.block=99; arcnet7f.word=0x5aa5; synax.info=0x0043; sis.data=a55a; "
        "synax.short"
    ),
    33: (
        f"{TO}; arcnet7f.length=4; arcnet7f.block=99; arcnet7f.word=0x5aa5; synax.info=0x0043; sis.data=a55a; "
        "sis.raw=1234; synax.unexpected"
    ),
    34: f"{TO}; arcnet7f.length=0; sis.raw=430063000000a55a1234; synax.short; synax.unexpected",
    35: f"{TO}; arcnet7f.length=2; sis.raw=43006300; synax.short",
    36: f"{FETCH}; arcnet7f.length=3; sis.raw=02000201; synax.short",
    37: f"{FETCH}; arcnet7f.length=3; synax.info=0x0002; synax.axis=2; {FINE}; sis.raw=1000; synax.unexpected",
    38: ("arcnet7f.message=0x1c20; arcnet7f.command=0; arcnet7f.length=2; sis.data=1234; synax.note; synax.short"),
    39: f"arcnet7f.message=0x1c20; arcnet7f.command=1; arcnet7f.length=3; synax.info=0x0002; synax.axis=2; {FINE}",
    40: (
        "arcnet7f.message=0x1c20; arcnet7f.command=1; arcnet7f.length=3; synax.info=0x0000; synax.axis=0; "
        "sis.parameter=C-0-0013"
    ),
    41: (
        f"{TO}; arcnet7f.length=5; arcnet7f.block=100; arcnet7f.word=0x0002,0x0000; synax.info=0x0043; "
        "sis.data=02000000; synax.note"
    ),
    42: f"{TO}; arcnet7f.length=5; synax.info=0x0011; sis.raw=55020000,01000200; synax.note",
    43: (
        "arcnet7f.message=0x1c20; arcnet7f.command=1; arcnet7f.length=3; synax.info=0x0010; sis.raw=55555555; "
        "synax.note"
    ),
}

LINKS = "synax.request_in synax.answer_in synax.answer_time"
PIECES = "arcnet7f.first_in synax.pieces.piece synax.pieces.length synax.pieces.whole_in"

STATIONS: Table = {
    1: "synax.answer_in=2",
    2: "synax.request_in=1; synax.answer_time=0.025000000",
    # Packet 4 has no answer. Not the answer to 5: from another station, of another axis, in the same direction
    5: "synax.answer_in=9; synax.unanswered_before",
    9: "synax.request_in=5; synax.answer_time=0.100000000",
    # 4 + 14 bytes in two telegrams
    11: "synax.pieces.whole_in=12",
    12: "arcnet7f.first_in=11; synax.pieces.piece=11,12; synax.pieces.length=18",
    # 4 + 8 bytes, fetched in three; an access to a data block comes between
    13: "synax.answer_in=14",
    14: "synax.request_in=13; synax.answer_time=0.025000000; synax.pieces.whole_in=19",
    15: "synax.answer_in=16",
    16: "synax.request_in=15; synax.answer_time=0.025000000; arcnet7f.first_in=14; synax.pieces.whole_in=19",
    17: "synax.answer_in=19",
    19: (
        "synax.request_in=17; synax.answer_time=0.050000000; arcnet7f.first_in=14; synax.pieces.piece=14,16,19; "
        "synax.pieces.length=12"
    ),
    20: "synax.answer_in=21",
    21: "synax.request_in=20; synax.answer_time=0.025000000; synax.pieces.whole_in=23",
    22: "synax.answer_in=23",
    23: (
        "synax.request_in=22; synax.answer_time=0.025000000; arcnet7f.first_in=21; synax.pieces.piece=21,23; "
        "synax.pieces.length=8"
    ),
    # 4 + 3 bytes in whole words; 4 + 2 announced and 10 there
    24: "synax.pieces.whole_in=25",
    25: "arcnet7f.first_in=24; synax.pieces.piece=24,25; synax.pieces.length=8",
    26: "synax.pieces.whole_in=27",
    27: "arcnet7f.first_in=26; synax.pieces.piece=26,27; synax.pieces.length=10; synax.unexpected",
    # Cancelled; a cut follow-up: no list goes on in 30, 32 and 33
    30: "synax.note",
    32: "synax.note; synax.short",
    33: "synax.note",
    34: "synax.pieces.whole_in=35",
    35: "arcnet7f.first_in=34; synax.pieces.piece=34,35; synax.pieces.length=8",
    # A number is left out; after the highest comes the lowest
    37: "synax.pieces.whole_in=39",
    38: "arcnet7f.first_in=37; synax.pieces.whole_in=39",
    39: "arcnet7f.first_in=37; synax.pieces.piece=37,38,39; synax.pieces.length=8; synax.note",
    40: "synax.pieces.whole_in=43",
    41: "arcnet7f.first_in=40; synax.pieces.whole_in=43",
    42: "arcnet7f.first_in=40; synax.pieces.whole_in=43",
    43: "arcnet7f.first_in=40; synax.pieces.piece=40,41,42,43; synax.pieces.length=10",
}

# The data of whole lists, length words first.
WHOLES = {
    12: "0e000001" + "01000200" + "03000400050006000700",
    19: "08000001" + "01000200" + "03000400",
    23: "04000001" + "01000200",
    25: "03000001" + "414243",
    27: "02000001" + "4142",
    35: "04000001" + "01000200",
}

# Without the two bytes of the offset, and with the message number that Wireshark takes for a flag.
BSD: Table = {
    1: f"{TO}; arcnet7f.length=5; arcnet7f.block=99; arcnet7f.word=0x5aa5,0x3412; sis.data=a55a1234",
    2: f"{TO}; arcnet7f.length=5; synax.pieces.whole_in=3",
    3: (
        "arcnet7f.message=0x1cff; arcnet7f.command=0; arcnet7f.length=2; arcnet7f.first_in=2; "
        "synax.pieces.piece=2,3; synax.pieces.length=8; sis.data=01000200,0400000101000200"
    ),
    4: "arcnet7f.message=0x1cff; arcnet7f.command=1; arcnet7f.length=0; synax.unexpected",
}


def test_telegrams(tshark: Tshark) -> None:
    check(tshark, "arcnet7f", FIELDS, EXPERTS, TELEGRAMS, prefix="")


def test_stations(tshark: Tshark) -> None:
    check(tshark, "arcnet", f"{LINKS} {PIECES}", f"{EXPERTS} synax.unanswered_before", STATIONS, prefix="")


@pytest.mark.thorough
def test_whole_lists(tshark: Tshark) -> None:
    frames = shown(tshark, HERE / "arcnet.pcapng", "sis.data", prefix="")
    assert {number: frames[number]["sis.data"].split(",")[-1] for number in WHOLES} == WHOLES


def test_bsd(tshark: Tshark) -> None:
    fields = "arcnet7f.message arcnet7f.command arcnet7f.length arcnet7f.block arcnet7f.word sis.data"
    check(tshark, "arcnet-bsd", f"{fields} {PIECES}", EXPERTS, BSD, prefix="")


@pytest.mark.thorough
@pytest.mark.parametrize("passes", [(), ("-2",)], ids=["one_pass", "two_passes"])
def test_every_cut(passes: tuple[str, ...], tshark: Tshark, tmp_path: Path) -> None:
    """Each telegram of a first, a follow-up and a block, cut after each of its bytes: never an exception."""
    telegrams = [Scenario(HERE / "arcnet7f.txt").items[number].raw or b"" for number in (0, 1, 17, 20, 36)]
    cut = [telegram[:length] for telegram in telegrams for length in range(1, len(telegram))]
    capture = tmp_path / "cut.pcapng"
    link = pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, "cut")
    packets = [
        pcapng.enhanced_packet(0, number * 1_000_000, pcapng.upper_pdu("arcnet7f", data), 0)
        for number, data in enumerate(cut)
    ]
    head = pcapng.section_header("test", "")
    capture.write_bytes(b"".join([head, pcapng.interface_description(link), *packets]))
    frames = shown(tshark, capture, "synax.short _ws.malformed", *passes, prefix="")
    assert len(frames) == len(cut)
    assert not [frame for frame in frames.values() if "_ws.malformed" in frame]
    for data, frame in zip(cut, frames.values(), strict=True):
        whole_without_data = data[3:4] == b"\x01" and len(data) >= 13
        assert ("synax.short" in frame) != whole_without_data, data.hex(" ")
