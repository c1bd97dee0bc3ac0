# SPDX-License-Identifier: GPL-2.0-or-later
"""Exams that are dealt: each has other numbers, all solutions are true, and no answer is in what a learner gets."""

from __future__ import annotations

import random
import subprocess
import sys
from pathlib import Path

import pytest
from sharkd import Sharkd

from exam import draw, write
from lesson import Given
from sistap.dissected.wireshark.tshark import Tshark
from test_course import Program, wrong

EXAM = Path(__file__).parent / "exam.py"


@pytest.mark.parametrize("seed", range(4))
def test_solutions_are_true(seed: int, tmp_path: Path, tshark: Tshark, sharkd: Sharkd) -> None:
    """Wireshark says so, of what was drawn."""
    lesson = write(tmp_path, draw(random.Random(seed)))
    for task in lesson.tasks:
        program = Program(lesson.path, lesson.path.with_suffix(".pcapng"), task.claims, tshark, sharkd)
        assert [(claim, said) for claim in task.claims if (said := wrong(program, claim))] == []
    (asked,) = (blank for task in lesson.tasks for blank in task.blanks if blank.kind == "telegram")
    built = [bytes.fromhex(one) for one in asked.accepted]
    program = Program(lesson.path, lesson.path, [Given(1, built, "sis.checksum.status", "1")], tshark, sharkd)
    assert program.given(tmp_path) == {tuple(built): {"sis.checksum.status": "1"}}


def test_a_value_by_hand() -> None:
    """1234.5 rpm with four decimal places: 12345000, 0x00BC5EA8."""

    class Drawn(random.Random):
        def randrange(self, *_: object) -> int:
            return 12345

    words = draw(Drawn(1))
    assert (words["later"], words["later_rpm"]) == ("A8 5E BC 00", "1234.5000")


def test_no_answer_is_in_what_a_learner_gets(tmp_path: Path) -> None:
    """And the same seed deals the same, each learner other numbers."""
    out, again = tmp_path / "out", tmp_path / "again"
    for folder in (out, again):
        subprocess.run([sys.executable, str(EXAM), "--seed", "7", "--learners", "3", str(folder)], check=True)
    files = {str(path.relative_to(out)): path.read_bytes() for path in sorted(out.rglob("*.*"))}
    assert list(files) == [
        *(f"{number:02}/exam.{kind}" for number in (1, 2, 3) for kind in ("html", "pcapng")),
        *(f"solutions/{number:02}.md" for number in (1, 2, 3)),
    ]
    assert files == {str(path.relative_to(again)): path.read_bytes() for path in sorted(again.rglob("*.*"))}
    assert len({files[f"{number:02}/exam.pcapng"] for number in (1, 2, 3)}) == 3
    words = draw(random.Random("7-1"))
    shown = files["01/exam.html"].decode()
    assert words["later"] in shown
    assert "{" not in shown.partition("</style>")[2]
    assert not [key for key in ("later_rpm", "error_words", "asked", "least") if words[key] in shown]


def test_a_folder_that_is_there_is_kept(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, str(EXAM), str(tmp_path)], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "name a new folder" in done.stderr
