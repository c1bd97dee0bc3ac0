# SPDX-License-Identifier: GPL-2.0-or-later
"""A line as long as annotate reads is read within seconds, whatever is in it: no pattern begins again everywhere."""

from __future__ import annotations

import time

import pytest

from sistap.commands.annotate.annotating import LONGEST_LINE, Passage
from sistap.commands.annotate.choosing import AnyReader
from sistap.commands.annotate.textlog import lines

_SECONDS = 5  # of a processor, for 50,000 characters
_LENGTH = 20_000
_SHARE = _SECONDS * _LENGTH / 50_000
# What a line repeats, and what it ends with.
_HOSTILE = [
    *((piece, "") for piece in ("w", "read", "aRead", "a read ", "r ", "a: ", "-> ", "-", "< ", " ", " '", ":", ".")),
    *((piece, "") for piece in ("0", "1:2:", "10:20:30 ", "1:02 03", "1 Jan ", "1700000000000 ", "12 bytes ", "2 ")),
    *((piece, "") for piece in ("02 ", "02-", "0x", "KH ", "$02", "00000010 ", "-1 ", '{"t": 12, "v": 34}, ')),
    *((piece, "") for piece in ("the 3 axes ", "W#16#02E1 ", "'", "b'", '\\"', "$'", "\\2\\204\\$", "\\", "#2")),
    *((piece, "") for piece in ("<STX>", "/dev/", "COM1 ", "ttyS", "\x1b[1", "发 ")),
    *((piece, "é") for piece in ("\t", "'a'", "   l", "<0x02>")),
    *[("w", " rx: x"), ("read   ", "x"), (" ", "02 56 02"), ("02e1", "g"), ("5 ", ", 33" + "  3" * 240)],
]
_BEGINNINGS = ["KH", "IRP_MJ_WRITE", "2026-01-01", "0000000"]  # and then only spaces


def _check(line: str, seconds: float) -> None:
    begun = time.process_time()
    for sample in ([*lines([line.encode()])], None):
        passage = Passage(AnyReader(sample))
        for one in lines([line.encode()]):
            passage.feed(one)
        passage.end()
    assert time.process_time() - begun < seconds


@pytest.mark.attack("lines of a log that make a naive search begin again at each character", "read within seconds")
@pytest.mark.parametrize(
    ("piece", "end"),
    [
        pytest.param(*line, id=str(number), marks=pytest.mark.thorough if number % 3 else ())
        for number, line in enumerate(_HOSTILE)
    ],
)
def test_a_hostile_line(piece: str, end: str) -> None:
    _check(piece * (_LENGTH // len(piece)) + end, _SHARE)


@pytest.mark.parametrize("beginning", _BEGINNINGS)
def test_a_hostile_line_of_spaces(beginning: str) -> None:
    _check(f"{beginning}{' ' * _LENGTH}x", _SHARE)


@pytest.mark.thorough
@pytest.mark.parametrize(("piece", "end"), _HOSTILE, ids=range(len(_HOSTILE)))
def test_a_hostile_line_of_a_quarter_of_the_longest_length(piece: str, end: str) -> None:
    """The test above shows that it costs as much as it is long; all of it would take half an hour."""
    _check(piece * ((LONGEST_LINE // 4 - len(end)) // len(piece)) + end, 5 * _SECONDS)


def test_numbers_in_many_lines_are_read_as_quickly_as_their_length() -> None:
    """What stands in front of a number is looked at, but not all of it for each number."""
    text = f"{'a1 b2 12 34 07 ' * 60}\n" * 200
    _check(text, _SECONDS)
