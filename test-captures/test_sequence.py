# SPDX-License-Identifier: GPL-2.0-or-later
"""Sequential telegrams: which pieces make a whole, and which do not."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from make import Scenario
from sistap.dissected.wireshark.tshark import Tshark
from tables import HERE, Table, check, shown

FIELDS = "data value sequence.piece sequence.length sequence.whole_in"
LIST_FIELDS = f"{FIELDS} sequence.begun_in phase.switch_in phase.switch_time"
EXPERTS = "sequence.ended sequence.piece_missing"

SEQUENCES: Table = {
    2: "data=01004400",
    # Read in three pieces: "ABC", "DEF", "GH"
    4: "data=414243; sequence.whole_in=8",
    6: "data=444546; sequence.whole_in=8",
    8: "data=4748,4142434445464748; sequence.piece=4,6,8; sequence.length=8; value=ABCDEFGH",
    # Written in three pieces; the reaction's control byte is 3C or 38
    9: "data=616263; sequence.whole_in=13",
    11: "data=646566; sequence.whole_in=13",
    13: "data=6768,6162636465666768; sequence.piece=9,11,13; sequence.length=8; value=abcdefgh",
    # The same parameter read twice in a row
    16: "data=4142; sequence.whole_in=18",
    18: "data=43,414243; sequence.piece=16,18; sequence.length=3; value=ABC",
    20: "data=4445; sequence.whole_in=22",
    22: "data=46,444546; sequence.piece=20,22; sequence.length=3; value=DEF",
    # Two pieces with the same bytes are two
    23: "data=6161; sequence.whole_in=27",
    25: "data=6161; sequence.whole_in=27",
    27: "data=62,6161616162; sequence.piece=23,25,27; sequence.length=5; value=aaaab",
    # A segment of a list is never a piece
    30: "data=4142; value=AB",
    31: "data=6162; value=ab",
    # Two drives behind one station, interleaved
    34: "data=4142; sequence.whole_in=38",
    36: "data=6162; sequence.whole_in=40",
    38: "data=43,414243; sequence.piece=34,38; sequence.length=3",
    40: "data=63,616263; sequence.piece=36,40; sequence.length=3",
    # Two stations, interleaved
    42: "data=4142; sequence.whole_in=46",
    44: "data=6162; sequence.whole_in=48",
    46: "data=43,414243; sequence.piece=42,46; sequence.length=3",
    48: "data=63,616263; sequence.piece=44,48; sequence.length=3",
    # A gap: what was damaged may have been a piece, and the slave may have gone on
    50: "data=4142",
    52: "data=4344",
    54: "data=4546; sequence.piece_missing",
    # Cancelled in the middle; then from the beginning
    56: "data=4142",
    58: "sequence.ended",
    60: "data=4344; sequence.whole_in=62",
    62: "data=4546,43444546; sequence.piece=60,62; sequence.length=4",
    # Status 0xF8 in the middle; then from the beginning
    64: "data=4142",
    66: "sequence.ended",
    68: "data=4344",
    # Another parameter of the same device read in between
    70: "data=4142",
    72: "data=78; sequence.ended",
    74: "data=4344",
    # Another parameter refused with 0x800C: the first goes on
    76: "data=4142; sequence.whole_in=82",
    82: "data=4344,41424344; sequence.piece=76,82; sequence.length=4",
    # A written piece again is not added twice
    83: "data=6162; sequence.whole_in=86",
    84: "data=6162",
    86: "data=6364,61626364; sequence.piece=83,86; sequence.length=4",
    # Refused while written; what follows is not put to it
    88: "data=6162",
    89: "sequence.ended",
    90: "data=6364",
    # A telegram number repeated: the kept reaction again is not another piece
    93: "data=4142; sequence.whole_in=97",
    95: "data=4142",
    97: "data=4344,41424344; sequence.piece=93,97; sequence.length=4",
    # Operating data and name of the same parameter do not mix
    99: "data=4e61; sequence.whole_in=101",
    101: "data=6d65,4e616d65; sequence.piece=99,101; sequence.length=4",
    103: "data=41",
    # Another master reads the same parameter of the same device: neither gets pieces of the other
    105: "data=4142; sequence.whole_in=109",
    109: "data=4344,41424344; sequence.piece=105,109; sequence.length=4",
    # Two drives behind a router: what the routers send on is one reading on each level
    112: "data=4142; sequence.whole_in=116",
    113: "data=4142; sequence.whole_in=117",
    116: "data=4344,41424344; sequence.piece=112,116; sequence.length=4",
    117: "data=4344,41424344; sequence.piece=113,117; sequence.length=4",
    # A damaged command was not heard: its piece comes once, with the repeat
    118: "data=6162; sequence.whole_in=123",
    120: "data=6364",
    121: "data=6364; sequence.whole_in=123",
    123: "data=65,6162636465; sequence.piece=118,121,123; sequence.length=5",
    # A damaged reaction to a written piece: all pieces are there
    125: "data=6162; sequence.whole_in=129",
    127: "data=6162",
    129: "data=63,616263; sequence.piece=125,129; sequence.length=3",
    # Busy is no refusal: the same command again, and the reading goes on
    132: "data=4142; sequence.whole_in=140",
    140: "data=4344,41424344; sequence.piece=132,140; sequence.length=4",
    # The name read in the middle of the operating data is no piece of them
    142: "data=4142",
    144: "data=4e; sequence.ended",
    # One byte of a cancel may be the device
    146: "data=4142",
    148: "sequence.ended",
    150: "data=4344; sequence.whole_in=152",
    152: "data=4546,43444546; sequence.piece=150,152; sequence.length=4",
    # Status 0xF8 twice, with a piece between
    154: "data=060006004142",
    156: "sequence.ended",
    158: "data=4344",
    160: "sequence.ended",
}

SEQUENCES_REPEATED: Table = {
    # A telegram number: the first reaction was damaged, the kept one is the piece
    2: "data=4142; sequence.whole_in=6",
    4: "data=4344",
    6: "data=4344,41424344; sequence.piece=2,6; sequence.length=4",
    # A telegram number: the first command was not answered
    8: "data=4142; sequence.whole_in=11",
    11: "data=4344,41424344; sequence.piece=8,11; sequence.length=4",
    # The last piece written again is not a parameter of its own
    13: "data=01004400",
    14: "data=6162; sequence.whole_in=16",
    16: "data=6364,61626364; sequence.piece=14,16; sequence.length=4; value=abcd",
    17: "data=6364",
    # A gap: the damaged reaction lost its form, so the tap recorded it as other characters
    20: "data=4142",
    24: "data=4546; sequence.piece_missing",
    # The tap alone took a reading command for damaged: the slave answered, and what it sent belongs to nothing known
    26: "data=4142",
    28: "data=4344",
    30: "data=4546; sequence.piece_missing",
    # The tap alone took a written piece for damaged: the slave accepted it
    31: "data=6162",
    33: "data=6364",
    35: "data=6566; sequence.piece_missing",
    # The tap lost characters between two pieces
    38: "data=4142",
    41: "data=4546; sequence.piece_missing",
    # A command that arrived damaged was not executed: status 0xF4, and the same piece again
    43: "data=4142; sequence.whole_in=47",
    47: "data=4344,41424344; sequence.piece=43,47; sequence.length=4",
    # Two damaged telegrams, each between other pieces
    49: "data=4142; sequence.whole_in=55",
    52: "data=4344; sequence.whole_in=55",
    55: "data=4546,414243444546; sequence.piece=49,52,55; sequence.length=6",
}

SEQUENCES_APART: Table = {
    # Another device is cancelled: this one goes on
    2: "data=4142; sequence.whole_in=6",
    6: "data=4344,41424344; sequence.piece=2,6; sequence.length=4",
    # Another service of the device is cancelled: this one goes on
    8: "data=4142; sequence.whole_in=12",
    12: "data=4344,41424344; sequence.piece=8,12; sequence.length=4",
    # Drives 8 and 9 behind router 4, both with device address 0: two readings
    14: "data=4142; sequence.whole_in=18",
    16: "data=6162; sequence.whole_in=20",
    18: "data=4344,41424344; sequence.piece=14,18; sequence.length=4",
    20: "data=6364,61626364; sequence.piece=16,20; sequence.length=4",
}


# Chapters 7.1 (only 0x04 itself is not in a list), 8.2 and 8.7 (bit 2 of the parameter control); 4 and fig. 2-3
# (cancel).
LISTS: Table = {
    # Read in two lists
    2: "data=0102; sequence.whole_in=4",
    4: "data=0304,01020304; sequence.piece=2,4; sequence.length=4",
    # Written in two lists
    6: "data=01001500",
    7: "data=01000200; sequence.whole_in=9",
    9: "data=04000900,0100020004000900; sequence.piece=7,9; sequence.length=8; value=1,2,4,9",
    # Two devices in one list; the second has one piece more
    12: "data=4142,6162; sequence.whole_in=14,16",
    14: "data=4344,41424344,6364; sequence.piece=12,14; sequence.length=4; sequence.whole_in=16",
    16: "data=6566,616263646566; sequence.piece=12,14,16; sequence.length=6",
    # Two parameters of one device in one list
    18: "data=4142,6162; sequence.whole_in=20,20",
    20: "data=4344,41424344,6364,61626364; sequence.piece=18,20,18,20; sequence.length=4,4",
    # One parameter twice in one list
    22: "data=4142,4344,41424344; sequence.piece=22,22; sequence.length=4; sequence.whole_in=22",
    # A list again, because no reaction came
    23: "data=6162; sequence.whole_in=26",
    24: "data=6162",
    26: "data=6364,61626364; sequence.piece=23,26; sequence.length=4",
    27: "data=6364",
    # One element is refused because the channel is busy
    29: "data=6162; sequence.whole_in=33",
    31: "data=6162",
    33: "data=6364,61626364; sequence.piece=29,33; sequence.length=4",
    # An element fails, the other goes on
    36: "data=4142,6162; sequence.whole_in=38",
    38: "data=6364,61626364; sequence.piece=36,38; sequence.length=4; sequence.begun_in=36; sequence.ended",
    40: "data=78",
    # The whole list is refused because it was damaged
    41: "data=6162; sequence.whole_in=45",
    43: "data=6162",
    45: "data=6364,61626364; sequence.piece=41,45; sequence.length=4",
    # Begun in a telegram, then in a list
    48: "data=4142",
    50: "data=4344; sequence.piece_missing; sequence.begun_in=48; sequence.ended",
    # The other way round; refused, and the list goes on
    52: "data=4142; sequence.whole_in=56",
    56: "data=4344,41424344; sequence.piece=52,56; sequence.length=4",
    # Cancelled in a list
    58: "data=4142",
    60: "sequence.begun_in=58; sequence.ended",
    62: "data=4344",
    # Cancelled at all stations, by master 16
    64: "data=4142",
    66: "data=6162",
    68: "data=4142; sequence.whole_in=73",
    69: "sequence.begun_in=66,64; sequence.ended",
    71: "data=4344",
    73: "data=4344,41424344; sequence.piece=68,73; sequence.length=4",
    # 254 on the level of router 3, then on that behind it, then 255
    75: "data=4142; sequence.whole_in=78",
    78: "data=4344,41424344; sequence.piece=75,78; sequence.length=4",
    80: "data=4142",
    81: "sequence.begun_in=80; sequence.ended",
    83: "data=4344",
    84: "sequence.begun_in=83; sequence.ended",
    86: "data=4546",
    # A cancel without a reaction: the pieces are there, but they are no value
    88: "data=4142; sequence.whole_in=91",
    91: "data=4344,41424344; sequence.piece=88,91; sequence.length=4; body.note",
    # The announced length tells that it went on
    93: "data=040004004142; sequence.whole_in=96",
    96: "data=4344,0400040041424344; sequence.piece=93,96; sequence.length=8",
    # Its length words again tell that it began anew
    98: "data=040004004142",
    101: "data=040004006162; sequence.whole_in=103; sequence.begun_in=98; sequence.ended",
    103: "data=6364,0400040061626364; sequence.piece=101,103; sequence.length=8",
    # A cancel that was not executed
    105: "data=4142; sequence.whole_in=109",
    109: "data=4344,41424344; sequence.piece=105,109; sequence.length=4",
    # A cancel to a group
    111: "data=4142; sequence.whole_in=116",
    114: "data=4344; sequence.whole_in=116; body.note",
    116: "data=4546,414243444546; sequence.piece=111,114,116; sequence.length=6; body.note",
    # A cancel in a list, answered the second time
    118: "data=4142",
    121: "sequence.begun_in=118; sequence.ended",
    123: "data=4344",
    # A phase switch and its polls: 25 + 11 + 25 + 9 + 25 + 12 + 25 + 9 + 25 ms, those without point times 1.145833
    127: "phase.switch_in=124",
    129: "phase.switch_in=124; phase.switch_time=0.171979153",
    # 25 + 8 + 25 + 9 + 25 ms
    133: "phase.switch_in=130; phase.switch_time=0.094479161",
}

# The transfer goes on; only after a cancel that failed (status 1) nobody knows it.
UNHARMED: Table = {
    2: "data=4142; sequence.whole_in=6",
    6: "data=4344,41424344; sequence.piece=2,6; sequence.length=4",
    8: "data=4142; sequence.whole_in=12",
    12: "data=4344,41424344; sequence.piece=8,12; sequence.length=4",
    14: "data=4142; sequence.whole_in=18",
    18: "data=4344,41424344; sequence.piece=14,18; sequence.length=4; body.note",
    20: "data=4142; sequence.whole_in=30",
    30: "data=4344,41424344; sequence.piece=20,30; sequence.length=4",
    32: "data=4142; sequence.whole_in=35",
    35: "data=4344,41424344; sequence.piece=32,35; sequence.length=4",
}

LISTS_ANEW: Table = {
    1: "data=4142",
    3: "data=4546; sequence.whole_in=5; sequence.begun_in=1; sequence.ended",
    5: "data=4748,45464748; sequence.piece=3,5; sequence.length=4",
    7: "data=4142",
    9: "data=4546; sequence.whole_in=12; sequence.begun_in=7; sequence.ended",
    10: "data=4546",
    12: "data=4748,45464748; sequence.piece=9,12; sequence.length=4",
    14: "data=4142",
    16: "data=4546; sequence.begun_in=14; sequence.ended",
    18: "data=4748; sequence.piece_missing",
    # The third element gives the first up
    20: "data=4142,4546; sequence.whole_in=22; sequence.begun_in=20; sequence.ended",
    22: "data=4748,45464748; sequence.piece=20,22; sequence.length=4",
    24: "data=4142",
    26: "data=4546; sequence.begun_in=24; sequence.ended",
    27: "sequence.begun_in=26; sequence.ended",
    28: "data=4748",
    31: "data=4142,6162",
    33: "data=4344",
    35: "data=4546,6566; sequence.piece_missing",
}

# The values that are read and written; none where a piece may be missing, or belongs to another transfer.
LIST_ACCESSES = {
    4: "01020304",
    10: "0100020004000900",
    14: "41424344",
    28: "61626364",
    34: "61626364",
    50: None,
    91: None,
}


def test_sequences(tshark: Tshark) -> None:
    check(tshark, "sequences", FIELDS, EXPERTS, SEQUENCES)


def test_sequences_repeated(tshark: Tshark) -> None:
    check(tshark, "sequences-repeated", FIELDS, f"{EXPERTS} reaction.again", SEQUENCES_REPEATED)


def test_sequences_apart(tshark: Tshark) -> None:
    check(tshark, "sequences-apart", FIELDS, EXPERTS, SEQUENCES_APART)


def test_lists(tshark: Tshark) -> None:
    check(tshark, "lists", LIST_FIELDS, f"{EXPERTS} body.note", LISTS)


def test_values_from_lists(tshark: Tshark) -> None:
    for passes in ((), ("-2",)):
        frames = shown(tshark, HERE / "lists.pcapng", "access", *passes)
        for number, data in LIST_ACCESSES.items():
            assert json.loads(frames[number]["access"]).get("data") == data


LONGEST = 65_535
PIECE = 236  # bytes of data in each reaction (chapter 8.2)


def long_list() -> bytes:
    """Return the longest list there is: its two length words, then single bytes."""
    words = (LONGEST - 4).to_bytes(2, "little") * 2
    return words + bytes(i % 251 for i in range(LONGEST - 4))


@pytest.mark.thorough
def test_longest_list(tshark: Tshark, tmp_path: Path) -> None:
    """65,535 bytes in 278 pieces; P-0-0072 is a list of single unsigned bytes by its attribute."""
    data = long_list()
    pieces = [data[start : start + PIECE] for start in range(0, len(data), PIECE)]
    lines = ["command 16>3 10 1C 05 00 48 80", "reaction 16>3 10 00 1C 05 01 00 14 00"]
    for piece in pieces:
        control = "3C" if piece is pieces[-1] else "38"
        lines += ["command 16>3 10 3C 05 00 48 80", f"reaction 16>3 10 00 {control} 05 {piece.hex()}"]
    (tmp_path / "long.txt").write_text("\n".join(lines))
    capture = tmp_path / "long.pcapng"
    capture.write_bytes(Scenario(tmp_path / "long.txt").capture())
    fields = "data value sequence.length sequence.count sequence.whole_in list.actual list.maximum"
    for passes in ((), ("-2",)):
        frames = shown(tshark, capture, fields, *passes)
        last = frames.pop(len(frames))
        assert last["sequence.length"] == str(LONGEST)
        assert last["sequence.count"] == str(len(pieces)) == "278"
        assert last["list.actual"] == last["list.maximum"] == str(LONGEST - 4)
        assert last["value"] == ",".join(map(str, data[4:]))
        assert last["data"] == f"{pieces[-1].hex()},{data.hex()}"
        for number, piece in enumerate(pieces[:-1]):
            whole = {"sequence.whole_in": str(2 + 2 * len(pieces))} if passes else {}
            assert frames[4 + 2 * number] == {"data": piece.hex()} | whole


def test_what_does_not_end_a_transfer(tshark: Tshark) -> None:
    check(tshark, "sequences-unharmed", FIELDS, f"{EXPERTS} body.note", UNHARMED)


def test_lists_in_which_the_order_counts(tshark: Tshark) -> None:
    check(tshark, "lists-anew", LIST_FIELDS, EXPERTS, LISTS_ANEW)


def test_last_piece_without_data_ends_a_reading(tshark: Tshark) -> None:
    for passes in ((), ("-2",)):
        frames = shown(tshark, HERE / "sequences-empty.pcapng", "data sequence.piece sequence.length", *passes)
        assert frames[8] == {"data": "4546,43444546", "sequence.piece": "6,8", "sequence.length": "4"}


def test_several_telegrams_in_a_packet(tshark: Tshark) -> None:
    """Every transfer keeps to its own pieces, in both passes."""
    for passes in ([], ["-2"]):
        fields = ("-T", "fields", "-e", "sis.data")
        data = tshark.output(*passes, "-r", str(HERE / "sequences-packed.pcapng"), *fields).splitlines()
        assert data == ["4142,43,414243,6162,63,616263", "4142", "", "43,414243"]


OPEN = 256  # transfers that may be open between two stations: one for each device address


def endless(count: int) -> str:
    """Begin a long write to another parameter each time, and end none."""
    return "\n".join(f"command 16>3 1F 38 {number % 256:02X} 00 {number % 256:02X} 00 01 02" for number in range(count))


@pytest.mark.thorough
def test_transfers_that_nobody_ends_are_forgotten(tshark: Tshark, tmp_path: Path) -> None:
    """The oldest is told to have ended; the newest goes on."""
    lines = [endless(OPEN), "command 16>3 1F 38 05 01 00 00 01 02", "command 16>3 1F 3C 05 01 00 00 03 04"]
    (tmp_path / "open.txt").write_text("\n".join(lines))
    capture = tmp_path / "open.pcapng"
    capture.write_bytes(Scenario(tmp_path / "open.txt").capture())
    for passes in ((), ("-2",)):
        frames = shown(tshark, capture, "sequence.begun_in sequence.length", *passes)
        begun = {frame: cells["sequence.begun_in"] for frame, cells in frames.items() if "sequence.begun_in" in cells}
        assert begun == {OPEN + 1: "1"}
        assert frames[OPEN + 2] == {"sequence.length": "4"}
    shown_text = tshark.output("-r", str(capture), "-V", "-Y", "sis.sequence.ended")
    assert "transfer ended unfinished: too many others have begun since" in shown_text


@pytest.mark.thorough
def test_pieces_without_an_end_are_not_put_together(tshark: Tshark, tmp_path: Path) -> None:
    """8,192 pieces are put together, one more is not; neither are more bytes than a list can have."""
    for count, size, is_whole in ((8192, 1, True), (8193, 1, False), (437, 150, False)):
        data = bytes(size).hex()
        lines = []
        for number in range(count):
            control = "3C" if number == count - 1 else "38"
            lines += [f"command 16>3 1F {control} 05 00 24 00 {data}", f"reaction 16>3 1F 00 {control} 05"]
        (tmp_path / "many.txt").write_text("\n".join(lines))
        capture = tmp_path / "many.pcapng"
        capture.write_bytes(Scenario(tmp_path / "many.txt").capture())
        for passes in ((), ("-2",)):
            last = shown(tshark, capture, "sequence.length sequence.piece_missing", *passes)[2 * count - 1]
            assert last == ({"sequence.length": str(count * size)} if is_whole else {"sequence.piece_missing": "1"})
