# SPDX-License-Identifier: GPL-2.0-or-later
"""Records as text."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from portable import take_over_zone
from specification import TELEGRAMS

from sistap.dissected.explain.plain import lines
from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import INTERVAL_MAX, Framing, Record, Type
from sistap.tap.sis.telegram import build

NOON_NS = 1_700_049_600_000_000_000  # 2023-11-15 12:00:00 UTC


@pytest.fixture(autouse=True)
def _utc_plus_one(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("TZ", "XXX-1")
    take_over_zone()
    yield
    monkeypatch.undo()
    take_over_zone()


def record(data: bytes, kind: Type = Type.FRAME, *, flags: bytes = b"", checksum_bad: bool = False) -> Record:
    # A second before it, then 1.2 ms a character, once 3.4567 ms.
    intervals = [1_000_000_000, 3_456_700, *[1_200_000] * len(data)][: len(data)]
    return Record(
        NOON_NS + 1_002_003,
        kind,
        0,
        LineSettings(),
        data,
        intervals,
        flags or bytes(len(data)),
        checksum_bad=checksum_bad,
    )


def test_a_command() -> None:
    assert lines(record(TELEGRAMS["6-15"])) == (
        "13:00:00.001002  16 -> 3     Command   Initialization of the SIS communication"
        "  checksum ok  longest interval 3.457 ms\n"
    )


def test_a_reaction_is_told_from_who_really_speaks() -> None:
    # Fig. 7-2 keeps the command's addresses, 16 and 3; 3 answers.
    assert "  3 -> 16     Reaction  Execute a list of SIS services  " in lines(record(TELEGRAMS["7-2"]))


def test_an_error_status_is_told() -> None:
    # Ident number not available: status 1, control byte, device, 0x1001 (facts of fig. 8-48).
    refused = build(0x10, 16, 3, bytes([1, 0x3C, 3, 0x01, 0x10]), reaction=True)
    assert "  3 -> 16     Reaction  Read parameter  STATUS 0x01  checksum ok  " in lines(record(refused))


def test_a_broadcast_is_for_all() -> None:
    assert "  16 -> 255 (all)  Command   Initialization" in lines(record(TELEGRAMS["6-24"]))


def test_what_is_wrong_is_marked() -> None:
    telegram = TELEGRAMS["8-23"]
    flags = bytes([0, Flag.CHARACTER_ERROR, Flag.BREAK | Flag.LOST_BEFORE]) + bytes(len(telegram) - 3)
    text = lines(record(telegram, flags=flags, checksum_bad=True))
    assert text.endswith("checksum WRONG  longest interval 3.457 ms  CHARACTER ERROR  BREAK  CHARACTERS LOST\n")


def test_intervals_inside_one_read_are_not_known() -> None:
    telegram = TELEGRAMS["8-23"]
    one_read = record(telegram)._replace(intervals=[5_000_000] + [0] * (len(telegram) - 1))
    assert "longest interval not known, all in one read" in lines(one_read)


def test_an_interval_longer_than_can_be_stored() -> None:
    telegram = TELEGRAMS["8-23"]
    longer = record(telegram)._replace(intervals=[0, INTERVAL_MAX] + [1_200_000] * (len(telegram) - 2))
    assert "longest interval more than 4294.967 ms" in lines(longer)
    counters = Counters()
    counters.add_record(longer)
    assert "longest interval more than 4294.967 ms" in str(counters)


def test_other_characters_are_folded() -> None:
    assert lines(record(b"Drive ready\r\n\x80abcdef", Type.OTHER)) == (
        "13:00:00.001002  44 72 69 76 65 20 72 65 61 64 79 0d 0a 80 61 62  |Drive ready...ab|\n"
        "                 63 64 65 66                                      |cdef|\n"
    )


def test_frames_of_another_protocol_are_bytes() -> None:
    assert "|.A|" in lines(record(b"\x02A")._replace(framing=Framing.SILENCE))
