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
from pages.tasks import PROVE, Blank, Lesson, Task

LESSONS = content.lessons()
FIRST = LESSONS[0]
PLAYED = Path(__file__).parents[2] / "build" / "course"  # captures of the virtual bus, also for ./bootstrap page

pytestmark = [pytest.mark.thorough, pytest.mark.timeout(600)]

Tried = tuple[dict[str, Any], str]


@pytest.fixture(scope="module")
def answers(node: Callable[..., Any], tmp_path_factory: pytest.TempPathFactory) -> Callable[..., list[Any]]:
    """Return what the page says of answers; of each lesson a list of {right, say}."""

    def run(tried: dict[str, list[Tried]]) -> list[Any]:
        jobs = [
            {
                "capture": str(content.capture(lesson, PLAYED)),
                "preferences": content.preferences(lesson),
                "tried": tried[lesson.path.stem],
            }
            for lesson in LESSONS
            if lesson.path.stem in tried
        ]
        path = tmp_path_factory.mktemp("answers") / "jobs.json"
        path.write_text(json.dumps(jobs))
        found: list[Any] = node("answers.mjs", path)
        return found

    return run


CHECKED = ("number", "packets", "hex", "text", "filter", "choice")  # by what is typed alone


def blanks(lesson: Lesson) -> list[Blank]:
    """Return what is checked with the capture of the lesson open."""
    other = lesson.proof != lesson.path.with_suffix(".pcapng")
    found = [section.tasks for section in lesson.sections if not (other and section.title == PROVE)]
    return [blank for tasks in found for task in tasks for blank in task.blanks if blank.kind in CHECKED]


def told(blank: Blank) -> list[tuple[str, bool, str]]:
    """Return what is typed, whether it is right, and what is said of a known mistake."""
    right = [(one, True, "Right.") for one in blank.accepted]
    return right + [(remark.code, False, remark.say) for remark in blank.remarks]


def test_right_answers_are_accepted_and_mistakes_have_their_words(answers: Callable[..., list[Any]]) -> None:
    expected = {lesson.path.stem: [(one, *rest) for one in blanks(lesson) for rest in told(one)] for lesson in LESSONS}
    tried = {name: [(content._blank(one), text) for one, text, *_ in rows] for name, rows in expected.items()}
    complaints = [
        f"{name}: {blank.prompt}: {text}: {result}"
        for (name, rows), said in zip(expected.items(), answers(tried), strict=True)
        for (blank, text, right, words), result in zip(rows, said, strict=True)
        if result["right"] is not right or words not in result["say"]
    ]
    assert not complaints, "\n".join(complaints)


def test_filters_are_compared_by_what_they_leave(answers: Callable[..., list[Any]]) -> None:
    """None: it cannot be read, and Wireshark says why."""
    tried = [
        ("sis.talker==0x4", True),
        ("(sis.talker eq 4) && frame.number > 0", True),
        ("sis.talker in {4}", True),
        ("sis.talker == 4 or sis.talker == 3", False),
        ("sis.talker ~ ((", None),
        ("constructor", None),
        ("sis.talker == 4) || (1 == 1", None),
    ]
    blank = content._blank(Blank("", "filter", "", [], ["sis.talker == 4"], []))
    (found,) = answers({FIRST.path.stem: [(blank, text) for text, _ in tried]})
    assert [said["right"] for said in found] == [expected for _, expected in tried]
    assert all(said["say"] for said in found)


@pytest.fixture
def chromium(window: Chromium, page: Path) -> Chromium:
    window.size(1500, 950)
    window.open(page.as_uri() + "#learn")
    window.until("document.querySelector('.lessons')")
    return window


def lesson(browser: Chromium, name: str, *, opened: bool = True) -> None:
    """Open a lesson, and wait for its packets; `opened`: without its predictions."""
    browser.run(f"location.hash = '#learn/{name}'")
    browser.until(f"document.querySelector('#open-name').textContent === '{name}.pcapng'")
    browser.until("document.querySelector('.gate')")
    if opened and not browser.run("document.querySelector('.gate').hidden"):
        browser.click("Open them now")
    if opened:
        browser.until("document.querySelector('.packet-list .row.selected')")


def selected(browser: Chromium) -> str:
    return str(browser.run("document.querySelector('.packet-list .row.selected')?.children[0].textContent ?? ''"))


def tool(browser: Chromium, words: str) -> None:
    browser.run(f"""
      [...document.querySelectorAll('details.tool')].find((one) => one.textContent.startsWith('{words}')).open = true
    """)


def fill(browser: Chromium, task: Task, texts: list[str] | None = None) -> None:
    """Type what is right in a task, or other texts, and check it."""
    for place, blank in enumerate(task.blanks):
        text, field = json.dumps(texts[place] if texts else blank.accepted[0]), f"blank-{task.number}-{place}"
        if blank.choices:
            browser.run(f"document.querySelector('[name={field}][value={text}]').click()")
        else:
            browser.run(f"document.getElementById('{field}').value = {text}")
            browser.run(f"document.getElementById('{field}').dispatchEvent(new Event('input'))")
    browser.run(f"document.querySelector('.task[data-number=\"{task.number}\"] form').requestSubmit()")


def state(browser: Chromium) -> str:
    return str(browser.run("document.querySelector('.lesson-state').textContent"))


def of_section(lesson: Lesson, title: str) -> list[Task]:
    return [task for section in lesson.sections if section.title == title for task in section.tasks]


def test_packets_are_shut_until_the_predictions_are_made(chromium: Chromium, page: Path, tmp_path: Path) -> None:
    """Then they are open, and stay so. What was typed is kept, and can be handed to a teacher."""
    lesson(chromium, FIRST.path.stem, opened=False)
    predicted = of_section(FIRST, "Predict")
    assert not chromium.run("document.querySelector('.gate').hidden")
    assert chromium.run("document.querySelector('.packet-list').checkVisibility()") is False
    assert chromium.run("document.querySelector('.tool').checkVisibility()") is False
    for task in predicted:
        fill(chromium, task)
        chromium.until(f"document.querySelector('.task.done[data-number=\"{task.number}\"]')")
    assert state(chromium) == f"{len(predicted)} of {len(FIRST.tasks)} tasks done."
    chromium.until("document.querySelector('.packet-list').checkVisibility()")
    chromium.open(page.as_uri() + f"?again#learn/{FIRST.path.stem}")
    chromium.until("document.querySelector('.task.done')")
    assert (
        chromium.run(f"document.getElementById('blank-{predicted[0].number}-0').value")
        == predicted[0].blanks[0].accepted[0]
    )
    chromium.run("location.hash = '#learn'")
    chromium.until("document.querySelector('.lessons')")
    done = "[...document.querySelectorAll('.lessons progress')].map((one) => one.value)"
    assert chromium.run(done)[:2] == [len(predicted), 0]
    assert chromium.run("document.querySelector('.form-line button').disabled")  # the certificate of a week
    results(chromium, tmp_path, len(predicted))


def test_a_known_mistake_is_told_and_no_answer_is_in_the_page(chromium: Chromium) -> None:
    """The solution is made when it is opened, not before."""
    lesson(chromium, FIRST.path.stem, opened=False)
    task = next(one for one in of_section(FIRST, "Predict") if one.blanks[0].remarks and not one.blanks[0].choices)
    remark = task.blanks[0].remarks[0]
    fill(chromium, task, [remark.code, *(blank.accepted[0] for blank in task.blanks[1:])])
    chromium.until(f"document.getElementById('blank-{task.number}-0-said').textContent === {json.dumps(remark.say)}")
    asked = f"document.querySelector('.task[data-number=\"{task.number}\"]')"
    assert chromium.run(f"{asked}.querySelector('.answer').children.length") == 1
    assert state(chromium).startswith("0 of ")


def test_a_telegram_is_built(chromium: Chromium) -> None:
    """Wireshark finds the conditions in it, or says the first that is missing."""
    lesson(chromium, FIRST.path.stem)
    task, place = next(
        (task, place)
        for task in of_section(FIRST, "Build")
        for place, blank in enumerate(task.blanks)
        if blank.kind == "telegram" and len(task.blanks) == 1
    )
    (blank,), field = task.blanks, f"blank-{task.number}-{place}"
    chromium.run(f"document.getElementById('{field}').focus()")
    fill(chromium, task, [blank.accepted[0].replace(" ", "", 1) + " 00"])
    said = f"document.getElementById('{field}-said').textContent"
    chromium.until(f"{said} === 'The telegram is over before your bytes are: 1 too many.'")
    fill(chromium, task, [blank.accepted[0][:-2] + "7E"])
    chromium.until(f"{json.dumps([remark.say for remark in blank.remarks])}.includes({said})")
    fill(chromium, task)
    chromium.until(f"document.querySelector('.task.done[data-number=\"{task.number}\"]')")
    tree = f"document.querySelector('.task[data-number=\"{task.number}\"] .tree').textContent"
    chromium.until(f"({tree}).includes('[correct]')")


def test_a_finding_is_held_against_points(chromium: Chromium) -> None:
    """The raw capture of a proof has no verdict. Who ticks all points has done it, by his own word."""
    proved = next(one for one in LESSONS if one.path.stem == "06-timing")
    lesson(chromium, proved.path.stem)
    chromium.click("Open its raw capture")
    chromium.until("document.querySelector('#open-name').textContent === '06-timing-proof.pcapng'")
    tree = "document.querySelector('.packets .tree').textContent"
    chromium.until(f"({tree}).includes('Rexroth SIS')")
    assert chromium.run(f"/[Vv]erdict|Expert Info/.test({tree})") is False
    task, place = next(
        (task, place)
        for task in of_section(proved, "Prove")
        for place, blank in enumerate(task.blanks)
        if blank.kind == "finding"
    )
    texts = [blank.accepted[0] if blank.accepted else "It is late. " * 9 for blank in task.blanks]
    fill(chromium, task, texts)
    points = f"[...document.querySelectorAll('.task[data-number=\"{task.number}\"] .points input')]"
    chromium.until(f"{points}.some((one) => one.checkVisibility())")
    fill(chromium, task, texts)
    chromium.until(f"document.getElementById('blank-{task.number}-{place}-said').textContent.startsWith('0 of ')")
    chromium.run(f"{points}.forEach((one) => one.click())")
    fill(chromium, task, texts)
    chromium.until(f"document.querySelector('.task.done[data-number=\"{task.number}\"]')")
    assert f'"{task.number}":"own"' in chromium.run("localStorage.getItem('sistap-course')")


def test_bytes_are_explained_in_place(chromium: Chromium) -> None:
    lesson(chromium, FIRST.path.stem)
    chromium.run("document.querySelectorAll('.explained')[0].querySelectorAll('.bytes-of')[1].click()")
    chromium.until("document.querySelector('.explained tr.chosen')")
    assert chromium.run("document.querySelectorAll('.explained').length") == 4


def results(browser: Chromium, folder: Path, count: int) -> None:
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
    assert cells[:3] == ["Ada <b>", f"{count}/{len(FIRST.tasks)}", f"0/{len(LESSONS[1].tasks)}"]
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
    """A right answer opens the box, too: that is not shown."""
    lesson(chromium, FIRST.path.stem, opened=False)
    task, count = of_section(FIRST, "Predict")[0], len(FIRST.tasks)
    asked = f"document.querySelector('.task[data-number=\"{task.number}\"]')"
    chromium.run(f"{asked}.querySelector('.answer summary').click()")
    text = "document.querySelector('.lesson-state').textContent"
    chromium.until(f"{text} === '0 of {count} tasks done, 1 answer shown.'")
    fill(chromium, task)
    chromium.until(f"{asked}.querySelector('.verdict').textContent.startsWith('Right. But the answer was opened')")
    assert state(chromium) == f"0 of {count} tasks done, 1 answer shown."
    assert chromium.run("document.querySelector('.task.done')") is None
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
    lesson(chromium, FIRST.path.stem)
    chromium.run("[...document.querySelectorAll('a.packet')].find((one) => one.textContent === '4').click()")
    chromium.until("document.querySelector('.packet-list .row.selected').children[0].textContent === '4'")
    solved = "document.querySelector('.answer:has(table.filter.packets)')"
    for summary in range(len(FIRST.tasks)):
        chromium.run(f"document.querySelectorAll('.answer summary')[{summary}].click()")
    chromium.until(f"{solved}?.querySelector('button.code')")
    chromium.run(f"{solved}.querySelector('button.code').click()")
    chromium.until("/of \\d+ packets/.test(document.querySelector('#filter-said').textContent)")
    assert chromium.run("location.hash") == f"#learn/{FIRST.path.stem}"


def test_a_lessons_settings_end_with_it(chromium: Chromium, page: Path) -> None:
    """Lesson 18 is about another edition."""
    assert content.preferences(next(one for one in LESSONS if one.path.stem == "18-ecodrive03"))
    lesson(chromium, "18-ecodrive03")
    lesson(chromium, "01-first-conversation")
    chromium.run("location.hash = '#packets'")
    chromium.click("Limits")
    chromium.until("document.querySelector('dialog[open]')")
    assert "ECODRIVE03" not in chromium.run("document.querySelector('dialog[open] select').value")


def test_a_telegram_is_decoded_while_it_is_changed(chromium: Chromium) -> None:
    """Figure 8-21 of the SIS definition: phase 2, checksum 0xc3."""
    lesson(chromium, "01-first-conversation")
    tool(chromium, "A telegram")
    tree = "document.querySelector('.tool .tree').textContent"
    chromium.until(f"({tree}).includes('Phase: 2 (parameter mode)') && ({tree}).includes('Checksum: 0xc3 [correct]')")
    chromium.run("[...document.querySelectorAll('.tool .cells button')].at(-1).click()")
    chromium.run("document.querySelector('.tool .bits [aria-label=\"Bit 0\"]').click()")
    chromium.until(f"({tree}).includes('Phase: 3') && /Checksum: 0xc3 .*should be 0xc2/.test({tree})")
    chromium.click("Set the checksum")
    chromium.until(f"({tree}).includes('Checksum: 0xc2 [correct]')")
    assert chromium.run("document.querySelector('.tool input.telegram').value") == "02 C2 02 02 10 12 10 03 00 03"


@pytest.mark.parametrize(
    ("name", "packet", "bytes_", "decoded"),
    [
        ("01-first-conversation", 1, "02 D9 00 00 00 12 10 03", "Checksum: 0xd9 [correct]"),
        (
            "15-who-may-speak",
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
    chromium.until(f"({take}, document.querySelector('.tool input.telegram').value === '{bytes_}')")
    tree = "document.querySelector('.tool .tree').textContent"
    chromium.until(f"({tree}).includes('{decoded}')")
    chromium.run("document.querySelectorAll('.tool .cells button')[6].click()")
    chromium.run("document.querySelector('.tool .bits [aria-label=\"Bit 0\"]').click()")
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
    lesson(chromium, "06-timing")
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


def test_errors_on_the_timeline(chromium: Chromium) -> None:
    lesson(chromium, "04-bad-line")
    chromium.until("document.querySelectorAll('.box').length > 5")
    faulty = chromium.run("document.querySelectorAll('.box.faulty').length")
    chromium.run("document.querySelector('.box:not(.faulty)').focus()")
    chromium.click("break")
    chromium.until(f"document.querySelectorAll('.box.faulty').length === {faulty} + 1")


def test_the_bus_of_a_lesson_plays_in_it(chromium: Chromium) -> None:
    """The annex needs no terminal."""
    lesson(chromium, "19-record-it-yourself")
    before = chromium.run("document.querySelector('.packet-list').getAttribute('aria-rowcount')")
    chromium.run("document.querySelector('.note button').click()")
    rows = "Number(document.querySelector('.packet-list').getAttribute('aria-rowcount'))"
    chromium.until(f"document.querySelector('.live-bar') && {rows} > 5 && {rows} < {before}")
    chromium.run("[...document.querySelectorAll('.live-bar button')].at(-1).click()")
    chromium.until("!document.querySelector('.live-bar') && document.querySelector('#busy').hidden")
    assert 5 < chromium.run(rows) < int(before)
    assert chromium.run("location.hash") == "#learn/19-record-it-yourself"


def test_a_lesson_on_paper(chromium: Chromium) -> None:
    """All packets, and no answer."""
    lesson(chromium, "01-first-conversation")
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
    assert chromium.run("document.querySelector('.print-only .answer')") is None
    chromium.call("Emulation.setEmulatedMedia", media="screen")


def test_a_certificate_of_the_week(chromium: Chromium, page: Path) -> None:
    """Of the lessons 1 to 14, whoever was shown an answer."""
    week = LESSONS[:14]
    kept = {one.path.stem: {"answers": {task.number: "right" for task in one.tasks}} for one in week}
    kept[FIRST.path.stem]["answers"][1] = "shown"
    chromium.run(f"localStorage.setItem('sistap-course', JSON.stringify({json.dumps(kept)}))")
    chromium.open(page.as_uri() + "?kept#open")
    chromium.run("location.hash = '#learn'; window.print = () => {}")
    chromium.until("document.querySelector('#learner')")
    chromium.run("document.querySelector('#learner').value = 'Ada <b>'")
    chromium.click("Print a certificate")
    chromium.until("document.querySelector('.print-only')")
    count = sum(len(one.tasks) for one in week)
    words = chromium.run("document.querySelector('.print-only').textContent")
    assert words.startswith("A week at the winderAda <b> has taken the course")
    assert f"{count - 1} of {count} tasks were done alone, 1 after the answer was shown." in words


@pytest.mark.parametrize(
    "store",
    [
        "Object.defineProperty(window, 'localStorage', {get() { throw new DOMException('no', 'SecurityError'); }})",
        "Storage.prototype.setItem = () => { throw new DOMException('full', 'QuotaExceededError'); }",
        "localStorage.setItem('sistap-course', '{\"01-first-conversation\": 3}')",
        "localStorage.setItem('sistap-course', '[')",
    ],
)
def test_without_a_store_the_lessons_work(store: str, chromium: Chromium, page: Path) -> None:
    chromium.before(f"if (window === top) {{ {store} }}")
    chromium.open(page.as_uri() + "?store#learn")
    chromium.until("document.querySelector('.lessons')")
    lesson(chromium, FIRST.path.stem, opened=False)
    fill(chromium, of_section(FIRST, "Predict")[0])
    chromium.until("document.querySelector('.task.done')")
