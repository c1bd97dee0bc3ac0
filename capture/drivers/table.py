# SPDX-License-Identifier: GPL-2.0-or-later
"""The table of drivers in README.md."""

from __future__ import annotations

import textwrap
from pathlib import Path

GOOD, NOT_JUDGED, FAILED = "good", "-", "FAILED"
BEGIN, END = "<!-- drivers: written by drivers/check -->", "<!-- drivers: end -->"


def write(file: Path, results: dict[str, dict[str, str]], pulled: str) -> None:
    """Put the results between the two marks."""
    text = file.read_text()
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"{file} lacks {BEGIN} or {END}")
    power = textwrap.fill(f"The plug was pulled ten times: {pulled}", 100)
    new = "\n".join([before + BEGIN, *rows(results), "", power, END]) + after
    if new != text:
        file.write_text(new)


def rows(results: dict[str, dict[str, str]]) -> list[str]:
    """Return the lines of the table, with a column for each driver."""
    names = list(results)
    judged = list(results[names[0]])
    lines = [["judged", *names], ["---"] * (len(names) + 1)]
    lines += [[what, *(results[name][what] for name in names)] for what in judged]
    return [f"| {' | '.join(line)} |" for line in lines]
