# SPDX-License-Identifier: GPL-2.0-or-later
"""Raw logs: told from text by their contents, and explained record by record."""

from __future__ import annotations

from pathlib import Path

import pytest
from commands import run
from hypothesis import given
from hypothesis import strategies as st
from logs import LOGS, PHASE, READ_PHASE, SET_RATE
from specification import TELEGRAMS

from sistap.commands.annotate.raw import RawCutter, RawReader, is_raw
from sistap.dissected.captures.reading import records
from sistap.tap.records.cut import PROCEDURE_3964R, SIS, Cut
from sistap.tap.records.record import Type

HEADING = "=~=~=~=~=~=~=~=~=~=~=~= PuTTY log 2013.03.14 08:21:14 =~=~=~=~=~=~=~=~=~=~=~="
BLOCK = bytes.fromhex("02 00 00 00 00 41 44 05 00 00 02 FF FF 12 34 10 03")
BCC = 0
for _byte in BLOCK[1:]:
    BCC ^= _byte
BLOCK += bytes([BCC])


@pytest.mark.parametrize("name", LOGS)
def test_text_is_text(name: str) -> None:
    """Also with the control characters of a terminal in it, and with the bytes beside their hexadecimal digits."""
    text, expected = LOGS[name]
    assert not any(is_raw(text.encode(encoding, "replace"), SIS) for encoding in ("utf-8", "latin-1", "utf-16"))
    beside = [f"{text}\a\b\0".encode(), *(b" " + telegram.data + b"\n" for telegram in expected)]
    assert not is_raw(b"".join(beside), SIS)


@given(st.lists(st.sampled_from([*TELEGRAMS.values()]), min_size=1), st.binary(max_size=30), st.text(max_size=30))
def test_telegrams_are_raw_whatever_stands_between_them(telegrams: list[bytes], noise: bytes, text: str) -> None:
    assert is_raw(b"".join([*telegrams, noise, telegrams[0], text.encode("latin-1", "replace"), SET_RATE * 9]), SIS)


@pytest.mark.parametrize(
    ("data", "framing"),
    [
        (b"", SIS),
        (b"a text with a bell\a and \x02 in it", SIS),
        (bytes(range(256)) * 9, SIS),
        (bytes(range(256)) * 9, PROCEDURE_3964R),  # some are handshakes
        (BLOCK, SIS),
        (READ_PHASE, Cut.parse("silence:5")),  # has no times
    ],
)
def test_what_is_not_raw(data: bytes, framing: Cut) -> None:
    assert not is_raw(data, framing)


def test_blocks_of_3964r_are_raw() -> None:
    assert is_raw(b"\x02\x10" + BLOCK[1:] + b"\x10", PROCEDURE_3964R)


@given(st.lists(st.one_of(st.sampled_from([*TELEGRAMS.values()]), st.binary(max_size=300))), st.integers(1, 500))
def test_no_byte_is_lost(parts: list[bytes], size: int) -> None:
    data = b"".join(parts)
    cutter = RawCutter(SIS)
    lines = [line for start in range(0, len(data), size) for line in cutter.feed(data[start : start + size])]
    pieces = [piece for line in (*lines, *cutter.end()) for piece in RawReader().contents(line).pieces]
    assert b"".join(piece.run.data for piece in pieces) == data


def test_a_log_of_putty(tmp_path: Path) -> None:
    (tmp_path / "x").write_bytes(f"{HEADING}\r\n".encode() + SET_RATE + b"\xdb\x10" + READ_PHASE + PHASE)
    done = run(tmp_path, "annotate", "x")
    assert done.stdout.splitlines() == [
        HEADING,
        SET_RATE.hex(" ").upper(),
        "^-- 16 -> 3  Command  Set baud rate: 9600",
        "DB 10",
        "^-- 2 other characters  db 10",
        READ_PHASE.hex(" ").upper(),
        "^-- 0 -> 0  Command  Read phase (SYNAX)",
        PHASE.hex(" ").upper(),
        "^-- 0 -> 0  Reaction  Read phase (SYNAX): phase 2 (parameter mode)",
    ]
    said = "sistap: x is no text: its bytes are read as they are, without times and directions\n"
    assert (done.returncode, done.stderr) == (0, said)
    assert run(tmp_path, "annotate", "x", "-w", "x.pcapng").stderr.startswith(said)
    found = [record.data for record in records(tmp_path / "x.pcapng") if record.type != Type.EVENT]
    assert found == [SET_RATE, b"\xdb\x10", READ_PHASE, PHASE]
