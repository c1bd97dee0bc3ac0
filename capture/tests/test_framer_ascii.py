# SPDX-License-Identifier: GPL-2.0-or-later
"""Lines of the ASCII protocol of ECODRIVE drives: conversations as public clients lead them, cuts, and noise."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.cut import Cut
from sistap.tap.records.framer import RUN_LIMIT
from sistap.tap.records.record import Framing, Record, Type

pytestmark = pytest.mark.tap

SETTINGS = LineSettings(9600)
# Open, read, write a list, with echo and prompts.
OPEN = [b"BCD:21\r\n", b"E21:>"]
READ = [b"S-0-0051,7,R\r\n", b"12.3456\r\n", b"E21:>"]
LIST = [b"P-0-4006,7,W,>\r\n", b"?", b"1.0000\r\n", b"?", b"<\r\n", b"E21:>"]
TELEGRAM = bytes.fromhex("02 6C 00 00 00 92 00 00")  # 02 + 6C + 92 is 00


def records(pieces: Sequence[bytes]) -> list[Record]:
    framer = Cut.parse("ascii").framer(0, SETTINGS)
    found = []
    for number, piece in enumerate(pieces):
        found += framer.feed(Read(0, number * 1_000_000, piece, bytes(len(piece)), 1000))
    return found + framer.flush()


def lines(pieces: Sequence[bytes]) -> list[bytes]:
    found = records(pieces)
    for record in found:
        is_telegram = record.type == Type.FRAME and record.data[:1] == TELEGRAM[:1]
        assert record.framing == (Framing.SIS if is_telegram else Framing.ASCII)
    return [record.data if record.type == Type.FRAME else b"other " + record.data for record in found]


@pytest.mark.parametrize("conversation", [OPEN, READ, LIST])
def test_a_line_is_a_frame_however_it_was_read(conversation: list[bytes]) -> None:
    whole = b"".join(conversation)
    assert lines([whole]) == conversation
    assert lines([bytes([c]) for c in whole]) == conversation


def test_line_ends() -> None:
    assert lines([b"one\rtwo\nthree\r\nfour"]) == [b"one\r", b"two\n", b"three\r\n", b"other four"]


@pytest.mark.parametrize("length", range(RUN_LIMIT - 2, RUN_LIMIT + 3))
def test_no_record_is_longer_than_the_limit(length: int) -> None:
    """A line of just that many characters, with its end, is still a line."""
    line = b"x" * (length - 2) + b"\r\n"
    found = records([line])
    assert b"".join(record.data for record in found) == line
    assert max(len(record.data) for record in found) <= RUN_LIMIT
    assert (len(found) == 1) == (length <= RUN_LIMIT)


def test_a_prompt_does_not_wait_for_more() -> None:
    framer = Cut.parse("ascii").framer(0, SETTINGS)
    assert [record.data for record in framer.feed(Read(0, 0, b"E21:>", bytes(5), 1000))] == [b"E21:>"]


def test_latin_1_is_text() -> None:
    assert lines([b"\xb0C\r\n"]) == [b"\xb0C\r\n"]


MIXED = [b"E21:>", TELEGRAM, b"BCD:3\r\n", TELEGRAM, b"E3:>"]


def test_telegrams_and_lines_on_one_bus() -> None:
    whole = b"".join(MIXED)
    assert lines([whole]) == MIXED
    assert lines([bytes([c]) for c in whole]) == MIXED


def test_a_line_that_a_telegram_breaks_off_is_none() -> None:
    assert lines([b"S-0-00", TELEGRAM, b"51,7,R\r"]) == [b"other S-0-00", TELEGRAM, b"51,7,R\r"]


def test_a_start_character_alone_holds_back_no_line() -> None:
    """Its lengths differ: x and y. A telegram with a wrong checksum is a frame of SIS."""
    assert lines([b"\x02axyBCD:3\r\n"]) == [b"other \x02", b"axyBCD:3\r\n"]
    bad = TELEGRAM[:1] + b"\x6d" + TELEGRAM[2:]
    found = records([b"E3:>", bad, b"BCD:3\r\n"])
    assert [record.data for record in found] == [b"E3:>", bad, b"BCD:3\r\n"]
    assert [record.checksum_bad for record in found] == [False, True, False]


def test_a_line_that_is_too_long_is_no_frame_however_it_was_read() -> None:
    long = b"x" * 5000 + b"\r\n"
    expected = [b"other " + b"x" * RUN_LIMIT, b"x" * (5000 - RUN_LIMIT) + b"\r\n"]
    assert lines([long]) == lines([bytes([c]) for c in long]) == expected


def test_other_traffic_ends_no_line() -> None:
    """A line whose beginning is old, because somebody types it: only a silence ends it."""
    framer = Cut.parse("ascii").framer(0, SETTINGS)
    found = [
        record
        for second, character in enumerate(b"BCD:21\r\n")
        for record in framer.feed(Read(0, second * 900_000_000, bytes([character]), b"\0", 1000)) + framer.idle(100)
    ]
    assert [record.data for record in found] == [b"BCD:21\r\n"]


@given(st.lists(st.one_of(st.binary(max_size=30), st.sampled_from([*READ, *LIST, TELEGRAM])), max_size=20))
def test_nothing_is_lost(pieces: list[bytes]) -> None:
    found = records(pieces)
    assert b"".join(record.data for record in found) == b"".join(pieces)
    assert all(record.data for record in found)


@given(st.lists(st.sampled_from([*READ, *LIST, TELEGRAM, b"\x02", b"\0x", b"\x02ab\5\5", b"x\r", b"\n"]), max_size=12))
def test_how_it_was_read_changes_nothing(pieces: list[bytes]) -> None:
    whole = b"".join(pieces)
    alone = [(record.type, record.data) for record in records([bytes([c]) for c in whole])]
    assert [(record.type, record.data) for record in records([whole])] == alone
