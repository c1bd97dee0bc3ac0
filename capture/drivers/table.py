# SPDX-License-Identifier: GPL-2.0-or-later
"""The table of drivers in README.md."""

from __future__ import annotations

import textwrap
from pathlib import Path

from truth import Figures

GOOD, NOT_JUDGED, FAILED = "good", "-", "FAILED"
BEGIN, END = "<!-- drivers: written by drivers/check -->", "<!-- drivers: end -->"


_SAID = "What was captured of the damaged characters among data, and of the losses:"
_HEAD = (
    *("driver", "errors", "exact / somewhere / missing", "innocents", "good ones in doubt", "false breaks"),
    *("losses told of sent", "made 00 by Linux"),
)


def write(file: Path, results: dict[str, dict[str, str]], figures: dict[str, Figures], pulled: str) -> None:
    """Put the results between the two marks."""
    text = file.read_text()
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"{file} lacks {BEGIN} or {END}")
    power = textwrap.fill(f"The plug was pulled ten times: {pulled}", 100)
    said = [_SAID, "", *rows_of_errors(figures)]
    new = "\n".join([before + BEGIN, *rows(results), "", *said, "", power, END]) + after
    if new != text:
        file.write_text(new)


def rows(results: dict[str, dict[str, str]]) -> list[str]:
    """Return the lines of the table, with a column for each driver."""
    names = list(results)
    judged = list(results[names[0]])
    lines = [["judged", *names], ["---"] * (len(names) + 1)]
    lines += [[what, *(results[name][what] for name in names)] for what in judged]
    return [f"| {' | '.join(line)} |" for line in lines]


def rows_of_errors(figures: dict[str, Figures]) -> list[str]:
    """Return the lines of the table of errors, with a row for each driver."""
    lines: list[tuple[object, ...]] = [_HEAD, ("---",) * len(_HEAD)]
    for name, one in figures.items():
        places = f"{one.exact} / {one.somewhere} / {one.missing}"
        losses = f"{one.told} of {one.losses}"
        lines.append((name, one.errors, places, one.innocents, one.doubted, one.false_breaks, losses, one.made_00))
    return [f"| {' | '.join(map(str, line))} |" for line in lines]
