# SPDX-License-Identifier: GPL-2.0-or-later
"""The plugin's tap for rows: the same packets as of `-T fields`."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar, cast

import pytest
from no_tap import WithoutTap
from report_capture import BUS, Sent, write

from sistap.commands.tables.rows import FIELDS as MORE
from sistap.dissected.captures.portions import Portion
from sistap.dissected.packets.dissection import Dissection, Packet
from sistap.dissected.packets.kept import Span
from sistap.dissected.wireshark import wiregasm
from sistap.dissected.wireshark.rows import JOINT, printed, told
from sistap.dissected.wireshark.trouble import is_cut, is_no_capture
from sistap.dissected.wireshark.tshark import Tshark, TsharkError
from sistap.tap.records.record import Type
from sistap.tap.terminal.console import visible

CAPTURES = Path(__file__).parents[2] / "test-captures"
SEEN = ("sis.parameter", "sis.firmware", "sis.type_key", *MORE[:-1])  # columns of a telegram that somebody looks at


def asked(capture: Path) -> list[str]:
    return ["-r", str(capture), "-2"]


def read(tshark: Tshark, capture: Path, more: Sequence[str] = ()) -> list[Packet]:
    with Dissection(tshark, [Portion(capture)], more) as dissection:
        return list(dissection.packets())


def plain(packet: Packet, is_asked: bool) -> Packet:
    """Return a packet without columns that nobody looks at, and with its load as `-T fields` prints it.

    Wireshark 4.2 and later print a backslash twice there, and 07 as a letter.
    """
    telegrams = [
        replace(
            one,
            columns={name: one.columns[name] for name in SEEN if one.columns.get(name)},
            load_percent=one.load_percent and round(one.load_percent, 4),
        )
        for one in packet.telegrams
    ]
    return replace(
        packet,
        text=packet.text.replace("\\\\", "\\").replace("\\a", "\\x07"),
        telegrams=telegrams,
        columns={},
        characters=packet.characters if is_asked else b"",
    )


def assert_alike(found: Sequence[Packet], expected: Sequence[Packet], is_asked: bool = False) -> None:
    assert len(found) == len(expected)
    for one, other in zip(found, expected, strict=True):
        assert plain(one, is_asked) == plain(other, is_asked)


@pytest.mark.parametrize("more", [(), MORE], ids=["plain", "more"])
def test_the_tap_tells_what_tshark_prints(tshark: Tshark, tmp_path: Path, more: Sequence[str]) -> None:
    """All captures, each a section of one."""
    every = tmp_path / "every.pcapng"
    every.write_bytes(b"".join(path.read_bytes() for path in sorted(CAPTURES.rglob("*.pcapng"))))
    expected = read(cast(Tshark, WithoutTap(tshark)), every, more)
    found = read(tshark, every, more)
    assert len(found) > 4000
    assert_alike(found, expected, bool(more))


@pytest.mark.attack("`-z sis,rows` of records that the capture has cut, at any place", "it says what `-T fields` says")
@pytest.mark.parametrize("bytes_kept", [60, 72, 110])
def test_cut_records(tshark: Tshark, tmp_path: Path, bytes_kept: int) -> None:
    """They are dissected under Wireshark's eyes, but the tap runs without them."""
    cut = tmp_path / "cut.pcapng"
    subprocess.run(["editcap", "-s", str(bytes_kept), str(CAPTURES / "bodies.pcapng"), str(cut)], check=True)
    assert_alike(read(tshark, cut), read(cast(Tshark, WithoutTap(tshark)), cut))


class InPieces:
    """A tshark whose output comes in pieces."""

    def __init__(self, pieces: Sequence[bytes]) -> None:
        self._pieces = pieces

    def pieces(self, _arguments: Sequence[str]) -> Iterator[bytes]:
        return iter(self._pieces)


def test_rows_come_in_pieces(tshark: Tshark, tmp_path: Path) -> None:
    capture = write(tmp_path / "x.pcapng", BUS)
    output = b"".join(tshark.pieces([*asked(capture), "-q", "-z", "sis,rows"]))
    pieces = [output[place : place + 5] for place in range(0, len(output), 5)]
    assert read(cast(Tshark, InPieces(pieces)), capture) == read(tshark, capture)


@pytest.mark.parametrize("head", ["sis,rows 2\n", "frame.number\tsis.service\n", ""])
def test_another_version_is_not_read(head: str) -> None:
    assert told(cast(Tshark, InPieces([head.encode()])), [], []) is None


def test_kinds_without_an_end(tshark: Tshark, tmp_path: Path) -> None:
    """After 2048 their numbers begin anew; what was kept is read with its own."""
    texts = [f"marker {number}" for number in range(5000)]
    capture = write(tmp_path / "x.pcapng", [Sent(text.encode(), type=Type.OTHER) for text in texts])
    with Dissection(tshark, [Portion(capture)]) as dissection:
        packets = list(dissection.packets())
        again = list(dissection.again([Span(packets[7].time_s, packets[9].time_s)]))
    assert [packet.text for packet in packets[1:]] == texts
    assert again == packets[7:10]


def test_a_field_that_nobody_knows_is_left_out(tshark: Tshark) -> None:
    found = told(tshark, asked(CAPTURES / "accesses.pcapng"), ["sis.value", "sis.nothing", "sis.service"])
    assert found is not None
    assert found[0] == ["sis.value", "sis.service"]


def test_no_text_of_a_capture_makes_a_row_a_column_or_a_value(tshark: Tshark, tmp_path: Path) -> None:
    hostile = f"a\tb\nc\rd{JOINT}e\x02=f"
    capture = write(tmp_path / "x.pcapng", [], started=hostile)
    for more in ((), ["sertap.text"]):
        (packet,) = read(tshark, capture, more)
        assert (packet.text, packet.type) == (visible(hostile), 2)
    assert packet.columns["sertap.text"] == visible(hostile)


@pytest.mark.attack("`-z sis,rows` of strange fields: named again, without a value, thousands", "nothing breaks down")
def test_strange_fields(tshark: Tshark) -> None:
    """The capture has a `text` that stands for no bytes."""
    names = ["frame.number", "text", "frame.number", "sis.service", "sis.service", "", "\x1b", *["sis.x"] * 5000]
    found = told(tshark, ["-r", str(CAPTURES / "tcp.pcapng")], names)
    assert found is not None
    assert found[0] == ["frame.number", "text", "sis.service"]
    first, *_ = found[1]  # all are read, so that tshark ends by itself: else coverage never hears of it
    assert first[1].endswith(b"1\t\t0x03\t")


@pytest.mark.attack("the disk is full, in `-z sis,rows`", "a line says that rows are missing")
def test_a_full_disk(full: Path) -> None:
    words = ["-q", "-r", str(CAPTURES / "tcp.pcapng"), "-z", "sis,rows"]
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
    found = told(tshark, asked(cut), [])
    assert found is not None
    next(found[1])
    with pytest.raises(TsharkError) as raised:
        list(found[1])
    assert is_cut(raised.value)


def test_what_is_no_capture_is_refused(tshark: Tshark, tmp_path: Path) -> None:
    text = tmp_path / "x.pcapng"
    text.write_text("no capture")
    with pytest.raises(TsharkError) as raised:
        list((told(tshark, asked(text), []) or ([], []))[1])
    assert is_no_capture(raised.value)


def test_a_capture_without_interfaces(tshark: Tshark, tmp_path: Path) -> None:
    """In the older format, packets have none."""
    old = tmp_path / "x.pcap"
    subprocess.run(["editcap", "-F", "pcap", str(CAPTURES / "accesses.pcapng"), str(old)], check=True)
    packets = read(tshark, old)
    assert {packet.interface for packet in packets} == {""}
    assert packets[0].telegrams


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
    browser = cast(Tshark, wiregasm.Tshark())
    assert told(browser, asked(CAPTURES / "accesses.pcapng"), ["sis.service"]) is None
    known, rows = printed(browser, asked(CAPTURES / "accesses.pcapng"), ["frame.number", "sis.service"])
    assert (known, list(rows)) == (["frame.number", "sis.service"], ["1\t0x10", "2\t0x12"])
