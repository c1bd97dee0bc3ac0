# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap help`: opens the handbook."""

from __future__ import annotations

import argparse
from pathlib import Path

from sistap.terminal.console import Console
from sistap.terminal.exits import DONE, FAILED
from sistap.web.command import PLACES, show

FIRST = Path("docs/index.html")  # beside the page for a browser

DESCRIPTION = """\
Open the handbook in a browser: how to wire a tap, what to do when something is wrong, every command, every warning and
every field. It needs no network. The address is printed, too.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments: there are none."""
    parser.description = DESCRIPTION


def run(_: argparse.Namespace) -> int:
    """Open the handbook; return the exit code."""
    pages = [place.parent / FIRST for place in PLACES]
    page = next(filter(Path.is_file, pages), None)
    if page is None:
        Console().say(f"{FIRST.as_posix()} is not here: `./bootstrap docs` in the sources of sistap makes it")
        return FAILED
    print(page.as_uri(), flush=True)
    show(page.as_uri())
    return DONE
