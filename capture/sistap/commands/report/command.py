# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap report`: its options."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from sistap.dissected.captures import since
from sistap.dissected.episodes.options import add_rule
from sistap.tap.sis.limits import milliseconds
from sistap.tap.terminal.console import visible
from sistap.tap.terminal.exits import argument
from sistap.tap.terminal.writing import FORCE

RUN = "sistap.commands.report.running"

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


FORMATS = ("html", "svg", "json", "text")
_LATEST_S = 1e10  # more than 64 bits of ns can say, so no capture is as long


def stretch(text: str) -> tuple[float, float]:
    """Read START+SECONDS. ValueError says what is wrong."""
    start, _, length = text.partition("+")
    try:
        start_s, length_s = float(start), float(length)
    except ValueError:
        start_s = length_s = math.nan
    if not (0 <= start_s < _LATEST_S and 0 < length_s < _LATEST_S):
        raise ValueError(f"'{text}' is not START+SECONDS, for example 12.5+0.2")
    return start_s, length_s


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
        type=argument(stretch),
        action="append",
        default=[],
        help="show these seconds in full detail, from START on; can be given several times",
    )
