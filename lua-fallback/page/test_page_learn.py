# SPDX-License-Identifier: GPL-2.0-or-later
"""The lessons in the page: answers as people type them, and what can be tried beside the text."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from chromium import Chromium
from pages import content
from pages.questions import Ask, Lesson

LESSONS = content.lessons()
PLAYED = Path(__file__).parents[2] / "build" / "course"  # captures of the virtual bus, also for ./bootstrap page

pytestmark = [pytest.mark.thorough, pytest.mark.timeout(600)]

Tried = tuple[Ask, str]


@pytest.fixture(scope="module")
def answers(node: Callable[..., Any], tmp_path_factory: pytest.TempPathFactory) -> Callable[..., list[Any]]:
    """Return what the page says of answers; of each lesson a list of {right, say}."""

    def run(tried: dict[str, list[Tried]]) -> list[Any]:
        jobs = [
            {
                "capture": str(content.capture(lesson, PLAYED)),
                "preferences": content.preferences(lesson),
                "tried": [(ask._asdict(), text) for ask, text in tried[lesson.path.stem]],
            }
            for lesson in LESSONS
            if lesson.path.stem in tried
        ]
        path = tmp_path_factory.mktemp("answers") / "jobs.json"
        path.write_text(json.dumps(jobs))
        found: list[Any] = node("answers.mjs", path)
        return found

    return run


def asks(lesson: Lesson) -> list[Ask]:
    return [ask for question in lesson.questions for ask in question.asks]


def wrong(ask: Ask) -> list[str]:
    """Return three answers that are not right; of few choices, those that there are."""
    if ask.kind == "choice":
        return [choice for choice in ask.choices if choice not in ask.accepted]
    return {
        "number": ["123457", "-3", "0xFFEE"],
        "packets": [f"{ask.accepted[0]}, 999" if ask.accepted[0] != "none" else "999", "998", "1-300"],
        "hex": ["EE EE EE", f"{ask.accepted[0]} 00", f"AA {ask.accepted[0]}"],
        "filter": ["frame.number == 99999", "frame.number >= 1", f"!({ask.accepted[0]})"],
        "text": ["S-7-4095", "nothing", f"{ask.accepted[0]} x"],
    }[ask.kind]


def test_right_answers_are_accepted_and_wrong_ones_refused(answers: Callable[..., list[Any]]) -> None:
    right = {lesson.path.stem: [(ask, text) for ask in asks(lesson) for text in ask.accepted] for lesson in LESSONS}
    false = {lesson.path.stem: [(ask, text) for ask in asks(lesson) for text in wrong(ask)] for lesson in LESSONS}
    for tried, expected in ((right, True), (false, False)):
        for name, said in zip(tried, answers(tried), strict=True):
            for (ask, text), result in zip(tried[name], said, strict=True):
                assert result["right"] is expected, (name, ask, text, result)
                assert result["say"]


@pytest.mark.parametrize("kind", ["number", "packets", "hex", "text", "filter"])
def test_answers_are_read_kindly(kind: str, answers: Callable[..., list[Any]]) -> None:
    """None: it cannot be read, and what to type is said."""
    tried: dict[str, list[tuple[str, str, bool | None]]] = {
        "number": [
            ("27", "0x1b", True),
            ("27", " 27 bytes ", True),
            ("27", "1B h", True),
            ("27", "1B", None),
            ("12 ms", "0,012 s", True),
            ("12 ms", "12", True),
            ("12 ms", "12 s", False),
            ("12 ms", "12 Bd", False),
            ("0.481 s", "0.48 s", True),
            ("0.481 s", "500 ms", False),
            ("0", "-0", True),
            ("12 ms", "12 milliseconds", True),
            ("12 s", "12 msec", False),
            ("0.5", ".5", True),
            ("4", "bit 4", True),
            ("4", "not 4", None),
            ("1350 rpm", "1350 1/min.", True),
            ("4", "3 bit 4", None),
        ],
        "packets": [
            ("7, 8", "7 + 8.", True),
            ("7, 8", "7 und 8", True),
            ("7, 8", "7/9", False),
            ("7, 8", "packets 8 and 7", True),
            ("1-6", "1 2 3 4 5 6", True),
            ("7", "7-", None),
            ("7", "1-99999999999", None),
            ("none", "None", True),
            ("none", "1", False),
        ],
        "hex": [
            ("0C 80", "0x0c,0x80", True),
            ("0C 80", "c80", None),
            ("0C", "c", True),
            ("0C 80", "80 0C", False),
        ],
        "text": [("S-0-0036", " s-0-0036. ", True), ("S-0-0036", "<b>", False), ("x", "  ", None)],
        "filter": [
            ("sis.talker == 4", "sis.talker==0x4", True),
            ("sis.talker == 4", "(sis.talker eq 4) && frame.number > 0", True),
            ("sis.talker == 4", "sis.talker == 4 or sis.talker == 3", False),
            ("sis.talker == 4", "sis.talker ~ ((", None),
            ("sis.talker == 4", "constructor", None),
            ("sis.talker == 4", "sis.talker in {4}", True),
            ("sis.talker == 4", "sis.talker == 4) || (1 == 1", None),
        ],
    }
    (found,) = answers({"02-who-talks": [(Ask("", kind, [accepted], []), text) for accepted, text, _ in tried[kind]]})
    for (accepted, text, expected), said in zip(tried[kind], found, strict=True):
        assert said["right"] is expected, (accepted, text, said)
        assert said["say"]


@pytest.fixture
def chromium(window: Chromium, page: Path) -> Chromium:
    window.size(1500, 950)
    window.open(page.as_uri() + "#learn")
    window.until("document.querySelector('.lessons')")
    return window


def lesson(browser: Chromium, name: str) -> None:
    """Open a lesson, and wait for its packets."""
    browser.run(f"location.hash = '#learn/{name}'")
    browser.until(f"document.querySelector('#open-name').textContent === '{name}.pcapng'")
    browser.until("document.querySelector('.packet-list .row.selected')")


def selected(browser: Chromium) -> str:
    return str(browser.run("document.querySelector('.packet-list .row.selected')?.children[0].textContent ?? ''"))


def tool(browser: Chromium, words: str) -> None:
    browser.run(f"""
      [...document.querySelectorAll('details.tool')].find((one) => one.textContent.startsWith('{words}')).open = true
    """)


def test_a_lesson_is_answered_by_keyboard_and_kept(chromium: Chromium, page: Path, tmp_path: Path) -> None:
    lesson(chromium, "01-first-telegram")
    chromium.run("document.getElementById('ask-1-0').focus()")
    chromium.type("27 bytes")
    chromium.press("Tab", 9)
    chromium.type("3")
    chromium.press("Enter", 13, "\r")
    chromium.until("document.querySelector('.question.done')")
    assert chromium.run("document.querySelector('.lesson-state').textContent") == "1 of 5 questions answered."
    chromium.open(page.as_uri() + "?again#learn/01-first-telegram")
    chromium.until("document.querySelector('.question.done')")
    assert chromium.run("document.getElementById('ask-1-0').value") == "27 bytes"
    chromium.run("location.hash = '#learn'")
    chromium.until("document.querySelector('.lessons')")
    assert chromium.run("[...document.querySelectorAll('.lessons progress')].map((one) => one.value)")[:3] == [0, 1, 0]
    results(chromium, tmp_path)


def results(browser: Chromium, folder: Path) -> None:
    """Save the results of a learner, and read them as a teacher."""
    browser.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(folder))
    browser.run("document.querySelector('#learner').value = 'Ada <b>'")
    browser.click("Save my results")
    saved = folder / "results Ada _b_.json"
    browser.until("document.querySelector('#results')")
    while not saved.exists():
        browser.run("new Promise((go) => setTimeout(go, 50))")
    browser.choose("#results", saved)
    browser.until("document.querySelector('[aria-label=\"Results of the class\"]')")
    cells = browser.run(
        "[...document.querySelectorAll('[aria-label=\"Results of the class\"] td')].map((c) => c.textContent)"
    )
    assert cells[:3] == ["Ada <b>", "0/3", "1/5"]
    teach(browser, saved, folder)


def teach(browser: Chromium, saved: Path, folder: Path) -> None:
    """Read the results of a class; two files are of something else."""
    spoofed = folder / "a\u202enosj.exe.json"
    (folder / "list.json").write_text("[]")
    spoofed.write_text("hello")
    browser.choose("#results", folder / "list.json", saved, spoofed)
    browser.until("document.querySelector('.not-read')")
    bad = browser.run("[...document.querySelectorAll('.not-read li')].map((one) => one.textContent)")
    why = "this is no file of results: learners save one with “Save my results”"
    assert bad == [f"list.json: {why}", f"a\\u202enosj.exe.json: {why}"]
    assert browser.run("document.querySelectorAll('[aria-label=\"Results of the class\"] tbody tr').length") == 1
    assert browser.run("document.querySelector('#trouble').textContent") == ""
    browser.choose("#results", saved)
    browser.until("!document.querySelector('.not-read')")


def test_an_answer_that_was_shown_stays_shown(chromium: Chromium) -> None:
    """Question 2 has one. A right answer opens the box, too: that is not shown."""
    lesson(chromium, "01-first-telegram")
    question = LESSONS[[one.path.stem for one in LESSONS].index("01-first-telegram")].questions[1]
    state = "document.querySelector('.lesson-state').textContent"
    asked = f"document.querySelectorAll('.question')[{question.number - 1}]"
    chromium.run(f"{asked}.querySelector('.answer summary').click()")
    chromium.until(f"{state} === '0 of 5 questions answered, 1 answer shown.'")
    for place, ask in enumerate(question.asks):
        field = f"#ask-{question.number}-{place}"
        if ask.choices:
            chromium.run(f"document.querySelector('[name={field[1:]}][value={json.dumps(ask.accepted[0])}]').click()")
        else:
            chromium.run(f"document.querySelector({json.dumps(field)}).value = {json.dumps(ask.accepted[0])}")
    chromium.run(f"{asked}.querySelector('form button').click()")
    chromium.until(f"{asked}.querySelector('.verdict').textContent.startsWith('Right. But the answer was opened')")
    assert chromium.run(state) == "0 of 5 questions answered, 1 answer shown."
    assert chromium.run("document.querySelector('.question.done')") is None
    chromium.run("location.hash = '#learn'")
    chromium.until("document.querySelector('.lessons')")
    chromium.click("Forget my progress")
    chromium.until("document.querySelector('dialog[open]')?.textContent.includes('This deletes 1 answer')")
    assert chromium.run("document.activeElement.textContent") == "Cancel"
    chromium.click("Cancel")
    assert "shown" in chromium.run("localStorage.getItem('sistap-course')")
    chromium.click("Forget my progress")
    chromium.click("Forget")
    chromium.until("localStorage.getItem('sistap-course') === null")


def test_names_of_learners_in_any_script(chromium: Chromium, tmp_path: Path) -> None:
    """The name of the file keeps their letters."""
    chromium.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    chromium.run("document.querySelector('#learner').value = 'Zoë Müller 王\\u202e/1'")
    chromium.click("Save my results")
    saved = tmp_path / "results Zoë Müller 王__1.json"
    while not saved.exists():
        chromium.run("new Promise((go) => setTimeout(go, 50))")
    chromium.choose("#results", saved)
    chromium.until("document.querySelector('[aria-label=\"Results of the class\"]')")
    first = chromium.run("document.querySelector('[aria-label=\"Results of the class\"] td').textContent")
    assert first == r"Zoë Müller 王\u202e/1"


def test_what_the_text_names_is_one_click_away(chromium: Chromium) -> None:
    lesson(chromium, "01-first-telegram")
    chromium.run("[...document.querySelectorAll('a.packet')].find((one) => one.textContent === '4').click()")
    chromium.until("document.querySelector('.packet-list .row.selected').children[0].textContent === '4'")
    chromium.click("sis.checksum")
    chosen = "document.querySelector('.tree [aria-selected=true] > .label')?.textContent ?? ''"
    chromium.until(f"({chosen}).startsWith('Checksum: 0x')")
    assert chromium.run("document.querySelectorAll('.dump b.marked').length") == 2  # the byte, and its letter
    chromium.run("document.querySelector('table.filter.packets button.code').click()")
    chromium.until("/of 6 packets/.test(document.querySelector('#filter-said').textContent)")
    assert chromium.run("location.hash") == "#learn/01-first-telegram"


def test_a_lessons_settings_end_with_it(chromium: Chromium, page: Path) -> None:
    """Lesson 18 is about another edition."""
    assert content.preferences(next(one for one in LESSONS if one.path.stem == "18-ecodrive03"))
    lesson(chromium, "18-ecodrive03")
    lesson(chromium, "01-first-telegram")
    chromium.run("location.hash = '#packets'")
    chromium.click("Limits")
    chromium.until("document.querySelector('dialog[open]')")
    assert "ECODRIVE03" not in chromium.run("document.querySelector('dialog[open] select').value")


def test_a_telegram_is_decoded_while_it_is_changed(chromium: Chromium) -> None:
    """Figure 8-21 of the SIS definition: phase 2, checksum 0xc3."""
    lesson(chromium, "01-first-telegram")
    tool(chromium, "A telegram")
    tree = "document.querySelector('.tool .tree').textContent"
    chromium.until(f"({tree}).includes('Phase: 2 (parameter mode)') && ({tree}).includes('Checksum: 0xc3 [correct]')")
    chromium.run("[...document.querySelectorAll('.cells button')].at(-1).click()")
    chromium.run("document.querySelector('.bits [aria-label=\"Bit 0\"]').click()")
    chromium.until(f"({tree}).includes('Phase: 3') && /Checksum: 0xc3 .*should be 0xc2/.test({tree})")
    chromium.click("Set the checksum")
    chromium.until(f"({tree}).includes('Checksum: 0xc2 [correct]')")
    assert chromium.run("document.querySelector('input.telegram').value") == "02 C2 02 02 10 12 10 03 00 03"


@pytest.mark.parametrize(
    ("name", "packet", "bytes_", "decoded"),
    [
        ("01-first-telegram", 1, "02 D9 00 00 00 12 10 03", "Checksum: 0xd9 [correct]"),
        (
            "14-who-may-speak",
            3,
            "00 00 45 44 00 00 00 01 FF FF 00 02 02 00 00 ED 10 03 FE",
            "Block check character: 0xfe [correct]",
        ),
    ],
)
def test_the_selected_telegram_can_be_changed(
    name: str, packet: int, bytes_: str, decoded: str, chromium: Chromium
) -> None:
    """Of SIS, and of another procedure."""
    lesson(chromium, name)
    tool(chromium, "A telegram")
    chromium.run(f"[...document.querySelectorAll('.row')].find((one) => one.ariaRowIndex === '{packet + 1}').click()")
    take = "[...document.querySelectorAll('.tool-buttons button')].at(-3).click()"
    chromium.until(f"({take}, document.querySelector('input.telegram').value === '{bytes_}')")
    tree = "document.querySelector('.tool .tree').textContent"
    chromium.until(f"({tree}).includes('{decoded}')")
    chromium.run("document.querySelectorAll('.cells button')[6].click()")
    chromium.run("document.querySelector('.bits [aria-label=\"Bit 0\"]').click()")
    chromium.until(f"/should be 0x/.test({tree})")
    chromium.click("Set the checksum")
    chromium.until(f"!/should be 0x/.test({tree})")


def verdict(browser: Chromium, words: str) -> None:
    browser.until(f"[...document.querySelectorAll('.verdicts li')].some((one) => one.textContent.includes('{words}'))")


def slide(browser: Chromium, words: str, value: float) -> None:
    browser.run(
        f"""(() => {{
          const labels = [...document.querySelectorAll('.sliders label')];
          const {{ control }} = labels.find((one) => one.textContent.trim() === '{words}');
          control.value = {value};
          control.dispatchEvent(new Event('input'));
        }})()"""
    )


def test_the_timeline_flips_verdicts(chromium: Chromium) -> None:
    """Packet 9 has an interval of 7 ms where TzA is 5 ms, and the tap is exact to 0.3 ms."""
    lesson(chromium, "09-timing")
    verdict(chromium, "Verdict on TzA: exceeded")
    slide(chromium, "TzA", 8)
    verdict(chromium, "Verdict on TzA: ok")
    slide(chromium, "TzA", 6)
    slide(chromium, "Uncertainty of the tap", 2)
    verdict(chromium, "Verdict on TzA: unresolved")
    slide(chromium, "Uncertainty of the tap", 0.3)
    slide(chromium, "TzA", 5)
    chromium.run("document.querySelector('[data-character=\"9.5\"]').focus()")
    left = "new KeyboardEvent('keydown', {key: 'ArrowLeft', shiftKey: true, bubbles: true})"
    for _ in range(3):
        chromium.run(f"document.activeElement.dispatchEvent({left})")
    verdict(chromium, "Longest interval: 4.000 ms")
    verdict(chromium, "Verdict on TzA: ok")


@pytest.mark.parametrize("name", ["11-damaged-line", "17-wiring"])
def test_errors_on_the_timeline(name: str, chromium: Chromium) -> None:
    lesson(chromium, name)
    chromium.until("document.querySelectorAll('.box').length > 5")
    faulty = chromium.run("document.querySelectorAll('.box.faulty').length")
    chromium.run("document.querySelector('.box:not(.faulty)').focus()")
    chromium.click("break")
    chromium.until(f"document.querySelectorAll('.box.faulty').length === {faulty} + 1")


def test_the_bus_of_a_lesson_plays_in_it(chromium: Chromium) -> None:
    """Lesson 0 needs no terminal."""
    lesson(chromium, "00-record-it-yourself")
    before = chromium.run("document.querySelector('.packet-list').getAttribute('aria-rowcount')")
    chromium.run("document.querySelector('.note button').click()")
    rows = "Number(document.querySelector('.packet-list').getAttribute('aria-rowcount'))"
    chromium.until(f"document.querySelector('.live-bar') && {rows} > 5 && {rows} < {before}")
    chromium.run("[...document.querySelectorAll('.live-bar button')].at(-1).click()")
    chromium.until("!document.querySelector('.live-bar') && document.querySelector('#busy').hidden")
    assert 5 < chromium.run(rows) < int(before)
    assert chromium.run("location.hash") == "#learn/00-record-it-yourself"


def test_a_lesson_on_paper(chromium: Chromium) -> None:
    """All packets; the answers on a page of their own."""
    lesson(chromium, "01-first-telegram")
    chromium.run("window.print = () => {}")
    chromium.click("Print")
    chromium.until("document.querySelector('.print-only')")
    cells = chromium.run(
        "[...document.querySelectorAll('.print-only [aria-label=Packets] td')].map((one) => one.textContent)"
    )
    assert cells[:4] == ["1", "0.0000", "16 -> 3  Command  Read phase", "02 D9 00 00 00 12 10 03"]
    chromium.call("Emulation.setEmulatedMedia", media="print")
    shown = "(one) => getComputedStyle(one).display !== 'none'"
    assert chromium.run(f"[...document.body.children].filter({shown}).map((one) => one.className)") == ["print-only"]
    assert chromium.run("getComputedStyle(document.querySelector('.new-page')).breakBefore") == "page"
    chromium.call("Emulation.setEmulatedMedia", media="screen")


@pytest.mark.parametrize(
    "store",
    [
        "Object.defineProperty(window, 'localStorage', {get() { throw new DOMException('no', 'SecurityError'); }})",
        "Storage.prototype.setItem = () => { throw new DOMException('full', 'QuotaExceededError'); }",
        "localStorage.setItem('sistap-course', '{\"01-first-telegram\": 3}')",
        "localStorage.setItem('sistap-course', '[')",
    ],
)
def test_without_a_store_the_lessons_work(store: str, chromium: Chromium, page: Path) -> None:
    chromium.before(f"if (window === top) {{ {store} }}")
    chromium.open(page.as_uri() + "?store#learn")
    chromium.until("document.querySelector('.lessons')")
    lesson(chromium, "01-first-telegram")
    chromium.run("document.getElementById('ask-1-0').value = '27'")
    chromium.run("document.getElementById('ask-1-1').value = '3'")
    chromium.run("document.querySelector('.question form').requestSubmit()")
    chromium.until("document.querySelector('.question.done')")
