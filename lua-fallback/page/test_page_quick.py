# SPDX-License-Identifier: GPL-2.0-or-later
"""The way that most people go through the page, in every run of the tests: open, filter, report, click."""

from __future__ import annotations

from test_page_browser import CAPTURE, choose, show_only
from test_page_report import FILTERED, FRAMED, JUDGED, READY

from chromium import Chromium


def test_open_filter_report_click(chromium: Chromium) -> None:
    choose(chromium, CAPTURE)
    chromium.until(JUDGED)
    chromium.run("document.querySelector('#filter').focus()")
    chromium.type("sis.service == 0x10")
    chromium.press("Enter", 13, "\r")
    chromium.until(FILTERED)
    show_only(chromium, "report")
    chromium.until(READY)
    link = f"{FRAMED}.querySelector('a')"
    chromium.run(f"{link}.click()")
    chromium.until(f"{FRAMED}?.querySelector(':target')")
    said = chromium.run(f"{READY}.textContent")
    chromium.run(f"{READY}.click()")
    chromium.until(f"document.querySelector('#filter').value === {said!r} && {FILTERED}")
    chromium.run("document.querySelector('.rows .row').click()")
    chromium.until("document.querySelector('.tree').textContent.includes('Checksum')")
