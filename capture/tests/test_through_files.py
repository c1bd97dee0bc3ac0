# SPDX-License-Identifier: GPL-2.0-or-later
"""A text that one part writes and another one reads is the same on both sides of a file."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from report_capture import ANSWER, LINE, READ, Sent, records

from sistap import cli
from sistap.dissected.captures import reading
from sistap.dissected.captures.portions import Portion
from sistap.dissected.packets.dissection import Dissection
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.capture.tap import Tapping
from sistap.tap.files.output import Output
from sistap.tap.files.pcapng import LINKTYPE_WIRESHARK_UPPER_PDU, Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import KEPT, Event, Record, event

SECOND = 1_000_000_000
TALK = [Sent(READ), Sent(ANSWER)] * 30


class Clock:
    """A wall clock that somebody sets."""

    def now_ns(self) -> int:
        return 0

    def step_ns(self) -> int:
        return -37 * SECOND


class Port:
    """A line without any character."""

    settings = LINE
    uncertainty_ns = 0


def write(path: Path, content: list[Record]) -> Path:
    """Write a capture as the tap does."""
    output = Output(str(path))
    writer = PcapngWriter(output, {0: Interface(LINKTYPE_WIRESHARK_UPPER_PDU, "a line")}, Counters())
    writer.begin(content[0])
    for record in content[1:]:
        writer.write(record)
    output.close()
    return path


def marked(text: str, code: Event = Event.MARKER) -> list[Record]:
    """Return exchanges with an event between them."""
    talk = records(TALK)
    middle = len(talk) // 2
    return [*talk[:middle], event(talk[middle].time_ns - 1, 0, LINE, code, text), *talk[middle:]]


def report(capsys: pytest.CaptureFixture[str], capture: Path) -> str:
    capsys.readouterr()
    assert cli.main(["report", "--format", "text", str(capture)]) == 0
    return " ".join(capsys.readouterr().out.split())


def said_by_the_tap(monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setattr("sistap.tap.capture.tap.CLOCK", Clock())
    noted: list[str] = []
    monkeypatch.setattr(Tapping, "note", lambda tap, number, code, text: noted.append(text))
    monkeypatch.setattr(Tapping, "reader", lambda tap, number: Port())
    tap = Tapping.__new__(Tapping)
    assert tap.note_clock_step(0)
    return noted[0]


OLD = "the system time jumped by -37 s; times go on without the jump"  # of earlier versions


@pytest.mark.parametrize("text", [said_by_the_tap, lambda _: OLD], ids=["now", "earlier"])
def test_a_clock_that_was_set_reaches_the_answer(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    text: Callable[[pytest.MonkeyPatch], str],
) -> None:
    told = report(capsys, write(tmp_path / "x.pcapng", marked(text(monkeypatch))))
    assert re.search(r"Limits: clock -37(\.000)? s at \d\d:\d\d:\d\d", told)


def test_another_marker_does_not(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "clock" not in report(capsys, write(tmp_path / "x.pcapng", marked("a lorry passed"))).partition("Times")[0]


def test_a_file_of_a_recorder_is_known_as_one(tmp_path: Path, tshark: Tshark) -> None:
    capture = write(tmp_path / "x.pcapng", marked(f"a tap{KEPT}late at 22:13:21.000", Event.CAPTURE_STARTED))
    assert sum(record.event == Event.CAPTURE_STARTED for record in reading.records(capture)) == 2
    with Dissection(tshark, [Portion(capture)], keeps=False) as dissection:
        assert sum(packet.is_kept_apart for packet in dissection.packets()) == 1
