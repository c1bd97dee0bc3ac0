# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap report`: the command line of the report."""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from sistap.report import plain, windows
from sistap.report.gather import Report, gather
from sistap.report.windows import Window
from sistap.sis.limits import argument as limit
from sistap.terminal.advice import no_matplotlib
from sistap.terminal.console import Console
from sistap.terminal.exits import DONE, FAILED, USAGE, UsageError
from sistap.terminal.stop import held
from sistap.terminal.streams import STANDARD_OUTPUT
from sistap.terminal.writing import Incomplete, NotOpened, opened
from sistap.wireshark.rows import NotACapture
from sistap.wireshark.tshark import Tshark, TsharkError

DESCRIPTION = """\
Put a whole capture on one page. It shows what was captured and how exact its times are, the limits of the bus and who
exceeded them, the ten worst moments with the display filters that find them in Wireshark, the bus in pictures, and
tables of stations and services. All figures come from Wireshark's dissector: install tshark with the plugin or sis.lua.
"""

EPILOG = """\
The seconds of a window are those of Wireshark's column Time: since the first packet. Windows around the three worst
moments are always there.

examples:
  sistap report day.pcapng                                the page report.html in this folder
  sistap report day.pcapng -o day.html --window 40.2+0.5  half a second in full detail, from 40.2 s on
  sistap report day.pcapng -o day.png                     the pictures alone
  sistap report day.pcapng --format text                  the tables alone, on standard output

exit status:
  0  done; also if the end of the capture is missing: the page says so
  1  failed while running: tshark, the plugin or matplotlib is missing, disk full
  2  wrong usage, a CAPTURE that cannot be read or a FILE that cannot be written
"""


class Format(NamedTuple):
    """A way to write a report."""

    write: Callable[[Report, str, str], bytes]  # report, title, note
    is_file: bool = True  # without -o: a file in this folder, else standard output
    has_plots: bool = True


def _page(report: Report, title: str, note: str) -> bytes:
    # Imported late, as below: it needs matplotlib, whose C code makes an ImportError of whatever comes meanwhile.
    with held():
        from sistap.report.page import page

    return page(report, title, note).encode()


def _picture(kind: str) -> Callable[[Report, str, str], bytes]:
    def draw(report: Report, title: str, note: str) -> bytes:
        with held():
            from sistap.report.plots import picture

        return picture(report, kind)

    return draw


FORMATS = {
    "html": Format(_page),
    "png": Format(_picture("png")),
    "svg": Format(_picture("svg")),
    "json": Format(lambda report, title, note: plain.as_json(report).encode(), is_file=False, has_plots=False),
    "text": Format(
        lambda report, title, note: plain.as_text(report, title, note).encode(), is_file=False, has_plots=False
    ),
}
_ENDINGS = {"htm": "html", "txt": "text"} | {name: name for name in FORMATS}


class _NoMatplotlib(Exception):
    """It is not installed; the text is the one line to show."""


def _window(text: str) -> Window:
    try:
        return windows.parse(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.add_argument(
        "capture", metavar="CAPTURE", type=Path, help="a capture of sistap, or any other with SIS in it"
    )
    parser.add_argument(
        "-o",
        dest="output",
        metavar="FILE",
        help="write to FILE; - is standard output (default: report.html, .png or .svg; text and json: -)",
    )
    parser.add_argument(
        "--format", choices=FORMATS, help="what to write (default: what the ending of FILE says, else html)"
    )
    parser.add_argument(
        "--tza",
        metavar="MS",
        type=limit,
        help="use this limit TzA in place of the one set on the bus: longest interval between two characters",
    )
    parser.add_argument(
        "--trs",
        metavar="MS",
        type=limit,
        help="use this limit TrS in place of the one set on the bus: longest reaction time",
    )
    parser.add_argument(
        "--title", default="", metavar="TEXT", help="the heading of the page, in place of the file name"
    )
    parser.add_argument(
        "--note", default="", metavar="TEXT", help="a note below the heading: machine, place, what was tried"
    )
    parser.add_argument(
        "--window",
        metavar="START+SECONDS",
        type=_window,
        action="append",
        default=[],
        help="show these seconds in full detail, from START on; can be given several times",
    )


def run(args: argparse.Namespace) -> int:
    """Write the report; return the exit code."""
    console = Console()
    try:
        name = _format(args)
        _check_files(args)
        if FORMATS[name].has_plots:
            _check_matplotlib()
        _write(args, name, _gather(args, console), console)
    except (UsageError, NotACapture, NotOpened) as error:
        console.say(str(error))
        return USAGE
    except (_NoMatplotlib, Incomplete, TsharkError) as error:
        console.say(str(error))
        return FAILED
    return DONE


def _format(args: argparse.Namespace) -> str:
    if args.format:
        return str(args.format)
    if args.output in (None, STANDARD_OUTPUT):
        return "html"
    ending = Path(args.output).suffix.lstrip(".").lower()
    if ending not in _ENDINGS:
        raise UsageError(f"'{args.output}' does not say what to write: end it in .html, or use --format")
    return _ENDINGS[ending]


def _check_files(args: argparse.Namespace) -> None:
    if args.capture.exists() and not args.capture.is_file():
        raise UsageError(f"{args.capture} is not a file: it is read twice, so save the capture first")
    try:
        args.capture.open("rb").close()
    except OSError as error:
        raise UsageError(f"cannot read {args.capture}: {error.strerror}; name a capture file") from None
    if args.output and Path(args.output).exists() and args.capture.samefile(args.output):
        raise UsageError(f"{args.output} is the capture itself; name another file with -o")


def _check_matplotlib() -> None:
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # without a home it warns of a slow start
    try:
        with held():
            import matplotlib  # noqa: F401, PLC0415
    except ImportError:
        raise _NoMatplotlib(f"{no_matplotlib()}; --format text and json do without") from None


def _gather(args: argparse.Namespace, console: Console) -> Report:
    progress = console.progress if console.shows_progress else _silent
    limits_ms = {name: value for name, value in (("tza", args.tza), ("trs", args.trs)) if value}
    with Tshark() as tshark:
        report = gather(tshark, args.capture, args.window, progress, limits_ms)
    if console.shows_progress:
        console.progress("")
    if report.warning:
        console.say(f"{args.capture}: the report is of what comes before the damage: {report.warning}")
    return report


def _silent(text: str) -> None:
    """Show no progress."""


def _write(args: argparse.Namespace, name: str, report: Report, console: Console) -> None:
    written = FORMATS[name].write(report, args.title, args.note)
    path = args.output or (f"report.{name}" if FORMATS[name].is_file else STANDARD_OUTPUT)
    if path == STANDARD_OUTPUT:
        sys.stdout.buffer.write(written)
        return
    with opened(path) as file:
        file.write(written)
    console.say(f"{path} written")
