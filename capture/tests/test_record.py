# SPDX-License-Identifier: GPL-2.0-or-later
"""The record's bytes match the layout, and parsing returns the original."""

from __future__ import annotations

from enum import IntEnum

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sistap.tap.line.settings import PARITIES, Flag, LineSettings
from sistap.tap.records.record import HEADER, INTERVAL_MAX, Event, Framing, Record, Type, event, unpack

pytestmark = pytest.mark.tap

SETTINGS = LineSettings(19200)
# Written down by hand from the layout: two characters, 19200 Bd 8E1, uncertainty 0.3 ms.
BY_HAND = bytes.fromhex(
    "01 14 00 02"  # version, header length 20, frame, line 2
    "00 00 4B 00"  # 19200
    "08 01 02 00"  # 8 data bits, even, 2 half stop bits, framing SIS
    "00 04 93 E0"  # 300000 ns
    "00 02 00 00"  # 2 characters, no event
    "02 FE"
    "00 00 00 00 00 08 BD 10"  # first: unknown; 572688 ns
    "20 02"  # interval unknown; character error
)
RECORD = Record(
    5,
    Type.FRAME,
    2,
    LineSettings(19200),
    b"\x02\xfe",
    (0, 572_688),
    bytes([Flag.INTERVAL_UNKNOWN, Flag.CHARACTER_ERROR]),
    300_000,
)

SETTINGS_OF_LINES = st.builds(
    LineSettings,
    st.integers(0, 0xFFFFFFFF),
    st.integers(5, 8),
    st.sampled_from(PARITIES),
    st.sampled_from([2, 3, 4]),
)


@st.composite
def records(draw: st.DrawFn) -> Record:
    data = draw(st.binary(max_size=300))
    time_ns, line = draw(st.integers(0, 2**63)), draw(st.integers(0, 2))
    settings = draw(SETTINGS_OF_LINES)
    uncertainty_ns = draw(st.integers(0, 0xFFFFFFFF))
    kind = draw(st.sampled_from(Type))
    if kind == Type.EVENT:
        return Record(time_ns, kind, line, settings, data, (), b"", uncertainty_ns, event=draw(st.sampled_from(Event)))
    intervals = tuple(draw(st.lists(st.integers(0, INTERVAL_MAX), min_size=len(data), max_size=len(data))))
    flags = draw(st.binary(min_size=len(data), max_size=len(data)))
    return Record(time_ns, kind, line, settings, data, intervals, flags, uncertainty_ns, draw(st.sampled_from(Framing)))


# The codes of the layout in plugin/docs/record.md, which files that exist already hold.
CODES = {
    Type: {"FRAME": 0, "OTHER": 1, "EVENT": 2, "BEFORE": 3},
    Framing: {"SIS": 0, "PROCEDURE_3964R": 1, "ASCII": 2, "SILENCE": 255},
    Event: {
        "NONE": 0,
        "CAPTURE_STARTED": 1,
        "SETTINGS_CHANGED": 2,
        "CHARACTERS_LOST": 3,
        "ADAPTER_LOST": 4,
        "MARKER": 5,
        "LIMITS_TOLD": 6,
        "TOLD_BEFORE": 7,
    },
}
WIRESHARKS_LARGEST_PACKET = 262_144
WRAPPER = 16  # of link type 252, around a record


def test_the_layout() -> None:
    assert RECORD.pack() == BY_HAND


@pytest.mark.parametrize("codes", CODES, ids=lambda codes: codes.__name__)
def test_the_codes_are_those_of_the_layout(codes: type[IntEnum]) -> None:
    assert {code.name: code.value for code in codes} == CODES[codes]


def test_an_event_of_a_later_version_keeps_its_number_and_text() -> None:
    later = unpack(event(0, 0, LineSettings(), Event(99), "later").pack())
    assert (later.event, later.data) == (99, b"later")


def test_an_interval_has_32_bits() -> None:
    assert INTERVAL_MAX == 4_294_967_295


def test_what_the_bytes_do_not_say() -> None:
    record = unpack(BY_HAND)
    assert (record.time_ns, record.checksum_bad) == (0, False)


def test_the_errors_of_all_characters_together() -> None:
    flags = [Flag.SAME_READ | Flag.BREAK, Flag.LOST_BEFORE, Flag.INTERVAL_UNKNOWN]
    assert RECORD._replace(flags=bytes(flags)).errors == Flag.BREAK | Flag.LOST_BEFORE
    assert RECORD._replace(flags=bytes([Flag.SAME_READ])).errors == Flag(0)


@given(records())
def test_a_record_comes_back(record: Record) -> None:
    assert unpack(record.pack(), record.time_ns) == record


@given(records())
def test_its_length_is_that_of_the_layout(record: Record) -> None:
    per_character = 1 if record.type == Type.EVENT else 6
    assert len(record.pack()) == 20 + per_character * len(record.data)


def test_a_longer_header_of_a_later_version_is_skipped() -> None:
    longer = BY_HAND[:1] + b"\x16" + BY_HAND[2:20] + b"\xaa\xbb" + BY_HAND[20:]
    assert unpack(longer, 5) == RECORD


@pytest.mark.parametrize(
    "data",
    [
        BY_HAND[:19],
        b"\x02" + BY_HAND[1:],  # version
        BY_HAND[:1] + b"\x13" + BY_HAND[2:],  # header shorter than the fields
        BY_HAND[:1] + b"\x13" + BY_HAND[2:-1],  # and as long as it says
        BY_HAND[:-1],
        BY_HAND + b"\0",
        BY_HAND[:16] + b"\x00\x03" + BY_HAND[18:],  # count
    ],
)
def test_what_does_not_fit_is_an_error(data: bytes) -> None:
    with pytest.raises(ValueError):
        unpack(data)


def of_size(count: int) -> Record:
    return Record(0, Type.OTHER, 0, SETTINGS, bytes(count), [0] * count, bytes(count))


def test_43_000_characters_fit_and_wireshark_takes_them() -> None:
    assert len(of_size(43_000).pack()) + WRAPPER <= WIRESHARKS_LARGEST_PACKET
    with pytest.raises(OverflowError):
        of_size(43_001).pack()


def test_an_event_is_cut_between_characters() -> None:
    record = event(0, 0, SETTINGS, Event.MARKER, "x" * 42_999 + "ä")
    assert record.data == b"x" * 42_999
    assert HEADER.unpack_from(record.pack())[-1] == Event.MARKER


@pytest.mark.parametrize(
    ("framing", "kind", "data", "is_handshake"),
    [
        (Framing.PROCEDURE_3964R, Type.FRAME, b"\x02", True),
        (Framing.PROCEDURE_3964R, Type.FRAME, b"\x10\x03\x13", False),
        (Framing.PROCEDURE_3964R, Type.OTHER, b"\x02", False),
        (Framing.SILENCE, Type.FRAME, b"\x02", False),
    ],
)
def test_a_handshake_is_one_character_of_3964r(framing: Framing, kind: Type, data: bytes, is_handshake: bool) -> None:
    size = len(data)
    made = Record(5, kind, 0, SETTINGS, data, (0,) * size, bytes(size), 300_000, framing)
    assert made.is_handshake == is_handshake


def test_a_character_comes_its_interval_after_the_one_before() -> None:
    """The first interval is that before the record."""
    record = Record(1000, Type.FRAME, 0, SETTINGS, b"\1\2\3", (7, 100, 250), bytes(3), 0)
    assert [character.time_ns for character in record.characters()] == [1000, 1100, 1350]
