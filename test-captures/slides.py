#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes slides of the lessons, from the same texts: one file for a browser, a page for each part.

    python3 slides.py OUT.html [LESSON ...]        LESSON is a number, such as 6; without one, all of the week

Page Down and Page Up turn the pages; printing gives a slide on each sheet. No solution is on them.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "capture"))

from pages import markdown  # noqa: E402
from pages.content import DAYS, in_page, lessons  # noqa: E402
from pages.tasks import Lesson, Section  # noqa: E402

WEEK = range(1, sum(DAYS.values()) + 1)
SHOWN = ("The case", "What to know", "Predict", "Build", "Prove")  # what a class does together
LONGEST = 90  # words on a slide
ROWS = 10  # of a table

STYLE = """
html { scroll-snap-type: y mandatory; font: 3.1vmin/1.4 "Liberation Sans", Arial, sans-serif; }
body { margin: 0; }
section { min-height: 100vh; box-sizing: border-box; padding: 5vmin 8vmin; }
section { scroll-snap-align: start; break-after: page; }
h1 { font-size: 6vmin; } h2 { color: #0a5c8a; } pre, code { font-family: "Liberation Mono", monospace; }
pre { background: #eef2f5; padding: 1vmin 2vmin; font-size: 3.4vmin; }
table { border-collapse: collapse; } td, th { border-bottom: 1px solid #aaa; padding: .3em .8em; text-align: left; }
footer { color: #666; font-size: 1.8vmin; margin-top: 3vmin; }
@page { size: A4 landscape; margin: 0; }
"""


def slides(lesson: Lesson) -> Iterator[str]:
    """Return the slides of a lesson as HTML: its title, then its sections, cut where they are too long."""
    yield f"<h1>{markdown.inline(lesson.title)}</h1><p>{markdown.inline(lesson.aim)}</p>"
    for section in lesson.sections:
        if section.title in SHOWN:
            yield from _section(section)


def _section(section: Section) -> Iterator[str]:
    heading = f"<h2>{markdown.inline(section.title)}</h2>"
    for text in _portions(in_page(section.text)):
        yield heading + markdown.html(text)
    for task in section.tasks:
        asked = "".join(f"<li>{markdown.inline(blank.prompt)}</li>" for blank in task.blanks)
        yield f"{heading}<h3>{task.number}. {markdown.inline(task.text)}</h3>{markdown.html(task.lead)}<ul>{asked}</ul>"


def _portions(text: str) -> Iterator[str]:
    """Cut a text between its paragraphs, lists and tables."""
    portion: list[str] = []
    for block in (part for whole in re.split(r"\n\n(?!    )", text) if whole.strip() for part in _tables(whole)):
        if portion and len(" ".join([*portion, block]).split()) > LONGEST:
            yield "\n\n".join(portion)
            portion = []
        portion.append(block)
    if portion:
        yield "\n\n".join(portion)


def _tables(block: str) -> Iterator[str]:
    """Cut a table between its rows, and repeat its head."""
    head, *rows = block.split("\n")
    if not head.startswith("|"):
        yield block
    else:
        for first in range(1, len(rows), ROWS):
            yield "\n".join([head, rows[0], *rows[first : first + ROWS]])


def page(chosen: list[Lesson]) -> str:
    """Return all slides as one page of HTML."""
    shown = [(lesson.title, slide) for lesson in chosen for slide in slides(lesson)]
    body = "".join(
        f"<section>{slide}<footer>{markdown.inline(title)} &middot; {number} of {len(shown)}</footer></section>\n"
        for number, (title, slide) in enumerate(shown, 1)
    )
    head = f'<!doctype html>\n<html lang="en"><meta charset="utf-8"><title>SIS: slides</title><style>{STYLE}</style>'
    return f"{head}\n{body}</html>\n"


def main() -> None:
    """Write the slides."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", metavar="OUT.html", type=Path)
    parser.add_argument("lesson", metavar="LESSON", type=int, nargs="*")
    given = parser.parse_args()
    numbered = {int(lesson.path.stem[:2]): lesson for lesson in lessons()}
    unknown = sorted(set(given.lesson) - set(numbered))
    if unknown:
        parser.error(f"there is no lesson {unknown[0]}: they are 1 to {max(numbered)}")
    given.out.write_text(page([numbered[number] for number in given.lesson or WEEK]))


if __name__ == "__main__":
    main()
