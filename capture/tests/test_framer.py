# SPDX-License-Identifier: GPL-2.0-or-later
"""The framer cuts by content, loses nothing, and does not depend on how the characters were read."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from itertools import accumulate, groupby, zip_longest

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from specification import TELEGRAMS

from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag, LineSettings, Read
from sistap.tap.records.cut import Cut
from sistap.tap.records.framer import Framer, SilenceFramer, SisFramer
from sistap.tap.records.record import INTERVAL_MAX, Framing, Record, Type
from sistap.tap.sis import telegram

pytestmark = pytest.mark.tap

SILENCE_NS = 1_000_000_000  # after this a telegram does not go on
RUN_LIMIT = 4096  # other characters of one record
SETTINGS = LineSettings(115200)
START_NS = 1_700_000_000_000_000_000
GOOD = TELEGRAMS["6-24"]
DAMAGED = GOOD[:-1] + b"\xfe"
OTHER, FRAME, BAD = "other", "frame", "bad"


def reads(*pieces: bytes, gap_ns: int = 100_000) -> list[Read]:
    return [Read(0, START_NS + i * gap_ns, piece, bytes(len(piece)), 1000) for i, piece in enumerate(pieces)]


def one_by_one(data: bytes, gap_ns: int = 100_000) -> list[Read]:
    return reads(*(bytes([c]) for c in data), gap_ns=gap_ns)


def feed(framer: Framer, what: Iterable[Read]) -> list[Record]:
    return [record for read in what for record in framer.feed(read)]


def frame(*what: Read) -> list[Record]:
    framer = SisFramer(0, SETTINGS)
    return feed(framer, what) + framer.flush()


def kind(record: Record) -> str:
    return OTHER if record.type == Type.OTHER else BAD if record.checksum_bad else FRAME


def kinds(records: list[Record]) -> list[tuple[str, bytes]]:
    return [(kind(record), record.data) for record in records]


def cut(data: bytes) -> list[tuple[str, bytes]]:
    return kinds(frame(*one_by_one(data)))


# -- The rules, said again as simply as they can be: over characters that end with silence ---------------------------


def complete_at(data: bytes, at: int) -> int:
    """Return where a telegram with equal lengths that starts here ends; 0 if there is none or it is cut off."""
    if at + 4 > len(data) or data[at] != 0x02 or data[at + 2] != data[at + 3]:
        return 0
    end = at + 8 + data[at + 3]
    return end if end <= len(data) else 0


def expected(data: bytes) -> list[tuple[str, bytes]]:
    good: list[tuple[int, int]] = []
    at = 0
    while at < len(data):
        end = complete_at(data, at)
        if end and sum(data[at:end]) % 256 == 0:
            good.append((at, end))
            at = end
        else:
            at += 1
    spans = [(start, end, FRAME) for start, end in good]
    for at in range(len(data)):
        end = complete_at(data, at)
        overlaps = any(at < other_end and start < end for start, other_end, _ in spans)
        if end and not overlaps:
            spans.append((at, end, BAD))
    result, done = [], 0
    for start, end, name in [*sorted(spans), (len(data), len(data), "")]:
        for run in range(done, start, RUN_LIMIT):
            result.append((OTHER, data[run : min(run + RUN_LIMIT, start)]))
        if name:
            result.append((name, data[start:end]))
        done = end
    return result


TELEGRAM = st.builds(
    telegram.build,
    st.integers(0, 255),
    st.integers(0, 127),
    st.integers(0, 255),
    st.binary(max_size=12) | st.just(b"\x02" * 9) | st.just(GOOD),
    reaction=st.booleans(),
    subaddresses=st.binary(max_size=7),
    number=st.none() | st.integers(0, 255),
)
SPOILED = st.builds(
    lambda t, at, c: t[: at % len(t)] + bytes([c]) + t[at % len(t) + 1 :], TELEGRAM, st.integers(0), st.integers(0, 255)
)
# Characters that make many plausible beginnings are as frequent as whole telegrams.
STREAM = st.lists(
    TELEGRAM
    | SPOILED
    | st.binary(max_size=8)
    | st.lists(st.sampled_from(b"\x02\x00\x01\x03\xff"), max_size=30).map(bytes),
    max_size=8,
).map(b"".join)


@st.composite
def read_lists(draw: st.DrawFn, longest_gap_ns: int) -> list[Read]:
    """Return any characters in any reads with any errors and pauses."""
    data = draw(STREAM)
    result, time_ns, at = [], START_NS, 0
    while at < len(data):
        count = draw(st.integers(1, 20))
        piece = data[at : at + count]
        flags = bytes(
            draw(st.lists(st.sampled_from([0, 0, 0, 2, 4, 8, 16, 30]), min_size=len(piece), max_size=len(piece)))
        )
        time_ns += draw(st.integers(0, longest_gap_ns))
        result.append(Read(0, time_ns, piece, flags, draw(st.sampled_from([0, 1000, UNCERTAINTY_UNKNOWN]))))
        at += count
    return result


# -- Properties -----------------------------------------------------------------------------------------------------


@given(read_lists(3 * SILENCE_NS))
def test_nothing_is_lost_or_invented(what: list[Read]) -> None:
    records = frame(*what)
    assert b"".join(record.data for record in records) == b"".join(read.data for read in what)
    made = Flag.SAME_READ | Flag.INTERVAL_UNKNOWN | Flag.INTERVAL_SATURATED
    flags = b"".join(record.flags for record in records)
    assert bytes(flag & ~made for flag in flags) == b"".join(read.flags for read in what)
    same = [bool(flag & Flag.SAME_READ) for flag in flags]
    assert same == [i > 0 for read in what for i in range(len(read.data))]


@given(read_lists(3 * SILENCE_NS))
def test_intervals_sum_up_to_the_times(what: list[Read]) -> None:
    times = [read.time_ns for read in what for _ in read.data]
    records = frame(*what)
    intervals = [interval for record in records for interval in record.intervals]
    assert list(accumulate(intervals)) == [time_ns - times[0] for time_ns in times]
    at = 0
    for record in records:
        assert record.time_ns == times[at]
        at += len(record.data)


@given(read_lists(3 * SILENCE_NS))
def test_a_record_is_as_uncertain_as_its_worst_read(what: list[Read]) -> None:
    uncertainties = [read.uncertainty_ns for read in what for _ in read.data]
    at = 0
    for record in frame(*what):
        assert record.uncertainty_ns == max(uncertainties[at : at + len(record.data)])
        at += len(record.data)


@given(read_lists(SILENCE_NS // 2))
@example(reads(b"\x02" * 40, gap_ns=0))
@example(reads(DAMAGED[:9] + b"\x02\x00\x00" + GOOD, gap_ns=0))
def test_it_cuts_by_content_however_it_was_read(what: list[Read]) -> None:
    assert kinds(frame(*what)) == expected(b"".join(read.data for read in what))


@given(read_lists(SILENCE_NS // 2), st.lists(st.integers(0, SILENCE_NS - 1)))
@example(reads(b"x", b"\x02\x00\xff\xff", DAMAGED, GOOD, b"y" * 9, gap_ns=SILENCE_NS // 2), [0] * 5)
def test_ticks_at_any_moment_cut_only_other_characters(what: list[Read], idle_ns: list[int]) -> None:
    framer = SisFramer(0, SETTINGS)
    records: list[Record] = []
    for read, idle in zip_longest(what, idle_ns[: len(what)]):
        records += framer.feed(read)
        records += framer.idle(idle) if idle is not None else []
    records += framer.flush()
    untouched = frame(*what)
    assert joined(kinds(records)) == joined(kinds(untouched))
    for field in ("flags", "intervals"):
        assert [x for r in records for x in getattr(r, field)] == [x for r in untouched for x in getattr(r, field)]
    times = iter(read.time_ns for read in what for _ in read.data)
    assert all(record.time_ns == [next(times) for _ in record.data][0] for record in records)


def joined(records: list[tuple[str, bytes]]) -> list[tuple[str, bytes]]:
    """Join successive records of other characters."""
    result = []
    for name, group in groupby(records, lambda record: record[0]):
        data = [data for _, data in group]
        result += [(name, b"".join(data))] if name == OTHER else [(name, one) for one in data]
    return result


@given(st.lists(TELEGRAM, min_size=1, max_size=6))
def test_telegrams_back_to_back_are_all_found(telegrams: list[bytes]) -> None:
    framer = SisFramer(0, SETTINGS)
    assert kinds(feed(framer, one_by_one(b"".join(telegrams)))) == [(FRAME, data) for data in telegrams]


@given(STREAM, TELEGRAM)
def test_a_telegram_is_found_after_silence(before: bytes, good: bytes) -> None:
    framer = SisFramer(0, SETTINGS)
    feed(framer, one_by_one(before))
    after = one_by_one(good)
    later = [read._replace(time_ns=read.time_ns + len(before) * 100_000 + SILENCE_NS) for read in after]
    assert kinds(feed(framer, later))[-1] == (FRAME, good)


@given(st.binary(max_size=60).filter(lambda data: 0x02 not in data), TELEGRAM)
def test_a_telegram_is_found_after_garbage_without_a_start(garbage: bytes, good: bytes) -> None:
    framer = SisFramer(0, SETTINGS)
    before = [(OTHER, garbage)] if garbage else []
    assert kinds(feed(framer, one_by_one(garbage + good))) == [*before, (FRAME, good)]


# -- Cases worth a name ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("figure", TELEGRAMS)
def test_telegrams_of_the_specification(figure: str) -> None:
    framer = SisFramer(0, SETTINGS)
    what = one_by_one(TELEGRAMS[figure])
    assert feed(framer, what[:-1]) == []
    (record,) = framer.feed(what[-1])
    assert (kind(record), record.data) == (FRAME, TELEGRAMS[figure])
    assert (record.framing, record.line, record.settings) == (Framing.SIS, 0, SETTINGS)


def test_a_wrong_checksum_alone_is_still_a_telegram() -> None:
    framer = SisFramer(0, SETTINGS)
    # Decided with its last character: no start is inside it.
    assert kinds(feed(framer, one_by_one(DAMAGED))) == [(BAD, DAMAGED)]
    assert kinds(feed(framer, one_by_one(GOOD))) == [(FRAME, GOOD)]


def test_a_good_telegram_inside_a_damaged_one_wins() -> None:
    shell = bytes([0x02, 0x00, 0x10, 0x10, 0, 0, 0, 0])
    assert cut(shell + GOOD + bytes(6)) == [(OTHER, shell), (FRAME, GOOD), (OTHER, bytes(6))]


def test_a_good_telegram_one_character_after_a_false_start_wins() -> None:
    """Its checksum is its length, so the start character before it seems to begin a telegram, too."""
    good = bytes.fromhex("02 05 05 05 00 10 10 03 3C 03 00 8D 00")
    assert cut(b"\x02" + good) == [(OTHER, b"\x02"), (FRAME, good)]


def test_a_damaged_telegram_right_before_a_good_one_stays_a_frame() -> None:
    """Also inside a longer damaged candidate, which overlaps the good telegram and is dropped."""
    shell = bytes([0x02, 0x00, 0x20, 0x20, 0, 0, 0, 0])
    rest = bytes(len(shell) + 0x20 - len(shell + DAMAGED + GOOD))
    assert cut(shell + DAMAGED + GOOD + rest) == [(OTHER, shell), (BAD, DAMAGED), (FRAME, GOOD), (OTHER, rest)]


def test_a_lost_character_costs_one_telegram() -> None:
    short = GOOD[:6] + GOOD[7:]
    assert cut(short + GOOD) == [(OTHER, short), (FRAME, GOOD)]


def test_different_lengths_are_no_telegram() -> None:
    wrong = GOOD[:2] + b"\x03" + GOOD[3:]
    assert cut(wrong + GOOD) == [(OTHER, wrong), (FRAME, GOOD)]


def test_what_is_certain_needs_no_further_character() -> None:
    framer = SisFramer(0, SETTINGS)
    for certain in (b"x", b"xyz", b"\x02\x00\x00\x01"):  # the last: two lengths that differ
        assert feed(framer, one_by_one(certain)) == []
        assert kinds(framer.settle()) == [(OTHER, certain)]
    assert feed(framer, one_by_one(GOOD[:3])) == []
    assert framer.settle() == []


def holds(framer: Framer) -> tuple[bool, int | None]:
    """Whether anything, and since when."""
    return not framer.empty, framer.oldest_ns


def test_what_it_holds_and_since_when() -> None:
    framer = SisFramer(0, SETTINGS)
    assert holds(framer) == (False, None)
    first, second, *_ = one_by_one(GOOD)
    feed(framer, [first])
    assert holds(framer) == (True, first.time_ns)
    feed(framer, [second])
    assert holds(framer) == (True, first.time_ns)
    framer.flush()
    assert holds(framer) == (False, None)
    third = first._replace(time_ns=first.time_ns + SILENCE_NS)
    feed(framer, [third])
    assert holds(framer) == (True, third.time_ns)


def test_what_may_become_a_telegram_holds_back_what_follows() -> None:
    framer = SisFramer(0, SETTINGS)
    beginning = b"\x02\x00\xff\xff"
    assert feed(framer, one_by_one(beginning + GOOD)) == []
    assert framer.idle(SILENCE_NS - 1) == []
    assert kinds(framer.idle(SILENCE_NS)) == [(OTHER, beginning), (FRAME, GOOD)]
    assert framer.idle(SILENCE_NS) == []


def test_a_pause_below_a_second_cuts_nothing() -> None:
    early, late = reads(GOOD[:5], GOOD[5:], gap_ns=SILENCE_NS - 1)
    assert kinds(frame(early, late)) == [(FRAME, GOOD)]
    # Of the five characters of the second read the first came four character times before the last.
    # And it may have come a little earlier.
    gap_ns = SILENCE_NS + 4 * SETTINGS.character_ns + late.uncertainty_ns
    assert kinds(frame(early, late._replace(time_ns=START_NS + gap_ns - 1))) == [(FRAME, GOOD)]
    assert kinds(frame(early, late._replace(time_ns=START_NS + gap_ns))) == [(OTHER, GOOD[:5]), (OTHER, GOOD[5:])]


@pytest.mark.parametrize("uncertainty_ns", [3 * SILENCE_NS // 2, UNCERTAINTY_UNKNOWN])
def test_what_waited_while_we_were_stopped_is_not_cut(uncertainty_ns: int) -> None:
    early, late = reads(GOOD[:5], GOOD[5:], gap_ns=2 * SILENCE_NS)
    assert kinds(frame(early, late._replace(uncertainty_ns=uncertainty_ns))) == [(FRAME, GOOD)]


def test_other_traffic_that_never_pauses_comes_every_second() -> None:
    framer = SisFramer(0, SETTINGS)
    line = b"pos=12.5\r\n"
    records: list[list[tuple[str, bytes]]] = []
    for read in reads(*[line] * 11, b"\x02\x00\xff\xff", line, gap_ns=SILENCE_NS // 5):
        assert framer.feed(read) == []
        records.append(kinds(framer.idle(0)))
    nothing: list[tuple[str, bytes]] = []
    second = [*[nothing] * 5, [(OTHER, line * 6)]]
    # What may become a telegram still waits, and what follows it.
    assert records == [*second, *[nothing] * 5, [(OTHER, line * 5)], nothing]
    assert kinds(framer.idle(SILENCE_NS)) == [(OTHER, b"\x02\x00\xff\xff" + line)]


def test_other_characters_are_one_record_until_a_frame_a_pause_or_the_limit() -> None:
    framer = SisFramer(0, SETTINGS)
    text = b"CCD: Com. error\r\n" * 300
    records = feed(framer, one_by_one(text))
    assert kinds(records) == [(OTHER, text[:RUN_LIMIT])]
    assert kinds(framer.idle(SILENCE_NS)) == [(OTHER, text[RUN_LIMIT:])]


def test_the_first_interval_is_unknown_and_a_long_one_saturated() -> None:
    pause_ns = INTERVAL_MAX + 1
    first, second, third = frame(
        Read(1, START_NS, b"a", b"\0", 1000),
        Read(1, START_NS + pause_ns, b"bc", b"\0\0", 1000),
        Read(1, START_NS + 2 * pause_ns - 1, b"d", b"\0", 1000),
    )
    assert (list(first.intervals), first.flags) == ([0], bytes([Flag.INTERVAL_UNKNOWN]))
    assert (list(second.intervals), second.flags) == (
        [INTERVAL_MAX, 0],
        bytes([Flag.INTERVAL_SATURATED, Flag.SAME_READ]),
    )
    assert (list(third.intervals), third.flags) == ([INTERVAL_MAX], b"\0")  # as long as can be stored
    assert third.time_ns == START_NS + 2 * pause_ns - 1


def test_a_clock_that_goes_back_does_no_harm() -> None:
    (record,) = frame(Read(0, START_NS, GOOD[:5], bytes(5)), Read(0, START_NS - 1, GOOD[5:], bytes(5)))
    assert (record.time_ns, sum(record.intervals)) == (START_NS, 0)


def test_a_read_without_characters_is_nothing() -> None:
    assert frame(Read(0, START_NS, b"", b"")) == []


@pytest.mark.attack("characters that almost form telegrams", "each costs the same, however many arrive")
@pytest.mark.parametrize(
    "pattern", [b"\x02", b"\xff", b"\x02\xff\xff", b"\x02\x02\xff\xff", b"\x02\x01" + b"\xff" * 2 + b"\x02" * 250]
)
def test_hostile_input_stays_cheap(pattern: bytes) -> None:
    """Counted, not timed: no start is judged twice, and none costs more than the longest telegram."""
    data = pattern * (20_000 // len(pattern))
    judged = 0

    class Counting(SisFramer):
        def _judge(self, records: list[Record], start: int, end: int) -> None:
            nonlocal judged
            judged += 1
            super()._judge(records, start, end)

    framer = Counting(0, SETTINGS)
    records = feed(framer, reads(*(data[i : i + 64] for i in range(0, len(data), 64)))) + framer.flush()
    assert b"".join(record.data for record in records) == data
    assert judged <= data.count(0x02)


def calls(cut: str, data: bytes) -> int:
    """Count what a framer calls for so many characters."""
    made = 0

    def count(_frame: object, event: str, _argument: object) -> None:
        nonlocal made
        made += event == "call"

    framer = Cut.parse(cut).framer(0, SETTINGS)
    pieces = reads(*(data[i : i + 64] for i in range(0, len(data), 64)))
    before = sys.getprofile()
    sys.setprofile(count)
    try:
        records = feed(framer, pieces) + framer.flush()
    finally:
        sys.setprofile(before)
    assert b"".join(record.data for record in records) == data
    return made


@pytest.mark.attack("characters that almost form telegrams", "each costs the same, however many arrive")
@pytest.mark.parametrize("pattern", [b"a", b"\r", b"?", b"\x02", b"\x10", b"\x02a\r", b"\x02ab\5\5", b"\x10\x03"])
@pytest.mark.parametrize("cut", ["ascii", "3964r"])
def test_hostile_lines_and_blocks_stay_cheap(cut: str, pattern: bytes) -> None:
    few, many = (calls(cut, pattern * (count // len(pattern))) for count in (5_000, 20_000))
    assert many < 5 * few


# -- By silence -----------------------------------------------------------------------------------------------------


def test_silence_cuts_frames_of_another_protocol() -> None:
    framer = SilenceFramer(2, SETTINGS, 5_000_000)
    pieces = [Read(2, START_NS + ms * 1_000_000, b"ab", b"\0\0") for ms in (0, 4, 10, 30)]
    records = feed(framer, pieces)
    assert kinds(records) == [(FRAME, b"abab"), (FRAME, b"ab")]
    assert kinds(framer.idle(5_000_000)) == [(FRAME, b"ab")]
    assert {record.framing for record in records} == {Framing.SILENCE}


@given(read_lists(SILENCE_NS))
def test_silence_loses_nothing(what: list[Read]) -> None:
    framer = SilenceFramer(0, SETTINGS, 20_000_000)
    records = feed(framer, what) + framer.flush()
    assert b"".join(record.data for record in records) == b"".join(read.data for read in what)


def test_a_pause_as_long_as_the_silence_cuts() -> None:
    framer = SilenceFramer(0, SETTINGS, 5_000_000)
    assert kinds(feed(framer, reads(b"a", b"b", gap_ns=4_999_999))) == []
    framer.flush()
    later = [read._replace(time_ns=read.time_ns + SILENCE_NS) for read in reads(b"a", b"b", gap_ns=5_000_000)]
    assert kinds(feed(framer, later)) == [(FRAME, b"a")]


def test_a_frame_without_silence_is_cut_after_half_a_second() -> None:
    """So a power cut costs at most a second. The interval before the second piece shows that it goes on."""
    framer = SilenceFramer(0, SETTINGS, 5_000_000)
    traffic = one_by_one(bytes(1200), gap_ns=1_000_000)
    records = feed(framer, traffic) + framer.flush()
    assert [len(record.data) for record in records] == [501, 501, 198]
    assert [record.intervals[0] for record in records[1:]] == [1_000_000, 1_000_000]
    patient = SilenceFramer(0, SETTINGS, 2 * SILENCE_NS)  # nobody can tell before how long such a frame is
    assert feed(patient, traffic) == []


def test_a_frame_without_silence_is_cut_at_the_limit() -> None:
    framer = SilenceFramer(0, SETTINGS, 5_000_000)
    assert [len(record.data) for record in feed(framer, reads(*[bytes(1000)] * 9))] == [RUN_LIMIT, RUN_LIMIT]
    assert [len(record.data) for record in framer.flush()] == [9000 - 2 * RUN_LIMIT]
    later = Read(0, START_NS + SILENCE_NS, bytes(RUN_LIMIT), bytes(RUN_LIMIT), 1000)
    assert [len(record.data) for record in framer.feed(later)] == [RUN_LIMIT]  # with its last character
