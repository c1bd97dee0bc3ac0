# SPDX-License-Identifier: GPL-2.0-or-later
"""The view of packets, by what a person sees: its rows, tree, bytes, filters."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from test_page_browser import CAPTURE, capture_of, choose, docklight, idle, tab_to, text_of

from chromium import Chromium
from make import HERE as CAPTURES
from sistap.tap.files.pcapng import LINKTYPE_WIRESHARK_UPPER_PDU, Interface
from sistap.tap.files.writer import Blocks
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.record import Record, Type

pytestmark = [pytest.mark.thorough, pytest.mark.timeout(600)]

SILENCE = CAPTURES / "course" / "07-silence.pcapng"  # station 9 never answers
ROWS = "[...document.querySelectorAll('.packet-list .rows .row')].sort((a, b) => a.ariaRowIndex - b.ariaRowIndex)"
SAID = "document.querySelector('#filter-said').textContent"


def heights(browser: Chromium, *selectors: str) -> list[float]:
    shown = "document.querySelector(selector).getBoundingClientRect().height"
    return list(browser.run(f"{list(selectors)}.map((selector) => {shown})"))


def colours(browser: Chromium, row: int) -> dict[str, str]:
    """Return the colours of a row; 1 is the first one."""
    styles = "(({color, backgroundColor, borderLeftColor}) => ({color, backgroundColor, borderLeftColor}))"
    return dict(browser.run(f"{styles}(getComputedStyle({ROWS}[{row - 1}]))"))


def judged(browser: Chromium) -> None:
    browser.until("/Slowest/.test(document.querySelector('.answer-bar').textContent)")


def test_most_of_a_small_screen_is_packets(chromium: Chromium, tmp_path: Path) -> None:
    """A head, a line that says what happened, a line of filters; the rest is the packets and their picture."""
    log = tmp_path / "docklight.txt"
    log.write_text(docklight(), newline="")
    chromium.size(1366, 768)
    choose(chromium, log)
    judged(chromium)
    head, answer, filters = heights(chromium, "header", ".folded", ".filter-bar")
    assert (head, answer < 32, filters < 40) == (40, True, True)
    chromium.until("!document.querySelector('.lanes-canvas').hidden")
    assert sum(heights(chromium, ".lanes", ".packet-list", ".below")) >= 580
    chromium.click("More")
    assert heights(chromium, ".folded")[0] > answer
    assert chromium.run("document.querySelector('.folded button.small').ariaExpanded") == "true"
    chromium.click("Less")
    assert heights(chromium, ".folded")[0] == answer


def test_who_goes_into_the_folded_answer_by_tab_sees_it(chromium: Chromium, tmp_path: Path) -> None:
    log = tmp_path / "docklight.txt"
    log.write_text(docklight(), newline="")
    chromium.size(390, 844)
    choose(chromium, log)
    judged(chromium)
    tab_to(chromium, ".answer-bar [href='#answer']")
    assert chromium.run("document.querySelector('.folded').classList.contains('unfolded')")


def test_the_row_of_filters_counts_what_they_leave(chromium: Chromium) -> None:
    """What is wrong with a filter moves nothing: it stands over the list. Escape takes it away."""
    choose(chromium, SILENCE)
    assert chromium.run(SAID) == "23 packets"
    before = heights(chromium, ".filter-bar")
    tab_to(chromium, "#filter")
    chromium.type("sis.nonsense")
    chromium.until(f"/nonsense/.test({SAID})")
    assert heights(chromium, ".filter-bar") == before
    chromium.press("Escape", 27)
    assert chromium.run(SAID) == "23 packets"
    chromium.click("Unanswered")
    chromium.until(f"/of 23 packets/.test({SAID})")


@pytest.mark.parametrize("dark", [False, True])
def test_only_faults_have_coloured_rows(dark: bool, chromium: Chromium) -> None:
    """Packet 1 is a command, 5 has no reaction. The selected row has one colour of its own."""
    choose(chromium, SILENCE)
    chromium.size(1366, 768, dark=dark)
    chromium.run(f"{ROWS}[1].click()")
    chromium.until(f"{ROWS}[1].matches('.selected')")
    paper = chromium.run("getComputedStyle(document.querySelector('.packet-list .rows')).backgroundColor")
    assert paper == "rgba(0, 0, 0, 0)"
    command, selected, fault = (colours(chromium, row) for row in (1, 2, 5))
    assert command["backgroundColor"] == paper
    assert command["borderLeftColor"] == "rgb(127, 166, 196)"  # as the profile has it
    assert fault["backgroundColor"] != paper
    assert fault["borderLeftColor"] == "rgb(117, 78, 175)"
    assert selected["backgroundColor"] not in (paper, fault["backgroundColor"])
    assert chromium.run("getComputedStyle(document.querySelector('.row.selected')).fontWeight") == "400"


@pytest.mark.parametrize("address", ["constructor", "__proto__", "packets/sis", "packets/%", "toString/x"])
def test_no_address_leads_to_an_empty_page(address: str, chromium: Chromium, page: Path) -> None:
    chromium.open(f"{page.as_uri()}#{address}")
    chromium.run(f"location.hash = '#{address}'")
    chromium.until("document.documentElement.dataset.ready")
    assert chromium.run("document.querySelector('#chooser').checkVisibility()")


def test_nothing_is_exported_while_nothing_is_open(chromium: Chromium) -> None:
    """While a capture is opened again with other limits, for example."""
    disabled = "[...document.querySelectorAll('.acts button')].find((one) => one.textContent === 'Export').disabled"
    choose(chromium, CAPTURE)
    assert chromium.run(disabled) is False
    chromium.run(f"""{{
      globalThis.seen = [];
      new MutationObserver(() => seen.push({disabled})).observe(document.querySelector('#busy'), {{attributes: true}});
    }}""")
    chromium.click("Limits")
    chromium.click("Use them")
    chromium.until("seen.length > 1")
    idle(chromium)
    assert chromium.run("seen[0]") is True
    assert chromium.run(disabled) is False


def asks_before_it_ends(browser: Chromium) -> Any:
    return browser.run("!dispatchEvent(new Event('beforeunload', {cancelable: true}))")


def test_reload_asks_whether_the_capture_may_go(chromium: Chromium) -> None:
    chromium.press("Shift", 16)
    chromium.press("Tab", 9)  # a browser asks whoever has done something
    assert not asks_before_it_ends(chromium)
    choose(chromium, CAPTURE)
    assert asks_before_it_ends(chromium)


FOCUSED = "document.activeElement.firstChild.textContent"
ITEMS = "document.querySelectorAll('.tree li').length"
DUMP = "document.querySelector('.dump')"


def long_record(characters: int) -> bytes:
    """Make a capture: a short record, and one whose characters all came after pauses, so that each is shown."""
    settings = LineSettings(19200)
    blocks = Blocks({0: Interface(LINKTYPE_WIRESHARK_UPPER_PDU, "line")})
    begin_ns = 10**18

    def record(count: int, time_ns: int) -> Record:
        data = bytes(7 * place & 0xFF for place in range(count))
        pauses = [settings.character_ns + 10_000_000 * (1 + place % 7) for place in range(count)]
        return Record(time_ns, Type.OTHER, 0, settings, data, pauses, bytes(count), 310_000)

    section = blocks.section()
    made = [blocks.packet(record(count, begin_ns + place)) for place, count in enumerate((3, characters))]
    return section + b"".join(made)


def select(browser: Chromium, row: int) -> None:
    """Click on a row; 1 is the first one."""
    browser.run(f"{ROWS}[{row - 1}].click()")
    browser.until(f"{ROWS}[{row - 1}].matches('.selected')")
    number = browser.run(f"{ROWS}[{row - 1}].children[0].textContent")
    browser.until(f"document.querySelector('.tree .label').textContent.startsWith('Frame {number}:')")


def focus_item(browser: Chromium, words: str) -> None:
    """Click on the item of the tree whose text begins so."""
    browser.run(f"""[...document.querySelectorAll('.tree .label')]
      .find((one) => one.textContent.startsWith({json.dumps(words)})).click()""")


def test_a_record_of_43_000_characters_does_not_freeze_the_page(chromium: Chromium, tmp_path: Path) -> None:
    """Its tree has 129,000 items. Those that are seen are made."""
    capture = tmp_path / "long.pcapng"
    capture.write_bytes(long_record(43_000))
    choose(chromium, capture)
    select(chromium, 2)
    chromium.run("""{
      globalThis.longest = 0;
      addEventListener("keydown", () => {
        const begin = performance.now();
        const end = () => (longest = Math.max(longest, performance.now() - begin));
        setTimeout(() => requestAnimationFrame(() => setTimeout(end)));
      }, true);
    }""")
    focus_item(chromium, "Serial tap")
    chromium.press("ArrowRight", 39)
    focus_item(chromium, "43000 characters")
    chromium.press("ArrowRight", 39)
    chromium.press("ArrowDown", 40)
    assert chromium.run(FOCUSED).startswith("Character 1:")
    chromium.press("ArrowRight", 39)
    assert chromium.run(ITEMS) < 1000
    chromium.until("longest > 0")
    assert chromium.run("longest") < 500


def test_a_long_branch_goes_on_where_its_items_end(chromium: Chromium, tmp_path: Path) -> None:
    """By the arrow keys, and by a click on what says that there are more. A byte far away is found, too."""
    capture = tmp_path / "long.pcapng"
    capture.write_bytes(long_record(2500))
    choose(chromium, capture)
    select(chromium, 2)
    focus_item(chromium, "Serial tap")
    chromium.press("ArrowRight", 39)
    focus_item(chromium, "2500 characters")
    chromium.press("ArrowRight", 39)
    focus_item(chromium, "Character 500:")
    chromium.press("ArrowDown", 40)
    assert chromium.run(FOCUSED).startswith("Character 501:")
    focus_item(chromium, "Show 500 more: 1,500 are after these")
    focus_item(chromium, "Character 1500:")
    data = 36  # the first character's place in the packet
    chromium.run("[...document.querySelectorAll('.dump button')].at(-1).click()")
    chromium.run(f"document.querySelectorAll('.dump .line > b')[{data + 2299 - 1024}].click()")
    chromium.until("/^Character 2300/.test(document.querySelector('.tree [aria-selected] .label').textContent)")
    focus_item(chromium, "Character 2001:")
    chromium.press("ArrowUp", 38)
    assert chromium.run(FOCUSED).startswith("Character 2000:")


def test_the_bytes_are_those_of_the_telegram(chromium: Chromium) -> None:
    """The envelope is a button away. In a narrow window lines are shorter, and letters still stand beside them."""
    chromium.size(1366, 768)
    choose(chromium, SILENCE)
    pressed = "document.querySelector('.tabs [aria-pressed=true]').textContent"
    assert chromium.run(pressed) == "Characters"
    line = f"{DUMP}.querySelector('.line').textContent"
    assert chromium.run(line) == "0000  02 aa 04 04 00 03 10 03  03 01 32 00              ··········2·\n"
    chromium.size(390, 844)
    chromium.until(f"{line}.length < 45")
    assert chromium.run(line) == "0000  02 aa 04 04 00 03 10 03  ········\n"
    assert chromium.run(f"{DUMP}.scrollWidth <= {DUMP}.clientWidth")
    chromium.click("Frame")
    chromium.until("/sertap/.test([...document.querySelectorAll('.letters')].map((one) => one.textContent).join(''))")


def test_only_bytes_that_change_are_touched(chromium: Chromium) -> None:
    choose(chromium, SILENCE)
    chromium.run("document.querySelectorAll('.dump .line > b')[1].click()")
    chromium.run(f"""{{
      globalThis.touched = 0;
      new MutationObserver((all) => (touched += all.length)).observe({DUMP}, {{subtree: true, attributes: true}});
    }}""")
    chromium.run("document.querySelectorAll('.dump .line > b')[2].click()")
    chromium.until("touched")
    assert chromium.run("touched") <= 4  # each has a letter, too
    assert chromium.run("document.querySelectorAll('.dump b.marked').length") == 2


CTRL = 2  # modifier
COPIED = "globalThis.copied"
MENU = "[...document.querySelectorAll('[role=menu] li')].map((one) => one.textContent)"


def watch_copies(browser: Chromium, *, is_file: bool = False) -> None:
    """Note what is copied; `is_file`: as in a page that is a file, there is no clipboard for scripts."""
    kept = "undefined" if is_file else "{writeText: async (text) => { globalThis.copied = text; }}"
    browser.run(f"""{{
      Object.defineProperty(navigator, "clipboard", {{configurable: true, value: {kept}}});
      const marked = () => String(document.getSelection()) || document.activeElement.value;
      document.addEventListener("copy", () => (globalThis.copied = marked()));
    }}""")


def press_with(browser: Chromium, key: str, code: int, modifiers: int) -> None:
    for kind in ("rawKeyDown", "keyUp"):
        browser.call("Input.dispatchKeyEvent", type=kind, key=key, windowsVirtualKeyCode=code, modifiers=modifiers)


def menu_at(browser: Chromium, expression: str) -> list[str]:
    """Click with the right button on an element; return what its menu offers."""
    x, y = browser.run(f"(({{left, top}}) => [left + 4, top + 4])(({expression}).getBoundingClientRect())")
    for kind in ("mousePressed", "mouseReleased"):
        browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="right", clickCount=1)
    browser.until("document.querySelector('[role=menu]')")
    return list(browser.run(MENU))


def take(browser: Chromium, words: str) -> None:
    browser.run(
        f"[...document.querySelectorAll('[role=menu] li')].find((one) => one.textContent === '{words}').click()"
    )


@pytest.mark.parametrize("is_file", [False, True])
def test_ctrl_c_copies_the_row_the_field_or_the_bytes(is_file: bool, chromium: Chromium) -> None:
    choose(chromium, SILENCE)
    watch_copies(chromium, is_file=is_file)
    select(chromium, 2)
    wanted = {
        ".packet-list": "2\t0.0246",
        ".tree [role=treeitem]": "Checksum: 0x",
        ".dump": "ce",
    }
    for selector, beginning in wanted.items():
        chromium.run(f"{COPIED} = ''")
        if selector.startswith(".tree"):
            focus_item(chromium, "Checksum")
        else:
            chromium.run(f"document.querySelector('{selector}').focus()")
        press_with(chromium, "c", 67, CTRL)
        chromium.until(COPIED)
        assert str(chromium.run(COPIED)).startswith(beginning), selector
        assert chromium.run(f"document.activeElement.matches('{selector}')")


def test_a_menu_copies_and_filters_a_cell(chromium: Chromium) -> None:
    """The cell From of row 8 is of station 3."""
    choose(chromium, SILENCE)
    watch_copies(chromium)
    offered = menu_at(chromium, f"{ROWS}[7].children[3]")
    assert offered == ["Copy row", "Copy value", "Copy bytes", "Copy filter", "Apply as filter", "Not this"]
    assert text_of(chromium, ".row.selected > span") == "8"
    for words, copied in {"Copy value": "3", "Copy filter": "sis.talker == 3", "Copy bytes": "02 "}.items():
        menu_at(chromium, f"{ROWS}[7].children[3]")
        take(chromium, words)
        chromium.until(f"String({COPIED}).startsWith('{copied}')")
    menu_at(chromium, f"{ROWS}[7].children[3]")
    take(chromium, "Apply as filter")
    chromium.until("document.querySelector('#filter').value === 'sis.talker == 3'")
    chromium.until(f"/ of 23 packets/.test({SAID})")
    assert "And this filter" in menu_at(chromium, f"{ROWS}[1].children[4]")
    take(chromium, "And this filter")
    chromium.until("document.querySelector('#filter').value === '(sis.talker == 3) && sis.listener == 16'")


def test_the_menus_work_by_keyboard(chromium: Chromium) -> None:
    """Of the list, the tree and the bytes. Escape leads back."""
    choose(chromium, SILENCE)
    for selector in (".packet-list", ".tree [role=treeitem]", ".dump"):
        tab_to(chromium, selector)
        chromium.run(
            "document.activeElement.dispatchEvent(new MouseEvent('contextmenu', {bubbles: true, cancelable: true}))"
        )
        chromium.until("document.activeElement.matches('[role=menu] li')")
        first = text_of(chromium, "[role=menu] li:focus")
        chromium.press("ArrowDown", 40)
        assert text_of(chromium, "[role=menu] li:focus") != first
        chromium.press("Escape", 27)
        assert chromium.run(f"document.activeElement.matches('{selector}')")
        assert not chromium.run("document.querySelector('[role=menu]')")


def test_the_menus_of_tree_and_bytes(chromium: Chromium) -> None:
    choose(chromium, SILENCE)
    watch_copies(chromium)
    label = "[...document.querySelectorAll('.tree .label')].find((one) => one.textContent.startsWith('Checksum:'))"
    assert "Copy filter" in menu_at(chromium, label)
    take(chromium, "Copy filter")
    chromium.until(f"String({COPIED}).startsWith('sis.checksum == ')")
    assert "Copy bytes" in menu_at(chromium, "document.querySelectorAll('.dump .line > b')[0]")
    take(chromium, "Copy row")
    chromium.until(f"String({COPIED}).startsWith('0000  02 ')")
    take_again = menu_at(chromium, "document.querySelectorAll('.dump .line > b')[2]")
    assert "Apply as filter" in take_again
    take(chromium, "Copy bytes")
    chromium.until(f"{COPIED} === '04'")


def test_what_wireshark_has_found_out_is_in_brackets(chromium: Chromium, tmp_path: Path) -> None:
    """As in Wireshark: in the tree, and in what is exported of it. Nothing has two of them."""
    choose(chromium, SILENCE)
    labels = chromium.run("[...document.querySelectorAll('.tree .label')].map((one) => one.textContent)")
    assert {"[Talker: 16]", "[Checksum Status: Good]", "Start character: 0x02", "Sender address: 16 (station)"} <= {
        *labels
    }
    assert not [label for label in labels if label.startswith("[[")]
    chromium.run("""{
      const made = URL.createObjectURL;
      URL.createObjectURL = (blob) => (blob.text().then((text) => (globalThis.saved = text)), made(blob));
      HTMLAnchorElement.prototype.click = () => {};
    }""")
    chromium.click("Export")
    chromium.click("The 23 packets that the list shows, with all fields (text)")
    chromium.until("globalThis.saved")
    assert "\n    [Talker: 16]\n" in chromium.run("saved")
    assert "\n    Service: Read phase (0x12)\n" in chromium.run("saved")


def test_back_uses_the_filter_before(chromium: Chromium) -> None:
    choose(chromium, SILENCE)
    used = "document.querySelector('#filter').value"
    for filter_ in ("sis.talker == 3", "sis.talker == 16"):
        chromium.run(f"document.querySelector('#filter').value = '{filter_}'")
        chromium.click("Apply")
        chromium.until(f"/ of 23 packets/.test({SAID})")
        idle(chromium)
    assert chromium.run("location.hash") == "#packets"
    for way, filter_ in (("back", "sis.talker == 3"), ("back", ""), ("forward", "sis.talker == 3")):
        chromium.run(f"history.{way}()")
        chromium.until(f"{used} === '{filter_}'")
        idle(chromium)
    chromium.run("location.hash = '#statistics'")
    chromium.until("document.querySelector('nav [href=\"#statistics\"]').ariaCurrent")
    chromium.run("history.back()")
    chromium.until("document.querySelector('.packets').checkVisibility()")
    assert chromium.run(used) == "sis.talker == 3"
    chromium.run("location.hash = '#packets/sis.talker%20%3D%3D%2016'")
    chromium.until(f"{used} === 'sis.talker == 16' && location.hash === '#packets'")


def test_back_keeps_filters_of_another_capture_away(chromium: Chromium) -> None:
    choose(chromium, SILENCE)
    chromium.click("Unanswered")
    chromium.until(f"/ of 23 packets/.test({SAID})")
    choose(chromium, CAPTURE)
    chromium.run("history.go(-2)")
    chromium.until("document.querySelector('.packets').checkVisibility()")
    idle(chromium)
    assert chromium.run("document.querySelector('#filter').value") == ""


def column(browser: Chromium, title: str) -> list[str]:
    """Return the texts of a column, from the top of the list on, as far as its rows are seen."""
    heads = "[...document.querySelectorAll('.head > span')].map((one) => one.firstChild.textContent)"
    place = browser.run(heads).index(title)
    browser.until(f"{ROWS}.every((row) => !row.matches('.waiting'))")
    return list(browser.run(f"{ROWS}.map((row) => row.children[{place}].textContent)"))


def head(browser: Chromium, title: str) -> str:
    return f"[...document.querySelectorAll('.head > span')].find((one) => one.firstChild.textContent === '{title}')"


def sort_by(browser: Chromium, title: str, order: str) -> None:
    browser.run(f"{head(browser, title)}.click()")
    browser.until(f"{head(browser, title)}.ariaSort === '{order}'")
    idle(browser)


def test_a_click_on_a_head_sorts(chromium: Chromium) -> None:
    """Numbers by what they are worth, what is empty last; a second click turns the order, a third one ends it.

    The selected packet stays, its keys go to its neighbours, and a filter leaves the order as it is.
    """
    choose(chromium, SILENCE)
    before = column(chromium, "No.")
    select(chromium, 3)
    sort_by(chromium, "Silence (ms)", "ascending")
    told = [float(text) for text in column(chromium, "Silence (ms)") if text]
    assert told == sorted(told)
    assert len({*told}) > 2
    assert text_of(chromium, ".row.selected > span") == "3"
    sort_by(chromium, "Silence (ms)", "descending")
    found = column(chromium, "Silence (ms)")
    told = [float(text) for text in found if text]
    assert told == sorted(told, reverse=True)
    assert found[len(told) :] == [""] * (len(found) - len(told))
    assert text_of(chromium, ".head [aria-sort=descending]").endswith("▼")
    select(chromium, 1)
    chromium.run("document.querySelector('.packet-list').focus()")
    chromium.press("ArrowDown", 40)
    chromium.until(f"{ROWS}[1].matches('.selected')")
    chromium.click("Unanswered")
    chromium.until(f"/ of 23 packets/.test({SAID})")
    idle(chromium)
    told = [float(text) for text in column(chromium, "Silence (ms)") if text]
    assert told == sorted(told, reverse=True)
    chromium.click("Clear")
    chromium.until(f"{SAID} === '23 packets'")
    idle(chromium)
    sort_by(chromium, "Silence (ms)", "none")
    assert column(chromium, "No.") == before


def test_the_heads_sort_by_keyboard(chromium: Chromium) -> None:
    choose(chromium, SILENCE)
    tab_to(chromium, ".packet-list")
    tab_to(chromium, ".head > span")
    chromium.press("ArrowRight", 39)
    chromium.press("Enter", 13, "\r")
    chromium.until("document.activeElement.ariaSort === 'ascending'")
    assert chromium.run("document.activeElement.textContent") == "Time▲"


def test_columns_are_chosen_and_remembered(chromium: Chromium, page: Path) -> None:
    choose(chromium, SILENCE)
    titles = "[...document.querySelectorAll('.head > span')].map((one) => one.textContent)"
    before = chromium.run(titles)
    chromium.run(
        f"{head(chromium, 'Time')}.dispatchEvent(new MouseEvent('contextmenu', {{bubbles: true, cancelable: true}}))"
    )
    assert chromium.run(MENU) == before
    take(chromium, "Silence (ms)")
    wanted = [title for title in before if title != "Silence (ms)"]
    assert chromium.run(titles) == wanted
    assert column(chromium, "Telegram")[1].startswith("3 -> 16  Reaction")
    assert chromium.run(f"{ROWS}[0].children.length") == len(wanted)
    chromium.open(page.as_uri())
    chromium.until("document.documentElement.dataset.ready")
    assert chromium.run(titles) == wanted


def test_sorting_tells_its_progress_and_can_be_cancelled(chromium: Chromium, tmp_path: Path) -> None:
    choose(chromium, capture_of(6000, tmp_path))
    chromium.run(f"{head(chromium, 'Telegram')}.click()")
    chromium.until("document.querySelector('#busy progress')?.value > 0.05")
    chromium.click("Cancel")
    idle(chromium)
    assert chromium.run(f"{head(chromium, 'Telegram')}.ariaSort") == "none"
    assert text_of(chromium, "#trouble") == ""
    sort_by(chromium, "Telegram", "ascending")
    found = column(chromium, "Telegram")
    assert found[:5] == sorted(found[:5])
