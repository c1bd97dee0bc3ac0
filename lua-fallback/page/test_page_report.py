# SPDX-License-Identifier: GPL-2.0-or-later
"""The report and the answer in the page: one run makes both, each link leads somewhere, and nothing is too large."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from test_page_browser import FIREFOX, capture_of, choose, idle, show_only

from chromium import Chromium

pytestmark = [pytest.mark.thorough, pytest.mark.timeout(900)]

FRAMED = "document.querySelector('.report-frame').contentDocument"
READY = f"{FRAMED}?.querySelector('code[role=link]')"
LINKS = f"[...{FRAMED}.querySelectorAll('a')].map((one) => one.href.baseVal ?? one.href)"
JUDGED = "/OK/.test(document.querySelector('.answer-bar').textContent)"
FILTERED = "/ of .* packets/.test(document.querySelector('#filter-said').textContent)"


@pytest.fixture(scope="module")
def day(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Play twenty seconds of the demo: its report has episodes and curves."""
    return capture_of(620, tmp_path_factory.mktemp("day"))


def kinds(links: list[str]) -> dict[str, str]:
    """Return a link of each kind, such as #episode of #episode0."""
    return {re.sub(r"\d+$", "", link.partition("#")[2]): link for link in links}


def test_each_link_of_a_report_works(chromium: Chromium, day: Path) -> None:
    """Links of its text, its pictures and its tables lead to their rows; a filter leads to its packets."""
    choose(chromium, day)
    chromium.until(JUDGED)
    show_only(chromium, "report")
    chromium.until(READY)
    found = kinds(chromium.run(LINKS))
    assert set(found) == {"episode", "parameter", "curves"}
    for link in found.values():
        one = f"[...{FRAMED}.querySelectorAll('a')].find((one) => (one.href.baseVal ?? one.href) === {link!r})"
        chromium.run(f"{one}.dispatchEvent(new MouseEvent('click', {{bubbles: true, cancelable: true, view: window}}))")
        chromium.until(f"{FRAMED}?.URL === {link!r}")
        assert chromium.run(f"{FRAMED}.querySelector(':target').id") == link.partition("#")[2]
    assert chromium.run("location.hash") == "#report"
    said = chromium.run(f"{READY}.textContent")
    chromium.run(f"{READY}.click()")
    chromium.until(FILTERED)
    assert chromium.run("document.querySelector('#filter').value") == said


@pytest.mark.skipif(FIREFOX is None, reason="needs Firefox (Debian: firefox-esr)")
def test_in_firefox_too(page: Path, node: Callable[..., Any], day: Path) -> None:
    link = f"{FRAMED}.querySelector('a')"
    steps = (
        JUDGED,
        "(location.hash = '#report')",
        f"{READY} && ({link}.click(), 'clicked')",
        f"{FRAMED}.querySelector(':target')?.id",
        f"{READY}.click() ?? 'clicked'",
        FILTERED,
    )
    found = node("report.mjs", str(FIREFOX), page, day, *steps)
    assert found["values"] == [True, "#report", "clicked", "episode0", "clicked", True]
    assert found["complaints"] == []


def test_a_link_of_the_answer_shows_what_it_says(chromium: Chromium, day: Path) -> None:
    """As many packets as it names, a parameter's accesses, and the telegram that wrote it."""
    choose(chromium, day)
    chromium.until(JUDGED)
    for table in ("Episodes", "Parameters"):
        show_only(chromium, "answer")
        link = f"document.querySelector('[aria-label={table}] td button')"
        words = chromium.run(f"{link}.textContent")
        chromium.run(f"{link}.click()")
        chromium.until(FILTERED)
        idle(chromium)
        said = chromium.run("document.querySelector('#filter-said').textContent")
        count = re.match(r"\d+", words)
        if count:
            assert said.startswith(f"{count[0]} of ")
        else:
            assert words in chromium.run("document.querySelector('.packet-list .rows').textContent")


def test_the_report_is_there_once_the_answer_is(chromium: Chromium, day: Path) -> None:
    """One run makes both, so nothing is busy any more."""
    choose(chromium, day)
    chromium.until(JUDGED)
    chromium.run("""{
      globalThis.waits = 0;
      new MutationObserver(() => waits++).observe(document.querySelector('#busy'), {childList: true});
    }""")
    show_only(chromium, "report")
    chromium.until(READY)
    assert chromium.run("waits") == 0


def test_what_lua_leaves_does_not_fill_the_memory(node: Callable[..., Any], tmp_path: Path) -> None:
    """WebAssembly has 2 GB. 20,000 rows and three filters took 480 MB and more, and all of that again the next time."""
    assert node("memory.mjs", capture_of(20_000, tmp_path))["memory"] < 350e6
