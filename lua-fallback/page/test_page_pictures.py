# SPDX-License-Identifier: GPL-2.0-or-later
"""What the pictures and the tables of a capture show, by what a person sees, and where a click leads."""

from __future__ import annotations

import os
from pathlib import Path
from statistics import median

import pytest
from test_page_browser import CAPTURE, capture_of, choose, idle, show_only, tab_to

from chromium import Chromium
from sistap.cli import main

pytestmark = [pytest.mark.thorough, pytest.mark.timeout(600)]

CANVAS = "document.querySelector('.lanes-canvas')"
SAID = "document.querySelector('.lanes-said').textContent"
CHOSEN = "document.querySelector('.row.selected')?.textContent"
LABELS, AXIS, LANE = 74, 15, 13  # pixels, as in lanepicture.js
SETTLED = "new Promise((go) => requestAnimationFrame(() => requestAnimationFrame(() => go(1))))"
DRAWN_S = {20_000: 2, 100_000: 10}  # on a quiet computer with two cores
FRAME_MS = 16
BEARABLE = 12  # times as long on a busy one


def played(scenario: str, folder: Path, duration_s: int = 20) -> Path:
    path = folder / f"{scenario}.pcapng"
    assert (
        main(
            [
                "bus",
                scenario,
                "-w",
                str(path),
                "--seed",
                "1",
                "--duration",
                str(duration_s),
            ]
        )
        == 0
    )
    return path


def lanes(browser: Chromium, capture: Path) -> None:
    """Open a capture, and wait for its lanes."""
    choose(browser, capture)
    browser.until(f"!{CANVAS}.hidden")
    browser.run(SETTLED)


def places(browser: Chromium, lane: int, colour: str) -> list[int]:
    """Return where the middle of a lane has a colour of the style sheet, in pixels from its left."""
    return list(
        browser.run(f"""(() => {{
      const canvas = {CANVAS}, pen = document.createElement('canvas').getContext('2d');
      pen.fillStyle = getComputedStyle(canvas).getPropertyValue({colour!r});
      pen.fillRect(0, 0, 1, 1);
      const same = (data, at) => [0, 1, 2].every((which) => data[at + which] === wanted[which]);
      const wanted = pen.getImageData(0, 0, 1, 1).data;
      const row = canvas.getContext('2d').getImageData(0, {AXIS + lane * LANE + LANE // 2}, canvas.width, 1).data;
      return Array.from({{length: canvas.width}}, (_, x) => x).filter((x) => x > {LABELS} && same(row, 4 * x));
    }})()""")
    )


def mouse(browser: Chromium, kind: str, x: float, lane: float, **more: object) -> None:
    """Do something with the mouse above a lane."""
    left, top = browser.run(f"(({{left, top}}) => [left, top])({CANVAS}.getBoundingClientRect())")
    at = {"x": left + x, "y": top + AXIS + (lane + 0.5) * LANE}
    browser.call("Input.dispatchMouseEvent", type=kind, **at, **more)


def click(browser: Chromium, x: float, lane: float) -> None:
    for kind in ("mousePressed", "mouseReleased"):
        mouse(browser, kind, x, lane, button="left", buttons=1, clickCount=1)


def test_the_lanes_show_who_was_silent(chromium: Chromium, tmp_path: Path) -> None:
    """Station 4, for a time: hollow marks in its lane. A click on one leads to the command, the tip says what it is."""
    lanes(chromium, played("silent-station", tmp_path))
    assert chromium.run(SAID).endswith("packets, 1 fault, 14 without a reaction")
    assert "Station 4: " in chromium.run(f"{CANVAS}.ariaLabel")
    assert not places(chromium, 1, "--wrong")
    marks = places(chromium, 2, "--wrong")
    assert marks
    mouse(chromium, "mouseMoved", marks[0] + 1, 2)
    tip = "document.querySelector('.lanes-tip:not([hidden])')?.innerText"
    chromium.until(tip)
    assert chromium.run(tip).startswith("Station 4\n")
    assert "16 -> 4, command, no reaction" in chromium.run(tip)
    click(chromium, marks[0] + 1, 2)
    chromium.until(f"{CHOSEN}?.includes('[no reaction]')")
    reactions = places(chromium, 1, "--lane-reaction")
    click(chromium, reactions[len(reactions) // 2], 1)
    chromium.until(f"{CHOSEN}?.includes('3 -> 16')")


def test_a_fault_is_red_and_tall(chromium: Chromium, tmp_path: Path) -> None:
    """Of many packets in a column, the damaged one is seen, above the bars of all others."""
    lanes(chromium, played("damaged", tmp_path))
    marks = places(chromium, 0, "--wrong")
    assert marks
    above = f"{CANVAS}.getContext('2d').getImageData({marks[0]}, {AXIS + 1}, 1, 1).data.join()"
    beside = f"{CANVAS}.getContext('2d').getImageData({marks[-1] + 4}, {AXIS + 1}, 1, 1).data.join()"
    assert chromium.run(above) != chromium.run(beside)
    click(chromium, marks[0], 0)
    chromium.until(f"{CHOSEN}?.includes('[wrong checksum')")


def seen(browser: Chromium) -> list[float]:
    """Return the begin and the end of the time that is seen, as the strip says them."""
    browser.run(SETTLED)
    return [float(word) for word in browser.run(f"{SAID}.match(/[-.\\d]+(?= s)/g)")]


def test_the_lanes_zoom_and_move(chromium: Chromium, tmp_path: Path) -> None:
    """With the wheel at the pointer, by dragging, and with keys."""
    lanes(chromium, played("silent-station", tmp_path))
    whole = chromium.run(SAID)
    width = chromium.run(f"{CANVAS}.clientWidth") - LABELS
    mouse(chromium, "mouseWheel", LABELS + width / 4, 1, deltaX=0, deltaY=-800)
    chromium.until(f"{SAID} !== {whole!r}")
    begin, end = seen(chromium)
    assert 4.5 < begin + (end - begin) / 4 < 5.5
    mouse(
        chromium,
        "mousePressed",
        LABELS + 300,
        1,
        button="left",
        buttons=1,
        clickCount=1,
    )
    mouse(chromium, "mouseMoved", LABELS + 100, 1, button="left", buttons=1)
    mouse(
        chromium,
        "mouseReleased",
        LABELS + 100,
        1,
        button="left",
        buttons=0,
        clickCount=1,
    )
    moved = seen(chromium)
    assert moved[0] == pytest.approx(begin + (end - begin) * 200 / width, abs=0.05)
    tab_to(chromium, ".lanes-canvas")
    chromium.press("ArrowLeft", 37)
    assert seen(chromium)[0] < moved[0]
    chromium.press("+", 187, "+")
    nearer = seen(chromium)
    assert nearer[1] - nearer[0] < (end - begin) * 0.7
    chromium.press("0", 48, "0")
    chromium.until(f"{SAID} === {whole!r}")
    chromium.press("Enter", 13, "\r")  # the packet in the middle
    time = "Number(document.querySelector('.row.selected')?.children[1].textContent)"
    chromium.until(f"{time} > 9 && {time} < 11")
    chromium.click("+")
    chromium.until(f"{SAID} !== {whole!r}")
    chromium.click("All")
    chromium.until(f"{SAID} === {whole!r}")


def test_the_report_is_behind_the_lanes(chromium: Chromium, tmp_path: Path) -> None:
    """Its episodes are bands: the silence of station 4 in its lane."""
    lanes(chromium, played("silent-station", tmp_path))
    chromium.until("document.querySelector('.answer-bar').textContent.startsWith('NOT OK')")
    chromium.run(SETTLED)
    band = places(chromium, 2, "--lane-error")
    assert band
    assert not places(chromium, 1, "--lane-error")
    mouse(chromium, "mouseMoved", band[len(band) // 2], 2)
    chromium.until("/error: Station silent/.test(document.querySelector('.lanes-tip:not([hidden])')?.textContent)")


def test_many_packets_are_drawn_when_asked(chromium: Chromium, tmp_path: Path) -> None:
    """With progress, and with Cancel."""
    load, _, _ = os.getloadavg()
    for telegrams, wanted_s in DRAWN_S.items():
        choose(chromium, capture_of(telegrams, tmp_path))
        draw = "document.querySelector('.lanes-said button')"
        chromium.until(draw)
        assert chromium.run(f"/^Draw \\d+,\\d+ packets$/.test({draw}.textContent)")
        chromium.run(f"{draw}.click()")
        if telegrams == 100_000:
            chromium.until("document.querySelector('#busy progress')?.value > 0.1", timeout_s=300)
            chromium.click("Cancel")
            chromium.until(f"document.querySelector('#busy').hidden && {draw}")
            chromium.run(f"{draw}.click()")
        begin = chromium.run("performance.now()")
        chromium.until(f"!{CANVAS}.hidden", timeout_s=300)
        took_s = (chromium.run("performance.now()") - begin) / 1000
        draws = chromium.run(f"""(async () => {{
          const took = [];
          for (const deltaY of [-60, -60, 60, -200, 100, -300]) {{
            {CANVAS}.dispatchEvent(new WheelEvent('wheel', {{deltaY, clientX: 600, cancelable: true}}));
            took.push(await new Promise((go) => requestAnimationFrame((begin) => go(performance.now() - begin))));
          }}
          return took;
        }})()""")
        print(f"{telegrams} telegrams, load {load:.0f}: lanes after {took_s:.1f} s, drawn in {median(draws):.1f} ms")
        assert median(draws) < FRAME_MS * (1 if load < 1 else BEARABLE)
        assert took_s < wanted_s * (1 if load < 1 else BEARABLE)


def test_folded_lanes_stay_folded(chromium: Chromium, page: Path) -> None:
    """Also when the page is opened again."""
    lanes(chromium, CAPTURE)
    chromium.click("Lanes")
    chromium.until(f"!{CANVAS}.offsetHeight")
    chromium.open(f"{page.as_uri()}?again")
    chromium.until("document.documentElement.dataset.ready")
    choose(chromium, CAPTURE)
    fold = "document.querySelector('.lanes-fold')"
    assert chromium.run(f"{fold}.ariaExpanded") == "false"
    assert chromium.run(f"{CANVAS}.hidden")
    chromium.click("Lanes")
    chromium.until(f"{CANVAS}.offsetHeight > 0")


def test_a_lesson_has_no_lanes(chromium: Chromium) -> None:
    """Who leaves it sees them."""
    chromium.run("location.hash = '#learn/06-timing'")
    chromium.until("document.querySelector('.lesson .packet-list .row.selected')")
    idle(chromium)
    assert chromium.run("document.querySelector('.lanes').offsetHeight") == 0
    show_only(chromium, "packets")
    chromium.until(f"{CANVAS}.offsetHeight > 0")


def test_all_changes_are_there_the_newest_first(chromium: Chromium, tmp_path: Path) -> None:
    """Also more than a thousand: those that are scrolled to. The last write has a line of its own."""
    choose(chromium, capture_of(20_000, tmp_path))
    show_only(chromium, "changes")
    chromium.until("document.querySelector('[aria-label=Changes] td button')", timeout_s=300)
    table = "document.querySelector('[aria-label=Changes]')"
    count = chromium.run(f"Number({table}.querySelector('table').ariaRowCount) - 1")
    assert count > 1500
    rows = f"[...{table}.querySelectorAll('tbody tr:not(.space)')]"
    cells = f"{rows}.map((row) => [...row.cells].map((cell) => cell.textContent))"
    first = chromium.run(cells)[0]
    assert chromium.run(f"{rows}.length") < 100
    last = chromium.run("document.querySelector('.last-write').textContent")
    assert last == (
        f"Last write: {first[0]}, master {first[1]}, station {first[2]}, {first[3]} {first[4]} "
        f"from {first[5]} to {first[6]}, packet {first[7]}"
    )
    assert [int(row[7]) for row in chromium.run(cells)] == sorted(
        (int(row[7]) for row in chromium.run(cells)), reverse=True
    )
    tab_to(chromium, "[aria-label=Changes]")
    for width in (1280, 390):
        chromium.size(width, 860)
        chromium.run(SETTLED)
        chromium.run(f"{table}.focus()")
        chromium.press("End", 35)
        chromium.until(f"{rows}.at(-1).ariaRowIndex === '{count + 1}'")
        assert int(chromium.run(cells)[-1][7]) < 100
        bottom = f"({rows}.at(-1).getBoundingClientRect().bottom - {table}.getBoundingClientRect().bottom)"
        chromium.until(f"Math.abs({bottom}) < 20")
        chromium.run(f"{table}.scrollTop = 0")
        chromium.until(f"{rows}[0].ariaRowIndex === '2'")
        assert chromium.run("document.documentElement.scrollWidth") <= width
    chromium.run("document.querySelector('.last-write button').click()")
    chromium.until(
        f"location.hash === '#packets' && "
        f"document.querySelector('.row.selected')?.children[0].textContent === '{first[7]}'"
    )


def test_changes_of_one_parameter(chromium: Chromium, tmp_path: Path) -> None:
    """The rarest is offered first."""
    choose(chromium, capture_of(1000, tmp_path))
    show_only(chromium, "changes")
    chromium.until("document.querySelector('[aria-label=Changes] td button')")
    chromium.run(
        "(([select]) => (select.selectedIndex = 1, select.dispatchEvent(new Event('change'))))"
        "([document.querySelector('#changed')])"
    )
    wanted = chromium.run("document.querySelector('#changed').selectedOptions[0].textContent")
    name, count = wanted.removesuffix(")").split(" (")
    rows = "[...document.querySelectorAll('[aria-label=Changes] tbody tr:not(.space)')]"
    assert chromium.run(f"{rows}.length") == int(count)
    shown = chromium.run(
        f"{rows}.map(({{cells}}) => "
        "`${cells[3].textContent} ${cells[4].textContent}, station ${cells[2].textContent}`)"
    )
    assert {one.replace(" ,", ",") for one in shown} == {name}


CURVE = "document.querySelector('svg.curve')"
CURVE_SAID = "document.querySelector('.curve-said').textContent"
FINER = "Measure this part more exactly"


def draw(browser: Chromium, name: str) -> None:
    """Choose one of the curves."""
    browser.run(f"""((select) => {{
      select.value = [...select.options].find((one) => one.textContent === {name!r}).value;
      select.dispatchEvent(new Event('change'));
    }})(document.querySelector('#curve-graph'))""")
    browser.until(f"{CURVE}?.ariaLabel.startsWith({name!r})")
    idle(browser)


def test_a_curve_has_units(chromium: Chromium, tmp_path: Path) -> None:
    """Times are in ms; a value has the unit that was read on the bus."""
    choose(chromium, capture_of(1000, tmp_path))
    show_only(chromium, "curve")
    chromium.until(CURVE)
    for name, unit in (
        ("Longest reaction time", "ms"),
        ("Longest interval in a telegram", "ms"),
        ("Velocity S-0-0040 of station 3", "rpm"),
        ("Position S-0-0051 of station 3", "Deg"),
    ):
        draw(chromium, name)
        assert chromium.run(f"{CURVE}.querySelector('.title').textContent") == f"{name} [{unit}]"
        assert chromium.run(CURVE_SAID).split(".  ")[0].split(" in ")[1].startswith(f"{unit}.")
    draw(chromium, "Bus load in %")
    assert chromium.run(f"{CURVE}.querySelector('.title').textContent") == "Bus load in %"


def test_a_curve_is_zoomed_and_leads_to_packets(chromium: Chromium, tmp_path: Path) -> None:
    """Far away it is a band and a line; near by it has dots. The part that is seen can be measured more exactly."""
    choose(chromium, capture_of(3000, tmp_path))
    show_only(chromium, "curve")
    chromium.until(CURVE)
    dots = f"{CURVE}.querySelectorAll('.value').length"
    assert chromium.run(dots) == 0
    assert chromium.run(f"{CURVE}.querySelector('.band').getBBox().height") > 50
    wheel = f"{CURVE}.dispatchEvent(new WheelEvent('wheel', {{deltaY: -1200, clientX: 600, cancelable: true}}))"
    chromium.run(wheel)
    assert 2 < chromium.run(dots) < 200
    chromium.click(FINER)
    chromium.until(
        f"{CURVE}.querySelectorAll('.value').length && [...document.querySelectorAll('button')]"
        ".some((one) => one.textContent === 'Measure all again' && !one.hidden)"
    )
    idle(chromium)
    assert "(1 packet)" not in chromium.run(CURVE_SAID)
    tab_to(chromium, "svg.curve")
    chromium.press("ArrowRight", 39)
    chromium.press("ArrowRight", 39)
    assert chromium.run(CURVE_SAID).endswith("(1 packet)")
    seconds, value = (float(word.split()[0]) for word in chromium.run(CURVE_SAID).split(": "))
    chromium.press("Enter", 13, "\r")
    chromium.until("location.hash === '#packets'")
    cells = "[...document.querySelector('.row.selected')?.children ?? []].map((one) => one.textContent)"
    chromium.until(f"Math.abs({cells}[1] - {seconds}) < 0.1 && Math.abs({cells}[7] - {value}) < 0.01")
    show_only(chromium, "curve")
    assert 2 < chromium.run(dots) < 200  # as it was left
    chromium.click("Measure all again")
    chromium.until(f"{CURVE} && !{dots}")
    idle(chromium)
