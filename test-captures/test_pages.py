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
from pages import HERE, markdown, tasks
from pages.content import content, in_page, lessons

LESSONS = lessons()
READABLE = {
    "number": r"0x[0-9a-f]+|-?\d+(\.\d+)?( \S+)?",
    "packets": r"none|\d+(-\d+)?(, \d+(-\d+)?)*",
    "hex": r"[0-9A-F ]+",
    "filter": r"\S.*",
    "text": r"\S.*",
    "choice": r"\S.*",
    "telegram": r"[0-9A-F]{2}( [0-9A-F]{2})*",
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
def test_every_task_can_be_checked() -> None:
    for task in (task for lesson in LESSONS for task in lesson.tasks):
        assert task.blanks
        for blank in task.blanks:
            assert blank.accepted or blank.kind == "finding", blank
            assert all(re.fullmatch(READABLE[blank.kind], one) for one in blank.accepted), blank


@pytest.mark.style
@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.path.stem)
def test_no_lesson_of_the_page_needs_a_terminal(lesson: tasks.Lesson) -> None:
    """The lesson on ASCII is about one, which somebody else had."""
    asked = [text for one in lesson.tasks for text in (one.text, one.lead, one.hint)]
    text = "\n".join(map(in_page, [lesson.head, *(section.text for section in lesson.sections), *asked, lesson.end]))
    told = re.findall(r"python3|\bpy -m|\bcd \w|wireshark -C|Command Prompt|<!--|-->|[Tt]erminals?\b", text)
    assert not told or (lesson.path.stem == "17-typed-by-hand" and {word.lower() for word in told} == {"terminal"})


ANSWERED = [
    (lesson.proof if section.title == tasks.PROVE else lesson.path.with_suffix(".pcapng"), expression)
    for lesson in SHORT
    for section in lesson.sections
    for task in section.tasks
    for blank in task.blanks
    if blank.kind == "filter"
    for expression in blank.accepted
]


def test_filters_of_answers_leave_something(sharkd: Sharkd) -> None:
    assert [answer for answer in ANSWERED if not sharkd.frames(*answer)] == []


def lesson_of(folder: Path, body: str, solution: str) -> tasks.Lesson:
    """Read a lesson that has one task."""
    path = folder / "01-one.md"
    path.write_text(f"# 1. One\n\nText.\n\n## Predict\n\n**1. What?**\n\n{body}\n\nNext: two.\n")
    (folder / "solutions").mkdir(exist_ok=True)
    tasks.solutions_of(path).write_text(f"# Solutions of lesson 1\n\n## 1\n\n{solution}")
    return tasks.read(path)


CLAIM = "| packet | field | value |\n|---|---|---|\n| 2 | `sis.status` | 0x01 |"


def test_a_task_and_its_solution_are_read(tmp_path: Path) -> None:
    hint = "\n\n<details>\n<summary>Hint</summary>\n\nLook.\n\n</details>"
    listed = "    02 D9\n\n- The *status*\n  byte (hex)\n- Its time (number, ms)\n- Good (yes / no / nobody can know)"
    first = "- `01` or `1`\n  - `10`: You read it\n    backwards.\n"
    right = f"{first}- `5 ms`\n- `no`\n  - `yes`: Look again.\n\nIt is bad.\n\n"
    lesson = lesson_of(tmp_path, listed + hint, right + CLAIM)
    (task,) = lesson.tasks
    assert (lesson.end, lesson.aim, task.hint, task.lead) == ("Next: two.", "Text.", "Look.", "    02 D9")
    assert task.blanks == [
        tasks.Blank("The *status* byte", "hex", "", [], ["01", "1"], [tasks.Remark("10", "You read it backwards.")]),
        tasks.Blank("Its time", "number", "ms", [], ["5 ms"], []),
        tasks.Blank(
            "Good", "choice", "", ["yes", "no", "nobody can know"], ["no"], [tasks.Remark("yes", "Look again.")]
        ),
    ]
    assert task.solution.startswith("It is bad.")
    assert len(task.claims) == 1


def test_a_finding_has_points(tmp_path: Path) -> None:
    lesson = lesson_of(tmp_path, "- Two sentences (finding)", "- Finding\n  - Names the drive.\n")
    assert lesson.tasks[0].blanks == [
        tasks.Blank("Two sentences", "finding", "", [], [], [tasks.Remark("", "Names the drive.")])
    ]


@pytest.mark.parametrize(
    ("body", "solution", "words"),
    [
        ("- It (word)", "- `x`\n", "word is none of"),
        ("- It (a / b / c)", "- `d`\n", "none of the choices"),
        ("- It", "- `x`\n", "does not end with its kind"),
        ("- It (text)", "- `x`\n  - y\n", "is not `what was typed`"),
        ("- It (text)\n- That (text)", "- `x`\n", "has 2 blanks"),
        ("- It (text)", "- `x`\n\n## 2\n\n- `y`\n", "no task has the number 2"),
        ("- It (text)", "Words.\n", "has no list"),
        ("Words.", "- `x`\n", "asks for nothing"),
    ],
)
def test_a_task_that_cannot_be_asked_is_refused(tmp_path: Path, body: str, solution: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        lesson_of(tmp_path, body, solution)


@pytest.mark.parametrize(
    ("text", "html"),
    [
        ("a <b> & *c* `<d>`", "<p>a &lt;b&gt; &amp; <em>c</em> <code>&lt;d&gt;</code></p>"),
        ("DOK-SYNAX*-SY*-08V", "<p>DOK-SYNAX*-SY*-08V</p>"),
        ("    02 D9\n    <x>", "<pre>02 D9\n&lt;x&gt;</pre>"),
        ("- one\n  more\n- **two**", "<ul><li>one more</li><li><strong>two</strong></li></ul>"),
        ("[next](02-status-and-errors.md)", '<p><a href="#learn/02-status-and-errors">next</a></p>'),
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
    assert [name for name, *_ in course["papers"]] == ["sheet", "poster", "wall-chart"]
    played = sorted((path, path.stat().st_mtime_ns) for path in tmp_path.iterdir())
    assert json.dumps(content(tmp_path)) == json.dumps(course)
    assert sorted((path, path.stat().st_mtime_ns) for path in tmp_path.iterdir()) == played
