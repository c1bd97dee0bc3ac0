# SPDX-License-Identifier: GPL-2.0-or-later
"""The claims of the lessons are true, and all lessons have the same structure."""

from __future__ import annotations

import csv
import re
import subprocess
import sys
import zlib
from collections.abc import Callable
from decimal import Decimal, InvalidOperation
from functools import cache
from pathlib import Path

import pytest
from sharkd import Sharkd

from lesson import (
    Button,
    Bytes,
    Claim,
    Click,
    Clicked,
    Command,
    Dialog,
    Filter,
    Typed,
    Value,
    claims,
    clicks,
    recording,
)
from make import Scenario
from sisbus.scenarios.scenario import names
from sistap.dissected.wireshark.tshark import Tshark
from tables import BOOLEANS

COURSE = Path(__file__).parent / "course"
LESSONS = sorted(COURSE.glob("*.md"))
ANSWER = re.compile(r"<details>\n<summary>Answer</summary>\n\n(.*?)\n\n</details>", re.DOTALL)

SISTAP = COURSE.parent.parent / "capture" / "sistap"
BUTTONS = SISTAP / "profile" / "SIS" / "dfilter_buttons"
SOURCES = {".txt", ".toml"}  # a capture as text, or a scenario of the virtual bus

COMMANDS = ("wireshark ", "python3 -m ", "py -m ")

LONG = {"19-the-night", "20-a-morning"}  # lessons whose capture takes seconds to make

every_capture = pytest.mark.parametrize(
    "path",
    [pytest.param(path, marks=pytest.mark.thorough) if path.stem in LONG else path for path in LESSONS],
    ids=lambda path: path.stem,
)


def every_lesson(check: Callable[[Path], None]) -> Callable[[], None]:
    """Make one test of a check of a lesson's text."""

    @pytest.mark.style
    def test() -> None:
        for path in LESSONS:
            check(path)

    return test


@pytest.fixture(scope="session")
def recorded() -> dict[Path, Path]:
    """Captures of lessons that the virtual bus plays, by lesson; `capture` fills it."""
    return {}


@pytest.fixture
def capture(path: Path, recorded: dict[Path, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The lesson's capture: the one beside it, or what its command writes."""
    arguments = recording(path)
    if not arguments:
        return path.with_suffix(".pcapng")
    if path not in recorded:
        written = tmp_path_factory.mktemp(path.stem) / f"{path.stem}.pcapng"
        arguments[arguments.index("-w") + 1] = str(written)
        subprocess.run([sys.executable, "-m", "sistap", *arguments], cwd=SISTAP.parent, check=True, capture_output=True)
        recorded[path] = written
    return recorded[path]


def options(path: Path) -> list[str]:
    """Return the options of tshark and Wireshark that the lesson needs."""
    text = path.with_suffix(".txt")
    return Scenario(text).options if text.exists() else []


@cache
def fields(tshark: Tshark, path: Path, capture: Path) -> list[dict[str, str]]:
    """Return what the packets have in the fields that the lesson names."""
    names = sorted({claim.field for claim in claims(path) if isinstance(claim, Value)})
    wanted = [option for name in names for option in ("-e", name)]
    lines = tshark.output("-r", str(capture), "-2", *options(path), "-T", "fields", *wanted).split("\n")
    return [dict(zip(names, line.split("\t"), strict=False)) for line in lines]


def same(claimed: str, found: str) -> bool:
    """Compare values; of times and numbers, 0.012 and 0.012000000 are the same."""
    if claimed == "there":
        return found != ""
    try:
        return Decimal(claimed) == Decimal(found)
    except InvalidOperation:
        return claimed == ",".join(BOOLEANS.get(value, value) for value in found.split(","))


class Program:
    """tshark and sharkd with the capture of a lesson."""

    def __init__(self, path: Path, capture: Path, tshark: Tshark, sharkd: Sharkd) -> None:
        self.path, self.capture = path, capture
        self._tshark, self._sharkd, self._options = tshark, sharkd, options(path)
        self._left: dict[str, list[int]] = {}

    def frames(self, expression: str) -> list[int]:
        """Return the packets that a filter leaves."""
        if expression not in self._left:
            self._left[expression] = self._frames(expression)
        return self._left[expression]

    def _frames(self, expression: str) -> list[int]:
        if not self._options:
            return self._sharkd.frames(self.capture, expression)
        command = (
            "-r",
            str(self.capture),
            "-2",
            *self._options,
            "-Y",
            expression,
            "-T",
            "fields",
            "-e",
            "frame.number",
        )
        return [int(line) for line in self._tshark.output(*command).split()]

    def field(self, packet: int, name: str) -> str:
        return fields(self._tshark, self.path, self.capture)[packet - 1][name]

    def printed(self, arguments: list[str]) -> list[str]:
        words = [str(self.capture) if word == f"{self.path.stem}.pcapng" else word for word in arguments]
        return [line.rstrip() for line in self._tshark.output(*words).splitlines()]

    def has(self, data: bytes) -> bool:
        text = self.path.with_suffix(".txt")
        if not text.exists():
            return data in self.capture.read_bytes()
        return data in b"".join(item.data for item in Scenario(text).items)


@pytest.fixture
def program(path: Path, capture: Path, tshark: Tshark, sharkd: Sharkd) -> Program:
    return Program(path, capture, tshark, sharkd)


def wrong(program: Program, claim: Claim) -> str:
    """Tell what the capture says instead, or nothing."""
    match claim:
        case Filter(_, expression, expected):
            left = program.frames(expression)
            return "" if left == expected else f"leaves {left}"
        case Value(_, packet, name, value):
            found = program.field(packet, name)
            return "" if same(value, found) else f"is {found!r}"
        case Command(_, arguments, output):
            lines = program.printed(arguments)
            return "" if lines == output else "\n".join(["prints", *lines])
        case Bytes(_, data):
            return "" if program.has(data) else "are not in the capture"


@every_capture
def test_claims(path: Path, program: Program) -> None:
    complaints = []
    for claim in claims(path):
        if words := wrong(program, claim):
            complaints.append(f"{path.name}:{claim.line}: {claim[1:]} {words}")
    assert not complaints, "\n".join(complaints)


def buttons() -> dict[str, str]:
    """Return the filters of the profile's buttons by their names."""
    rows = csv.reader(line for line in BUTTONS.read_text().splitlines() if not line.startswith("#"))
    return {name: expression for _, name, expression, _ in rows}


class Window:
    """Wireshark's window as far as it counts here: a capture, and the filter in force."""

    def __init__(self, program: Program) -> None:
        self._program, self._filter = program, ""

    def click(self, click: Click) -> str:
        """Do it, and tell why it cannot be done, or nothing."""
        match click:
            case Button(name):
                self._filter = buttons()[name]
            case Typed(expression):
                self._filter = expression
            case Clicked(packets):
                hidden = set(packets) - set(self._program.frames(self._filter or "frame"))
                return f"hides packets {sorted(hidden)}" if hidden else ""
            case Dialog(menu):
                return f"is in force at {menu}" if self._filter else ""
        return ""


@every_capture
def test_clicks(path: Path, program: Program) -> None:
    """A display filter in force hides what the next click names."""
    window = Window(program)
    steps = clicks(path.read_text())
    complaints = [
        f"{path.name}, step {number}: the filter {words}"
        for number, step in enumerate(steps, 1)
        for click in step
        if (words := window.click(click))
    ]
    assert any(isinstance(click, Clicked) for step in steps for click in step)
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
    assert f"\n    wireshark {' '.join(['-C SIS', *options(path)])} {path.stem}.pcapng\n" in text
    assert all(f"\n## {part}\n" in text for part in ("The case", "What to know", "Click", "Try", "Questions")), name
    questions = re.findall(r"^\*\*(\d)\. .*\*\*$", text, re.MULTILINE)
    assert questions == [str(number) for number in range(1, len(questions) + 1)]
    assert 3 <= len(questions) <= 6
    assert len(ANSWER.findall(text)) == len(questions) == text.count("<summary>Answer</summary>")


@every_lesson
def test_each_command_has_its_folder(path: Path) -> None:
    """The paragraph before a command names the folder, or `cd` in the line above leads there."""
    blocks = re.findall(r"((?:[^\n]+\n)+)\n((?:    [^\n]+\n)+)", path.read_text())
    typed = [(before, block) for before, block in blocks if block.strip().startswith(COMMANDS)]
    assert typed
    assert [block for before, block in typed if "in the folder" not in " ".join(before.split())] == []


@every_lesson
def test_every_answer_has_a_claim(path: Path) -> None:
    """An answer without a claim may become wrong unnoticed."""
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
    built_in = names()
    played = {path.stem: recording(path) for path in LESSONS}
    sources = {stem: bool(command) for stem, command in played.items() if not set(command) & set(built_in)}
    assert sources == {path.stem: path.suffix == ".toml" for path in COURSE.iterdir() if path.suffix in SOURCES}


def test_each_lesson_leads_to_the_next() -> None:
    for path, following in zip(LESSONS, LESSONS[1:], strict=False):
        assert f"]({following.name})" in path.read_text().splitlines()[-1], path.name
