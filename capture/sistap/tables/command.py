# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap tables`: the command line."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from sistap.tables.rows import NoSuchTime
from sistap.terminal.console import Console
from sistap.terminal.exits import DONE, FAILED, USAGE, UsageError
from sistap.terminal.stop import held
from sistap.terminal.writing import Incomplete
from sistap.wireshark.rows import NotACapture
from sistap.wireshark.tshark import Tshark, TsharkError

DESCRIPTION = """\
Put captures into tables of Parquet files, for questions about many months and many machines: telegrams, values of
parameters, events. DuckDB, Spark, pandas and others read them. What is there already is not put there again, so it can
be run as often as you like: of captures that have grown, or that have the same telegrams, only what is new is added.
Wireshark's dissector says what is in the captures, through tshark, which has to be installed with the plugin or
sis.lua.
"""

EPILOG = """\
The tables are folders in FOLDER, with a folder for each tap and each day in them (UTC). A tap is named after its port,
which on many machines is the same: name it with --tap where tables of several machines come together.

examples:
  sistap tables day.pcapng -o tables
  sistap tables --tap press-4 ring/*.pcapng -o /srv/tables        once an hour, of a ring that goes on
  duckdb -c "SELECT sender, max(reaction_s) FROM 'tables/telegrams/*/*/*.parquet' GROUP BY sender"

exit status:
  0  done; also of a capture that is cut, which is said on standard error
  1  failed while running: tshark, the plugin or pyarrow is missing, disk full; captures before that are in the tables
  2  wrong usage, a CAPTURE that cannot be read, a FOLDER that cannot be written
"""


class _NoPyarrow(Exception):
    """It is not installed; the text is the one line to show."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.add_argument("captures", metavar="CAPTURE", type=Path, nargs="+", help="a capture with SIS in it")
    parser.add_argument(
        "-o", dest="output", metavar="FOLDER", type=Path, required=True, help="where the tables are, or will be"
    )
    parser.add_argument("--tap", metavar="NAME", default="", help="the name of the tap (default: that of its port)")


def run(args: argparse.Namespace) -> int:
    """Put the captures into the tables; return the exit code."""
    console = Console()
    try:
        _check(args)
        _check_pyarrow()
        _put(args, console)
    except (UsageError, NotACapture) as error:
        console.say(str(error))
        return USAGE
    except (_NoPyarrow, NoSuchTime, Incomplete, TsharkError) as error:
        console.say(str(error))
        return FAILED
    return DONE


def _put(args: argparse.Namespace, console: Console) -> None:
    with held():  # imported late: they need pyarrow
        from sistap.tables.convert import put
        from sistap.tables.store import Store, slug

    store, tap = Store(args.output), slug(args.tap) if args.tap else ""
    with Tshark() as tshark:
        for capture in args.captures:
            put(tshark, capture, store, tap, console)


def _check(args: argparse.Namespace) -> None:
    for capture in args.captures:
        if capture.exists() and not capture.is_file():
            raise UsageError(f"{capture} is not a file: it is read twice, so save the capture first")
        try:
            capture.open("rb").close()
        except OSError as error:
            raise UsageError(f"cannot read {capture}: {error.strerror}; name a capture file") from None
    try:
        args.output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"cannot write {args.output}: {error.strerror}; name another folder with -o") from None


def _check_pyarrow() -> None:
    try:
        with held():
            import pyarrow  # noqa: F401, PLC0415
    except ImportError:
        raise _NoPyarrow(
            f"pyarrow is missing for {sys.executable}: `{sys.executable} -m pip install pyarrow`"
        ) from None
