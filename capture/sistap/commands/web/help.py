# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap help`: opens the handbook."""

from __future__ import annotations

import argparse

from sistap.commands.web.command import show
from sistap.tap.common import pages
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.exits import DONE, FAILED

DESCRIPTION = """\
Open the handbook in a browser: how to wire a tap, what to do when something is wrong, every command, every warning and
every field. It needs no network. The address is printed, too.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments: there are none."""
    parser.description = DESCRIPTION


def run(_: argparse.Namespace) -> int:
    """Open the handbook; return the exit code."""
    page = pages.found(pages.HANDBOOK)
    if page is None:
        Console().say(f"{pages.HANDBOOK} is not here: `./bootstrap docs` in the sources of sistap makes it")
        return FAILED
    print(page.as_uri(), flush=True)
    show(page.as_uri())
    return DONE
