# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap tables`: its options, and how it runs."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from sistap.dissected.captures.joining import check_captures, in_order
from sistap.dissected.episodes.options import add_rule
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.common.packages import needing
from sistap.tap.common.writing import make_folder
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.exits import DONE, Refusal
from sistap.tap.terminal.writing import mode_like

DESCRIPTION = """\
Collect captures in tables (Parquet files), to query many months and many machines: telegrams, values of parameters,
events, and what happened. DuckDB, Spark, pandas and other programs read them. Run it as often as you like: it adds only
what is new. A capture may have grown, or have telegrams of another capture. What happened is judged over all captures
of a call, as `sistap report` does. The contents come from Wireshark's dissector: install tshark with the plugin or
sis.lua.
"""

EPILOG = """\
The tables are folders in FOLDER, with a subfolder for each tap and each day (UTC). A tap is named after its port.
Several machines may use the same port name. If they write into the same FOLDER, name each tap with --tap.

examples:
  sistap tables day.pcapng -o tables
  sistap tables --tap press-4 ring/*.pcapng -o /srv/tables        run once an hour for a ring
  duckdb -c "SELECT sender, max(reaction_s) FROM 'tables/telegrams/*/*/*.parquet' GROUP BY sender"

exit status:
  0  done; a message on standard error says if the end of a capture is missing
  1  failed while running: tshark, the plugin or pyarrow is missing, disk full; earlier captures are in the tables
  2  wrong usage, a CAPTURE that cannot be read, or a FOLDER that cannot be written
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("captures", metavar="CAPTURE", type=Path, nargs="+", help="a capture that contains SIS")
    parser.add_argument(
        "-o",
        dest="output",
        metavar="FOLDER",
        type=Path,
        required=True,
        help="the folder of the tables; created if missing",
    )
    add_rule(parser)
    parser.add_argument("--tap", metavar="NAME", default="", help="the name of the tap (default: the name of its port)")


def run(args: argparse.Namespace) -> int:
    """Put the captures into the tables; return the exit code."""
    console = Console()
    _check(args, console)
    _put(args, console)
    return DONE


def _put(args: argparse.Namespace, console: Console) -> None:
    with needing("pyarrow"):  # imported late, as other commands do without it
        import pyarrow.dataset
        import pyarrow.parquet  # noqa: F401 - what fails in sistap's own modules is not the fault of pyarrow

    from sistap.commands.tables.convert import put
    from sistap.commands.tables.store import Store, slug

    store, tap = Store(args.output), slug(args.tap) if args.tap else ""
    with Tshark() as tshark:
        put(tshark, in_order(args.captures), store, tap, args.thresholds, console)


def _check(args: argparse.Namespace, console: Console) -> None:
    args.captures = check_captures(args.captures, console.say)
    try:
        make_folder(args.output, mode_like(args.captures))
        tempfile.TemporaryFile(dir=args.output).close()  # not after the work
    except OSError as error:
        raise Refusal(f"cannot write {args.output}: {error.strerror}; name another folder with -o") from None
