# SPDX-License-Identifier: GPL-2.0-or-later
"""The plugin's tap for rows: the same as `-T fields`."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar, cast

import pytest
from report_capture import write

from sistap.commands.tables.rows import FIELDS as MORE
from sistap.dissected.packets.apart import PACKED
from sistap.dissected.packets.dissection import FIELDS
from sistap.dissected.wireshark import wiregasm
from sistap.dissected.wireshark.rows import JOINT, printing, safe, told
from sistap.dissected.wireshark.trouble import is_cut, is_no_capture
from sistap.dissected.wireshark.tshark import Tshark, TsharkError
from sistap.tap.terminal.console import visible

CAPTURES = Path(__file__).parents[2] / "test-captures"


def asked(capture: Path) -> list[str]:
    return ["-r", str(capture), "-2"]


def printed(tshark: Tshark, capture: Path, names: Sequence[str]) -> list[str]:
    try:
        return [safe(row) for row in tshark.lines([*asked(capture), *printing(names)])]
    except TsharkError:
        return []  # a capture that is cut


FIRST, *REST = sorted(CAPTURES.rglob("*.pcapng"))


@pytest.mark.parametrize(
    "capture", [FIRST, *(pytest.param(one, marks=pytest.mark.thorough) for one in REST)], ids=lambda one: one.stem
)
def test_the_tap_says_what_tshark_prints(tshark: Tshark, capture: Path) -> None:
    names = [name for name in (*FIELDS, *MORE) if name != PACKED]  # which says what is in the tree
    expected = printed(tshark, capture, names)
    known, rows = told(tshark, asked(capture), names)
    assert known == names
    if expected:
        assert list(rows) == expected


def test_a_field_that_nobody_knows_is_left_out(tshark: Tshark) -> None:
    known, rows = told(tshark, asked(CAPTURES / "accesses.pcapng"), ["frame.number", "sis.nothing", "sis.service"])
    assert known == ["frame.number", "sis.service"]
    assert next(rows).startswith("1\t")


def test_no_text_of_a_capture_makes_a_row_a_column_or_a_value(tshark: Tshark, tmp_path: Path) -> None:
    hostile = f"a\tb\nc\rd{JOINT}e\x02"
    capture = write(tmp_path / "x.pcapng", [], started=hostile)
    _, rows = told(tshark, asked(capture), ["sertap.text", "sertap.type"])
    assert [row.split("\t") for row in rows] == [[visible(hostile), "2"]]


@pytest.mark.attack("`-z sis,rows` of strange fields: named again, without a value, thousands", "nothing breaks down")
def test_strange_fields(tshark: Tshark) -> None:
    """The capture has a `text` that stands for no bytes."""
    names = ["frame.number", "text", "frame.number", "sis.service", "sis.service", "", "\x1b", *["sis.x"] * 5000]
    known, rows = told(tshark, ["-r", str(CAPTURES / "tcp.pcapng")], names)
    assert known == ["frame.number", "text", "sis.service"]
    assert next(rows) == "1\t\t0x03"


@pytest.mark.attack("the disk is full, in `-z sis,rows`", "a line says that rows are missing")
def test_a_full_disk(full: Path) -> None:
    words = ["-q", "-r", str(CAPTURES / "tcp.pcapng"), "-z", "sis,rows,frame.number"]
    with full.open("w") as stdout:
        done = subprocess.run(
            [sys.executable, "-m", "sistap.dissected.wireshark", *words],
            stdout=stdout,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert "sis,rows: rows are missing in standard output: No space left on device" in done.stderr


def test_a_cut_capture_says_so_after_its_last_row(tshark: Tshark, tmp_path: Path) -> None:
    cut = tmp_path / "x.pcapng"
    cut.write_bytes((CAPTURES / "accesses.pcapng").read_bytes()[:-10])
    _, rows = told(tshark, asked(cut), ["frame.number"])
    assert next(rows) == "1"
    with pytest.raises(TsharkError) as raised:
        list(rows)
    assert is_cut(raised.value)


def test_what_is_no_capture_is_refused(tshark: Tshark, tmp_path: Path) -> None:
    text = tmp_path / "x.pcapng"
    text.write_text("no capture")
    with pytest.raises(TsharkError) as raised:
        told(tshark, asked(text), ["frame.number"])
    assert is_no_capture(raised.value)


def test_a_capture_without_interfaces(tshark: Tshark, tmp_path: Path) -> None:
    """In the older format, packets have none."""
    old = tmp_path / "x.pcap"
    subprocess.run(["editcap", "-F", "pcap", str(CAPTURES / "accesses.pcapng"), str(old)], check=True)
    names = ["frame.interface_name", "sis.service"]
    known, rows = told(tshark, asked(old), names)
    assert (known, list(rows)) == (names, printed(tshark, old, names))


def test_a_browser_has_no_tap(monkeypatch: pytest.MonkeyPatch) -> None:
    """There the names stand before the rows, too."""

    class Rows:
        unknown: ClassVar[list[str]] = []
        isCapture, isCut = True, False  # noqa: N815 - as in JavaScript
        pieces: ClassVar[list[str]] = ["1\t0x10\n2\t0x12", ""]

        def next(self) -> str:
            return self.pieces.pop(0)

    page = SimpleNamespace(open=lambda _capture, _asked: Rows())
    monkeypatch.setattr(wiregasm, "_page", lambda: page)
    known, rows = told(
        cast(Tshark, wiregasm.Tshark()), asked(CAPTURES / "accesses.pcapng"), ["frame.number", "sis.service"]
    )
    assert (known, list(rows)) == (["frame.number", "sis.service"], ["1\t0x10", "2\t0x12"])
