# SPDX-License-Identifier: GPL-2.0-or-later
"""The pages of the course, without a browser: what is in them, and that nothing in them comes from outside."""

from __future__ import annotations

import json
import re
from base64 import b64encode
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest
from sharkd import Sharkd

from lesson import Filter, recording
from pages import HERE, markdown, page, questions, workbench
from pages.__main__ import lessons
from pages.dissection import buttons, chosen, dissection, rules

LESSONS = lessons()
READABLE = {
    "number": r"0x[0-9a-f]+|-?\d+(\.\d+)?( \w+)?",
    "packets": r"none|\d+(-\d+)?(, \d+(-\d+)?)*",
    "hex": r"[0-9A-F ]+",
    "filter": r"\S.*",
    "text": r"\S.*",
    "choice": r"\S.*",
}

every_lesson = pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.path.stem)
first_lesson = next(lesson for lesson in LESSONS if lesson.path.stem == "01-first-telegram")
SHORT = [lesson for lesson in LESSONS if not recording(lesson.path)]


@pytest.fixture(scope="module")
def data(sharkd: Sharkd) -> dict[str, Any]:
    return dissection(sharkd, first_lesson, first_lesson.path.with_suffix(".pcapng"))


@every_lesson
def test_every_question_can_be_checked(lesson: questions.Lesson) -> None:
    assert [question.number for question in lesson.questions] == list(range(1, len(lesson.questions) + 1))
    for question in lesson.questions:
        assert question.hint
        assert question.answer
        assert question.asks
        for ask in question.asks:
            assert ask.accepted
            assert all(re.fullmatch(READABLE[ask.kind], one) for one in ask.accepted), ask
            assert len(ask.choices) != 1


@pytest.mark.parametrize("lesson", SHORT, ids=lambda lesson: lesson.path.stem)
def test_filters_of_answers_leave_something(lesson: questions.Lesson, sharkd: Sharkd) -> None:
    for question in lesson.questions:
        for ask in question.asks:
            for expression in ask.accepted if ask.kind == "filter" else ():
                assert sharkd.frames(lesson.path.with_suffix(".pcapng"), expression)


def question(folder: Path, body: str) -> questions.Question:
    """Read a lesson that has one question."""
    path = folder / "01-one.md"
    path.write_text(f"# 1. One\n\nText.\n\n## Questions\n\n**1. What?**\n\n{body}\n\nNext: two.\n")
    lesson = questions.read(path)
    assert lesson.end == "Next: two."
    return lesson.questions[0]


ANSWER = "<details>\n<summary>Answer</summary>\n\n{}\n\n</details>"
CLAIM = "| packet | field | value |\n|---|---|---|\n| 2 | `sis.status` | 0x01 |"


def test_hint_and_list_are_read(tmp_path: Path) -> None:
    hint = "<details>\n<summary>Hint</summary>\n\nLook.\n\n</details>\n\n"
    listed = "- The *status*\n  byte (hex): `01` or `1`\n- Good (yes / no): `no`\n\nIt is bad.\n\n"
    found = question(tmp_path, hint + ANSWER.format(listed + CLAIM))
    assert found.marked
    assert found.hint == "Look."
    assert found.asks == [
        questions.Ask("The *status* byte", "hex", ["01", "1"], []),
        questions.Ask("Good", "choice", ["no"], ["yes", "no"]),
    ]
    assert found.answer.startswith("It is bad.")


def test_question_without_a_list_asks_for_its_first_claim(tmp_path: Path) -> None:
    found = question(tmp_path, ANSWER.format("- Not a list to type.\n\n" + CLAIM))
    assert not found.marked
    assert found.asks == [questions.Ask("`sis.status` of packet 2", "number", ["0x01"], [])]
    assert found.hint == "Look at packet 2."
    assert "Not a list to type." in found.answer


@pytest.mark.parametrize(
    ("listed", "words"),
    [("- It (word): `x`", "word is none of"), ("- It (a / b): `c`", "none of the choices")],
)
def test_list_that_cannot_be_asked_is_refused(tmp_path: Path, listed: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        question(tmp_path, ANSWER.format(f"{listed}\n\n{CLAIM}"))


def test_answer_with_nothing_to_check_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="nothing to check"):
        question(tmp_path, ANSWER.format("Words."))


def test_packets_have_fields_and_coloured_bytes(data: dict[str, Any]) -> None:
    """Chapter 2.2: start, checksum and two lengths; control; service; two addresses; then status and data."""
    second = data["packets"][1]
    assert data["count"] == 6
    assert second["bytes"] == "02c302021012100300" "02"
    assert second["kinds"] == [*["frame"] * 4, "control", "service", "address", "address", "status", "data"]
    assert second["columns"][1:3] == ["3", "16"]
    assert any(label.startswith("Rexroth SIS") for label, *_ in second["tree"])


def test_filters_are_those_of_the_lesson_and_of_the_fields(data: dict[str, Any]) -> None:
    for claim in first_lesson.claims:
        if isinstance(claim, Filter):
            assert data["filters"][claim.expression] == claim.packets
    assert data["filters"]["sis.service == 0x12"] == [1, 2, 5, 6]
    assert data["filters"]["sis.status"] == [2, 4, 6]
    assert all(filter_ in data["filters"] for _, filter_, _ in buttons())


def test_same_lesson_makes_the_same_page(data: dict[str, Any]) -> None:
    with Sharkd() as again:
        other = dissection(again, first_lesson, first_lesson.path.with_suffix(".pcapng"))
    assert page.lesson_page(first_lesson, LESSONS, data) == page.lesson_page(first_lesson, LESSONS, other)


def test_page_needs_nothing_else(data: dict[str, Any]) -> None:
    text = page.lesson_page(first_lesson, LESSONS, data)
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text)
    assert policy
    assert policy[1].startswith("default-src 'none'; img-src data:; ")
    for tag in ("style", "script"):
        inside = re.search(rf"<{tag}>(.*?)</{tag}>", text, re.DOTALL)
        assert inside
        assert f"{tag}-src 'sha256-{b64encode(sha256(inside[1].encode()).digest()).decode()}'" in policy[1]
    assert not re.search(r'(src|href)="(https?:)?//|@import|url\(', text)
    assert not re.search(r' (style|on\w+)="', text)


def test_what_a_capture_holds_is_data(data: dict[str, Any]) -> None:
    hostile = '</script><script>alert("x")</script><!--'
    packets = [{**data["packets"][0], "columns": [hostile] * 4}]
    text = page.lesson_page(first_lesson, LESSONS, {**data, "packets": packets})
    assert hostile not in text
    assert text.count("</script>") == 2
    inside = re.search(r'id="data">(.*?)</script>', text)
    assert inside
    assert json.loads(inside[1])["packets"][0]["columns"] == [hostile] * 4


@pytest.mark.parametrize(
    ("text", "html"),
    [
        ("a <b> & *c* `<d>`", "<p>a &lt;b&gt; &amp; <em>c</em> <code>&lt;d&gt;</code></p>"),
        ("DOK-SYNAX*-SY*-08V", "<p>DOK-SYNAX*-SY*-08V</p>"),
        ("    02 D9\n    <x>", "<pre>02 D9\n&lt;x&gt;</pre>"),
        ("- one\n  more\n- **two**", "<ul><li>one more</li><li><strong>two</strong></li></ul>"),
        ("[next](02-who-talks.md)", '<p><a href="02-who-talks.html">next</a></p>'),
        ("[up](../README.md)", '<p><a href="index.html">up</a></p>'),
        ("[a file](../../plugin/sis/names.c)", "<p>a file</p>"),
        ("[bad](javascript:alert(1))", "<p>bad)</p>"),
        ("| filter | packets |\n|---|---|\n| `a \\| b` | none |", None),
    ],
)
def test_markdown(text: str, html: str | None) -> None:
    shown = markdown.html(text)
    assert shown == html if html else "<td><code>a | b</code></td><td>none</td>" in shown


def test_packets_in_words_are_links() -> None:
    assert re.findall(r'href="#packet-(\d+)"', markdown.inline("Packets 4 to 7, 9 and 12; packet 3 of 20.")) == [
        "4",
        "7",
        "9",
        "12",
        "3",
    ]


def test_a_time_after_a_packet_is_no_packet() -> None:
    assert markdown.packets("In packet 10, 0.57 s later, and at packet 12, 6:15. Packet 13.5 s, packet 14:30.") == {
        10,
        12,
    }


def test_packets_that_a_lesson_leads_to_are_in_its_page() -> None:
    """Of a long capture, the page has only some."""
    first = next(lesson for lesson in LESSONS if lesson.path.stem == "00-record-it-yourself")
    assert 18 in chosen(first, 10_000)


def test_workbench_has_the_codes_of_the_plugin() -> None:
    tables = workbench.tables()
    assert [0x12, 0x12, "Read phase"] in tables["tables"]["services"]
    assert [0xF0, 0xF0, "Invalid service"] in tables["tables"]["status"]
    assert [0, 126, "station"] in tables["addresses"]
    used = {meaning for body in tables["bodies"].values() for layout in body.values() for _, _, meaning in layout}
    assert used - set(tables["tables"]) == {"number", "data", "parameter", "parameter control"}


def test_menus_are_marked_as_wiresharks() -> None:
    assert markdown.inline("*File > Merge*, *Late*") == '<em class="menu">File &gt; Merge</em>, <em>Late</em>'


def test_colours_are_those_of_the_profile() -> None:
    assert rules()[0].name == "SIS: damaged telegram"
    assert rules()[0].paper == "#d55e00"


def test_index_links_every_lesson_and_the_glossary() -> None:
    text = page.index_page(LESSONS)
    assert re.findall(r'<li><a href="([^"]+)"', text) == [f"{lesson.path.stem}.html" for lesson in LESSONS]
    assert all(word in text for word in ('id="glossary"', "TzA", "TrS", f'href="{page.POSTER}"'))
    assert (HERE / "glossary.md").read_text().startswith("# Glossary\n")  # also read alone, as a file
    assert (text.count("<h1"), text.count(">Glossary<")) == (1, 1)
    for lesson in LESSONS:
        assert f'href="{page.POSTER}"' in page.lesson_page(lesson, LESSONS, {})
