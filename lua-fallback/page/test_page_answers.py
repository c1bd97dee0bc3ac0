# SPDX-License-Identifier: GPL-2.0-or-later
"""Answers as people type them: test-captures/pages/spellings.tsv, and what is said of mistakes."""

from __future__ import annotations

import csv
import json
import shutil
import subprocess
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from pages import HERE

SPELLINGS = HERE / "spellings.tsv"
VERDICTS = {"right": True, "wrong": False, "unread": None}

Said = list[dict[str, Any]]


@pytest.fixture
def answers(tmp_path: Path) -> Callable[..., Said]:
    """Return what the page says of answers."""
    if shutil.which("node") is None:
        pytest.skip("needs node")

    def run(tried: Sequence[tuple[Any, ...]]) -> Said:
        path = tmp_path / "tried.json"
        path.write_text(json.dumps(tried))
        command = ["node", str(Path(__file__).parent / "test" / "spellings.mjs"), str(path)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[-3000:]
        said: Said = json.loads(done.stdout)
        return said

    return run


def ask(form: str, accepted: str, **mistakes: str) -> dict[str, Any]:
    """Make a blank from what a lesson writes, such as `number, ms`."""
    kind, _, unit = form.partition(", ")
    told = [{"wrong": wrong, "say": say} for wrong, say in mistakes.items()]
    return {
        "prompt": "",
        "kind": kind,
        "unit": unit,
        "accepted": accepted.split(" or "),
        "choices": [],
        "mistakes": told,
    }


def test_spellings_are_judged_as_a_teacher_would(answers: Callable[..., Said]) -> None:
    with SPELLINGS.open(newline="") as file:
        rows = list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
    verdicts = Counter(row["verdict"] for row in rows)
    assert verdicts["right"] >= 130
    assert verdicts["wrong"] + verdicts["unread"] >= 70
    found = answers([(ask(row["kind"], row["accepted"]), row["typed"]) for row in rows])
    assert all(said["say"] for said in found)
    misjudged = [
        (row["kind"], row["accepted"], row["typed"], row["verdict"], said)
        for row, said in zip(rows, found, strict=True)
        if said["right"] is not VERDICTS[row["verdict"]]
    ]
    assert misjudged == []


@pytest.mark.parametrize(
    ("form", "accepted", "typed", "words"),
    [
        ("number, rpm", "10 rpm", "10 ms", "That is a time; a speed is asked."),
        ("number, rpm", "100.0000 rpm", "1000", "The digits are right. Count the decimal places."),
        ("number, ms", "12 ms", "12 s", "The digits are right. Look at the unit."),
        ("number", "16", "10", "That is the number in hexadecimal; a decimal one is asked."),
        ("number", "27", "1B", "That is the number in hexadecimal; a decimal one is asked."),
        ("number", "1000000", "1078071040", "The bytes are in reverse order."),
        ("number", "5", "1280", "The bytes are in reverse order."),
        ("hex", "C3", "195", "That is the number in decimal; a hexadecimal one is asked."),
        ("hex", "80 96 98 00", "00 98 96 80", "The bytes are in reverse order."),
        ("packets", "3, 5, 9", "3, 4, 5", "2 right, 1 missing, 1 too many."),
    ],
)
def test_a_mistake_is_named(form: str, accepted: str, typed: str, words: str, answers: Callable[..., Said]) -> None:
    (said,) = answers([(ask(form, accepted), typed)])
    assert said["right"] is not True
    assert said["say"] == words


@pytest.mark.parametrize(
    ("form", "accepted", "mistake", "typed"),
    [
        ("number, rpm", "100.0000 rpm", "1000 rpm", "1.000 U/min"),
        ("number, rpm", "100.0000 rpm", "100 ms", "0.1 s"),
        ("number", "27", "1B", "1B"),
        ("hex", "7007", "07 70", "0x07 0x70"),
        ("text", "S-0-0036", "P-0-0036", "p 0 36"),
        ("packets", "3, 5", "3-5", "3 to 5"),
        ("choice", "low", "nobody can know", "nobody can know"),
    ],
)
def test_known_mistakes_have_their_words(
    form: str, accepted: str, mistake: str, typed: str, answers: Callable[..., Said]
) -> None:
    asked = ask(form, accepted, **{mistake: "You did this."})
    one, other = answers([(asked, typed), (asked, accepted)])
    assert one == {"right": False, "say": "You did this."}
    assert other["right"] is True


def test_the_first_reading_of_a_mistake_counts(answers: Callable[..., Said]) -> None:
    """-2.404 is also -2404, as Germans write thousands."""
    (said,) = answers([(ask("number, mm", "-24.04 mm", **{"-2404 mm": "None.", "-2.404 mm": "Three."}), "-2.404 mm")])
    assert said == {"right": False, "say": "Three."}


def test_a_value_is_not_the_bytes_of_the_line(answers: Callable[..., Said]) -> None:
    asked = ask("hex", "7007 or 07 70", **{"0770": "Those are the bytes.", "70 07": "That is the value."})
    said = answers([(asked, typed) for typed in ("7007", "07 70", "0770", "70 07")])
    assert [one["say"] for one in said] == ["Right.", "Right.", "Those are the bytes.", "That is the value."]


def test_a_number_without_unit_has_that_of_the_prompt(answers: Callable[..., Said]) -> None:
    asked = {**ask("number", "1500"), "prompt": "Speed of the motor then, in rpm"}
    said = answers([(asked, "1500 U/min"), (asked, "1500 ms"), (asked, "1500")])
    assert [one["right"] for one in said] == [True, False, True]


def test_a_unit_that_only_the_lesson_knows(answers: Callable[..., Said]) -> None:
    asked = ask("number, Nm", "12")
    said = answers([(asked, "12 Nm"), (asked, "12"), (asked, "12 ms"), (asked, "12 kg")])
    assert [one["right"] for one in said] == [True, True, False, None]


def test_filters_are_what_they_leave(answers: Callable[..., Said]) -> None:
    """So is a mistake."""
    leaves = {"talker": [2, 4], "station": [2, 4], "sender": [1, 2, 3], "from": [1, 2, 3], "all": [1, 2, 3, 4]}
    asked = ask("filter", "talker", sender="The sender of a reaction is the master.")
    said = answers([(asked, typed, leaves) for typed in ("talker", "station", "from", "all", "nonsense")])
    assert [(one["right"], one["say"]) for one in said] == [
        (True, "Right."),
        (True, "Right."),
        (False, "The sender of a reaction is the master."),
        (False, "That leaves 4 packets, 2 of them right."),
        (None, "nonsense is no filter"),
    ]
