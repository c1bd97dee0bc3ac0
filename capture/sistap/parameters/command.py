# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap parameters`: its options, and how it runs."""

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
List the parameters that were read and written. For each parameter of each device, the list has its name and unit. It
has the number of reads, writes and refusals, the first, last, lowest and highest value, and who wrote it last. Name the
files of a ring in the order of their time. The figures come from Wireshark's dissector: install tshark with the plugin
or sis.lua.
"""

EPILOG = f"""\
A read counts when its reaction comes. A write counts when its reaction accepts it. A refusal counts as an error. If the
attribute of a parameter is not known, its values are shown as bytes. The value before a change is the last value that
was read or written. If there is none, it is unknown. A segment of a list is counted, but it is not the value of the
list. Stations with the same address at different ports are different stations. There is room for {MOST} parameters.

examples:
  sistap parameters day.pcapng                              the list
  sistap parameters --changes night-*.pcapng                who changed what and when, old and new value
  sistap parameters --csv day.pcapng -o parameters.csv      for a spreadsheet

exit status:
  0  done; a message on standard error says if the end of a capture is missing
  1  failed while running: tshark or the plugin is missing, disk full
  2  wrong usage, a CAPTURE that cannot be read, or a FILE that cannot be written
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.add_argument("captures", metavar="CAPTURE", type=Path, nargs="+", help="a capture that contains SIS")
    parser.add_argument("--changes", action="store_true", help="list every write that changed a value, instead")
    parser.add_argument("--csv", action="store_true", help="write comma-separated values; the first line has the names")
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
