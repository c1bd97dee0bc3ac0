# SPDX-License-Identifier: GPL-2.0-or-later
"""Which records a recorder writes into which file: each number is a record of that second."""

from __future__ import annotations

from collections.abc import Collection, Iterable

import pytest

from sistap.commands.recorder import keeper
from sistap.commands.recorder.keeper import Around, Beginning, Keeper
from sistap.dissected.explain.relay import Entry
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.before import Heard
from sistap.tap.sis import telegram

SECOND = 1_000_000_000


class Files:
    """Remembers what was begun, written and completed."""

    def __init__(self) -> None:
        self.begun: list[Kept] = []
        self.said: list[str] = []

    def begin(self, beginning: Beginning) -> Kept:
        self.begun.append(Kept(beginning))
        return self.begun[-1]

    @property
    def contents(self) -> list[list[int]]:
        return [kept.written for kept in self.begun]


class Kept:
    def __init__(self, beginning: Beginning) -> None:
        self.heading, self.known, self.reason = beginning.heading, beginning.known, beginning.reason
        self.first, self.time = beginning.first_ns // SECOND, beginning.time_ns // SECOND
        self.blocks: list[bytes] = []
        self.complete = False

    def write(self, block: bytes) -> None:
        assert not self.complete
        self.blocks.append(block)

    def close(self, reasons: Collection[str]) -> None:
        assert not self.complete
        self.complete = True
        self.reasons = list(reasons)

    @property
    def written(self) -> list[int]:
        return [int(block) for block in self.blocks if block.isdigit()]


@pytest.fixture
def files() -> Files:
    return Files()


def keep(files: Files, before: int = 3, after: int = 2) -> Keeper:
    return Keeper(Around(before * SECOND, after * SECOND), files.begin, b"heading", files.said.append)


def play(keeper: Keeper, seconds: Iterable[int], matter: Iterable[int] = ()) -> None:
    for second in seconds:
        keeper.take(Entry(second * SECOND, b"%d" % second), "late" if second in matter else "")


def test_a_file_has_what_is_around_its_reason(files: Files) -> None:
    play(keep(files), range(100), {50})
    assert files.contents == [list(range(47, 53))]
    (kept,) = files.begun
    assert (kept.heading, kept.first, kept.time, kept.reason, kept.complete) == (b"heading", 47, 50, "late", True)


def test_a_reason_that_is_known_late_has_what_came_before_its_beginning(files: Files) -> None:
    """A step of a value; and a silence, of which nothing is dropped while it lasts."""
    keeper = keep(files)
    play(keeper, range(50))
    keeper.take(Entry(50 * SECOND, b"50"), "step", 30 * SECOND)
    play(keeper, range(51, 101))
    keeper.look(450 * SECOND)
    keeper.take(Entry(500 * SECOND, b"500"), "bus-silent", 100 * SECOND)
    assert files.contents == [[*range(27, 53)], [*range(97, 101), 500]]
    assert [kept.time for kept in files.begun] == [30, 100]


def test_what_matters_first_has_nothing_before_it(files: Files) -> None:
    play(keep(files), range(100), {1})
    assert files.contents == [[0, 1, 2, 3]]


TOLD = telegram.build(0x03, 16, 255, b"\0\1\x28\0")  # TrS, to all
ACCEPTED = telegram.build(0x03, 16, 255, b"\0\xff")
ASKED = b"\x03\0\x24\0"  # device and parameter
NAME = [telegram.build(0x10, 16, 3, b"\x14" + ASKED), telegram.build(0x10, 16, 3, b"\0\x14\x03N", reaction=True)]
VALUE = [telegram.build(0x10, 16, 3, b"\x3c" + ASKED), telegram.build(0x10, 16, 3, b"\0\x3c\x03V", reaction=True)]


def test_a_file_begins_with_what_was_told_before_it(files: Files) -> None:
    """Limits and names, not values; and not what the file has itself."""
    keeper = keep(files)
    telegrams = {1: TOLD, 2: NAME[0], 3: NAME[1], 4: VALUE[0], 5: VALUE[1], 20: VALUE[0], 49: ACCEPTED}
    for second in range(60):
        heard = Heard(0, LineSettings(), second * SECOND, telegrams.get(second, b""), is_disturbed=False)
        keeper.take(Entry(second * SECOND, b"%d " % second, heard), "late" if second in (3, 30, 50) else "")
    keeper.take(Entry(90 * SECOND, b"90 "), "late")
    known = [[record.data for record in kept.known] for kept in files.begun]
    assert known == [[], *[[TOLD, *NAME]] * 2, [TOLD, *NAME, ACCEPTED]]
    assert {record.time_ns // SECOND for record in files.begun[1].known} == {files.begun[1].first}


@pytest.mark.parametrize(
    ("matter", "contents"),
    [
        ({50, 51}, [range(47, 54)]),
        ({50, 55}, [range(47, 58)]),  # the one ends where the other begins
        ({50, 56}, [range(47, 53), range(53, 59)]),  # side by side: nothing is there twice
        ({50, 60}, [range(47, 53), range(57, 63)]),
        (set(range(50, 60)), [range(47, 62)]),
    ],
)
def test_those_that_overlap_are_one(files: Files, matter: set[int], contents: list[range]) -> None:
    play(keep(files), range(100), matter)
    assert files.contents == [list(content) for content in contents]


def test_a_file_is_complete_when_nothing_can_belong_to_it_any_more(files: Files) -> None:
    keeper = keep(files)
    play(keeper, range(56), {50})
    assert not files.begun[0].complete
    keeper.look(56 * SECOND)
    assert files.begun[0].complete


def test_at_the_end_a_file_is_complete(files: Files) -> None:
    keeper = keep(files)
    play(keeper, range(51), {50})
    keeper.end()
    assert files.contents == [[47, 48, 49, 50]] and files.begun[0].complete


def test_a_file_goes_on_in_the_next_when_it_is_too_large(files: Files, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(keeper, "LARGEST", 20)
    play(keep(files), range(10, 100), range(20, 60))
    assert len(files.contents) > 2
    assert sum(files.contents, []) == list(range(17, 62))
    assert all(len(content) <= 11 for content in files.contents)


def test_a_file_knows_all_its_reasons(files: Files) -> None:
    """The last one came before the next file; a file that goes on has that of the file before."""
    keeper = keep(files)
    for second in range(30):
        reason = {10: "write", 11: "late", 12: "write", 20: "late"}.get(second, "")
        keeper.take(Entry(second * SECOND, b"%d" % second), reason)
    assert [(kept.reason, kept.reasons) for kept in files.begun] == [("write", ["write", "late"]), ("late", ["late"])]


def test_what_waits_is_bounded(files: Files, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(keeper, "MOST_HISTORY", 10)
    play(keep(files, before=30), range(10, 60), {50})
    assert files.contents == [list(range(45, 53))]
    (said,) = files.said
    assert "--before is too long for the memory: files begin 4 s before" in said


def test_what_was_written_waits_no_more(files: Files, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else each file would begin later than the one before it."""
    monkeypatch.setattr(keeper, "MOST_HISTORY", 16)
    play(keep(files, before=6), range(10, 90), range(17, 90, 20))
    assert files.said == []
    assert files.contents == [list(range(first, first + 9)) for first in range(11, 80, 20)]


def test_an_interface_that_came_up_is_in_each_later_file_once(files: Files) -> None:
    keeper = keep(files)
    for second in range(60):
        if second == 10:
            keeper.take(Entry(second * SECOND, b"interface", is_packet=False))
        keeper.take(Entry(second * SECOND, b"%d" % second), "late" if second in (11, 40) else "")
    first, second_file = files.begun
    assert (first.heading, first.blocks.count(b"interface")) == (b"heading", 1)
    assert (second_file.heading, second_file.blocks.count(b"interface")) == (b"headinginterface", 0)


def test_a_clock_that_was_set_back_begins_anew(files: Files) -> None:
    keeper = keep(files)
    play(keeper, range(1000, 1100), {1099})
    play(keeper, range(50), {1, 20})
    assert files.contents == [list(range(1096, 1100)), [0, 1, 2, 3], list(range(17, 23))]
