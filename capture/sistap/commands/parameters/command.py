# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap parameters`: its options, and how it runs."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from sistap.commands.parameters import against, wide, writing
from sistap.commands.parameters.backup import LATIN_1, Drive, drives, is_station
from sistap.commands.parameters.reading import FoundAccess, found
from sistap.dissected.accesses.listing import MOST, Listing
from sistap.dissected.captures.joining import check_captures
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.common.writing import opened
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.exits import DONE, Refusal
from sistap.tap.terminal.writing import FORCE

DESCRIPTION = """\
List the parameters that were read and written. For each parameter of each device, the list has its name and unit. It
has the number of reads, writes and refusals, the first, last, lowest and highest value, and who wrote it last. Several
files, such as those of a ring, are read as one, in the order of their time. The figures come from Wireshark's
dissector: install tshark with the plugin or sis.lua. With a backup of a drive (a .par file of IndraWorks), this command
also makes the table "SIS parameters" of Wireshark, and compares a capture with the backup.
"""

EPILOG = f"""\
A read counts when its reaction comes. A write counts when its reaction accepts it. A refusal counts as an error. If the
attribute of a parameter is not known, its values are shown as bytes. If it was read later, they are decoded, too. A
column "Bytes" counts values that are still bytes: the lowest and highest may be among them. The value before a change
is the last value that was read or written. If there is none, it is unknown. A segment of a list is counted, but it is
not the value of the list. Stations with the same address at different ports are different stations. There is room for
{MOST} parameters.

With --from, the output is the file "sis_parameters" of a profile of Wireshark: names, units, attributes and limits of
all parameters, for the plugin and for sis.lua. Without --station, the rows are for every station. If the backup has
several drives, the address of each is its station, and --station chooses one. With --against, the last value of each
parameter in the capture is compared with the backup. Parameters that nobody can write are left out. Without --station,
a backup of one drive is compared with every station: the last line names them.

examples:
  sistap parameters day.pcapng                              the list
  sistap parameters --changes night-*.pcapng                who changed what and when, old and new value
  sistap parameters --csv day.pcapng -o parameters.csv      for a spreadsheet
  sistap parameters --csv --wide day.pcapng -o values.csv   all values, for curves
  sistap parameters --from drive.par -o ~/.config/wireshark/profiles/SIS/sis_parameters
                                                            names for Wireshark with the profile SIS
  sistap parameters day.pcapng --against drive.par          what differs from the backup, and who wrote it

exit status:
  0  done; a message on standard error says if the end of a capture is missing
  1  failed while running: tshark or the plugin is missing, disk full
  2  wrong usage, a CAPTURE or backup that cannot be read, nothing to compare, or a FILE that cannot be written
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("captures", metavar="CAPTURE", type=Path, nargs="*", help="a capture that contains SIS")
    parser.add_argument("--from", dest="backup", metavar="PAR", type=Path, help="make Wireshark's table from a backup")
    parser.add_argument("--against", metavar="PAR", type=Path, help="list what differs from a backup, instead")
    parser.add_argument("--station", metavar="N", help="the station of the backup, such as 3, behind routers 3/2/8")
    parser.add_argument("--changes", action="store_true", help="list every write that changed a value, instead")
    parser.add_argument("--csv", action="store_true", help="write comma-separated values; the first line has the names")
    parser.add_argument(
        "--wide", action="store_true", help="with --csv: all values, a line for each time, a column for each parameter"
    )
    parser.add_argument("-o", dest="output", metavar="FILE", help="write to FILE (default: standard output)")
    parser.add_argument("--force", action="store_true", help=FORCE)


def run(args: argparse.Namespace) -> int:
    """Write the list or the changes; return the exit code."""
    console = Console()
    _check(args, console)
    if args.backup:
        _write_table(args, console)
    else:
        _write_accesses(args, console)
    return DONE


def _write_table(args: argparse.Namespace, console: Console) -> None:
    unreadable: list[str] = []
    saved = _stations(args, drives(args.backup, unreadable.append), console)
    with opened(args.output, [args.backup], force=args.force) as file:
        file.writelines(f"{line}\n".encode() for station, drive in saved for line in writing.user_table(drive, station))
    if unreadable:
        more = f", and so are {len(unreadable) - 1} more values" if len(unreadable) > 1 else ""
        console.say(f"{unreadable[0]}{more}; the table is complete, because it needs no values")


def _write_accesses(args: argparse.Namespace, console: Console) -> None:
    saved = _stations(args, drives(args.against), console) if args.against else []
    with Tshark() as tshark, opened(args.output, args.captures, force=args.force) as file:
        came = found(tshark, args.captures, console.say)
        if args.against:
            lines: Iterable[str] = against.lines(saved, came)
        else:
            lines = wide.lines(came) if args.wide else _lines(args, came, console)
        file.writelines(f"{line}\n".encode() for line in lines)


def _stations(args: argparse.Namespace, found_drives: Sequence[Drive], console: Console) -> Sequence[tuple[str, Drive]]:
    """Return the drives of a backup with their stations; "" is every station. Raise Refusal."""
    if found_drives[0].encoding != LATIN_1:
        console.say(f"{args.backup or args.against}: its units and texts are read as {found_drives[0].encoding}")
    if len(found_drives) == 1:
        return [(args.station or "", found_drives[0])]
    several = [(drive.address, drive) for drive in found_drives if args.station in (None, drive.address)]
    if not several:
        addresses = ", ".join(drive.address for drive in found_drives)
        raise Refusal(f"{args.backup or args.against} has no drive {args.station}: --station is one of {addresses}")
    return several


def _check_usage(args: argparse.Namespace) -> None:
    if args.wide and (args.changes or not args.csv):
        raise Refusal("--wide belongs to --csv, without --changes")
    if args.backup and (args.captures or args.against or args.changes or args.csv):
        raise Refusal("--from makes a table from a backup: leave out captures and other options")
    if not args.backup and not args.captures:
        raise Refusal("name a capture, or a backup with --from")
    if args.against and (args.changes or args.csv):
        raise Refusal("--against has an output of its own: leave out --changes and --csv")
    if args.station is not None and not (args.backup or args.against):
        raise Refusal("--station belongs to --from or --against")
    if args.station is not None and not is_station(args.station):
        raise Refusal("--station is an address from 0 to 255, behind routers such as 3/2/8")


def _check(args: argparse.Namespace, console: Console) -> None:
    _check_usage(args)
    args.captures = check_captures(args.captures, console.say, args.output)


def _lines(args: argparse.Namespace, accesses: Iterable[FoundAccess], console: Console) -> Iterator[str]:
    listing = Listing()
    several_files = len(args.captures) > 1
    if args.changes and args.csv:
        yield writing.csv_line(writing.CSV_CHANGES)
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
