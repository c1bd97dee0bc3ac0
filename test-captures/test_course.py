# SPDX-License-Identifier: GPL-2.0-or-later
"""What the lessons of the course claim is so, and each is built as the others are."""

from __future__ import annotations

import csv
import re
import zlib
from decimal import Decimal, InvalidOperation
from functools import cache
from pathlib import Path

import pytest
from sharkd import Sharkd

from lesson import Button, Bytes, Claim, Click, Clicked, Command, Dialog, Filter, Typed, Value, claims, clicks
from make import Scenario
from sistap.wireshark.tshark import Tshark
from tables import BOOLEANS

COURSE = Path(__file__).parent / "course"
LESSONS = sorted(COURSE.glob("*.md"))
ANSWER = re.compile(r"<details>\n<summary>Answer</summary>\n\n(.*?)\n\n</details>", re.DOTALL)

BUTTONS = COURSE.parent.parent / "capture" / "sistap" / "profile" / "SIS" / "dfilter_buttons"

every_lesson = pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)


def capture(path: Path) -> str:
    return str(path.with_suffix(".pcapng"))


@cache
def fields(tshark: Tshark, path: Path) -> list[dict[str, str]]:
    """Return what the packets have in the fields that the lesson names."""
    names = sorted({claim.field for claim in claims(path) if isinstance(claim, Value)})
    options = [option for name in names for option in ("-e", name)]
    lines = tshark.output("-r", capture(path), "-2", "-T", "fields", *options).split("\n")
    return [dict(zip(names, line.split("\t"), strict=False)) for line in lines]


def same(claimed: str, found: str) -> bool:
    """Compare values; of times and numbers, 0.012 and 0.012000000 are the same."""
    if claimed == "there":
        return found != ""
    try:
        return Decimal(claimed) == Decimal(found)
    except InvalidOperation:
        return claimed == ",".join(BOOLEANS.get(value, value) for value in found.split(","))


def printed(tshark: Tshark, path: Path, arguments: list[str]) -> list[str]:
    words = [capture(path) if word == path.with_suffix(".pcapng").name else word for word in arguments]
    return [line.rstrip() for line in tshark.output(*words).splitlines()]


def wrong(tshark: Tshark, sharkd: Sharkd, path: Path, claim: Claim) -> str:
    """Tell what the capture says instead, or nothing."""
    match claim:
        case Filter(_, expression, expected):
            left = sharkd.frames(path.with_suffix(".pcapng"), expression)
            return "" if left == expected else f"leaves {left}"
        case Value(_, packet, name, value):
            found = fields(tshark, path)[packet - 1][name]
            return "" if same(value, found) else f"is {found!r}"
        case Command(_, arguments, output):
            lines = printed(tshark, path, arguments)
            return "" if lines == output else "\n".join(["prints", *lines])
        case Bytes(_, data):
            line = b"".join(item.data for item in Scenario(path.with_suffix(".txt")).items)
            return "" if data in line else "are not in the capture"


@every_lesson
def test_claims(path: Path, tshark: Tshark, sharkd: Sharkd) -> None:
    complaints = []
    for claim in claims(path):
        if words := wrong(tshark, sharkd, path, claim):
            complaints.append(f"{path.name}:{claim.line}: {claim[1:]} {words}")
    assert not complaints, "\n".join(complaints)


def buttons() -> dict[str, str]:
    """Return the filters of the profile's buttons by their names."""
    rows = csv.reader(line for line in BUTTONS.read_text().splitlines() if not line.startswith("#"))
    return {name: expression for _, name, expression, _ in rows}


class Window:
    """Wireshark's window as far as it counts here: a capture, and the filter in force."""

    def __init__(self, sharkd: Sharkd, capture: Path) -> None:
        self._sharkd, self._capture, self._filter = sharkd, capture, ""

    def click(self, click: Click) -> str:
        """Do it, and tell why it cannot be done, or nothing."""
        match click:
            case Button(name):
                self._filter = buttons()[name]
            case Typed(expression):
                self._filter = expression
            case Clicked(packets):
                hidden = set(packets) - set(self._sharkd.frames(self._capture, self._filter or "frame"))
                return f"hides packets {sorted(hidden)}" if hidden else ""
            case Dialog(menu):
                return f"is in force at {menu}" if self._filter else ""
        return ""


@every_lesson
def test_clicks(path: Path, sharkd: Sharkd) -> None:
    """A display filter in force hides what the next click names."""
    window = Window(sharkd, path.with_suffix(".pcapng"))
    steps = clicks(path.read_text())
    complaints = [
        f"{path.name}, step {number}: the filter {words}"
        for number, step in enumerate(steps, 1)
        for click in step
        if (words := window.click(click))
    ]
    assert steps
    assert not complaints, "\n".join(complaints)


@every_lesson
def test_no_filter_is_left_for_the_questions(path: Path) -> None:
    tries = path.read_text().split("\n## Try\n")[1].split("\n## Questions\n")[0]
    assert "Clear the filter" in tries


@every_lesson
def test_lesson_is_whole(path: Path) -> None:
    """What it is for, its capture, how to open it, and three to six questions with their answers."""
    text = path.read_text()
    number, name = path.stem.split("-", 1)
    assert text.startswith(f"# {int(number)}. ")
    assert text.split("\n")[2].startswith("After this lesson you can ")
    assert f"\n    wireshark -C SIS {path.stem}.pcapng\n" in text
    assert all(f"\n## {part}\n" in text for part in ("The case", "What to know", "Click", "Try", "Questions")), name
    questions = re.findall(r"^\*\*(\d)\. .*\*\*$", text, re.MULTILINE)
    assert questions == [str(number) for number in range(1, len(questions) + 1)]
    assert 3 <= len(questions) <= 6
    assert len(ANSWER.findall(text)) == len(questions) == text.count("<details>")


@every_lesson
def test_every_answer_has_a_claim(path: Path) -> None:
    """What no claim holds may go stale."""
    text = path.read_text()
    claimed = [claim.line for claim in claims(path)]
    for answer in ANSWER.finditer(text):
        first, last = (text[:place].count("\n") + 1 for place in answer.span())
        assert any(first < line < last for line in claimed), f"{path.name}:{first}"


@every_lesson
def test_prose_is_wrapped(path: Path) -> None:
    lines = enumerate(path.read_text().splitlines(), 1)
    assert not [number for number, line in lines if len(line) > 100 and not line.startswith(("|", "    "))]


def test_crc_of_the_failed_download() -> None:
    """Lesson 13: without the bit that the line changed, the module's CRC32 is the one stored in it."""
    lesson = COURSE / "13-failed-flash-download"
    programmed = (item.data for item in Scenario(lesson.with_suffix(".txt")).items if item.data[5] == 0x02)
    blocks = [data[15:] for data in programmed if data[9] == 0x96 and len(data) > 12]  # after address and memory
    received = b"".join(blocks)
    sent = received.replace(b"\x0b", b"\x0a", 1)
    stored = int.from_bytes(received[58:62], "little")
    text = lesson.with_suffix(".md").read_text()
    assert zlib.crc32(sent[:58]) == stored == 0xE2C98B44
    assert all(f"{value:#x}" in text for value in (stored, zlib.crc32(received[:58])))


def test_readme_has_every_lesson_in_order() -> None:
    readme = (COURSE.parent / "README.md").read_text()
    assert re.findall(r"\(course/(\S+)[.]md\)", readme) == [path.stem for path in LESSONS]
    assert [path.with_suffix(".txt") for path in LESSONS] == sorted(COURSE.glob("*.txt"))


def test_each_lesson_leads_to_the_next() -> None:
    for path, following in zip(LESSONS, LESSONS[1:], strict=False):
        assert f"]({following.name})" in path.read_text().splitlines()[-1], path.name
