# SPDX-License-Identifier: GPL-2.0-or-later
"""The search of the handbook, in a browser: what somebody types at a machine at night finds its place first."""

from collections.abc import Iterator
from urllib.parse import urlencode

import pytest

from chromium import Chromium, program
from make import HERE

pytestmark = pytest.mark.thorough

HANDBOOK = HERE.parent / "build" / "docs"
FIRST = "document.querySelector('ul.search li a')"


@pytest.fixture(scope="module")
def browser() -> Iterator[Chromium]:
    if program() is None or not HANDBOOK.is_dir():
        pytest.skip("needs chromium (Debian: chromium), and ./bootstrap docs")
    with Chromium() as browser:
        yield browser


@pytest.mark.parametrize(
    ("words", "place"),
    [
        ("pinout 9-pin", "capture/docs/wiring.html#pinout-9-pin-and-15-pin-plug"),
        ("Pause in a telegram longer than TzA", "plugin/REFERENCE.html#interval-in-a-telegram-longer-than-tza"),
        ("only other characters", "capture/docs/troubleshooting.html#only-errors-or-only-other-characters"),
        ("drive does not answer", "capture/docs/troubleshooting.html"),
        ("permission denied", "capture/docs/troubleshooting.html"),
        ("TrS exceeded", "plugin/REFERENCE.html#trs-exceeded"),
        ("docklight log", "capture/docs/logs.html"),
        ("termination resistor", "capture/docs/wiring.html"),
        ("wrong baud rate", "capture/docs/troubleshooting.html"),
    ],
)
def test_it_finds_the_place_first(browser: Chromium, words: str, place: str) -> None:
    browser.open(f"{(HANDBOOK / 'search.html').as_uri()}?{urlencode({'q': words})}")
    browser.until(f"{FIRST} || /did not match/.test(document.body.textContent)", 20)
    assert browser.run(f"{FIRST}?.href.split('#highlight')[0]") == f"{HANDBOOK.as_uri()}/{place}"
    assert browser.complaints == []
