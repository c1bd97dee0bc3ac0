# SPDX-License-Identifier: GPL-2.0-or-later
"""The pages of the course in a headless chromium: answers, progress, filters, packets, the workbench."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from chromium import Chromium, program
from pages.__main__ import build, lessons
from pages.questions import Ask, Lesson

pytestmark = [
    pytest.mark.thorough,
    pytest.mark.timeout(900),  # the first test waits for all pages, and for a morning of the virtual bus
    pytest.mark.skipif(program() is None, reason="needs chromium (Debian: chromium)"),
]
LESSONS = lessons()

FIRST = next(lesson for lesson in LESSONS if lesson.path.stem == "01-first-telegram")

every_lesson = pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.path.stem)

# Fills in what is typed and chosen, presses the button, and tells what the page says.
ANSWER = """(number, typed) => {
  const section = document.getElementById(`question-${number}`);
  const form = section.querySelector("form");
  typed.forEach((text, place) => {
    const field = form.elements[`ask-${number}-${place}`];
    if (field instanceof RadioNodeList) {
      for (const button of field) button.checked = button.value === text;
    } else field.value = text;
  });
  form.querySelector("button").click();
  return {
    said: typed.map((_, place) => document.getElementById(`ask-${number}-${place}-said`).className),
    words: typed.map((_, place) => document.getElementById(`ask-${number}-${place}-said`).textContent),
    done: section.classList.contains("done"),
    open: section.querySelector("details.answer").open,
  };
}"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("course")
    build(folder)
    return folder


@pytest.fixture(scope="module")
def browser() -> Iterator[Chromium]:
    with Chromium() as browser:
        yield browser


@pytest.fixture
def chromium(browser: Chromium) -> Iterator[Chromium]:
    browser.renew()
    yield browser
    assert browser.complaints == []


def address(folder: Path, name: str) -> str:
    return (folder / f"{name}.html").as_uri()


def answer(chromium: Chromium, number: int, typed: list[str]) -> dict[str, Any]:
    said: dict[str, Any] = chromium.run(f"({ANSWER})({number}, {json.dumps(typed)})")
    return said


def right(lesson: Lesson, number: int) -> list[str]:
    return [ask.accepted[0] for ask in lesson.questions[number - 1].asks]


def wrong(ask: Ask) -> list[str]:
    """Return three answers that are not right; of few choices, those that there are."""
    if ask.kind == "choice":
        return [choice for choice in ask.choices if choice not in ask.accepted]
    return {
        "number": ["123457", "-3", "0xFFEE"],
        "packets": [f"{ask.accepted[0]}, 999" if ask.accepted[0] != "none" else "999", "998", "1-300"],
        "hex": ["EE EE EE", f"{ask.accepted[0]} 00", f"AA {ask.accepted[0]}"],
        "filter": ["frame.number == 999", "frame.number >= 1", f"!({ask.accepted[0]})"],
        "text": ["S-7-4095", "nothing", f"{ask.accepted[0]} x"],
    }[ask.kind]


@every_lesson
def test_right_answers_are_accepted_and_kept(lesson: Lesson, chromium: Chromium, folder: Path) -> None:
    chromium.open(address(folder, lesson.path.stem))
    for question in lesson.questions:
        for place, ask in enumerate(question.asks):
            for accepted in ask.accepted:
                typed = right(lesson, question.number)
                typed[place] = accepted
                said = answer(chromium, question.number, typed)
                assert said["done"], (question.number, said)
                assert said["open"]
    count = len(lesson.questions)
    words = f"{count} of {count} questions answered."
    assert chromium.run("document.getElementById('progress').textContent") == words
    chromium.open(address(folder, lesson.path.stem))
    assert chromium.run("document.getElementById('progress').textContent") == words
    chromium.run("document.querySelector('nav a').click()")  # a store for each file does not keep it from the index
    chromium.open(address(folder, "index"))
    assert chromium.run(f"document.querySelector('[data-lesson=\"{lesson.path.stem}\"]').value") == count


@every_lesson
def test_wrong_answers_are_refused(lesson: Lesson, chromium: Chromium, folder: Path) -> None:
    chromium.open(address(folder, lesson.path.stem))
    for question in lesson.questions:
        for place, ask in enumerate(question.asks):
            tried = wrong(ask)
            assert len(tried) == 3 or ask.kind == "choice"
            for text in tried:
                typed = right(lesson, question.number)
                typed[place] = text
                said = answer(chromium, question.number, typed)
                assert said["said"][place] == "said wrong", (question.number, text, said)
                assert said["words"][place]
                assert not said["done"]
                assert not said["open"]
    assert chromium.run("document.getElementById('progress').textContent").startswith("0 of ")


@pytest.mark.parametrize(
    ("kind", "accepted", "typed", "expected"),
    [
        ("number", "27", "0x1b", True),
        ("number", "27", " 27 bytes ", True),
        ("number", "27", "1B h", True),
        ("number", "27", "1B", None),
        ("number", "12 ms", "0,012 s", True),
        ("number", "12 ms", "12", True),
        ("number", "12 ms", "12 s", False),
        ("number", "12 ms", "12 Bd", False),
        ("number", "0.481 s", "0.48 s", True),
        ("number", "0.481 s", "500 ms", False),
        ("number", "0", "-0", True),
        ("number", "12 ms", "12 milliseconds", True),
        ("number", "12 s", "12 msec", False),
        ("number", "0.5", ".5", True),
        ("number", "4", "bit 4", True),
        ("number", "4", "bit 5", False),
        ("number", "4", "not 4", None),
        ("number", "-4", "minus 4", None),
        ("number", "1350", "1350 1/min.", True),
        ("number", "4", "3 bit 4", None),
        ("packets", "7, 8", "7 + 8.", True),
        ("packets", "7, 8", "7 und 8", True),
        ("packets", "7, 8", "7/9", False),
        ("packets", "7, 8", "packets 8 and 7", True),
        ("packets", "1-6", "1 2 3 4 5 6", True),
        ("packets", "7", "7-", None),
        ("packets", "7", "1-99999999999", None),
        ("packets", "none", "None", True),
        ("packets", "none", "1", False),
        ("hex", "0C 80", "0x0c,0x80", True),
        ("hex", "0C 80", "c80", None),
        ("hex", "0C", "c", True),
        ("hex", "0C 80", "80 0C", False),
        ("text", "S-0-0036", " s-0-0036. ", True),
        ("text", "S-0-0036", "<b>", False),
        ("filter", "sis.talker == 4", "sis.talker==0x4", True),
        ("filter", "sis.talker == 4", "(sis.talker eq 4) && frame.number > 0", True),
        ("filter", "sis.talker == 4", "sis.talker == 4 or sis.talker == 3", False),
        ("filter", "sis.talker == 4", "not sis.talker", False),
        ("filter", "sis.talker == 4", "sis.talker ~ ((", None),
        ("filter", "sis.talker == 4", "constructor", None),
        ("filter", "sis.talker == 4", "sis.talker in {4}", True),
        ("filter", "sis.talker == 4", "sis.talker in {3, 4}", False),
        ("filter", "sis.talker == 4", "sis.talker in {constructor}", None),
        ("text", "x", "  ", None),
    ],
)
def test_answers_are_read_kindly(
    chromium: Chromium, folder: Path, kind: str, accepted: str, typed: str, expected: bool | None
) -> None:
    chromium.open(address(folder, "02-who-talks"))
    ask = {"kind": kind, "accepted": [accepted]}
    assert chromium.run(f"check({json.dumps(ask)}, {json.dumps(typed)}).right") is expected


def fields(chromium: Chromium, text: str) -> dict[str, str]:
    """Type into the workbench, and return the fields with what they mean."""
    chromium.run("document.getElementById('bench-text').value = ''; document.getElementById('bench-text').focus()")
    chromium.type(text)
    texts = "[...row.cells].map((cell) => cell.textContent)"
    rows = chromium.run(f"[...document.querySelectorAll('#bench-fields tbody tr')].map((row) => {texts})")
    return {f"{name}: {pairs}": meaning for pairs, name, meaning in rows}


def test_workbench_takes_telegrams_apart(chromium: Chromium, folder: Path) -> None:
    """Figure 8-21, and a read of S-0-0036 that was refused, by chapters 2.2 and 9 of the definition."""
    chromium.open(address(folder, "index"))
    found = fields(chromium, "02 56 02 02 10 92 00 00 00 02")
    assert found["Checksum: 56"].startswith("good")
    assert found["Length: 02"].startswith("2: good")
    assert found["Control: 10"].startswith("reaction; 0 subaddresses")
    assert found["Service: 92"] == "Read phase (SYNAX)"
    assert found["Status: 00"] == "Transmission error-free"
    assert found["Phase: 02"] == "02: parameter mode"
    found = fields(chromium, "0x02,0xBD,5,5,10,10,10,03,01,3C,03,01,10")
    assert found["Checksum: BD"] == "must be 70"  # without it the sum is 190
    assert found["Status: 01"] == "Execution error"
    assert found["Parameter control: 3C"] == "Operating data, last transmission"
    assert found["Error code: 01 10"] == "1001: Ident number not available"
    chromium.run("document.getElementById('bench-checksum').click()")
    assert chromium.run("document.getElementById('bench-text').value").startswith("02 70 05 05")


def test_workbench_reads_routes_and_numbers(chromium: Chromium, folder: Path) -> None:
    """Figure 2-10 has two subaddresses; a write to P-0-0100 with telegram number 7 is made by hand."""
    chromium.open(address(folder, "index"))
    found = fields(chromium, "02 E1 05 05 02 03 10 03 02 08 F0 01 00")
    assert found["Checksum: E1"].startswith("good")
    assert found["Subaddress 1: 02"] == "2, station"
    assert found["Subaddress 2: 08"] == "8, station"
    found = fields(chromium, "02 89 08 08 08 1F 10 03 07 3C 03 00 64 80 01 00")
    assert found["Checksum: 89"].startswith("good")
    assert found["Telegram number: 07"] == "7"
    assert found["Parameter: 00 64 80"] == "P-0-0100"
    assert found["Data: 01 00"].startswith("2 bytes, low byte first: 1")
    assert fields(chromium, "02 4") == {"Start: 02": "good", "Checksum: 04": "must be FE"}
    assert fields(chromium, "hello") == {}


def test_packets_are_shown_with_their_bytes(chromium: Chromium, folder: Path) -> None:
    chromium.open(address(folder, "01-first-telegram") + "#packet-4")
    assert chromium.run("selected.number") == 4
    words = chromium.run("[...rows.get(4).cells].slice(2).map((cell) => cell.textContent)")
    assert words[:2] == ["3", "16"]
    assert words[2].startswith("Reaction  ")  # From and To say who speaks
    chromium.run("showField('sis.data')")
    marked = "[...document.querySelectorAll('#packet-bytes b.marked')].map((one) => one.textContent).join(' ')"
    assert chromium.run(marked) == "46 32 32 38 20 45 78 63 65 73 73 20 64 65 76 2E"
    chromium.run("document.querySelector('#packet-bytes b').click()")
    assert chromium.run("document.activeElement.textContent").startswith("Start character")
    chromium.run("rows.get(4).focus()")
    chromium.press("ArrowDown", 40)
    assert chromium.run("selected.number") == 5


def test_a_double_click_leads_to_the_named_packet(chromium: Chromium, folder: Path) -> None:
    chromium.open(address(folder, "01-first-telegram") + "#packet-2")
    field = "[...details.querySelectorAll('button')].find(({ item }) => item[4].startsWith('sis.command_in'))"
    chromium.run(f"{field}.dispatchEvent(new MouseEvent('dblclick'))")
    assert chromium.run("selected.number") == 1
    assert chromium.run("document.activeElement.id") == "packet-1"
    chromium.run(f"{field.replace('command', 'reaction')}.focus()")
    chromium.press("Enter", 13, "\r")
    assert chromium.run("selected.number") == 2


def test_a_packet_that_the_page_has_not_is_named(chromium: Chromium, folder: Path) -> None:
    chromium.open(address(folder, "01-first-telegram") + "#packet-700")
    assert chromium.run("filterSaid.textContent").startswith("Packet 700 is not in this page.")
    assert chromium.run("selected.number") == 1


def test_filter_box(chromium: Chromium, folder: Path) -> None:
    chromium.open(address(folder, "01-first-telegram"))
    visible = "[...rows].filter(([, row]) => !row.hidden).map(([number]) => number)"
    chromium.run("document.getElementById('filter-text').focus()")
    chromium.type("sis.length > 2 and sis.sender == 16")
    chromium.press("Enter", 13, "\r")
    assert chromium.run(visible) == [3, 4]
    chromium.run("applyFilter('sis.length * 2')")
    assert chromium.run(visible) == [3, 4]
    assert "cannot run" in chromium.run("filterSaid.textContent")
    chromium.run("document.getElementById('filter-clear').click()")
    assert chromium.run(visible) == [1, 2, 3, 4, 5, 6]


def test_answer_by_keyboard(chromium: Chromium, folder: Path) -> None:
    chromium.open(address(folder, "01-first-telegram"))
    chromium.run("document.getElementById('ask-1-0').focus()")
    chromium.type("27 bytes")
    chromium.press("Tab", 9)
    chromium.type("3")
    chromium.press("Enter", 13, "\r")
    assert chromium.run("document.getElementById('question-1').classList.contains('done')")


def test_what_is_typed_stays(chromium: Chromium, folder: Path) -> None:
    chromium.open(address(folder, "02-who-talks"))
    chromium.run("document.getElementById('ask-1-1').focus()")
    chromium.type("7")
    chromium.run("document.querySelector('[type=radio]').click()")
    chosen = "[...document.querySelectorAll('[type=radio]')].map((one) => one.checked)"
    assert chromium.run(chosen)[0]
    chromium.open(address(folder, "02-who-talks"))
    assert chromium.run("document.getElementById('ask-1-1').value") == "7"
    assert chromium.run(chosen)[0]
    chromium.open(address(folder, "index"))
    chromium.run("document.getElementById('forget').click()")
    chromium.open(address(folder, "02-who-talks"))
    assert chromium.run("document.getElementById('ask-1-1').value") == ""
    assert not any(chromium.run(chosen))


@pytest.mark.parametrize(
    "store",
    [
        "Object.defineProperty(window, 'localStorage', {get() { throw new DOMException('no', 'SecurityError'); }})",
        "Object.defineProperty(window, 'localStorage', {value: null})",
        "Storage.prototype.setItem = () => { throw new DOMException('full', 'QuotaExceededError'); }",
    ],
)
def test_without_a_store_the_page_works(chromium: Chromium, folder: Path, store: str) -> None:
    chromium.call("Page.addScriptToEvaluateOnNewDocument", source=store)
    chromium.open(address(folder, FIRST.path.stem))
    assert answer(chromium, 1, right(FIRST, 1))["done"]
    assert "does not let" in chromium.run("document.getElementById('progress').textContent")


@pytest.mark.parametrize("kept", ["[", "[]", "7", "null", '{"01-first-telegram": 3}', '{"01-first-telegram": null}'])
def test_damaged_progress_begins_again(chromium: Chromium, folder: Path, kept: str) -> None:
    chromium.open(address(folder, "index"))
    for place in ("sistap-course", "sistap-course-typed"):
        chromium.run(f"localStorage.setItem('{place}', {json.dumps(kept)})")
    chromium.open(address(folder, FIRST.path.stem))
    assert chromium.run("document.getElementById('progress').textContent").startswith("0 of ")
    assert answer(chromium, 1, right(FIRST, 1))["done"]


def test_index_takes_progress_from_the_link(chromium: Chromium, folder: Path) -> None:
    chromium.open(address(folder, "index") + "#01-first-telegram=" + '{"1":"right","2":"shown","x":"<b>"}')
    assert chromium.run("document.querySelector('[data-lesson=\"01-first-telegram\"]').value") == 1
    chromium.run("document.getElementById('forget').click()")
    assert chromium.run("document.querySelector('[data-lesson=\"01-first-telegram\"]').value") == 0
