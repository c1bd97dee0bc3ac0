# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap import`: the command line."""

from __future__ import annotations

import argparse
import os
from collections import Counter
from contextlib import ExitStack, closing
from pathlib import Path

from sistap.commands.imports import messages
from sistap.commands.imports.convert import Conversion
from sistap.commands.imports.formats import NAMES, opened
from sistap.commands.imports.source import Source, Stated
from sistap.dissected.wireshark.tshark import TsharkError
from sistap.tap.files.output import Output
from sistap.tap.files.pcapng import LINKTYPE_WIRESHARK_UPPER_PDU, Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN
from sistap.tap.records.counters import Counters
from sistap.tap.records.cut import HELP, SIS, WORDS, Cut
from sistap.tap.records.record import LARGEST_RATE
from sistap.tap.terminal.console import STANDARD_OUTPUT, Console
from sistap.tap.terminal.exits import DONE, Refusal, argument
from sistap.tap.terminal.stop import Stop
from sistap.tap.terminal.writing import FORCE

_LIST = "\n".join(f"  {name}" for name in NAMES)

DESCRIPTION = f"""\
Convert what another tool recorded into a capture of sistap:

{_LIST}

sistap detects the format from the contents of FILE. It keeps all characters, their errors, and their times. The last
message says how exact the times are. Captures of USB and RTAC need tshark.

From the levels of a logic analyser, sistap finds rate, format, polarity and the channels of the bus. The last message
says what was found. What you state with --baud, --format and --device is not searched for.

With --dissector, FILE is a table of whole messages. Each line has the time in s, M (master) or S (slave), and the
bytes. Each message becomes a packet for that dissector of Wireshark.
"""

EPILOG = """\
examples:
  sistap import usb.pcapng -w bus.pcapng                               the file contains rate and format
  sistap import usb.pcapng -w bus.pcapng --device 1.5                  one of several adapters
  sistap import pulseview.sr -w bus.pcapng                             levels (.sr, .vcd, .csv ...): the rate is found
  sistap import decoded.csv -w bus.pcapng --baud 9600                  characters of a decoder: no rate in the table
  sistap import decoded.csv -w s5.pcapng --baud 9600 --framing 3964r   an S5 and a PPC over 3964R
  sistap import pulseview.txt -w - --baud 9600 --samplerate 1000000 | wireshark -C SIS -k -i -
  sistap import messages.csv -w pcp.pcapng --dissector synaxpcp        lines such as 0.125,M,0082 000C 0002

exit status:
  0  done; also if the end of FILE is missing: a message says so
  1  failed while running: tshark is missing, disk full
  2  wrong usage, a FILE that cannot be read or an OUT that cannot be written
"""


def _whole(text: str) -> int:
    try:
        if 0 < (number := int(text)) <= LARGEST_RATE:
            return number
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from 1 to {LARGEST_RATE}")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    add = parser.add_argument
    add("file", metavar="FILE", type=Path, help="the recording of another tool")
    add("-w", dest="output", metavar="OUT", required=True, help="write a pcapng file; - is standard output")
    add("--force", action="store_true", help=FORCE)
    add("--baud", type=_whole, metavar="RATE", help="rate in Bd; goes before what FILE says")
    add(
        "--format",
        metavar="FORMAT",
        help="data bits, parity N, E, O, M or S, stop bits; goes before what FILE says (default 8E1; found in levels)",
    )
    add("--framing", type=argument(Cut.parse), default=SIS, metavar=WORDS, help=HELP)
    add(
        "--device",
        metavar="ADAPTER|CHANNELS",
        help="of a USB capture with several adapters, the one to take: BUS.ADDRESS, such as 1.5; of the levels of a "
        "logic analyser, the channels of the bus: D0 or D0,D1",
    )
    add(
        "--samplerate",
        type=_whole,
        metavar="HZ",
        help="sample rate of the logic analyser; needed for texts of sigrok; makes the times of a table exact",
    )
    add("--dissector", choices=messages.DISSECTORS, help="FILE is a table of messages for this dissector")


def run(args: argparse.Namespace) -> int:
    """Import; return the exit code."""
    stop = Stop.current()
    console = Console()
    stated = _stated(args)
    if args.dissector:
        return _take_messages(args, stated, stop, console)
    with ExitStack() as tools:
        output = tools.enter_context(closing(_output(args, stop)))
        source = opened(args.file, stated, tools)
        stop.at_once = False
        return _convert(args, source, output, stop, console)


def _stated(args: argparse.Namespace) -> Stated:
    """Check what the options say. May raise Refusal."""
    stated = Stated(args.baud, args.format, args.samplerate, args.device, args.framing)
    try:
        stated.settings  # noqa: B018 - only whether it can be made
    except ValueError as error:
        raise Refusal(str(error)) from None
    _check_output(args)
    return stated


def _check_output(args: argparse.Namespace) -> None:
    if args.output == STANDARD_OUTPUT and os.isatty(1):
        raise Refusal("a terminal cannot show a pcapng file: add | wireshark -C SIS -k -i -, or name a file with -w")
    if args.file.exists() and Path(args.output).exists() and args.file.samefile(args.output):
        raise Refusal(f"{args.output} is FILE itself: name another file with -w")


def _output(args: argparse.Namespace, stop: Stop) -> Output:
    """Open the output, before FILE is read: that may take long."""
    return Output(args.output, stopped=lambda: stop.asked, force=args.force, sources=[args.file])


def _take_messages(args: argparse.Namespace, stated: Stated, stop: Stop, console: Console) -> int:
    """Make packets of a table of messages."""
    if stated != Stated():
        raise Refusal(
            "a table of messages has no line: leave out --baud, --format, --framing, --device and --samplerate"
        )
    with closing(_output(args, stop)) as output:
        found = messages.read(args.file)
        messages.write(output, args.dissector, args.file.name, found)
        console.say(f"{len(found)} messages for {args.dissector} {output.written}")
    return DONE


def _convert(args: argparse.Namespace, source: Source, output: Output, stop: Stop, console: Console) -> int:
    counters = Counters()
    settings, timing = source.settings, source.timing
    interfaces = {
        line: Interface(LINKTYPE_WIRESHARK_UPPER_PDU, text, f"{settings}; {timing}", settings.baud)
        for line, text in source.lines.items()
    }
    conversion = Conversion(source, PcapngWriter(output, interfaces, counters), counters, args.file.name, args.framing)
    try:
        conversion.run(lambda: stop.asked, console.progress)
    except TsharkError:
        if not stop.asked:  # else the same Ctrl-C has ended it
            raise
    if source.warning:
        console.say(f"{args.file}: {source.warning}")
    console.say(f"{counters} {output.written}")
    console.say(f"{settings}, {source.settings_from}; {timing}: {_precision(conversion.uncertainties)}")
    return DONE


def _precision(uncertainties_ns: Counter[int]) -> str:
    """Say what the times are good for."""
    if not uncertainties_ns:
        return "stopped before the first character"
    if UNCERTAINTY_UNKNOWN in uncertainties_ns:
        return "their uncertainty is unknown, so verdicts on limits are unresolved"
    ordered = sorted(uncertainties_ns)
    passed, half = 0, 0
    for half in ordered:
        passed += uncertainties_ns[half]
        if 2 * passed >= uncertainties_ns.total():
            break
    most = f" (half of them {_milliseconds(half)})" if half < ordered[-1] else ""
    return (
        f"characters can have come up to {_milliseconds(ordered[-1])} earlier{most}; an interval that close to its "
        "limit gets no verdict"
    )


def _milliseconds(time_ns: int) -> str:
    return f"{time_ns / 1e6:.2g} ms" if time_ns >= 1000 else f"{time_ns} ns"
