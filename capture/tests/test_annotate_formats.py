# SPDX-License-Identifier: GPL-2.0-or-later
"""Telegrams, directions and times of logs as several programs write them."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from logs import LOGS, PHASE, READ_PHASE, SET_RATE, Expected
from specification import TELEGRAMS

from sistap.commands.annotate.annotating import Passage
from sistap.commands.annotate.choosing import AnyReader
from sistap.commands.annotate.marks import MASK
from sistap.commands.annotate.notations import BY_NAME, PAIRS, plain
from sistap.commands.annotate.pattern import PatternReader
from sistap.commands.annotate.reading import LogReader
from sistap.commands.annotate.textlog import lines
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag
from sistap.tap.records.cut import PROCEDURE_3964R, SIS, Cut
from sistap.tap.records.record import Record, Type


def records(
    text: str, reader: LogReader | None = None, troubles: list[tuple[int, str]] | None = None, framing: Cut = SIS
) -> list[Record]:
    said = [] if troubles is None else troubles
    log = [*lines([text.encode()])]
    passage = Passage(reader or AnyReader(log, framing), lambda number, why: said.append((number, why)), framing)
    cuts = [cut for line in log for cut in passage.feed(line).cuts]
    return [cut.record for cut in cuts + passage.end()]


@pytest.mark.parametrize("name", LOGS)
def test_a_log(name: str) -> None:
    text, expected = LOGS[name]
    troubles: list[tuple[int, str]] = []
    found = records(text, troubles=troubles)
    assert {record.type for record in found} == {Type.FRAME}
    assert [(record.data, record.line) for record in found] == [(each.data, each.line) for each in expected]
    stamped = [record.uncertainty_ns != UNCERTAINTY_UNKNOWN for record in found]
    assert stamped == [each.time_ms is not None for each in expected]
    first_ns = found[0].time_ns
    times_ms = [(record.time_ns - first_ns) / 1e6 for record in found]
    assert times_ms == [each.time_ms or 0 for each in expected]
    assert troubles == []


def test_the_uncertainty_is_a_step_of_the_stamps_and_the_longest_line_at_the_slowest_rate() -> None:
    found = records(LOGS["docklight, 12-hour clock"][0])
    # 11 characters of 11 bits at 9600 Bd, and a step of 1 ms.
    assert [round(record.uncertainty_ns / 1e6, 3) for record in found] == [round(1 + 11 * 11 / 9.6, 3)] * 3


def test_characters_of_one_stamp_have_no_times_of_their_own() -> None:
    found = records(LOGS["docklight"][0])
    assert found[0].flags[0] == Flag.INTERVAL_UNKNOWN
    assert set(found[0].flags[1:]) == {Flag.SAME_READ}  # also those of the second line
    assert set(found[2].flags[1:]) == {Flag.SAME_READ}
    unstamped = records(LOGS["one line"][0])
    assert all(flag & Flag.INTERVAL_UNKNOWN for record in unstamped for flag in record.flags)


def test_nobody_knows_the_rate() -> None:
    assert {record.settings.baud for record in records(LOGS["docklight"][0])} == {0}


def test_a_second_of_silence_ends_a_telegram_also_on_the_other_line() -> None:
    whole = TELEGRAMS["8-21"].hex(" ")
    text = f"10:00:00.000 RX {whole[:14]}\n10:00:01.500 TX {whole}\n10:00:01.600 RX {whole}\n"
    assert [(record.type, record.line) for record in records(text)] == [(1, 1), (0, 2), (0, 1)]


def test_a_direction_may_come_late() -> None:
    """Lines without one are a line of their own. A block was granted there, but none of its characters came."""
    found = records("02 10\n<< 41\n", framing=PROCEDURE_3964R)
    assert [(record.data.hex(), record.line) for record in found] == [("02", 0), ("10", 0), ("41", 1)]


def test_a_clock_that_was_set_back_begins_anew() -> None:
    whole = PHASE.hex(" ")
    found = records(f"10:00:00.000 {whole}\n09:00:00.000 {whole}\n")
    assert found[0].time_ns - found[1].time_ns == 3600 * 10**9


def test_what_is_no_telegram_is_in_the_records_of_its_line() -> None:
    found = records("41 30 33 0D\n02 56 02\n02 10 92 00 00 00 02 FF FE FD FC\n")
    assert [(record.type, record.data) for record in found] == [
        (Type.OTHER, b"A03\r"),
        (Type.FRAME, PHASE),
        (Type.OTHER, b"\xff\xfe\xfd\xfc"),
    ]


def test_what_is_certainly_no_telegram_does_not_wait() -> None:
    passage = Passage(AnyReader())
    found = [[cut.record.data for cut in passage.feed(line).cuts] for line in lines([b"41 42 43 44\n02 56 02 02\n"])]
    assert found == [[b"ABCD"], []]


@pytest.mark.parametrize(
    "line", ["31 32 20 33 34 41  12 34A", "3132 2033 3441  |12 34A|", "31 32 20 33 34 41\t'12 34A'"]
)
def test_a_column_of_characters_that_look_like_bytes(line: str) -> None:
    assert [record.data for record in records(line)] == [b"12 34A"]


@pytest.mark.parametrize(("width", "of_a_dump"), [(256, True), (257, False)])
def test_a_line_of_a_dump_has_at_most_256_bytes(width: int, of_a_dump: bool) -> None:
    data = b"z" * (width - 12) + b" 12 34 56 78"
    found = b"".join(record.data for record in records(f"{data.hex(' ')}  {data.decode()}"))
    assert found == data + (b"" if of_a_dump else b"\x12\x34\x56\x78")


@pytest.mark.parametrize("line", ["DR 02 6C 00 00 00 92 00 00", "IB 02 6C 00 00 00 92 00 00", "02 6C DB 10 00 00"])
def test_bytes_that_look_like_addresses(line: str) -> None:
    data = re.sub("^[DI][RB]|[^0-9A-F]", "", line)
    assert b"".join(record.data for record in records(line)) == bytes.fromhex(data)


def test_a_wrong_checksum_is_a_frame() -> None:
    [record] = records("02 57 02 02 10 92 00 00 00 02")
    assert record.type == Type.FRAME
    assert record.checksum_bad


def test_a_whole_telegram_ends_what_the_log_has_cut() -> None:
    """Those behind it do not wait for its rest."""
    log = (
        "RX: 02 a2 6b 6b 10 10 00 05 00 3c 05 ... 104 more bytes\nTX: 02 6c 00 00 00 92 00 00\n"
        "RX: 02 56 02 02 10 92 00 00 00 02\nTX: 02 D7 03 03 00 03 10 03 04 07 00\n"
    )
    assert [record.data for record in records(log) if record.is_good_frame] == [READ_PHASE, PHASE, SET_RATE]


def test_a_dump_of_whole_packets() -> None:
    """Headers of IP and TCP are in front of each; the last row of the third telegram has two bytes."""
    header = bytes.fromhex(
        "45 00 00 3a 00 04 40 00 40 06 b7 4b c0 a8 01 0a c0 a8 01 14"
        "c3 cb 0f a1 00 00 03 e9 00 00 13 89 50 18 fa f0 49 75 00 00"
    )
    telegrams = [SET_RATE, READ_PHASE, PHASE] * 12
    log = ""
    for data in telegrams:
        packet = header + data
        for at in range(0, len(packet), 16):
            row = packet[at : at + 16]
            shown = "".join(chr(byte) if 0x20 <= byte < 0x7F else "." for byte in row)
            log += f"{at:04x}  {row.hex(' '):47}   {shown}\n"
    assert [record.data for record in records(log) if record.is_good_frame] == telegrams


def test_equal_lengths_alone_are_no_telegram() -> None:
    """A solar inverter begins with 02, too: 05 is its address, 02 02 its lengths and its command."""
    log = "02 05 02 02 60 01 A1 B8 03\n02 06 02 9D 60 01 15 D5 02 FA F0 C9 31 FF 5D A0 52 36 49 1E 94 03\n"
    assert {record.type for record in records(log)} == {Type.OTHER}


@pytest.mark.parametrize(
    "line",
    [
        "Port 10 opened at 9600 Bd, 8 data bits",
        "Axis 3 added, dead band 00 be",
        "COM3: 9600,e,8,1",
        "/dev/ttyUSB0 at 19200 8E1",
        "Rate 115200 Bd, N-8-1",
        "DB10",
        "DB 10",
        "FETCH DB10 DW5",
        "SEND DB10",
        "FB 20",
        "RET_VAL W#16#8180",
        "  ^-- 3 -> 16  Reaction  Read parameter S-0-0047, 4 bytes: 39 30 00 00",
        "2013-03-14 08:21:14.541 timeout 05",
        "10.0.0.12 192.168.10.20",
        "struct sockaddr_in6 of request_2",
        "'C:\\build\\release'",
        "",
        "\t",
        "\x00\x01\ufffd",
    ],
)
def test_words_and_numbers_are_no_bytes(line: str) -> None:
    troubles: list[tuple[int, str]] = []
    assert records(line, troubles=troubles) == []
    assert troubles == []


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("14.03.2013 08:21:14.541 [RX] - <STX>V<STX><STX><DLE>\ufffd<NUL><NUL><NUL><STX>", "log in hexadecimal"),
        ("rx 025602021092000000020", "an odd number of hexadecimal digits (21)"),
        ("rx 02 56 02 02 10 GG 00 00 00 02", "'GG' is not a byte"),
    ],
)
def test_a_line_that_cannot_be_read(line: str, why: str) -> None:
    troubles: list[tuple[int, str]] = []
    records("comment\n" + line, troubles=troubles)
    assert [number for number, _ in troubles] == [2]
    assert why in troubles[0][1]


REGEX = r"^(?<time>[\d:.]+);(?<dir>.);(?<data>[0-9A-Fa-f ]*);"


def test_a_regular_expression_says_where_bytes_are() -> None:
    text = (
        "time;dir;bytes;comment 41 42 43 44\n"
        "08:21:14.541;O;02D703030003 1003040700;41 42 43 44\n"
        "08:21:14.641;>;02 6C 00 00 00 92 00 00;\n"
        "08:21:14.677;I;02560202109200000002;\n"
    )
    found = records(text, PatternReader(REGEX))
    assert [Expected(record.data, record.line, (record.time_ns - found[0].time_ns) / 1e6) for record in found] == LOGS[
        "docklight"
    ][1]


def test_where_each_byte_of_a_word_stands() -> None:
    text = "DW#16#0256_0202 KH = 1092, W#16#0000 16#0002"
    runs, _ = BY_NAME["words"].runs(text)
    assert [text[start:end] for run in runs for start, end in run.spans()] == [
        *("DW#16#02", "56", "_02", "02", "KH = 10", "92", "W#16#00", "00", "16#00", "02"),
    ]


@pytest.mark.parametrize("data", ["16#02 B#16#6C", "W#16#026C", "KH = 026C", "DW#16#026C_0000"])
def test_a_regular_expression_finds_the_notations_of_controls(data: str) -> None:
    [record] = records(f"x={data};", PatternReader("x=(?<data>.*);"))
    assert record.data in (b"\x02l", b"\x02l\0\0")


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("08:21:14.541;O;025;", "an odd number of hexadecimal digits (3)"),
        ("08:21:14.541;X;02 56;", "'X' is not a direction"),
        ("99:21:14.541;O;02 56;", "'99:21:14.541' is not a time"),
    ],
)
def test_what_a_regular_expression_finds_can_be_wrong(line: str, why: str) -> None:
    troubles: list[tuple[int, str]] = []
    records(line, PatternReader(REGEX), troubles)
    assert troubles == [(1, why)]


@pytest.mark.parametrize(
    ("pattern", "why"),
    [
        ("(", "is not a regular expression"),
        ("(?<time>.*)", "has no group (?<data>...)"),
        ("(?<data>.*)(?P<seqno>.)", "not seqno"),
    ],
)
def test_a_regular_expression_that_cannot_be_right(pattern: str, why: str) -> None:
    with pytest.raises(ValueError, match=r".*") as error:
        PatternReader(pattern)
    assert why in str(error.value)


@pytest.mark.parametrize("form", ["{:02X} ", "0x{:02x}, ", "{:02x}", "{:02x}-", "\\x{:02X}", "{:03d} "])
def test_all_telegrams_of_the_specification_wherever_their_lines_end(form: str) -> None:
    everything = b"".join(TELEGRAMS.values())
    for width in range(4 if "d" in form else 1, 40):
        rows = (everything[i : i + width] for i in range(0, len(everything), width))
        text = "\n".join("".join(map(form.format, row)).rstrip(" ,-") for row in rows)
        assert [record.data for record in records(text)] == list(TELEGRAMS.values()), width


_SCRAPS = ["02", "E1", "ff", "00 ", " 6C", " ", "  ", "\t", "\n", "[TX]", "RX", "x", "b", "8", "\u0663", MASK, "..l."]
_SCRAPS += ["b'", *"-<>:.#/+'\"\\|$", "16#", "0x"]


@given(st.lists(st.sampled_from(_SCRAPS), max_size=10).map("".join))
def test_the_quick_way_finds_what_the_long_one_finds(text: str) -> None:
    if run := plain(text):
        assert PAIRS.runs(text)[0] == [run]
