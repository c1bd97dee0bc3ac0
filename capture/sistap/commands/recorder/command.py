# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap record`: its options, and the recorder that a capture writes into."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager
from dataclasses import replace
from pathlib import Path

from sistap.commands.recorder import retention
from sistap.commands.recorder.keeper import Around
from sistap.commands.recorder.reasons import FAULTS, FILTERS, NOTHING, judges
from sistap.commands.recorder.recorder import Recorder, Wanted
from sistap.commands.recorder.values import ValueLines
from sistap.dissected.episodes.live import LIVE
from sistap.dissected.episodes.options import add_rule
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.capture.command import (
    Once,
    add_end_arguments,
    add_line_arguments,
    number,
    options_of,
    started,
)
from sistap.tap.capture.running import Opener
from sistap.tap.files.output import Output
from sistap.tap.files.pcapng import Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.records.counters import Counters
from sistap.tap.terminal.console import STANDARD_OUTPUT, Audience, Console
from sistap.tap.terminal.exits import Refusal

AROUND_S = 30  # what is kept before and after
AT_MOST = 100  # files that are kept
LARGEST_S = 86_400  # before and after

DESCRIPTION = """\
Listen to a bus for months, and keep what happens: what `sistap report` tells as a warning or an error, or what a
display filter finds. Around each, a file kept_TIME_REASON.pcapng is written into FOLDER. sistap never writes to the
port.
"""

EPILOG = """\
Overlapping times share one file. A file ends --after seconds after its last reason. The recorder waits --before seconds
more before it closes the file and starts COMMAND: a reason in that time goes into the same file. In the first hour it
learns what is usual: steps of values, and first writes of a master, are kept from then on. FILTER is tested live: a
command without a reaction is found at the next command (sis.unanswered_before).

`sistap capture --help` describes PORT, --baud auto, --follow-baud and capture filters.

examples:
  sistap record -i /dev/ttyUSB0 --wait-for-port -w kept/       for months: half a minute around each fault
  sistap record -i /dev/ttyUSB0 --keep writes --keep faults -w kept/
                                                               also around each written parameter
  sistap record -i /dev/ttyUSB0 --keep 'sis.parameter == "S-0-0044"' -w kept/
                                                               around each telegram about a parameter
  sistap record -i /dev/ttyUSB0 -w kept/ -b duration:3600 -b files:168
                                                               also all records, in a ring of a week
  sistap record -i /dev/ttyUSB0 -w kept/ --keep nothing -b duration:3600 --compress
                                                               all records alone, compressed: 3 to 12 times smaller
  sistap record -i /dev/ttyUSB0 -w kept/ --values - | mosquitto_pub -h broker -t press-4 -l
                                                               also each value, to a broker of MQTT

exit status:
  0  done; also when stopped by Ctrl-C, SIGTERM, or the end of the terminal
  1  failed while running (port lost, disk full): what came before is saved
  2  wrong usage, wrong filter, or a FOLDER that cannot be written
  3  the port cannot be opened
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add_line_arguments(parser)
    add("-w", dest="folder", action=Once, metavar="FOLDER", help="the folder for the files; it is made if necessary")
    add(
        "--keep",
        action="append",
        default=[],
        metavar="FILTER",
        help=f"keep a file around each packet that matches this display filter (default {FAULTS}). {FAULTS} is what "
        f"happens, as `sistap report` tells it, {' and '.join(FILTERS)} a ready-made filter, {NOTHING} leaves only "
        "the full ring of -b, or --values; can be given several times",
    )
    add_rule(parser, LIVE)
    add(
        "--before",
        dest="before_s",
        type=_seconds,
        default=AROUND_S,
        metavar="SECONDS",
        help=f"time kept before a reason (default {AROUND_S})",
    )
    add(
        "--after",
        dest="after_s",
        type=_seconds,
        default=AROUND_S,
        metavar="SECONDS",
        help=f"time kept after a reason (default {AROUND_S})",
    )
    add(
        "--at-most",
        type=number,
        default=AT_MOST,
        metavar="N",
        help=f"number of files (default {AT_MOST}); old repeats go, the first of each reason stays",
    )
    add(
        "--on-keep",
        action=Once,
        metavar="COMMAND",
        help="shell command to run for each complete file; gets the name of the file",
    )
    add(
        "--compress",
        action="store_true",
        help="compress complete files (NAME.pcapng.gz, 3 to 12 times smaller); Wireshark opens them as they are",
    )
    add(
        "--values",
        action=Once,
        metavar="-",
        help="write each value of a parameter to standard output when it is read or written: lines of InfluxDB's line "
        "protocol, for Telegraf or mosquitto_pub",
    )
    add_end_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Check everything before a port is opened, then record; return the exit code."""
    console = Console()
    folder = _folder(args.folder)
    options = options_of(args, str(folder / retention.RING) if args.ring else os.devnull)
    files = options.limits.keep
    if "filesize" in options.autostop and not options.ring:
        raise Refusal("-a filesize: is for the full ring: add -b duration:SECONDS or -b filesize:KB")
    if NOTHING in args.keep and (len(args.keep) > 1 or not (options.ring or args.values)):
        alone = "is for a full ring alone, or --values: add -b duration:SECONDS, leave out other --keep"
        raise Refusal(f"--keep {NOTHING} {alone}")
    if args.values not in (None, STANDARD_OUTPUT):
        raise Refusal(f"--values {args.values}: it is - alone, for Telegraf, or `| mosquitto_pub -l ...` behind it")
    values = ValueLines() if args.values else None
    with Tshark() as tshark:
        deciding = judges(tshark, args.keep or [FAULTS], args.thresholds, values)
    _make(folder)
    around = Around(int(args.before_s * 1e9), int(args.after_s * 1e9))
    wanted = Wanted(folder, deciding, around, args.at_most, args.on_keep, files, args.compress)
    # The recorder deletes the files of the ring: it counts those of earlier runs, too.
    ring = {name: value for name, value in options.ring.items() if name != "files"}
    return started(replace(options, ring=ring), console, _opener(wanted, values, has_ring=bool(ring)))


def _opener(wanted: Wanted, values: ValueLines | None, *, has_ring: bool) -> Opener:
    @contextmanager
    def opened(
        interfaces: Mapping[int, Interface], output: Output, counters: Counters, console: Audience
    ) -> Iterator[Recorder]:
        ring = PcapngWriter(output, interfaces, counters) if has_ring else None
        with ExitStack() as stack:
            if values:
                values.start(console.say)
                stack.callback(values.close)
            tshark = stack.enter_context(Tshark())
            yield stack.enter_context(closing(Recorder(wanted, tshark, interfaces, console.say, ring=ring)))

    return opened


def _folder(named: str | None) -> Path:
    if named is None or named == STANDARD_OUTPUT:
        raise Refusal("a recorder needs a folder for its files: say it with -w")
    if Path(named).exists() and not Path(named).is_dir():
        raise Refusal(f"{named} is no folder: a recorder needs one for its files, say another with -w")
    return Path(named)


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Refusal(f"{folder} cannot be made: {error.strerror}; name another folder with -w") from None


def _seconds(text: str) -> float:
    try:
        if 0 <= (seconds := float(text)) <= LARGEST_S:
            return seconds
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is not a number of seconds from 0 to {LARGEST_S}")
