# SPDX-License-Identifier: GPL-2.0-or-later
"""Lines of logs in any encoding, however they come."""

from __future__ import annotations

import codecs

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sistap.commands.annotate.textlog import LineCutter, LogLine, lines


def joined(found: list[LogLine]) -> bytes:
    return b"".join(line.raw + line.ending for line in found)


@given(
    st.binary(), st.sampled_from([b"", codecs.BOM_UTF8, codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE]), st.integers(1, 9)
)
def test_no_byte_is_lost_however_they_come(data: bytes, mark: bytes, size: int) -> None:
    log = mark + data
    whole = list(lines([log]))
    assert joined(whole) == log
    pieces = [log[i : i + size] for i in range(0, len(log), size)]
    assert [(line.raw, line.text) for line in lines(pieces)] == [(line.raw, line.text) for line in whole]
    assert [line.number for line in whole] == list(range(1, len(whole) + 1))


@pytest.mark.parametrize(
    ("log", "texts"),
    [
        ("über\r\n02 56\n".encode(), ["über", "02 56"]),
        ("über\r\n02 56\n".encode("latin-1"), ["über", "02 56"]),
        ("[08:21:14.541]发→◇02 56 □\r\n".encode("gb18030"), ["[08:21:14.541]发→◇02 56 □"]),
        (codecs.BOM_UTF8 + b"02 56", ["02 56"]),
        (b"\xfc\n\xc3\xbc\n", ["ü", "Ã¼"]),  # Latin-1 from here on
        # Halves of two characters that look like an end.
        (codecs.BOM_UTF16_LE + "\u0a41\u0100\r\n02 56".encode("utf-16-le"), ["\u0a41\u0100", "02 56"]),
        (codecs.BOM_UTF16_BE + "\u0100\u0a41\r\n02 56\r\n".encode("utf-16-be"), ["\u0100\u0a41", "02 56"]),
        (b"", []),
        (b"\n", [""]),
        (b"a", ["a"]),
    ],
)
def test_encodings(log: bytes, texts: list[str]) -> None:
    assert [line.text for line in lines([log])] == texts


def test_a_line_comes_as_soon_as_it_ends() -> None:
    cutter = LineCutter()
    assert [line.text for line in cutter.feed(b"02 56\n02")] == ["02 56"]
    assert [line.text for line in cutter.feed(b" 02\r\n")] == ["02 02"]
    assert list(cutter.end()) == []
