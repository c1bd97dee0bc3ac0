# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap web`: opens the page for a browser."""

from __future__ import annotations

import argparse
import os
import sys
import webbrowser

from sistap.tap.common import pages
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.exits import DONE, FAILED

DESCRIPTION = """\
Open the page: Wireshark with the dissector, sistap and the course in one file for a browser. The browser opens the
file itself, and sistap ends. The address is printed, too.
"""


def run(_: argparse.Namespace) -> int:
    """Open the page; return the exit code."""
    return show(pages.PAGE, "page")


def show(name: str, made_by: str) -> int:
    """Open a page in a browser, where there is a screen for it. Whoever has none sees the address."""
    page = pages.found(name)
    if page is None:
        Console().say(f"{name} is not here: `./bootstrap {made_by}` in the sources of sistap makes it")
        return FAILED
    print(page.as_uri(), flush=True)
    if sys.platform in ("win32", "darwin") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        webbrowser.open(page.as_uri())
    return DONE
