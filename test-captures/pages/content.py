# SPDX-License-Identifier: GPL-2.0-or-later
"""The course as data for the page in a browser: texts as HTML, what is to be typed, and captures."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from base64 import b64encode
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import sistap
from lesson import recording
from make import Scenario
from pages import COURSE, glossary, markdown, tasks
from pages.tasks import Blank, Lesson, Section, Task

CAPTURE = Path(sistap.__file__).parents[1]
# How the text opens its capture in Wireshark; the page has it open.
_OPENED = re.compile(r"(?:^.+\n)*.*in the\s+folder\s+`test-captures/course`:\n\n    wireshark .*\n\n", re.MULTILINE)
# What needs a terminal, and what stands in its place in the page: for other readers, a comment that they do not see.
_TERMINAL = re.compile(r"<!-- with a terminal -->\n.*?<!-- in the page:\n(.*?\n)-->(?:\n|\Z)", re.DOTALL)
# How many lessons a day of the week has. Those after the week show other roads to a drive.
DAYS = {"Monday": 3, "Tuesday": 3, "Wednesday": 3, "Thursday": 3, "Friday": 2}
PAPERS = {"sheet": "The telegram on one page", "poster": "Poster", "wall-chart": "Wall chart"}


def lessons() -> list[Lesson]:
    """Read all lessons, in their order."""
    return [tasks.read(path) for path in sorted(COURSE.glob("[0-9][0-9]-*.md"))]


def content(folder: Path) -> dict[str, Any]:
    """Return the whole course. Captures that the virtual bus plays are kept in a folder, for the next time."""
    papers = [(name, title, (COURSE / f"{name}.svg").read_text()) for name, title in PAPERS.items()]
    return {
        "days": list(DAYS.items()),
        "lessons": [_lesson(lesson, folder) for lesson in lessons()],
        "glossary": markdown.html(glossary.text()),
        "papers": papers,
    }


def _lesson(lesson: Lesson, folder: Path) -> dict[str, Any]:
    scenario = lesson.path.with_suffix(".toml")
    return {
        "name": lesson.path.stem,
        "title": lesson.title,
        "aim": markdown.inline(lesson.aim),
        "minutes": minutes(lesson),
        "text": markdown.html(in_page(lesson.head)),
        "sections": [_section(section) for section in lesson.sections],
        "end": markdown.html(lesson.end),
        "capture": _encoded(capture(lesson, folder)),
        "proof": "" if lesson.proof == lesson.path.with_suffix(".pcapng") else _encoded(lesson.proof),
        "preferences": preferences(lesson),
        "scenario": scenario.read_text() if scenario.exists() else "",
        "seconds": _seconds(lesson),
    }


def _encoded(path: Path) -> str:
    return b64encode(path.read_bytes()).decode()


def minutes(lesson: Lesson) -> int:
    """Return how long a lesson takes: 120 words a minute to read, two minutes a blank, to the next five minutes."""
    words = len(re.findall(r"\w+", " ".join([lesson.head, *(section.text for section in lesson.sections)])))
    blanks = sum(len(task.blanks) for task in lesson.tasks)
    return 5 * math.ceil((words / 120 + 2 * blanks) / 5)


def in_page(text: str) -> str:
    """Return a text as the page has it: the capture is open, and there is no terminal."""
    return _TERMINAL.sub(r"\1", _OPENED.sub("", text, count=1))


def _section(section: Section) -> dict[str, Any]:
    return {
        "title": section.title,
        "text": markdown.html(in_page(section.text)),
        "tasks": [_task(task) for task in section.tasks],
    }


def _task(task: Task) -> dict[str, Any]:
    return {
        "number": task.number,
        "text": markdown.inline(task.text),
        "lead": markdown.html(task.lead),
        "hint": markdown.html(task.hint),
        "solution": markdown.html(task.solution),
        "blanks": [_blank(blank) for blank in task.blanks],
    }


def _blank(blank: Blank) -> dict[str, Any]:
    found = {
        "prompt": markdown.inline(blank.prompt),
        "kind": blank.kind,
        "unit": blank.unit,
        "choices": blank.choices,
        "accepted": blank.accepted,
    }
    if blank.kind == "telegram":
        return {
            **found,
            "isAnswered": blank.unit == "answered",
            "conditions": [{"filter": code, "say": say} for code, say in blank.remarks],
        }
    if blank.kind == "finding":
        return {**found, "points": [markdown.inline(say) for _, say in blank.remarks]}
    return {**found, "mistakes": [{"wrong": code, "say": say} for code, say in blank.remarks]}


def preferences(lesson: Lesson) -> dict[str, str]:
    """Return what the lesson sets with options of Wireshark."""
    text = lesson.path.with_suffix(".txt")
    words = Scenario(text).options if text.exists() else []
    return dict(word.split(":", 1) for word in words if ":" in word)


def _seconds(lesson: Lesson) -> int:
    """Return how long the bus of a lesson plays; 0 if it has none."""
    arguments = recording(lesson.path)
    return int(arguments[arguments.index("--duration") + 1]) if "--duration" in arguments else 0


def capture(lesson: Lesson, folder: Path) -> Path:
    """Return the capture of a lesson. The virtual bus writes one that is not beside it, once a version."""
    arguments = recording(lesson.path)
    if not arguments:
        return lesson.path.with_suffix(".pcapng")
    written = folder / f"{lesson.path.stem}-{_version(lesson)}.pcapng"
    if not written.exists():
        folder.mkdir(parents=True, exist_ok=True)
        for old in folder.glob(f"{lesson.path.stem}-*"):
            old.unlink(missing_ok=True)
        with TemporaryDirectory(dir=folder) as ours:  # another process may be making the same
            part = Path(ours).resolve() / written.name
            arguments[arguments.index("-w") + 1] = str(part)
            subprocess.run([sys.executable, "-m", "sistap", *arguments], cwd=CAPTURE, check=True, capture_output=True)
            part.replace(written)
    return written


def _version(lesson: Lesson) -> str:
    """Return a word that changes with the scenario, and with what plays it."""
    rooms = (CAPTURE / room for room in ("sisbus", "sistap/tap/files", "sistap/tap/records", "sistap/tap/sis"))
    sources = [path for room in rooms for path in sorted(room.rglob("*.[pt]*")) if path.suffix in (".py", ".toml")]
    found = sha256(lesson.path.read_bytes())
    for path in [*sources, lesson.path.with_suffix(".toml")]:
        if path.exists():
            found.update(path.read_bytes())
    return found.hexdigest()[:12]
