#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Deals an exam: each learner gets a capture and a sheet with other numbers. No answer is in either.

    python3 exam.py --seed 7 --learners 20 OUT

OUT/01 to OUT/20 are for the learners: exam.pcapng, and exam.html to print. OUT/solutions is for the teacher.
The same seed deals the same numbers. In the folder exam/ are the capture and the texts; {words} in braces are what is
drawn here.
"""

from __future__ import annotations

import argparse
import random
import sys
from collections.abc import Mapping
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "capture"))

from make import Scenario, built_telegram  # noqa: E402
from pages import markdown, tasks  # noqa: E402

TEMPLATES = {"capture.txt.in": "exam.txt", "tasks.md.in": "exam.md", "solutions.md.in": "solutions/exam.md"}
# Error codes, their words, and values in rpm that a drive refuses with them.
ERRORS = {
    "7006": ("smaller than the minimum", range(-900, -100)),
    "7007": ("greater than the maximum", range(4000, 9000)),
    "7005": ("write-protected at present", range(500, 2900)),
}
STYLE = """
body { font: 12pt sans-serif; max-width: 45em; margin: 2em auto; }
p { margin: 1em 0; overflow-wrap: anywhere; }
pre { background: #eee; padding: .5em; }
"""


def draw(chance: random.Random) -> dict[str, str]:
    """Draw the numbers of an exam: what stands in braces in its texts."""
    drive = chance.choice([3, 4, 5])
    dead = chance.choice([6, 7, 8, 11, 12])
    polls = chance.randint(2, 6)
    rpm, later = (chance.randrange(2005, 29995, 10) / 10 for _ in range(2))
    error = chance.choice(sorted(ERRORS))
    tza, pause = chance.choice([(5, 9), (10, 15), (8, 13)])
    place = chance.randint(4, 8)
    first = 3 + 2 * polls  # what follows the accepted times and the polls
    return {
        "drive": str(drive),
        "device": f"{drive:02X}",
        "dead": str(dead),
        "polls": f"command 12\nsilence 12\nreaction 12 00 04\nsilence {chance.randint(20, 40)}\n" * polls,
        "speed": _low_first(rpm),
        "later": _low_first(later),
        "later_rpm": f"{later:.4f}",
        "later_shifted": f"{later / 10:.4f}",
        "later_raw": str(round(later * 10_000)),
        "limit": _low_first(chance.choice(ERRORS[error][1])),
        "error": error,
        "error_bytes": f"{error[2:]} {error[:2]}",
        "error_words": ERRORS[error][0],
        "tza": str(tza),
        "tza_bytes": f"{tza:02X} 00",
        "pause": str(pause),
        "place": str(place),
        "refused": str(first + 5),
        "unanswered": f"{first + 6}, {first + 7}",
        "repeat": str(first + 7),
        "late": str(first + 9),
        "idle": f"{pause - 11 / 9.6:.3f}",
        "least": f"{pause - 11 / 9.6 - 0.1:.3f}",
        "asked": built_telegram(f"17>{dead} 12", reaction=False).hex(" ").upper(),
    }


def _low_first(value: float) -> str:
    """Return a number with four decimal places as four bytes."""
    return round(value * 10_000).to_bytes(4, "little", signed=True).hex(" ").upper()


def filled(template: str, words: Mapping[str, str]) -> str:
    """Put what was drawn into a text."""
    for word, text in words.items():
        template = template.replace(f"{{{word}}}", text)
    return template


def write(folder: Path, words: Mapping[str, str]) -> tasks.Lesson:
    """Write the texts of an exam, and its capture; return what it asks."""
    (folder / "solutions").mkdir(parents=True, exist_ok=True)
    for template, name in TEMPLATES.items():
        (folder / name).write_text(filled((HERE / "exam" / template).read_text(), words))
    (folder / "exam.pcapng").write_bytes(Scenario(folder / "exam.txt").capture())
    return tasks.read(folder / "exam.md")


def sheet(lesson: tasks.Lesson) -> str:
    """Return the sheet of a learner as HTML, with lines to write on."""
    parts = [f"<h1>{markdown.inline(lesson.title)}</h1><p>Name: {'_' * 40}</p>", markdown.html(lesson.head)]
    for task in lesson.tasks:
        parts += [f"<h3>{task.number}. {markdown.inline(task.text)}</h3>", markdown.html(task.lead)]
        for blank in task.blanks:
            line = " / ".join(blank.choices) or "_" * (240 if blank.kind == "finding" else 40)
            parts.append(f"<p>{markdown.inline(blank.prompt)}: {line} {blank.unit}</p>")
    return f"<!doctype html><meta charset='utf-8'><title>Exam</title><style>{STYLE}</style>{''.join(parts)}\n"


def main() -> None:
    """Deal the exams."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", metavar="OUT", type=Path, help="the folder to write; it must not be there yet")
    parser.add_argument("--seed", type=int, default=1, help="the same number deals the same exams (default 1)")
    parser.add_argument("--learners", metavar="N", type=int, default=1, help="how many (default 1)")
    given = parser.parse_args()
    if given.out.exists():
        parser.error(f"{given.out} is there: name a new folder")
    if not 1 <= given.learners <= 99:
        parser.error("--learners is 1 to 99")
    for number in range(1, given.learners + 1):
        folder = given.out / f"{number:02}"
        lesson = write(folder, draw(random.Random(f"{given.seed}-{number}")))
        (folder / "exam.html").write_text(sheet(lesson))
        (given.out / "solutions").mkdir(exist_ok=True)
        (folder / "solutions" / "exam.md").replace(given.out / "solutions" / f"{number:02}.md")
        (folder / "solutions").rmdir()
        for name in ("exam.txt", "exam.md"):
            (folder / name).unlink()


if __name__ == "__main__":
    main()
