# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap report`: the command line of the report."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

from sistap.commands.report import plain, windows
from sistap.commands.report.gather import Report, gather, learned
from sistap.commands.report.page import page
from sistap.commands.report.plots import drawings
from sistap.dissected.captures import portions, since
from sistap.dissected.captures.joining import check_captures, in_order
from sistap.dissected.draw.svg import stacked
from sistap.dissected.episodes.engine import Engine
from sistap.dissected.episodes.options import add_rule
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.common.writing import opened
from sistap.tap.sis.limits import milliseconds
from sistap.tap.terminal.console import STANDARD_OUTPUT, Console, visible
from sistap.tap.terminal.exits import DONE, Refusal, argument
from sistap.tap.terminal.writing import FORCE

DESCRIPTION = """\
Put a whole capture on one page. Five lines say what happened: when, and at which station. Then come a timeline with the
display filters that find it in Wireshark, what was captured and how exact its times are, the limits of the bus and who
exceeded them, the bus in pictures, and tables of stations and services. All figures come from Wireshark's dissector:
install tshark with the plugin or sis.lua.
"""

EPILOG = """\
The seconds of a window are those of Wireshark's column Time: since the first packet. There are always windows around
the three worst telegrams.

examples:
  sistap report day.pcapng                                the page report.html in this folder
  sistap report day.pcapng -o day.html --window 40.2+0.5  half a second in full detail, from 40.2 s on
  sistap report ring/*.pcapng -o night.html               the files of a ring, as one capture
  sistap report today.pcapng --baseline good.pcapng       beside a good day
  sistap report --since 22:00 --format text FOLDER        last night from a recorder's folder, as a mail for cron
  sistap report day.pcapng -o day.svg                     the pictures alone
  sistap report day.pcapng --format text                  the tables alone, on standard output

exit status:
  0  done; also if the end of a capture, or one in a folder, cannot be read: the page says so
  1  failed while running: tshark or the plugin is missing; disk full
  2  wrong usage, a CAPTURE that cannot be read or a FILE that cannot be written
"""


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


def _heading(text: str) -> str:
    """Return a text that a page can show, whatever the shell has passed on."""
    return visible(text, keep="\n")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.add_argument(
        "captures",
        metavar="CAPTURE",
        type=Path,
        nargs="+",
        help="a capture of sistap, any other with SIS in it, or a folder of them; several, as of a ring, are one",
    )
    parser.add_argument(
        "-o",
        dest="output",
        metavar="FILE",
        help="write to FILE; - is standard output (default: report.html or .svg; text and json: -)",
    )
    parser.add_argument("--force", action="store_true", help=FORCE)
    parser.add_argument(
        "--format", choices=FORMATS, help="what to write (default: what the ending of FILE says, else html)"
    )
    parser.add_argument(
        "--tza",
        metavar="MS",
        type=argument(milliseconds),
        help="use this limit TzA in place of the one set on the bus: longest interval between two characters",
    )
    parser.add_argument(
        "--trs",
        metavar="MS",
        type=argument(milliseconds),
        help="use this limit TrS in place of the one set on the bus: longest reaction time",
    )
    parser.add_argument(
        "--since",
        metavar="TIME",
        type=argument(since.parse),
        help="tell what happened from TIME on: 06:00, a date, or so long before the end of the last CAPTURE: 30m, 8h, "
        "2d; what came before only says what is usual",
    )
    parser.add_argument(
        "--baseline",
        metavar="CAPTURE",
        type=Path,
        action="append",
        default=[],
        help="a capture of a good day: its masters, writes, refusals, values and drifts are usual; can be given "
        "several times",
    )
    add_rule(parser)
    parser.add_argument(
        "--title",
        default="",
        metavar="TEXT",
        type=_heading,
        help="the heading of the page, in place of the file name",
    )
    parser.add_argument(
        "--note",
        default="",
        metavar="TEXT",
        type=_heading,
        help="a note below the heading: machine, place, what was tried",
    )
    parser.add_argument(
        "--window",
        metavar="START+SECONDS",
        type=argument(windows.parse),
        action="append",
        default=[],
        help="show these seconds in full detail, from START on; can be given several times",
    )


def run(args: argparse.Namespace) -> int:
    """Write the report; return the exit code."""
    console = Console()
    name = _format(args)
    left_out = _Noting(console)
    args.captures = check_captures(args.captures, left_out, args.output)
    args.baseline = check_captures(args.baseline, left_out, args.output) if args.baseline else []
    _write(args, name, console, left_out)
    return DONE


def _format(args: argparse.Namespace) -> str:
    if args.format:
        return str(args.format)
    if args.output in (None, STANDARD_OUTPUT):
        return "html"
    ending = Path(args.output).suffix.lstrip(".").lower()
    if ending not in _ENDINGS:
        raise Refusal(f"'{args.output}' does not say what to write: end it in .html, or use --format")
    return _ENDINGS[ending]


class _Noting:
    """Says what the report does not have, and notes it: the report says it, too."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self.noted: list[str] = []

    def __call__(self, text: str) -> None:
        self._console.say(text)
        self.noted.append(visible(text))


def _gather(args: argparse.Namespace, console: Console, left_out: _Noting, *, has_windows: bool) -> Report:
    limits_ms = {name: value for name, value in (("tza", args.tza), ("trs", args.trs)) if value}
    captures, since_s = in_order(args.captures), -math.inf
    if args.since:
        captures, since_s = since.recent(captures, args.since)
    several = f"{len(captures)} files, {captures[0].name} to {captures[-1].name}"
    name = several if len(captures) > 1 else captures[0].name
    console.progress(f"reading {name}")
    with Tshark() as tshark, closing(portions.in_turn(captures, portions.TOGETHER, left_out)) as files:
        before = _before(args, tshark, left_out)
        known = limits_ms, since_s, args.thresholds, before
        report = gather(tshark, files, args.window, console.progress, *known, has_windows=has_windows)
    report.name, report.files, report.left_out = visible(name), len(captures), left_out.noted
    console.progress("")
    if report.warning:
        console.say(f"{captures[0]}: the report is of what comes before the damage: {report.warning}")
    return report


def _before(args: argparse.Namespace, tshark: Tshark, left_out: _Noting) -> Engine | None:
    """Return what knows the good captures, if there are any."""
    if not args.baseline:
        return None
    with closing(portions.in_turn(in_order(args.baseline), portions.TOGETHER, left_out)) as files:
        return learned(tshark, files, args.thresholds)


def _write(args: argparse.Namespace, name: str, console: Console, left_out: _Noting) -> None:
    """Open the file before the work, which may take minutes."""
    path = args.output or (f"report.{name}" if FORMATS[name].is_file else STANDARD_OUTPUT)
    with opened(path, args.captures, force=args.force) as file:
        report = _gather(args, console, left_out, has_windows=FORMATS[name].has_windows)
        file.write(FORMATS[name].write(report, args.title, args.note))
    if path != STANDARD_OUTPUT:
        console.say(f"{path} written")
