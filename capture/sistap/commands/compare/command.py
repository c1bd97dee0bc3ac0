# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap compare`: its options, and how it runs."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from sistap.commands.compare import plain
from sistap.commands.compare.differences import Comparison, compare
from sistap.commands.compare.page import page
from sistap.commands.compare.side import read
from sistap.dissected.captures.joining import check_captures
from sistap.dissected.captures.twice import twice
from sistap.dissected.episodes.engine import Engine
from sistap.dissected.episodes.options import add_rule
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.common.writing import opened
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.exits import DONE, Refusal
from sistap.tap.terminal.writing import FORCE

DESCRIPTION = """\
Show what changed between a good time and a bad one. First comes what happened in the bad time alone, with times and
stations: silences, drives, masters never seen before and what they wrote, phases, rates, limits, faults of the bus.
Then come reaction times and intervals that differ, and tables of everything. Whatever may be chance says so. All
figures come from Wireshark's dissector: install tshark with the plugin or sis.lua.
"""

EPILOG = """\
A side may have several files, such as those of a ring. Name them with --good and --bad.

What happened is found as in `sistap report`. The good capture tells what is usual: who asks, what is written, phases,
limits, levels of values.

Chance: a difference counts if it is 3.5 times as large as its scatter. For times, that is the scatter of pieces of
each capture, because neighbouring telegrams are alike. Counts scatter by the square root of their number. This is a
rule of thumb: of a thousand comparisons of equal captures, it finds a few.

examples:
  sistap compare evening.pcapng night.pcapng                     good first, then bad
  sistap compare --good monday-*.pcapng --bad friday-*.pcapng    several files on each side
  sistap compare evening.pcapng night.pcapng --format html -o changed.html

exit status:
  0  done, whatever changed; a message on standard error says if the end of a capture is missing
  1  failed while running: tshark or the plugin is missing, disk full
  2  wrong usage, a capture that cannot be read, or a FILE that cannot be written
"""

FORMATS: dict[str, Callable[[Comparison], str]] = {"text": plain.as_text, "html": page, "json": plain.as_json}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("captures", metavar="GOOD BAD", type=Path, nargs="*", help="one capture for each side")
    for side, time in (("good", "all was well"), ("bad", "it was not")):
        parser.add_argument(
            f"--{side}", metavar="CAPTURE", type=Path, nargs="+", help=f"captures of the time when {time}"
        )
    parser.add_argument("--format", choices=FORMATS, default="text", help="what to write (default: text)")
    add_rule(parser)
    parser.add_argument("-o", dest="output", metavar="FILE", help="write to FILE (default: standard output)")
    parser.add_argument("--force", action="store_true", help=FORCE)


def run(args: argparse.Namespace) -> int:
    """Write the comparison; return the exit code."""
    console = Console()
    good, bad = (check_captures(side, console.say, args.output) for side in _sides(args))
    with Tshark() as tshark, opened(args.output, [*good, *bad], force=args.force) as file:
        if reason := twice([*good, *bad]):
            console.say(f"{reason}: what is on both sides cannot differ")
        before = read(tshark, good, console.say, console.progress, Engine(thresholds=args.thresholds))
        engine = Engine(before.engine, args.thresholds)
        comparison = compare(before, read(tshark, bad, console.say, console.progress, engine))
        console.progress("")
        file.write(FORMATS[args.format](comparison).encode())
    return DONE


def _sides(args: argparse.Namespace) -> tuple[list[Path], list[Path]]:
    if len(args.captures) == 2 and not args.good and not args.bad:
        sides = args.captures[:1], args.captures[1:]
    elif args.good and args.bad and not args.captures:
        sides = args.good, args.bad
    else:
        raise Refusal("name two captures, good and bad; for several files of a side use --good and --bad")
    return sides
