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
from itertools import accumulate
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
    Explained,
    Filter,
    Given,
    Typed,
    Value,
    clicks,
    recording,
)
from make import Scenario
from pages.content import DAYS
from pages.tasks import KNOW, PROVE, Blank, Lesson, Task, read, solutions_of
from sisbus.library import answer
from sisbus.scenarios.scenario import names
from sistap.commands.web.play import WINDER
from sistap.dissected.wireshark.tshark import Tshark
from tables import BOOLEANS

COURSE = Path(__file__).parent / "course"
LESSONS = sorted(COURSE.glob("[0-9][0-9]-*.md"))
SECTIONS = ["The case", "Remember", KNOW, "Predict", "Look", "Build", PROVE]

SISTAP = COURSE.parent.parent / "capture" / "sistap"
BUTTONS = SISTAP / "profile" / "SIS" / "dfilter_buttons"
SOURCES = {".txt", ".toml"}  # a capture as text, or a scenario of the virtual bus

COMMANDS = ("wireshark ", "python3 -m ", "py -m ")

LONG = {"13-the-night", "14-a-morning"}  # lessons whose capture takes seconds to make

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
def lesson_of(path: Path) -> Lesson:
    return read(path)


def about(lesson: Lesson, capture: Path) -> list[tuple[Path, str, list[Claim]]]:
    """Return what is claimed of which capture, and where."""
    solved = f"solutions/{lesson.path.name}"
    found = [(capture, f"{lesson.path.name}, {KNOW}", lesson.claims)]
    for section in lesson.sections:
        other = lesson.proof != lesson.path.with_suffix(".pcapng") and section.title == PROVE
        shown = lesson.proof if other else capture
        found += [(shown, f"{solved}, task {task.number}", task.claims) for task in section.tasks]
    return found


@cache
def fields(tshark: Tshark, capture: Path, names: tuple[str, ...], options: tuple[str, ...]) -> list[dict[str, str]]:
    """Return what the packets have in some fields."""
    wanted = [option for name in names for option in ("-e", name)]
    lines = tshark.output("-r", str(capture), "-2", *options, "-T", "fields", *wanted).split("\n")
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
    """tshark and sharkd with a capture of a lesson."""

    def __init__(self, path: Path, capture: Path, claims: list[Claim], tshark: Tshark, sharkd: Sharkd) -> None:
        self.path, self.capture, self.claims = path, capture, claims
        self._tshark, self._sharkd, self._options = tshark, sharkd, options(path)
        self._names = tuple(sorted({claim.field for claim in claims if isinstance(claim, Value)}))
        self._left: dict[str, list[int]] = {}

    def frames(self, expression: str) -> list[int]:
        """Return the packets that a filter leaves."""
        if expression not in self._left:
            self._left[expression] = self._frames(expression)
        return self._left[expression]

    def _frames(self, expression: str) -> list[int]:
        if not self._options:
            return self._sharkd.frames(self.capture, expression)
        shown = ("-Y", expression, "-T", "fields", "-e", "frame.number")
        return [
            int(line) for line in self._tshark.output("-r", str(self.capture), "-2", *self._options, *shown).split()
        ]

    def field(self, packet: int, name: str) -> str:
        return fields(self._tshark, self.capture, self._names, tuple(self._options))[packet - 1][name]

    def given(self, folder: Path) -> dict[tuple[bytes, ...], dict[str, str]]:
        """Return the claimed fields of the last of each lot of telegrams. Each lot is a capture of its own."""
        lots = list(dict.fromkeys(tuple(claim.telegrams) for claim in self.claims if isinstance(claim, Given)))
        names = tuple(sorted({claim.field for claim in self.claims if isinstance(claim, Given)}))
        if not lots:
            return {}
        text, made = folder / "given.txt", folder / "given.pcapng"
        parts = ("".join(f"telegram {telegram.hex(' ')}\n" for telegram in lot) for lot in lots)
        text.write_text("@link sis\n" + "section\n".join(parts))
        made.write_bytes(Scenario(text).capture())
        rows = fields(self._tshark, made, names, tuple(self._options))
        ends = accumulate(len(lot) for lot in lots)
        return {lot: rows[end - 1] for lot, end in zip(lots, ends, strict=True)}

    def printed(self, arguments: list[str]) -> list[str]:
        words = [str(self.capture) if word == self.capture.name else word for word in arguments]
        return [line.rstrip() for line in self._tshark.output(*words).splitlines()]

    def has(self, data: bytes) -> bool:
        text = self.capture.with_suffix(".txt")
        if not text.exists():
            return data in self.capture.read_bytes()
        return data in b"".join(item.data for item in Scenario(text).items)

    def telegram(self, packet: int) -> bytes:
        return Scenario(self.capture.with_suffix(".txt")).items[packet - 1].data


@pytest.fixture
def program(path: Path, capture: Path, tshark: Tshark, sharkd: Sharkd) -> Program:
    return Program(path, capture, [], tshark, sharkd)


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
        case Explained(_, packet, _):
            rows = [one.data for one in program.claims if isinstance(one, Explained) and one.packet == packet]
            return "" if b"".join(rows) == program.telegram(packet) else "are not all bytes of the packet"
    return ""  # of a Given, see below


@every_capture
def test_claims(path: Path, capture: Path, tshark: Tshark, sharkd: Sharkd) -> None:
    complaints = []
    for shown, where, said in about(lesson_of(path), capture):
        program = Program(path, shown, said, tshark, sharkd)
        for claim in said:
            if words := wrong(program, claim):
                complaints.append(f"{where}, line {claim.line}: {claim[1:]} {words}")
    assert not complaints, "\n".join(complaints)


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_given_telegrams(path: Path, tshark: Tshark, sharkd: Sharkd, tmp_path: Path) -> None:
    """Wireshark decodes the bytes of the tasks as their solutions say."""
    said = [(task.number, claim) for task in lesson_of(path).tasks for claim in task.claims if isinstance(claim, Given)]
    found = Program(path, path, [claim for _, claim in said], tshark, sharkd).given(tmp_path)
    complaints = [
        f"solutions/{path.name}, task {number}: {claim[1:]} is {decoded!r}"
        for number, claim in said
        if not same(claim.value, decoded := found[tuple(claim.telegrams)][claim.field])
    ]
    assert not complaints, "\n".join(complaints)


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_telegrams_to_build(path: Path, tshark: Tshark, sharkd: Sharkd, tmp_path: Path) -> None:
    """One telegram meets all conditions, with the reaction of a drive if it counts; what is to be repaired does not."""
    complaints = []
    for task, blank in built(lesson_of(path)):
        for place, one in enumerate([*blank.accepted, *given(task)]):
            made = tmp_path / f"{task.number}-{place}.pcapng"
            made.write_bytes(as_sent(bytes.fromhex(one), blank, tmp_path))
            program = Program(path, made, [], tshark, sharkd)
            met = [bool(program.frames(condition)) for condition, _ in blank.remarks]
            if all(met) is not (one in blank.accepted):
                complaints.append(f"{path.name}, task {task.number}: {one} meets {met}")
    assert not complaints, "\n".join(complaints)


def as_sent(telegram: bytes, blank: Blank, folder: Path) -> bytes:
    """Return a capture with a telegram, and with the reaction of a virtual drive if it counts."""
    reaction = answer(telegram, WINDER) if blank.unit == "answered" else b""
    text = folder / "built.txt"
    text.write_text("@link sis\n" + "".join(f"telegram {one.hex(' ')}\n" for one in (telegram, reaction) if one))
    return Scenario(text).capture()


def given(task: Task) -> list[str]:
    """Return the bytes that a task gives, a line each."""
    return [line.strip() for line in task.lead.splitlines() if re.fullmatch(r"    [0-9A-F]{2}( [0-9A-F]{2})*", line)]


def built(lesson: Lesson) -> list[tuple[Task, Blank]]:
    return [(task, blank) for task in lesson.tasks for blank in task.blanks if blank.kind == "telegram"]


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
    assert steps, path.name
    assert not complaints, "\n".join(complaints)


@every_lesson
def test_lesson_is_whole(path: Path) -> None:
    """What it is for, its capture, how to open it, its sections in their order, and tasks with their solutions."""
    lesson = lesson_of(path)
    number, _ = path.stem.split("-", 1)
    assert lesson.title.startswith(f"{int(number)}. ")
    assert lesson.aim.startswith("After this lesson you can ")
    assert f"\n    wireshark {' '.join(['-C SIS', *options(path)])} {path.stem}.pcapng\n" in path.read_text()
    titles = [section.title for section in lesson.sections]
    assert titles == [title for title in SECTIONS if title in titles], path.name
    assert {"The case", KNOW, "Predict", "Look"} <= set(titles), path.name
    assert [task.number for task in lesson.tasks] == list(range(1, len(lesson.tasks) + 1))
    assert solutions_of(path).read_text().startswith(f"# Solutions of lesson {int(number)}\n")


@every_lesson
def test_each_lesson_asks_two_things_of_earlier_ones(path: Path) -> None:
    remembered = [section for section in lesson_of(path).sections if section.title == "Remember"]
    assert path == LESSONS[0] or [len(section.tasks) for section in remembered] == [2], path.name


@every_lesson
def test_most_tasks_cannot_be_guessed(path: Path) -> None:
    """What is only chosen is less than half, and of three or more."""
    blanks = [blank for task in lesson_of(path).tasks for blank in task.blanks]
    chosen = [blank for blank in blanks if blank.kind == "choice"]
    assert len(chosen) <= len(blanks) / 2, path.name
    assert all(len(blank.choices) > 2 for blank in chosen), path.name


@every_lesson
def test_mistakes_are_known(path: Path) -> None:
    """Each wrong choice has its words, and so have two mistakes of what is typed. A finding has three points."""
    for task in lesson_of(path).tasks:
        for blank in task.blanks:
            known = {remark.code for remark in blank.remarks}
            where = f"{path.name}, task {task.number}: {blank.prompt}"
            assert not known & set(blank.accepted), where
            if blank.kind == "choice":
                assert known == set(blank.choices) - set(blank.accepted), where
            elif blank.kind == "finding":
                assert len(blank.remarks) >= 3, where
            else:
                assert len(known) >= 2, where


@every_lesson
def test_no_answer_stands_in_the_lesson(path: Path) -> None:
    """What is typed cannot be copied: neither the text of the lesson has it, nor a hint or another task."""
    text = " ".join(path.read_text().split()).upper()
    copied = [
        f"{path.name}, task {task.number}: {answer}"
        for task in lesson_of(path).tasks
        for blank in task.blanks
        if blank.kind in ("number", "hex", "text", "filter")
        for answer in blank.accepted
        if len(answer.split(" ")[0]) > 2 and re.search(rf"(?<![\w.]){re.escape(answer.upper())}(?![\w.]*\w)", text)
    ]
    assert not copied, "\n".join(copied)


@every_lesson
def test_each_command_has_its_folder(path: Path) -> None:
    """The paragraph before a command names the folder, or `cd` in the line above leads there."""
    blocks = re.findall(r"((?:[^\n]+\n)+)\n((?:    [^\n]+\n)+)", path.read_text())
    typed = [(before, block) for before, block in blocks if block.strip().startswith(COMMANDS)]
    assert typed
    assert [block for before, block in typed if "in the folder" not in " ".join(before.split())] == []


@every_lesson
def test_most_solutions_have_a_claim(path: Path) -> None:
    """A solution without a claim may become wrong unnoticed. What only the definition says has none."""
    tasks = lesson_of(path).tasks
    assert sum(bool(task.claims) for task in tasks) >= 2 * len(tasks) / 3, path.name


@every_lesson
def test_prose_is_wrapped(path: Path) -> None:
    for one in (path, solutions_of(path)):
        lines = enumerate(one.read_text().splitlines(), 1)
        free = re.compile(r"\||    | *- `")  # tables, what is typed, and conditions
        long = [number for number, line in lines if len(line) > 100 and not free.match(line)]
        assert not long, (one, long)


def test_crc_of_the_failed_download() -> None:
    """Lesson 12: without the bit that the line changed, the module's CRC32 is the one stored in it."""
    lesson = COURSE / "12-failed-flash-download"
    programmed = (item.data for item in Scenario(lesson.with_suffix(".txt")).items if item.data[5] == 0x02)
    blocks = [data[15:] for data in programmed if data[9] == 0x96 and len(data) > 12]  # after address and memory
    received = b"".join(blocks)
    sent = received.replace(b"\x0b", b"\x0a", 1)
    stored = int.from_bytes(received[58:62], "little")
    text = solutions_of(lesson.with_suffix(".md")).read_text()
    assert zlib.crc32(sent[:58]) == stored == 0xE2C98B44
    assert all(f"{value:#x}" in text for value in (stored, zlib.crc32(received[:58])))


def test_readme_has_every_lesson_in_order() -> None:
    readme = (COURSE.parent / "README.md").read_text()
    days = re.split(r"\*\*(\w+day|Other roads)\*\*", readme)[1:]
    assert {day: rows.count("(course/") for day, rows in zip(days[:-2:2], days[1::2], strict=False)} == DAYS
    assert re.findall(r"\(course/(\S+)[.]md\)", readme) == [path.stem for path in LESSONS]
    built_in = names()
    played = {path.stem: recording(path) for path in LESSONS}
    sources = {stem: bool(command) for stem, command in played.items() if not set(command) & set(built_in)}
    made = {
        path.stem.removesuffix("-proof"): path.suffix == ".toml" for path in COURSE.iterdir() if path.suffix in SOURCES
    }
    assert sources == made


def test_each_lesson_leads_to_the_next() -> None:
    for path, following in zip(LESSONS, LESSONS[1:], strict=False):
        assert f"]({following.name})" in path.read_text().splitlines()[-1], path.name
