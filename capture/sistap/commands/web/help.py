# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap help`: opens the handbook."""

from __future__ import annotations

import argparse

from sistap.commands.web.command import show
from sistap.tap.common import pages

DESCRIPTION = """\
Open the handbook in a browser: how to wire a tap, what to do when something is wrong, every command, every warning and
every field. It needs no network. The address is printed, too.
"""


def run(_: argparse.Namespace) -> int:
    """Open the handbook; return the exit code."""
    return show(pages.HANDBOOK, "docs")
