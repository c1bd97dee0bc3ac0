# SPDX-License-Identifier: GPL-2.0-or-later
"""What `sistap report` says of a capture, its page and its figures, of one reading: that takes longest."""

from __future__ import annotations

import argparse
from pathlib import Path

from sistap.commands.report import command, running
from sistap.tap.terminal.console import Console


def judge(words: list[str], page: str, figures: str) -> None:
    """Write a report as HTML and as JSON; `words` are those of the command. May raise Refusal and TsharkError."""
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    args, console = parser.parse_args(words), Console()
    report = running.gathered(args, console, running.checked(args, console), has_windows=True)
    for file, name in ((page, "html"), (figures, "json")):
        Path(file).write_bytes(running.FORMATS[name].write(report, "", ""))
