# SPDX-License-Identifier: GPL-2.0-or-later
"""The log again with its explanations: nothing lost, nothing moved, each explanation in its place."""

from __future__ import annotations

import io
import re
from collections.abc import Iterable
from pathlib import Path
from typing import cast

import pytest
from hypothesis import given
from hypothesis import strategies as st
from logs import LOGS
from specification import TELEGRAMS

from sistap.commands.annotate.annotating import Passage, annotate_live, annotate_recorded, record
from sistap.commands.annotate.annotator import TextAnnotator
from sistap.commands.annotate.choosing import AnyReader
from sistap.commands.annotate.explaining import LiveCapture, WholeCapture
from sistap.commands.annotate.spool import LogEntry, Spool
from sistap.commands.annotate.textlog import LogLine, lines
from sistap.dissected.explain.fields import Said, sentence
from sistap.tap.records.record import Record
from sistap.tap.terminal.exits import Refusal

PHASE = TELEGRAMS["8-21"].hex(" ").upper()


class Sayer:
    """Says of each record what its bytes are."""

    def __init__(self) -> None:
        self.records: list[Record] = []

    def put(self, record: Record) -> None:
        self.records.append(record)

    def get(self) -> Said:
        told = self.records.pop(0)
        return Said(f"{told.type.name} {told.data.hex()}", True, None, False)

    def answer(self) -> list[str]:
        return []


def woven(batches: Iterable[list[LogLine]]) -> bytes:
    output = io.BytesIO()
    annotate_live(batches, Passage(AnyReader()), cast(LiveCapture, Sayer()), TextAnnotator(output.write), output.flush)
    return output.getvalue()


def kept_and_woven(batches: list[list[LogLine]]) -> bytes:
    """Annotate through a spool, as for a file."""
    output, sayer = io.BytesIO(), Sayer()
    reading = Passage(AnyReader())
    cuts = [cut for batch in batches for line in batch for cut in reading.feed(line).cuts]
    sayer.records = [cut.record for cut in [*cuts, *reading.end()]]
    with Spool() as spool:
        record(batches, Passage(AnyReader()), "a log", lambda _: None, spool)
        spooled, annotator = spool.batches(lambda _: None), TextAnnotator(output.write)
        annotate_recorded(spooled, cast(WholeCapture, sayer), annotator, output.flush)
    return output.getvalue()


def annotated(log: bytes) -> str:
    return woven([list(lines([log]))]).decode()


def without(text: bytes, encoding: str = "latin-1") -> bytes:
    """Remove the explanations: whole lines, or the end of the last."""
    plain = re.sub(r"(?m)^[ \t]*\^-- .*\n", "", text.decode(encoding, "surrogateescape"))
    return re.sub(r"\r?\n[ \t]*\^-- .*\Z", "", plain).encode(encoding, "surrogateescape")


_HEX = st.lists(st.sampled_from(list(TELEGRAMS.values())), max_size=3).map(lambda many: b"".join(many).hex(" "))
_LINE = st.one_of(
    _HEX,
    _HEX.map(lambda text: text[:20]),
    _HEX.map(lambda text: f"12:00:00.123 [RX] - \t{text}  ...."),
    _HEX.map(lambda text: f"\tTX {text.replace(' ', '')}"),
    st.sampled_from([text for text, _ in LOGS.values()]),
    st.text(st.characters(codec="latin-1")),
)
_LOG = st.lists(st.tuples(_LINE, st.sampled_from(["\n", "\r\n", "\r", ""])), max_size=30).map(
    lambda parts: "".join(text + end for text, end in parts).replace("^--", "^- ")
)


@pytest.mark.thorough
@given(_LOG, st.sampled_from(["utf-8", "latin-1"]), st.lists(st.booleans(), max_size=30))
def test_without_the_explanations_it_is_the_log(log: str, encoding: str, pauses: list[bool]) -> None:
    data = log.encode(encoding, "replace").rstrip(b"\r")  # nobody could tell it from that of an explanation
    batches: list[list[LogLine]] = []
    for number, line in enumerate(lines([data])):
        batches += [[]] if pauses[number : number + 1] == [True] else []
        batches.append([line])
    assert without(woven(batches)) == data
    assert without(woven([list(lines([data]))])) == data


@given(_LOG, st.sampled_from(["utf-8", "latin-1", "utf-16"]), st.integers(1, 40))
def test_what_was_kept_meanwhile_is_explained_as_what_comes(log: str, encoding: str, together: int) -> None:
    every = list(lines([log.encode(encoding, "replace")]))
    batches = [every[start : start + together] for start in range(0, len(every), together)]
    assert kept_and_woven(batches) == woven(batches)


def test_no_room_to_keep_it(full: Path) -> None:
    with Spool() as spool:
        spool._blobs._file = full.open("w+b")
        with pytest.raises(Refusal, match="cannot keep the log: No space left on device; .* TMPDIR$"):
            spool.put([LogEntry(line, 0, []) for line in lines([b"one line"])])


@given(st.binary())
def test_any_bytes_come_through(data: bytes) -> None:
    assert without(woven([list(lines([data]))])) == data


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be", "utf-8-sig"])
def test_encodings_with_a_mark(encoding: str) -> None:
    text = f"\ufeffProtokoll für Ü\r\n10:00:00 [RX] - {PHASE}\r\nEnde"
    data = text.encode(encoding.removesuffix("-sig"))
    output = woven([list(lines([data]))])
    assert without(output, encoding.removesuffix("-sig")) == data
    shown = output.decode(encoding.removesuffix("-sig"))
    assert f"{PHASE}\r\n{' ' * 16}^-- FRAME" in shown


def test_an_explanation_is_under_its_telegram() -> None:
    assert annotated(f"10:00:00\tRX: {PHASE}, {PHASE}\r\nend\r\n".encode()).splitlines() == [
        f"10:00:00\tRX: {PHASE}, {PHASE}",
        f"        \t    ^-- FRAME {PHASE.replace(' ', '').lower()}",
        f"        \t    {' ' * 31}^-- FRAME {PHASE.replace(' ', '').lower()}",
        "end",
    ]


def test_wide_characters_take_two_places() -> None:
    assert annotated(f"收 {PHASE}".encode()).splitlines()[1].startswith("   ^-- FRAME")


def test_a_telegram_on_several_lines_says_so_under_the_last() -> None:
    assert annotated(f"a\nTX  {PHASE[:12]}\nb\n    {PHASE[12:]}\nc".encode()).splitlines() == [
        "a",
        f"TX  {PHASE[:12]}",
        "b",
        f"    {PHASE[12:]}",
        f"    ^-- (lines 2 to 4) FRAME {PHASE.replace(' ', '').lower()}",
        "c",
    ]


def test_the_last_line_may_not_end() -> None:
    assert annotated(PHASE.encode()) == f"{PHASE}\n^-- FRAME {PHASE.replace(' ', '').lower()}"


def test_far_to_the_right_the_column_is_said() -> None:
    text = annotated((f"{PHASE} " * 100).encode())
    assert f"\n^-- (column {30 * 99 + 1}) FRAME" in text
    assert len(text) < 20_000


def test_a_line_that_waits_is_shown_when_nothing_comes_and_explained_later() -> None:
    [first, second] = lines([f"RX {PHASE[:12]}\n{PHASE[12:]}\n".encode()])
    assert woven([[first], [], [second]]).decode().splitlines() == [
        f"RX {PHASE[:12]}",
        PHASE[12:],
        f"^-- (lines 1 to 2) FRAME {PHASE.replace(' ', '').lower()}",
    ]
    [first, other] = lines([f"RX {PHASE[:12]}\nno more\n".encode()])
    assert woven([[first], [other], []]).decode().splitlines() == [
        f"RX {PHASE[:12]}",
        "no more",
        f"^-- (line 1) OTHER {PHASE[:12].replace(' ', '').lower()}",
    ]


def test_a_line_waits_for_all_of_its_bytes() -> None:
    log = f"10:00:00.0 RX {PHASE[:12]} TX {PHASE}\n10:00:05.0 TX {PHASE}\n"
    shown = woven([[line] for line in lines([log.encode()])]).decode().splitlines()
    assert [line.strip()[:9] for line in shown] == ["10:00:00.", "^-- OTHER", "^-- FRAME", "10:00:05.", "^-- FRAME"]


def test_nothing_is_written_behind_a_line_that_does_not_end() -> None:
    log = f"RX {PHASE[:12]}\nno more".encode()
    [first, last] = lines([log])
    assert without(woven([[first], [], [last]])) == log


def test_a_direction_that_keeps_silent_holds_up_only_so_many_lines() -> None:
    log = f"RX {PHASE[:12]}\n".encode() + f"TX {PHASE}\n".encode() * 5000
    shown = io.BytesIO()
    sizes = []

    def batches() -> Iterable[list[LogLine]]:
        for line in lines([log]):
            yield [line]
            sizes.append(shown.tell())

    annotate_live(batches(), Passage(AnyReader()), cast(LiveCapture, Sayer()), TextAnnotator(shown.write), shown.flush)
    assert sizes[-1] > 3900 * len(f"TX {PHASE}\n")
    assert without(shown.getvalue()) == log
    assert shown.getvalue().decode().splitlines()[-1].startswith("^-- (line 1) OTHER")


@pytest.mark.parametrize(
    ("resolution_ns", "text"),
    [
        (1, "Reaction, reached after 0.227 s  36.124 ms after the command"),
        (10**6, "Reaction, reached after 0.227 s  36 ms after the command"),
        (10**9, "Reaction, reached"),
        (None, "Reaction, reached"),
    ],
)
def test_of_times_only_what_the_stamps_can_tell(resolution_ns: int | None, text: str) -> None:
    assert sentence(Said("Reaction, reached after 0.227 s", True, 0.0361239, False), resolution_ns) == text


def test_a_command_without_a_reaction() -> None:
    assert sentence(Said("Command", True, None, True), 1) == "Command  [no reaction]"
