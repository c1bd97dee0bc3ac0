# SPDX-License-Identifier: GPL-2.0-or-later
"""Slides have every part of a lesson that a class does together, and no solution."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from pages.content import lessons
from slides import LONGEST, slides

SLIDES = Path(__file__).parent / "slides.py"


def test_slides_of_a_lesson(tmp_path: Path) -> None:
    out = tmp_path / "slides.html"
    subprocess.run([sys.executable, str(SLIDES), str(out), "1"], check=True)
    text, lesson = out.read_text(), lessons()[0]
    shown = [task for section in lesson.sections for task in section.tasks if section.title not in ("Remember", "Look")]
    assert re.findall(r"<h3>(\d+)\.", text) == [str(task.number) for task in shown]
    assert text.count("<section>") == len(list(slides(lesson)))
    assert f"of {text.count('<section>')}</footer>" in text
    told = [blank.remarks[0].say for task in shown for blank in task.blanks]
    assert not [words for words in told if words in text]


def test_no_slide_is_longer_than_a_screen() -> None:
    """Words of its text; tables may have more, in small rows."""
    long = [
        (lesson.path.stem, len(words), slide[:60])
        for lesson in lessons()
        for slide in slides(lesson)
        if len(words := re.sub(r"<[^>]*>", " ", re.sub(r"<table.*?</table>", "", slide, flags=re.DOTALL)).split())
        > 1.6 * LONGEST
    ]
    assert long == []


def test_a_lesson_that_is_not_there_is_named(tmp_path: Path) -> None:
    command = [sys.executable, str(SLIDES), str(tmp_path / "out.html"), "99"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "there is no lesson 99: they are 1 to 19" in done.stderr
