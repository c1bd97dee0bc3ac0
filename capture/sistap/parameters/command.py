# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap parameters`: the command line of the list of parameters."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from pathlib import Path

from sistap.accesses.listing import MOST, Listing
from sistap.parameters import writing
from sistap.parameters.reading import Found, found
from sistap.terminal.console import Console
from sistap.terminal.exits import DONE, FAILED, USAGE
from sistap.terminal.writing import Incomplete, NotOpened, opened
from sistap.wireshark.rows import NotACapture
from sistap.wireshark.tshark import Tshark, TsharkError

DESCRIPTION = """\
List the parameters that were read and written: of each device its name, unit, how often it was read, written and
refused, its first, last, least and greatest value, and who has written it last. Several captures, such as the files of
a ring, are read in the order in which they are named. Wireshark's dissector says all this, through tshark, which has
to be installed with the plugin or sis.lua.
"""

EPILOG = f"""\
A reading counts with its reaction, a writing when its reaction accepts it; what is refused counts as an error. Values
of parameters whose attribute is not known are bytes. The value before a change is the last one that was read or
written, else it is unknown. A segment of a list is counted, but it is not the value of the list. Stations are told
apart by the name of their port. There is room for {MOST} parameters.

examples:
  sistap parameters day.pcapng                              the list
  sistap parameters --changes night-*.pcapng                who has changed what, when, from and to
  sistap parameters --csv day.pcapng -o parameters.csv      for a spreadsheet

exit status:
  0  done; also of a capture that is cut, which is said on standard error
  1  failed while running: tshark or the plugin is missing, disk full
  2  wrong usage, a CAPTURE that cannot be read, a FILE that cannot be written
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.add_argument("captures", metavar="CAPTURE", type=Path, nargs="+", help="a capture with SIS in it")
    parser.add_argument(
        "--changes", action="store_true", help="every writing that has changed something, in place of the list"
    )
    parser.add_argument("--csv", action="store_true", help="comma-separated values, with a line of names before them")
    parser.add_argument("-o", dest="output", metavar="FILE", help="write to FILE (default: standard output)")


def run(args: argparse.Namespace) -> int:
    """Write the list or the changes; return the exit code."""
    console = Console()
    try:
        _check(args)
        with Tshark() as tshark, opened(args.output) as file:
            for line in _lines(args, found(tshark, args.captures, console.say), console):
                file.write(f"{line}\n".encode())
    except (NotACapture, NotOpened) as error:
        console.say(str(error))
        return USAGE
    except (Incomplete, TsharkError) as error:
        console.say(str(error))
        return FAILED
    return DONE


def _check(args: argparse.Namespace) -> None:
    for capture in args.captures:
        if capture.exists() and not capture.is_file():
            raise NotACapture(f"{capture} is not a file: save the capture first")
        try:
            capture.open("rb").close()
        except OSError as error:
            raise NotACapture(f"cannot read {capture}: {error.strerror}; name a capture file") from None
        if args.output and Path(args.output).exists() and capture.samefile(args.output):
            raise NotOpened(f"{args.output} is the capture itself; name another file with -o")


def _lines(args: argparse.Namespace, accesses: Iterable[Found], console: Console) -> Iterator[str]:
    listing = Listing()
    several_files = len(args.captures) > 1
    if args.changes and args.csv:
        yield writing.csv_head_of_changes()
    for place, access in accesses:
        change = listing.add(place, access)
        if change and args.changes:
            yield (
                writing.change_as_csv(change)
                if args.csv
                else writing.change_as_text(change, several_files=several_files)
            )
    if not args.changes:
        yield from (
            writing.list_as_csv(listing) if args.csv else writing.list_as_text(listing, several_files=several_files)
        )
    if listing.left_out:
        console.say(f"more than {MOST} parameters: {listing.left_out} accesses to others are not in the list")
    elif not len(listing):
        console.say("no parameter was read or written")
