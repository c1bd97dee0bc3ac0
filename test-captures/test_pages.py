# SPDX-License-Identifier: GPL-2.0-or-later
"""The lessons as the page has them: what is asked, and their text as HTML."""

from __future__ import annotations

import json
import re
from base64 import b64decode
from pathlib import Path

import pytest
from sharkd import Sharkd

from lesson import recording
from pages import HERE, markdown, questions
from pages.content import content, in_page, lessons

LESSONS = lessons()
READABLE = {
    "number": r"0x[0-9a-f]+|-?\d+(\.\d+)?( \w+)?",
    "packets": r"none|\d+(-\d+)?(, \d+(-\d+)?)*",
    "hex": r"[0-9A-F ]+",
    "filter": r"\S.*",
    "text": r"\S.*",
    "choice": r"\S.*",
}

SHORT = [lesson for lesson in LESSONS if not recording(lesson.path)]


@pytest.mark.attack("HTML in a lesson, on a line that folds", "shown as text")
@pytest.mark.parametrize(
    "line", ["<details><script>x</script>", "<details onclick=x>", "<summary><img src=x></summary>"]
)
def test_no_html_of_a_lesson_passes_but_what_folds(line: str) -> None:
    made = markdown.html(f"{line}\n")
    assert set(re.findall(r"<([^<>]*)>", made)) <= {"p", "/p", "details", "summary", "/summary"}, made


@pytest.mark.style
def test_every_question_can_be_checked() -> None:
    for lesson in LESSONS:
        assert [question.number for question in lesson.questions] == list(range(1, len(lesson.questions) + 1))
    for question in (question for lesson in LESSONS for question in lesson.questions):
        assert question.hint
        assert question.answer
        assert question.asks
        for ask in question.asks:
            assert ask.accepted
            assert all(re.fullmatch(READABLE[ask.kind], one) for one in ask.accepted), ask
            assert len(ask.choices) != 1


@pytest.mark.style
@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.path.stem)
def test_no_lesson_of_the_page_needs_a_terminal(lesson: questions.Lesson) -> None:
    """Lesson 21 is about one, which somebody else had."""
    asked = [text for one in lesson.questions for text in (one.text, one.lead, one.hint, one.answer)]
    text = "\n".join([in_page(lesson.text), *asked, lesson.end])
    told = re.findall(r"python3|\bpy -m|\bcd \w|wireshark -C|Command Prompt|<!--|-->|[Tt]erminals?\b", text)
    assert not told or (lesson.path.stem == "21-typed-by-hand" and {word.lower() for word in told} == {"terminal"})
    assert "\n## What to know\n" in text
    assert "\n## Click\n" in text


ANSWERED = [
    (lesson.path.with_suffix(".pcapng"), expression)
    for lesson in SHORT
    for question in lesson.questions
    for ask in question.asks
    if ask.kind == "filter"
    for expression in ask.accepted
]


def test_filters_of_answers_leave_something(sharkd: Sharkd) -> None:
    assert len(ANSWERED) > 3
    assert [answer for answer in ANSWERED if not sharkd.frames(*answer)] == []


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


@pytest.mark.parametrize(
    ("text", "html"),
    [
        ("a <b> & *c* `<d>`", "<p>a &lt;b&gt; &amp; <em>c</em> <code>&lt;d&gt;</code></p>"),
        ("DOK-SYNAX*-SY*-08V", "<p>DOK-SYNAX*-SY*-08V</p>"),
        ("    02 D9\n    <x>", "<pre>02 D9\n&lt;x&gt;</pre>"),
        ("- one\n  more\n- **two**", "<ul><li>one more</li><li><strong>two</strong></li></ul>"),
        ("[next](02-who-talks.md)", '<p><a href="#learn/02-who-talks">next</a></p>'),
        ("[up](../README.md)", '<p><a href="#learn">up</a></p>'),
        ("[a file](../../plugin/protocol/codes.toml)", "<p>a file</p>"),
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


def test_menus_are_marked_as_wiresharks() -> None:
    assert markdown.inline("*File > Merge*, *Late*") == '<em class="menu">File &gt; Merge</em>, <em>Late</em>'


@pytest.mark.thorough
def test_the_page_has_every_lesson_with_its_capture(tmp_path: Path) -> None:
    """Those of the virtual bus are played once."""
    course = content(tmp_path)
    assert [lesson["name"] for lesson in course["lessons"]] == [lesson.path.stem for lesson in LESSONS]
    assert all(b64decode(lesson["capture"])[:4] == b"\n\r\r\n" for lesson in course["lessons"])
    assert not any("<pre>wireshark -C" in lesson["text"].partition("<h2")[0] for lesson in course["lessons"])
    assert all(word in course["glossary"] for word in ("TzA", "TrS"))
    assert (HERE / "glossary.md").read_text().startswith("# Glossary\n")  # also read alone, as a file
    assert [name for name, *_ in course["papers"]] == ["sheet", "poster"]
    played = sorted((path, path.stat().st_mtime_ns) for path in tmp_path.iterdir())
    assert json.dumps(content(tmp_path)) == json.dumps(course)
    assert sorted((path, path.stat().st_mtime_ns) for path in tmp_path.iterdir()) == played
