# SPDX-License-Identifier: GPL-2.0-or-later
"""The claims of the lessons are true, and all lessons have the same structure."""

from __future__ import annotations

import re
from decimal import Decimal, InvalidOperation
from functools import cache
from pathlib import Path

import pytest
from sharkd import Sharkd

from lesson import Bytes, Claim, Command, Filter, Value, claims
from make import Scenario
from sistap.wireshark.tshark import Tshark
from tables import BOOLEANS

COURSE = Path(__file__).parent / "course"
LESSONS = sorted(COURSE.glob("*.md"))
ANSWER = re.compile(r"<details>\n<summary>Answer</summary>\n\n(.*?)\n\n</details>", re.DOTALL)

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
    """Return what the capture has instead, or nothing."""
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


@every_lesson
def test_lesson_is_whole(path: Path) -> None:
    """The goal, the capture, how to open it, and three to five questions with answers."""
    text = path.read_text()
    number, name = path.stem.split("-", 1)
    assert text.startswith(f"# {int(number)}. ")
    assert text.split("\n")[2].startswith("After this lesson you can ")
    assert f"\n    wireshark -C SIS {path.stem}.pcapng\n" in text
    assert all(f"\n## {part}\n" in text for part in ("The case", "What to know", "Click", "Try", "Questions")), name
    questions = re.findall(r"^\*\*(\d)\. .*\*\*$", text, re.MULTILINE)
    assert questions == [str(number) for number in range(1, len(questions) + 1)]
    assert 3 <= len(questions) <= 5
    assert len(ANSWER.findall(text)) == len(questions) == text.count("<details>")


@every_lesson
def test_every_answer_has_a_claim(path: Path) -> None:
    """An answer without a claim may become wrong unnoticed."""
    text = path.read_text()
    claimed = [claim.line for claim in claims(path)]
    for answer in ANSWER.finditer(text):
        first, last = (text[:place].count("\n") + 1 for place in answer.span())
        assert any(first < line < last for line in claimed), f"{path.name}:{first}"


def test_readme_has_every_lesson_in_order() -> None:
    readme = (COURSE.parent / "README.md").read_text()
    assert re.findall(r"\(course/(\S+)[.]md\)", readme) == [path.stem for path in LESSONS]
    assert [path.with_suffix(".txt") for path in LESSONS] == sorted(COURSE.glob("*.txt"))


def test_each_lesson_leads_to_the_next() -> None:
    for path, following in zip(LESSONS, LESSONS[1:], strict=False):
        assert f"]({following.name})" in path.read_text().splitlines()[-1], path.name
