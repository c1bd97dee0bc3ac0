# SPDX-License-Identifier: GPL-2.0-or-later
"""3964R and RK512 with the Indramat extension: what each frame of the captures must show (chapter 8)."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import bad_input
from sistap.dissected.wireshark.tshark import Tshark
from tables import HERE

ASKS, BOTH_ASK, GRANTS, NOT_READY, BLOCK, RECEIVED, REFUSED, NOTHING = range(8)

PROCEDURE = {  # meaning, the unit that it answers, attempt, and other fields
    1: (ASKS, None, 1, ""),
    2: (GRANTS, 1, None, "qvz.verdict=0"),
    3: (BLOCK, None, 1, "length=16 bcc=0xfe bcc.status=1 zvz.verdict=0"),
    4: (RECEIVED, 3, None, "qvz.verdict=0"),
    5: (ASKS, None, 1, ""),
    6: (GRANTS, 5, None, "qvz.verdict=0"),
    7: (BLOCK, None, 1, "length=6 bcc=0x14 bcc.status=1 zvz.verdict=0"),
    8: (RECEIVED, 7, None, "qvz.verdict=0"),
    9: (ASKS, None, 1, ""),
    10: (GRANTS, 9, None, "qvz.verdict=0"),
    11: (BLOCK, None, 1, "length=18 doubled=1 bcc=0xff bcc.status=0 bcc.bad zvz.verdict=0"),
    12: (REFUSED, 11, None, "qvz.verdict=0 refused"),
    13: (ASKS, None, 1, ""),
    14: (GRANTS, 13, None, "qvz.verdict=0"),
    15: (BLOCK, None, 2, "length=18 doubled=1 bcc=0x9e bcc.status=1 zvz.verdict=0"),
    16: (RECEIVED, 15, None, "qvz.verdict=0"),
    17: (ASKS, None, 1, ""),
    18: (GRANTS, 17, None, "qvz.verdict=0"),
    19: (BLOCK, None, 1, "length=4 bcc=0x05 bcc.status=1 zvz.verdict=0"),
    20: (RECEIVED, 19, None, "qvz.verdict=0"),
    21: (ASKS, None, 1, ""),
    22: (NOT_READY, 21, None, "qvz.verdict=0 refused"),
    23: (ASKS, None, 2, ""),
    24: (ASKS, None, 3, "unanswered_before=23 unanswered"),
    25: (GRANTS, 24, None, "qvz.verdict=0"),
    26: (BLOCK, None, 1, "length=14 bcc=0xae bcc.status=1 zvz.verdict=1 exceeded"),
    27: (RECEIVED, 26, None, "qvz.verdict=1 exceeded"),
    28: (ASKS, None, 1, ""),
    29: (BOTH_ASK, None, 1, "conflict"),
    30: (GRANTS, 29, None, "qvz.verdict=0"),  # the station of frame 28 gives way
    31: (BLOCK, None, 1, "raw=000041440100 broken zvz.verdict=0"),
    32: (BLOCK, None, 1, "raw=00104144100310 broken zvz.verdict=0"),
}
PROCEDURE_FIELDS = (
    "meaning answers try length doubled bcc bcc.status raw unanswered_before repeat_of qvz.verdict zvz.verdict "
    "bcc.bad broken conflict unexpected refused repeat unanswered tries exceeded unresolved"
).split()

# rk512i, synax and sis fields of the blocks.
RK512 = {
    3: "rk512i.command=0x45 rk512i.kind=0x44 rk512i.block=0 rk512i.word=0 rk512i.count=1 rk512i.flag_byte=0xff "
    "synax.info=0x0002 synax.axis=2 sis.parameter=S-0-0237 synax.answer_in=7",
    # From the end of frame 3 to the beginning of frame 7: four silences of 25 ms
    7: "rk512i.error=0x00 sis.parameter=S-0-0237 sis.data=0007 synax.request_in=3 synax.answer_time=0.100000000",
    15: "rk512i.command=0x41 rk512i.kind=0x44 rk512i.block=0 rk512i.word=0 rk512i.count=4 rk512i.flag_byte=0xff "
    "synax.info=0x0003 synax.axis=3 sis.parameter=P-0-0012 sis.data=0010 synax.answer_in=19",
    19: "rk512i.error=0x16 synax.error sis.parameter=P-0-0012 synax.request_in=15 synax.answer_time=0.100000000",
    26: "rk512i.command=0x41 rk512i.kind=0x44 rk512i.block=99 rk512i.word=0 rk512i.count=2 rk512i.flag_byte=0xff "
    "rk512i.data=a55a1234 rk512i.block.word=0xa55a,0x1234",
}
RK512_FIELDS = (
    "rk512i.command rk512i.kind rk512i.block rk512i.word rk512i.count rk512i.flag_byte rk512i.error rk512i.data "
    "rk512i.block.word synax.info synax.axis synax.request_in synax.answer_in synax.answer_time synax.error synax.note "
    "synax.short sis.parameter sis.data"
).split()
# Of rk512-notes.
NOTES = {
    1: "synax.info=0x0003 sis.parameter=P-0-0012 sis.data=0010",
    2: "sis.parameter=P-0-0012 synax.error",
    3: "synax.info=0x0002 sis.parameter=S-0-4095",
    4: "sis.parameter=S-0-4095 synax.error",
    5: "synax.info=0x0003 sis.parameter=P-0-0012 sis.data=0010",
    6: "sis.parameter=P-0-0012",
    7: "synax.info=0x0011 sis.raw=55020000,0002 synax.note",
    9: "synax.info=0x0012 sis.raw=55555555 synax.note",
    10: "sis.raw=0007",
    11: "rk512i.data=00030300800c0010 synax.note",
    13: "rk512i.data=0010 synax.note",
    15: "rk512i.data=0010 synax.note",
    17: "rk512i.data=0001010080480010",
    18: "sis.parameter=P-0-0072",
    20: "rk512i.data=a55a1234 rk512i.block.word=0xa55a,0x1234",
    21: "synax.note",
    22: "synax.error",
    23: "rk512i.data=0002 rk512i.block.word=0x0002 synax.note",
    25: "synax.note",
    26: "synax.error",
    28: "rk512i.data=0001",
    29: "synax.note",
    30: "rk512i.data=0001",
    31: "rk512i.data=00030300800c0010 synax.note",
    32: "synax.error",
    33: "rk512i.data=a55a1234 rk512i.block.word=0xa55a,0x1234 synax.unexpected",
    35: "synax.info=0x0002 sis.parameter=S-0-0237",
    36: "sis.parameter=S-0-0237 sis.data=00070008 synax.unexpected",
    38: "synax.unanswered_before",
    39: "rk512i.data=a55a12340000 rk512i.block.word=0xa55a,0x1234,0x0000",
    40: "synax.note",
    41: "rk512i.data=a55a1234 rk512i.block.word=0xa55a,0x1234",
    42: "rk512i.data=0003010080480010 synax.note",
}
NOTE_FIELDS = (
    "rk512i.data rk512i.block.word synax.info sis.parameter sis.data sis.raw "
    "synax.note synax.unexpected synax.unanswered_before synax.error"
).split()
BOOLEANS = {"False": "0", "True": "1", "Good": "1", "Bad": "0"}  # how some versions write them


def shown(tshark: Tshark, name: str, fields: list[str], *options: str) -> list[dict[str, str]]:
    """Return what each frame shows of these fields; an expert item is there or not."""
    columns = [word for field in fields for word in ("-e", field)]
    lines = tshark.output("-r", str(HERE / f"{name}.pcapng"), *options, "-T", "fields", *columns).splitlines()
    rows = [dict(zip(fields, line.split("\t"), strict=True)) for line in lines]
    return [{field: BOOLEANS.get(cell, cell) for field, cell in row.items() if cell} for row in rows]


def expected(words: str, prefix: str = "") -> dict[str, str]:
    """Read `field=value` and, of expert items, `field`."""
    pairs = (word.partition("=") for word in words.split())
    return {prefix + name: value or "there" for name, _, value in pairs}


def with_experts(row: dict[str, str], wanted: dict[str, str]) -> dict[str, str]:
    """Return a row in which an expert item is "there", whatever its text."""
    return {name: "there" if wanted.get(name) == "there" else value for name, value in row.items()}


@pytest.mark.parametrize("passes", [(), ("-2",)], ids=["one pass", "two passes"])
def test_the_procedure(passes: tuple[str, ...], tshark: Tshark) -> None:
    rows = shown(tshark, "3964r", [f"3964r.{field}" for field in PROCEDURE_FIELDS], *passes)
    assert len(rows) == len(PROCEDURE)
    for number, row in enumerate(rows, 1):
        meaning, answers, attempt, more = PROCEDURE[number]
        wanted = expected(more, "3964r.") | {"3964r.meaning": str(meaning)}
        wanted |= {"3964r.answers": str(answers)} if answers else {}
        wanted |= {"3964r.try": str(attempt)} if attempt else {}
        assert with_experts(row, wanted) == wanted, f"frame {number}"


def test_without_a_verdict_on_qvz_all_else_is_the_same(tshark: Tshark) -> None:
    """Frame 29 asks while frame 28 waits for its answer, whether or not answers are judged."""
    fields = [f"3964r.{field}" for field in PROCEDURE_FIELDS if field != "qvz.verdict"]
    without = shown(tshark, "3964r", fields, "-o", "3964r.qvz_ms:0")
    assert without[28]["3964r.meaning"] == str(BOTH_ASK)
    judged = shown(tshark, "3964r", fields)
    for row in (*without, *judged):  # the expert item of the verdicts
        row.pop("3964r.exceeded", None)
    assert without == judged


# Of 3964r-lines: meaning, and what it answers. Of two that ask at once, the one that then grants is not granted.
LINES = [
    *((ASKS, None), (NOTHING, None), (GRANTS, 1)),
    *((BLOCK, None), (NOTHING, None), (RECEIVED, 4), (NOTHING, None)),
    *((ASKS, None), (BOTH_ASK, None), (GRANTS, 8), (NOTHING, None)),
    *((ASKS, None), (BOTH_ASK, None), (GRANTS, 13)),
]


@pytest.mark.parametrize("passes", [(), ("-2",)], ids=["one pass", "two passes"])
def test_nobody_answers_himself(passes: tuple[str, ...], tshark: Tshark) -> None:
    fields = ["3964r.meaning", "3964r.answers", "3964r.answer_time", "3964r.qvz.verdict"]
    rows = shown(tshark, "3964r-lines", fields, *passes)
    assert [(int(row["3964r.meaning"]), row.get("3964r.answers")) for row in rows] == [
        (meaning, str(answered) if answered else None) for meaning, answered in LINES
    ]
    assert all(("3964r.answers" in row) == ("3964r.answer_time" in row) == ("3964r.qvz.verdict" in row) for row in rows)


# Of 3964r-tries: which try each request and each block is.
TRIES = [
    *(try_ for block in range(1, 10) for try_ in (1, block)),
    *(1, 1),  # after a block that was accepted
    *(1, 1),  # after a pause
    *(1, 2),  # no answer to the block
    *(1, 2, 1),  # not ready; a pause
    *(1, 1),  # the partner asks on his own
    *(1, 1, 1, 1, 1),  # both ask, and the sender gives way
    *(1, 1, 1, 1, 2),  # it does not
    *(1, 1, 1, 2, 1, 1, 1),  # on a shared line nobody knows
    *(1, 1, 1, 1),  # and the tap has missed a DLE
    *(1, 1, 2),  # a block that broke off
]


@pytest.mark.parametrize("passes", [(), ("-2",)], ids=["one pass", "two passes"])
def test_tries_of_the_procedure(passes: tuple[str, ...], tshark: Tshark) -> None:
    """A damaged block counts like a good one; Siemens' procedure has six tries."""
    rows = shown(tshark, "3964r-tries", ["3964r.try", "3964r.tries"], *passes)
    assert [int(row["3964r.try"]) for row in rows if "3964r.try" in row] == TRIES
    assert [number for number, row in enumerate(rows, 1) if "3964r.tries" in row] == [27, 31, 35]


def test_nothing_at_all(tshark: Tshark, tmp_path: Path) -> None:
    """No character: neither a line of the tree nor a name in the packet list."""
    bad_input.write(tmp_path / "empty.pcapng", [b""], "3964r")
    columns = ("-T", "fields", "-e", "frame.protocols", "-e", "_ws.col.Protocol")
    (line,) = tshark.output("-r", str(tmp_path / "empty.pcapng"), "-V", *columns).splitlines()
    assert "3964" not in line


@pytest.mark.parametrize("passes", [(), ("-2",)], ids=["one pass", "two passes"])
def test_the_telegrams(passes: tuple[str, ...], tshark: Tshark) -> None:
    rows = shown(tshark, "3964r", RK512_FIELDS, *passes)
    for number, row in enumerate(rows, 1):
        wanted = expected(RK512.get(number, ""))
        if not passes:  # it is known only after it has come
            wanted.pop("synax.answer_in", None)
        assert with_experts(row, wanted) == wanted, f"frame {number}"


@pytest.mark.parametrize("passes", [(), ("-2",)], ids=["one pass", "two passes"])
def test_what_is_not_defined_or_not_allowed(passes: tuple[str, ...], tshark: Tshark) -> None:
    for number, row in enumerate(shown(tshark, "rk512-notes", NOTE_FIELDS, *passes), 1):
        wanted = expected(NOTES.get(number, ""))
        assert with_experts(row, wanted) == wanted, f"frame {number}"


def test_a_block_that_comes_again_takes_no_part(tshark: Tshark) -> None:
    """Without the reaction between them, the second of two equal blocks repeats the first."""
    rows = shown(tshark, "3964r-again", ["3964r.repeat_of", "3964r.try", "synax.pieces.count", "sis.data"])
    assert [row.get("3964r.repeat_of") for row in rows] == [None] * 6 + ["3"] + [None] * 9
    assert rows[-2]["synax.pieces.count"] == "2"
    assert rows[-2]["sis.data"] == "0102030405060708"


def test_the_cam_table_of_the_manual(tshark: Tshark) -> None:
    """2053 words: 3 of the head, 2 length words, 1024 points of 4 bytes, numbered from 1 (pages 8-27 to 8-31)."""
    fields = ["rk512i.data", "rk512i.count", "synax.pieces.count", "sis.parameter", "sis.data", "synax.axis"]
    rows = shown(tshark, "rk512-list", fields)
    pieces = [row["rk512i.data"] for row in rows if "rk512i.data" in row]
    assert len(pieces) == 31 + 2, "DB 2 has 31 telegrams, DB 1 what is left: 138 bytes"
    assert [row["rk512i.count"] for row in rows if "rk512i.count" in row] == ["1984", "69"]
    # As printed: follow-up 1 begins in the middle of point 0x1E, DB 1 in the middle of point 0x3DE.
    assert pieces[1].startswith("001e0000001f000000200000" + "0021")
    assert pieces[1].endswith("0000003d0000")
    assert pieces[31].startswith("03de00")
    whole = next(row for row in rows if "sis.data" in row)
    points = b"".join(point.to_bytes(4, "big") for point in range(1, 1025))
    assert (whole["sis.parameter"], whole["synax.axis"], whole["synax.pieces.count"]) == ("P-0-0072", "1", "33")
    assert bytes.fromhex(whole["sis.data"]) == (4096).to_bytes(2, "big") * 2 + points
    notes = shown(tshark, "rk512-list", ["synax.note", "synax.unexpected", "synax.unanswered_before"])
    assert not any(notes), "it is the manual's own example"


def test_response_times(tshark: Tshark) -> None:
    """A read and a write, each answered 100 ms after its end; the block of inputs was not answered."""
    text = tshark.output("-q", "-z", "rk512i,srt", "-r", str(HERE / "3964r.pcapng"))
    rows = re.findall(r"^ +\d+ +(SEND|FETCH) +(\d+) +([\d.]+)", text, re.MULTILINE)
    assert rows == [("SEND", "1", "0.100000"), ("FETCH", "1", "0.100000")]
