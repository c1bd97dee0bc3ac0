# SPDX-License-Identifier: GPL-2.0-or-later
"""3964R is cut by content: handshakes and blocks of both partners, on one line or on a line each."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sistap.dissected.explain.plain import lines
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag, LineSettings, Read
from sistap.tap.records.counters import Counters
from sistap.tap.records.cut import PROCEDURE_3964R, SIS, Cut
from sistap.tap.records.framer_3964r import BLOCK_LIMIT, Framer3964R
from sistap.tap.records.record import INTERVAL_MAX, Framing, Record, Type

pytestmark = pytest.mark.tap

SILENCE_NS = 1_000_000_000
START_NS = 1_700_000_000_000_000_000
SETTINGS = LineSettings(9600)
SHARED, OWN = 0, 1
OTHER, FRAME, BAD = "other", "frame", "bad"

# S-0-0237 is read. BCC by hand: 45 ^ 44 = 01, ^ 10 (DLE) ^ 03 (ETX) = 12.
ASKED = bytes.fromhex("00 00 45 44 00 00 00 00 00 00 10 03 12")
# One data byte 10 hex: it stands there twice, so only DLE and ETX are left in the sum.
DOUBLED = bytes.fromhex("10 10 10 03 13")
WRONG = ASKED[:-1] + b"\x13"


CHARACTER_NS = SETTINGS.character_ns
ANSWER_NS = 4_000_000  # a partner takes that long for its answer
PAUSES_NS = {"-": SILENCE_NS, "~": 242_000_000}  # the second is a little longer than ZVZ


def came(text: str, line: int = SHARED, gap_ns: int = CHARACTER_NS, uncertainty_ns: int = 1000) -> list[Read]:
    """Read characters one by one. Each word comes at once, after a partner's time for an answer.

    "<" before a word: it comes on the other line. "." before it: without any pause. "=" before a character: at the same
    time as the one before it.
    """
    reads, time_ns = [], START_NS
    for word in text.split():
        time_ns += PAUSES_NS.get(word, 0 if "." in word or "=" in word else ANSWER_NS)
        for value in bytes.fromhex(word.strip("-~<.=")):
            time_ns += 0 if "=" in word else gap_ns
            reads.append(Read(3 - line if "<" in word else line, time_ns, bytes([value]), b"\0", uncertainty_ns))
    return reads


def kinds(records: list[Record]) -> list[tuple[str, str]]:
    return [
        (OTHER if record.type == Type.OTHER else BAD if record.checksum_bad else FRAME, record.data.hex())
        for record in records
    ]


def heard(reads: list[Read], line: int) -> tuple[Framer3964R, list[Record]]:
    """Return the framer of a line and what it has completed."""
    framer = Framer3964R(line, SETTINGS)
    return framer, [
        record for read in reads for record in (framer.feed(read) if read.line == line else framer.beside(read))
    ]


def cut(text: str, line: int = SHARED, *, to_the_end: bool = True, uncertainty_ns: int = 1000) -> list[tuple[str, str]]:
    framer, records = heard(came(text, line, uncertainty_ns=uncertainty_ns), line)
    return kinds(records + (framer.flush() if to_the_end else []))


def frames(*texts: str) -> list[tuple[str, str]]:
    return [(FRAME, text) for text in texts]


A, D, W = ASKED.hex(), DOUBLED.hex(), WRONG.hex()
BLOCK = "41 43 10 03 11".replace(" ", "")  # 41 ^ 43 ^ 10 ^ 03


# -- Both partners on one line --------------------------------------------------------------------------------------


def test_a_request_and_its_reaction() -> None:
    """Each is complete with its last character."""
    assert cut(f"02 10 {A} 10 02 10 {D} 10", to_the_end=False) == frames("02", "10", A, "10", "02", "10", D, "10")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("02 15 02 10 " + A, frames("02", "15", "02", "10", A)),
        ("02 02 10 " + A, frames("02", "02", "10", A)),  # both ask
        (f"02 10 {W} 15 02 10 {A} 10", [*frames("02", "10"), (BAD, W), *frames("15", "02", "10", A, "10")]),
        # The grant comes late, or the request is repeated.
        ("02 - 10 " + A, frames("02", "10", A)),
        ("02 - - 02 10 " + A, frames("02", "02", "10", A)),
        ("02 10 - " + A, frames("02", "10", A)),
        # The grant was not heard.
        ("02 " + A, frames("02", A)),
        # A block breaks off: after ZVZ its receiver says NAK; the sender asks again, soon or later.
        (f"02 10 000045 ~ 15 02 10 {A}", [*frames("02", "10"), (OTHER, "000045"), *frames("15", "02", "10", A)]),
        (f"02 10 000045 ~ 15 - 02 10 {A}", [*frames("02", "10"), (OTHER, "000045"), *frames("15", "02", "10", A)]),
        # Before ZVZ, 15 can be data. A request with a pause before it and a grant after it is one.
        (f"02 10 000045 15 02 10 {A}", [*frames("02", "10"), (OTHER, "00004515"), *frames("02", "10", A)]),
        (f"02 10 00 .02 .10 {A}", [*frames("02", "10"), (OTHER, "000210" + A)]),
        (f"02 10 000045 - 02 10 {A}", [*frames("02", "10"), (OTHER, "000045"), *frames("02", "10", A)]),
        ("02 10 000045", [*frames("02", "10"), (OTHER, "000045")]),
        ("02 10 000045 10 03", [*frames("02", "10"), (OTHER, "0000451003")]),  # BCC is missing
        ("02 10 ~ 15 02 10 " + A, frames("02", "10", "15", "02", "10", A)),  # nothing came of it
        # A block that begins with a doubled DLE is asked for again after one that broke off.
        ("02 10 41 02 10 101041100352", [*frames("02", "10"), (OTHER, "41"), *frames("02", "10", "101041100352")]),
        # DLE is followed by what may not follow it.
        (
            f"02 10 41 10 42 43 10 03 55 02 10 {A}",
            [*frames("02", "10"), (OTHER, "41104243100355"), *frames("02", "10", A)],
        ),
        # A BCC that is DLE or STX: 03 ^ 10 ^ 03 = 10, 11 ^ 10 ^ 03 = 02.
        (
            "02 10 03 10 03 10 10 02 10 11 10 03 02 10",
            frames("02", "10", "03100310", "10", "02", "10", "11100302", "10"),
        ),
        ("02 10 15 10 41 10 03 55", [*frames("02", "10"), (OTHER, "151041100355")]),
        # A pair is over: 42 ^ 10 ^ 03 = 51.
        ("02 10 10 10 42 10 03 51", frames("02", "10", "101042100351")),
        # An STX without a pause before it is data, though a DLE comes after one: 41 ^ 02 ^ 42 ^ 10 ^ 03 = 12.
        ("02 10 41 .02 10 .1042100312", frames("02", "10", "4102101042100312")),
        # On one line a request inside a block would have been granted there: 42 ^ 10 ^ 03 = 51.
        ("02 10 41 02 42100351", [*frames("02", "10"), (BAD, "410242100351")]),
        # Noise after a request: the sender asks again.
        ("02 41 02 10 " + A, [(FRAME, "02"), (OTHER, "41"), *frames("02", "10", A)]),
        # Also a complete block ends at a pause above ZVZ: 41 ^ 10 ^ 03 = 52.
        ("02 10 41 ~ 100352", [*frames("02", "10"), (OTHER, "41"), (FRAME, "10"), (OTHER, "0352")]),
        # Without its grant, what follows an STX is a block only if the STX stands apart.
        ("02 .41100352", [(FRAME, "02"), (OTHER, "41100352")]),
        ("42 .02 41100352", [(OTHER, "42"), (FRAME, "02"), (OTHER, "41100352")]),
        (f"02 {W} 02 {A}", [(FRAME, "02"), (BAD, W), *frames("02", A)]),
        # Outside of blocks.
        ("41 42 02 10 " + A, [(OTHER, "4142"), *frames("02", "10", A)]),
        ("41 10 42 15 43", [(OTHER, "41"), (FRAME, "10"), (OTHER, "42"), (FRAME, "15"), (OTHER, "43")]),
        # A log may have lines with a direction, too. They are no other line of this one: whatever they say.
        ("02 10 <41 <10 <15 " + A, frames("02", "10", A)),
        ("02 <15 " + A, frames("02", A)),
    ],
)
def test_on_one_line(text: str, expected: list[tuple[str, str]]) -> None:
    assert cut(text) == expected


# -- A line for each ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("02 <10 " + A, frames("02", A)),
        (f"02 <10 {A} <10 <02 10 <41 10 02 <10 {D}", frames("02", A, "10", "10", "02", D)),
        ("10 10 10 10", frames("10", "10", "10", "10")),
        ("02 <10 " + W, [(FRAME, "02"), (BAD, W)]),
        # The grant takes longer than a second; a repeated request, too.
        ("02 - <10 " + A, frames("02", A)),
        ("02 - - 02 <10 " + A, frames("02", "02", A)),
        # Refused, with a damaged answer, too, and asked again.
        ("02 <15 02 <10 " + A, frames("02", "02", A)),
        ("02 <55 02 <10 " + A, frames("02", "02", A)),
        ("02 <15 41 02 <10 " + A, [(FRAME, "02"), (OTHER, "41"), *frames("02", A)]),
        # A block may begin with 02: 02 ^ 41 ^ 10 ^ 03 = 50.
        ("02 <10 0241100350", frames("02", "0241100350")),
        # Both asked, at once or one after the other; this one gave way, granted and answered, then asked again.
        ("02 <02 10 <41 10 02 <10 " + A, frames("02", "10", "10", "02", A)),
        ("<02 02 10 <41 15 02 <10 " + A, frames("02", "10", "15", "02", A)),
        ("02 <02 10 <41 10 -", frames("02", "10", "10")),
        ("02 - 10 10 02 <10 " + A, frames("02", "10", "10", "02", A)),
        # Or the other one gave way.
        ("02 <02 <10 1010100313", frames("02", "1010100313")),
        # Broken off, and asked again: after ZVZ, or when the other one said NAK before.
        ("02 <10 000045 ~ <15 02 <10 " + A, [(FRAME, "02"), (OTHER, "000045"), *frames("02", A)]),
        ("02 <10 000045 <15 02 <10 " + A, [(FRAME, "02"), (OTHER, "000045"), *frames("02", A)]),
        ("02 <10 000010 <15 02 <10 " + A, [(FRAME, "02"), (OTHER, "000010"), *frames("02", A)]),
        ("02 <10 411003 <15 02 <10 " + A, [(FRAME, "02"), (OTHER, "411003"), *frames("02", A)]),
        ("02 <10 000045 <15 02 <02 10", [(FRAME, "02"), (OTHER, "000045"), *frames("02", "10")]),
        ("02 <10 41 .10 .42 <15 02 <10 " + A, [(FRAME, "02"), (OTHER, "411042"), *frames("02", A)]),
        ("02 <10 4142 - 41100352", [(FRAME, "02"), (OTHER, "4142"), (OTHER, "41"), (FRAME, "10"), (OTHER, "0352")]),
        ("02 <10 4110424310 .0355", [(FRAME, "02"), (OTHER, "41104243100355")]),
        # BCC did not come: the STX after the pause is none, though it would be right (11 ^ 10 ^ 03 = 02).
        ("02 <10 111003 ~ <15 02 <10 " + A, [(FRAME, "02"), (OTHER, "111003"), *frames("02", A)]),
        # The same block sent on, although noise came on the other line: 41 ^ 02 ^ 42 ^ 10 ^ 03 = 12. NAK would end it.
        ("02 <10 41 <55 .02 .42100312", frames("02", "410242100312")),
        ("02 <10 41 <15 .02 .42100312", [(FRAME, "02"), (OTHER, "41"), (FRAME, "02"), (OTHER, "42100312")]),
        # That STX is data, too: NAK came after it.
        ("02 <10 41 .02 <15 .42100312", frames("02", "410242100312")),
        # A request with noise after it ends a block, too: 41 ^ 02 ^ 43 is 0, so the XOR of all is right.
        (
            f"02 <10 41 <15 02 .43 <10 {BLOCK}",
            [(FRAME, "02"), (OTHER, "41"), (FRAME, "02"), (OTHER, "43"), (FRAME, BLOCK)],
        ),
        # An STX inside is data, whatever is right after it.
        ("02 <10 4102100313", [(FRAME, "02"), (BAD, "4102100313")]),
        ("02 <10 41100302", [(FRAME, "02"), (BAD, "41100302")]),
        ("02 <10 410242100300", [(FRAME, "02"), (BAD, "410242100300")]),
        ("02 <10 41021042100355", [(FRAME, "02"), (OTHER, "41021042100355")]),
        # After a pause a DLE is an answer to the partner, and no grant.
        ("02 - 10 41100352", [*frames("02", "10"), (OTHER, "41"), (FRAME, "10"), (OTHER, "0352")]),
        ("02 <02 10 <41 15 4142", [*frames("02", "10", "15"), (OTHER, "4142")]),
        # What ends a block that broke off is no partner's NAK: that is on the other line.
        ("02 <10 000015 -", [(FRAME, "02"), (OTHER, "000015")]),
        # 41 42 02 43: the capture begins inside a block, or its end was damaged: 43 ^ 10 ^ 03 = 50.
        ("4142 .0243100350", [(OTHER, "41420243100350")]),
        (".0243100350", [(FRAME, "02"), (OTHER, "43100350")]),
        ("02 <10 41100355 .420243100350 <15", [(FRAME, "02"), (BAD, "41100355"), (OTHER, "420243100350")]),
        # The other one said NAK while the last character came: the next one may be a request.
        (f"02 <10 4110035542 <15 .02 <10 {A}", [(FRAME, "02"), (BAD, "41100355"), (OTHER, "42"), *frames("02", A)]),
        # A sender that goes on after a pause was not granted what follows an 02.
        ("02 <10 41 ~ <15 .0243100350", [(FRAME, "02"), (OTHER, "41"), (FRAME, "02"), (OTHER, "43100350")]),
        # One character of noise before a request or after it.
        ("FF .02 .FF <10 " + A, [(OTHER, "ff"), (FRAME, "02"), (OTHER, "ff"), (FRAME, A)]),
        # A block that seems to begin with requests.
        (f"02 <10 02 02 <10 {A}", frames("02", "02", "02", A)),
    ],
)
def test_on_a_line_of_its_own(text: str, expected: list[tuple[str, str]]) -> None:
    assert cut(text, OWN) == expected


LIST = "000241440102000 1ffff0005100311".replace(" ", "")  # what follows its first 02 has a right BCC


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # Two conflicts, then a block. The XOR of all from the first DLE on is right, too.
        (f"02 <02 10 <55 10 02 <02 10 <55 10 02 <10 {BLOCK}", frames("02", "10", "10", "02", "10", "10", "02", BLOCK)),
        (f"02 <15 02 <02 10 <55 10 02 <10 {BLOCK}", frames("02", "02", "10", "10", "02", BLOCK)),
        # Without the other line, the pause shows it.
        (f"02 10 10 ~ 02 10 10 02 {BLOCK}", frames("02", "10", "10", "02", "10", "10", "02", BLOCK)),
        # A DLE in a block of the other one grants nothing. 02 02 before a block leaves the sum as it was.
        (
            f"<41 .<42 .<43 =02 .<10 02 .02 <10 {BLOCK}",
            [*frames("02", "02"), (OTHER, "02"), (FRAME, BLOCK)],
        ),
        # Nobody granted it, and NAK ends it.
        ("02 41 <15 .43100311", [(FRAME, "02"), (OTHER, "41"), (OTHER, "43"), (FRAME, "10"), (OTHER, "0311")]),
        # Damaged ones.
        (f"02 <10 {LIST} <15", [(FRAME, "02"), (BAD, LIST)]),
        (f"02 {LIST}", [(FRAME, "02"), (BAD, LIST)]),
    ],
)
def test_a_right_sum_makes_no_block(text: str, expected: list[tuple[str, str]]) -> None:
    assert cut(text, OWN) == expected


def test_an_answer_may_be_read_late() -> None:
    """Each port has its own delay: a grant, a refusal, or the request of the other one comes after what followed it."""
    late = 5 * SETTINGS.character_ns
    assert cut("02 42 <10 .100351", OWN, uncertainty_ns=late) == frames("02", "42100351")
    assert cut(f"02 02 <15 <10 {A}", OWN, uncertainty_ns=late) == frames("02", "02", A)
    assert cut(f"02 10 <02 <41 10 02 <10 {A}", OWN, uncertainty_ns=late) == frames("02", "10", "10", "02", A)


def test_a_broken_block_is_given_at_its_end() -> None:
    assert cut("02 41104243100355", OWN, to_the_end=False) == [(FRAME, "02"), (OTHER, "41104243100355")]


# -- On any line ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("line", [SHARED, OWN])
def test_records_say_how_they_were_cut(line: int) -> None:
    framer = Framer3964R(line, SETTINGS)
    records = [record for read in came(f"02 {A} 41", line) for record in framer.feed(read)] + framer.flush()
    assert {(record.framing, record.line, record.settings) for record in records} == {
        (Framing.PROCEDURE_3964R, line, SETTINGS)
    }
    assert [record.type for record in records] == [Type.FRAME, Type.FRAME, Type.OTHER]
    assert {record.pack()[11] for record in records} == {1}


@pytest.mark.parametrize("line", [SHARED, OWN])
@pytest.mark.parametrize("uncertainty_ns", [2 * SILENCE_NS, UNCERTAINTY_UNKNOWN])
def test_what_waited_while_we_were_stopped_is_not_cut(line: int, uncertainty_ns: int) -> None:
    framer = Framer3964R(line, SETTINGS)
    reads = [read._replace(uncertainty_ns=uncertainty_ns) for read in came(f"02 {A[:8]} - {A[8:]}", line)]
    assert kinds([record for read in reads for record in framer.feed(read)]) == frames("02", A)


@pytest.mark.parametrize("line", [SHARED, OWN])
def test_a_block_without_an_end_is_given_up(line: int) -> None:
    framer = Framer3964R(line, SETTINGS)
    assert BLOCK_LIMIT == 2 * 4096 + 3  # so that the longest block fits
    reads = [
        Read(line, START_NS + time_ns, data, bytes(len(data)), 1000)
        for data, time_ns in (
            (b"\x02", 0),
            (b"A" * BLOCK_LIMIT, 20 * SILENCE_NS),
            (b"\x15", 20 * SILENCE_NS + ANSWER_NS),
        )
    ]
    records = [record for read in reads for record in framer.feed(read)]
    assert [len(record.data) for record in records] == [1, 4096, 4096, BLOCK_LIMIT - 8192, 1]
    assert records[-1].type == Type.FRAME
    assert framer.empty


def test_other_characters_are_given_when_there_are_many() -> None:
    framer = Framer3964R(SHARED, SETTINGS)
    records = framer.feed(Read(SHARED, START_NS, b"A" * 5000, bytes(5000), 1000))
    assert [len(record.data) for record in records] == [4096]
    assert [len(record.data) for record in framer.flush()] == [904]
    exact = Read(SHARED, START_NS + SILENCE_NS, b"A" * 4096, bytes(4096), 1000)
    assert [len(record.data) for record in framer.feed(exact)] == [4096]


def test_other_characters_without_a_pause_come_every_second() -> None:
    framer = Framer3964R(SHARED, SETTINGS)
    given = []
    for place, read in enumerate(came("41" * 12, gap_ns=SILENCE_NS // 5)):
        given += [(place, record.data) for record in framer.feed(read) + framer.idle(0)]
    assert given == [(5, b"A" * 6), (11, b"A" * 6)]


PIECES = st.lists(
    st.sampled_from([b"\x02", b"\x10", b"\x03", b"\x15", b"\x02\x10", b"\x10\x03", ASKED, DOUBLED, WRONG, b"A"])
    | st.binary(max_size=5),
    max_size=30,
).map(b"".join)


@st.composite
def read_lists(draw: st.DrawFn) -> list[Read]:
    """Any characters in any reads of any lines, with any errors and pauses."""
    data, time_ns, at, result = draw(PIECES), START_NS, 0, []
    lines = draw(st.sampled_from([[0], [1, 2], [0, 1], [0, 1, 2]]))
    while at < len(data):
        piece = data[at : at + draw(st.sampled_from([1, 2, 3, 20]))]
        line = draw(st.sampled_from(lines))
        time_ns += draw(st.sampled_from([0, 1_000_000, SILENCE_NS // 2, 2 * SILENCE_NS]))
        flags = bytes(draw(st.lists(st.sampled_from([0, 2, 4, 8, 16]), min_size=len(piece), max_size=len(piece))))
        result.append(Read(line, time_ns, piece, flags, draw(st.sampled_from([0, 1000, UNCERTAINTY_UNKNOWN]))))
        at += len(piece)
    return result


def framed(reads: list[Read], idle_ns: int | None = None, line: int | None = None) -> list[Record]:
    """Return the records of a line, or of the first one that is read."""
    first = reads[0].line if reads else SHARED
    framer = Framer3964R(first if line is None else line, SETTINGS)
    records = []
    for read in reads:
        records += framer.feed(read) if read.line == framer.line else framer.beside(read)
        records += framer.idle(idle_ns) if idle_ns is not None else []
    return records + framer.flush()


@given(read_lists(), st.none() | st.sampled_from([0, SILENCE_NS // 2, SILENCE_NS]), st.sampled_from([0, 1, 2]))
def test_nothing_is_lost_or_invented(heard: list[Read], idle_ns: int | None, line: int) -> None:
    records = framed(heard, idle_ns, line)
    reads = [read for read in heard if read.line == line]
    assert b"".join(record.data for record in records) == b"".join(read.data for read in reads)
    made = Flag.SAME_READ | Flag.INTERVAL_UNKNOWN | Flag.INTERVAL_SATURATED
    flags = b"".join(record.flags for record in records)
    assert bytes(flag & ~made for flag in flags) == b"".join(read.flags for read in reads)
    times = [read.time_ns for read in reads for _ in read.data]
    intervals = [interval for record in records for interval in record.intervals]
    assert intervals[1:] == [min(later - earlier, INTERVAL_MAX) for earlier, later in pairwise(times)]


@given(read_lists())
def test_frames_are_handshakes_or_blocks(reads: list[Read]) -> None:
    for record in framed(reads):
        if record.type == Type.FRAME and len(record.data) == 1:
            assert record.data in (b"\x02", b"\x10", b"\x15")
        elif record.type == Type.FRAME:
            assert record.data[-3:-1] == b"\x10\x03"
            left = 0
            for value in record.data:
                left ^= value
            assert record.checksum_bad == (left != 0)
            assert b"\x10" not in record.data[:-3].replace(b"\x10\x10", b"")


@given(PIECES, st.integers(1, 20), st.sampled_from([SHARED, OWN]))
def test_it_does_not_care_how_it_was_read(data: bytes, size: int, line: int) -> None:
    whole = Read(line, START_NS, data, bytes(len(data)), SILENCE_NS)
    parts = [data[at : at + size] for at in range(0, len(data), size)]
    pieces = [whole._replace(data=part, flags=bytes(len(part))) for part in parts]
    assert kinds(framed(pieces)) == kinds(framed([whole] if data else []))


# -- What is said of it ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("sis", SIS),
        ("3964r", PROCEDURE_3964R),
        ("silence:5", Cut(Framing.SILENCE, 5)),
        ("silence:.5", Cut(Framing.SILENCE, 0.5)),
        ("silence:1e12", Cut(Framing.SILENCE, 1e12)),
    ],
)
def test_the_option(text: str, expected: Cut) -> None:
    assert Cut.parse(text) == expected
    assert expected.framer(1, SETTINGS).framing == expected.framing


def test_silence_is_in_milliseconds() -> None:
    assert Cut.parse("silence:0.5").framer(1, SETTINGS).silence_ns == 500_000


def test_what_a_description_says() -> None:
    said = [Cut.parse(text).said for text in ("sis", "3964r", "silence:2.5")]
    assert said == ["", "; blocks of procedure 3964R", "; frames cut by 2.5 ms of silence"]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "3964",
        "SIS",
        "silence",
        "silence:",
        "silence:0",
        "silence:nan",
        "silence:1.1e12",
        "silence:1e305",
        "pause:5",
    ],
)
def test_what_the_option_may_not_be(text: str) -> None:
    with pytest.raises(ValueError, match=f"'{text}' is not sis, 3964r, ascii or silence:MILLISECONDS"):
        Cut.parse(text)


def test_handshakes_are_not_counted_as_telegrams() -> None:
    counters = Counters()
    for record in framed(came(f"02 10 {A} 10 02 10 {W} 15 41")):
        counters.add_record(record)
    assert (counters.telegrams, counters.damaged, counters.received[0]) == (1, 1, 9)


def test_as_text() -> None:
    shown = [lines(record).rstrip("\n").split("  ", 1)[1] for record in framed(came(f"02 10 {D} 15 41"))]
    assert [text.strip() for text in shown] == [
        "STX",
        "DLE",
        f"{'10 10 10 03 13':47}  |.....|  BCC ok",
        "NAK",
        f"{'41':47}  |A|",
    ]


def test_a_pause_that_nobody_measured_ends_no_block() -> None:
    """Five seconds, by a clock of unknown uncertainty."""
    pause = "- " * 5
    text = f"02 10 4143 {pause} 1003 11"
    assert cut(text, uncertainty_ns=UNCERTAINTY_UNKNOWN) == frames("02", "10", BLOCK)
    assert (FRAME, BLOCK) not in cut(text)


def test_characters_that_once_came_too_fast_show_no_pauses_later() -> None:
    """As at a pseudo terminal: a request is then none that a pause shows."""
    text = f"000045 15 02 10 {A}"
    assert cut(f"02 10 {text}") == [*frames("02", "10"), (OTHER, "00004515"), *frames("02", "10", A)]
    assert cut(f"=0210 {text}") == [*frames("02", "10"), (OTHER, "000045150210" + A)]
