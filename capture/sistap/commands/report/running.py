# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap report`, once its options are right: captures are read, and a report is written."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

from sistap.commands.report import plain
from sistap.commands.report.gather import Report, gather, learned
from sistap.commands.report.page import page
from sistap.commands.report.plots import drawings
from sistap.commands.report.windows import asked
from sistap.dissected.captures import portions, since
from sistap.dissected.captures.joining import check_captures, in_order
from sistap.dissected.captures.twice import twice
from sistap.dissected.draw.svg import stacked
from sistap.dissected.episodes.engine import Engine
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.common.writing import opened
from sistap.tap.terminal.console import STANDARD_OUTPUT, Console, visible
from sistap.tap.terminal.exits import DONE, Refusal


class OutputFormat(NamedTuple):
    """A way to write a report."""

    write: Callable[[Report, str, str], bytes]  # report, title, note
    is_file: bool = True  # without -o: a file in this folder, else standard output
    has_windows: bool = True


FORMATS = {
    "html": OutputFormat(lambda report, title, note: page(report, title, note).encode()),
    "svg": OutputFormat(lambda report, title, note: stacked(report.name, drawings(report)).encode()),
    "json": OutputFormat(lambda report, title, note: plain.as_json(report).encode(), is_file=False),
    "text": OutputFormat(
        lambda report, title, note: plain.as_text(report, title, note).encode(), is_file=False, has_windows=False
    ),
}
_ENDINGS = {"htm": "html", "txt": "text"} | {name: name for name in FORMATS}


def run(args: argparse.Namespace) -> int:
    """Write the report; return the exit code."""
    console = Console()
    name = _format(args)
    left_out = checked(args, console)
    _write(args, name, console, left_out)
    return DONE


def checked(args: argparse.Namespace, console: Console) -> Noting:
    """Find the captures that are named, and return what notes those that are left out. May raise Refusal."""
    left_out = Noting(console)
    args.captures = check_captures(args.captures, left_out, args.output)
    args.baseline = check_captures(args.baseline, left_out, args.output) if args.baseline else []
    if reason := twice([*args.captures, *args.baseline]):
        console.say(f"{reason}: all that is in it is taken for usual")
    return left_out


def _format(args: argparse.Namespace) -> str:
    if args.format:
        return str(args.format)
    if args.output in (None, STANDARD_OUTPUT):
        return "html"
    ending = Path(args.output).suffix.lstrip(".").lower()
    if ending not in _ENDINGS:
        raise Refusal(f"'{args.output}' does not say what to write: end it in .html, or use --format")
    return _ENDINGS[ending]


class Noting:
    """Says what the report does not have, and notes it: the report says it, too."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self.noted: list[str] = []

    def __call__(self, text: str) -> None:
        """Say it, and note it."""
        self._console.say(text)
        self.noted.append(visible(text))


def gathered(args: argparse.Namespace, console: Console, left_out: Noting, *, has_windows: bool) -> Report:
    """Read the captures that were checked. May raise Refusal and TsharkError."""
    limits_ms = {name: value for name, value in (("tza", args.tza), ("trs", args.trs)) if value}
    captures, since_s = in_order(args.captures), -math.inf
    if args.since:
        captures, since_s = since.recent(captures, args.since)
    several = f"{len(captures)} files, {captures[0].name} to {captures[-1].name}"
    name = several if len(captures) > 1 else captures[0].name
    console.progress(f"reading {name}")
    with Tshark() as tshark, closing(portions.in_turn(captures, portions.TOGETHER, left_out)) as files:
        before = _before(args, tshark, left_out)
        windows = [asked(*stretch) for stretch in args.window]
        known = limits_ms, since_s, args.thresholds, before
        report = gather(tshark, files, windows, console.progress, *known, has_windows=has_windows)
    report.name, report.files, report.left_out = visible(name), len(captures), left_out.noted
    console.progress("")
    if report.warning:
        console.say(f"{captures[0]}: the report is of what comes before the damage: {report.warning}")
    return report


def _before(args: argparse.Namespace, tshark: Tshark, left_out: Noting) -> Engine | None:
    """Return what knows the good captures, if there are any."""
    if not args.baseline:
        return None
    with closing(portions.in_turn(in_order(args.baseline), portions.TOGETHER, left_out)) as files:
        return learned(tshark, files, args.thresholds)


def _write(args: argparse.Namespace, name: str, console: Console, left_out: Noting) -> None:
    """Open the file before the work, which may take minutes."""
    path = args.output or (f"report.{name}" if FORMATS[name].is_file else STANDARD_OUTPUT)
    with opened(path, args.captures, force=args.force) as file:
        report = gathered(args, console, left_out, has_windows=FORMATS[name].has_windows)
        file.write(FORMATS[name].write(report, args.title, args.note))
    if path != STANDARD_OUTPUT:
        console.say(f"{path} written")
