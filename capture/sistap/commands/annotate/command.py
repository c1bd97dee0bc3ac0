# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap annotate`: its options, and how it runs."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from sistap.commands.annotate import annotating, sources
from sistap.commands.annotate.annotating import Passage
from sistap.commands.annotate.annotator import Annotator, TextAnnotator
from sistap.commands.annotate.explaining import LiveCapture, WholeCapture
from sistap.commands.annotate.meanings import Meanings
from sistap.commands.annotate.page import PageAnnotator
from sistap.commands.annotate.pattern import PatternReader
from sistap.commands.annotate.reading import LogReader
from sistap.commands.annotate.sources import LogSource
from sistap.commands.annotate.spool import Spool
from sistap.commands.annotate.troubles import Troubles
from sistap.dissected.episodes.options import add_rule
from sistap.dissected.explain import advice
from sistap.dissected.explain.fields import Fields
from sistap.dissected.packets.dissection import FIELDS
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.common import temporary
from sistap.tap.common.garbage import uncollected
from sistap.tap.common.writing import opened
from sistap.tap.files.output import Output, ReaderGone
from sistap.tap.records.cut import HELP, SIS, WORDS, Cut
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.exits import DONE, FAILED, USAGE, Refusal, argument
from sistap.tap.terminal.writing import FORCE

DESCRIPTION = """\
Explain a log. The input is any text with the bytes of SIS telegrams. The output is the same text with an explanation
below each telegram. The explanations come from Wireshark's dissector: install tshark with the plugin or sis.lua.

sistap reads bytes as programs write them: "02 E1", "0x02,0xE1", "02E1", \\x02\\xE1, "2-225", "W#16#02E1" and others. It
takes the notation that makes telegrams with right checksums, and names it. Lines may have offsets and a column of
characters. A telegram may go over several lines, and a line may hold several telegrams.
sistap uses time stamps and direction marks if the log has them. The log itself is copied byte for byte. The added lines
begin with blanks and "^--". Of a file with the bytes themselves, the output has a line for each telegram. With
--framing ascii, a log may also be the text of a terminal program, with or without times in front.
"""

EPILOG = """\
A file is read to its end before it is explained. So sistap knows which command had no reaction. If the log has times
and something has to be looked at, five lines at its end say what happened and when. Lines that are added later are not
in the output. Standard input (-) is explained live: each telegram as soon as it is complete.

examples:
  sistap annotate docklight.txt                    the log and its explanation
  sistap annotate --format html docklight.txt -o log.html
                                                   as a page: point at a byte to see its meaning
  sistap annotate docklight.txt -w log.pcapng      as a capture, for Wireshark and `sistap report`
  sistap annotate --framing ascii putty.log        a session of the ASCII protocol of a drive
  tail -f trace.log | sistap annotate -            live, while another program writes the log
  sistap annotate --regex '(?<time>[^;]*);(?<dir>[^;]*);(?<data>.*)' plc.csv
                                                   a layout that sistap does not recognise itself

exit status:
  0  done; also when stopped by Ctrl-C; standard error names lines that could not be read
  1  failed while running: tshark or the plugin is missing, disk full
  2  wrong usage, a LOG that cannot be read or has no bytes, or a FILE that cannot be written
"""


def _reader(pattern: str) -> Callable[[], LogReader]:
    """Return what makes readers. ValueError says what is wrong with the expression."""
    PatternReader(pattern)
    return lambda: PatternReader(pattern)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("log", metavar="LOG", help="a text file, a raw log as PuTTY saves it, or - for standard input")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--format", choices=("text", "html"), default="text", help="what to write (default: text)")
    what.add_argument(
        "-w", dest="capture", metavar="FILE", help="write a capture (pcapng) instead; - is standard output"
    )
    parser.add_argument("--force", action="store_true", help=FORCE)
    parser.add_argument("-o", dest="output", metavar="FILE", help="write to FILE (default: standard output)")
    parser.add_argument(
        "--regex",
        dest="reader",
        metavar="REGEX",
        type=argument(_reader),
        help="a pattern (regular expression) for a line of the log, with the names of text2pcap: (?<data>...) is the "
        "bytes in hexadecimal; (?<time>...) and (?<dir>...) are optional; lines that do not fit are left out",
    )
    add_rule(parser)
    parser.add_argument("--framing", type=argument(Cut.parse), default=SIS, metavar=WORDS, help=HELP)


def run(args: argparse.Namespace) -> int:
    """Explain a log; return the exit code."""
    console = Console()
    troubles = Troubles(console.say)
    try:
        _check(args)
        source = sources.look(args.log, args.framing, args.reader and args.reader())
        if source.is_raw:
            console.say(f"{_name(args)} is no text: its bytes are read as they are, without times and directions")
        passage = Passage(source.reader, troubles.add, args.framing)
        written = ""
        if args.capture:
            written = _capture(args, source, passage, console)
        else:
            _explain(args, source, passage, console)
    except ReaderGone:
        return FAILED
    if passage.telegrams:
        troubles.end()
        if source.reader.notation:
            console.say(f"{_name(args)}: bytes: {source.reader.notation}")
    if written and passage.bytes:
        console.say(written)
    return _judge(args, passage, troubles, console)


def _check(args: argparse.Namespace) -> None:
    if args.capture and args.output:
        raise Refusal("-w names the file already: leave out -o")
    for option, path in (("-w", args.capture), ("-o", args.output)):
        if path and _is_same(path, args.log):
            raise Refusal(f"{path} is the log itself; name another file with {option}")


def _judge(args: argparse.Namespace, passage: Passage, troubles: Troubles, console: Console) -> int:
    """Report it if there was nothing to explain."""
    log = _name(args)
    if passage.has_ascii:
        console.say(f"{log} has lines of the ASCII protocol of drives: explain them with --framing ascii")
        return DONE if passage.bytes else USAGE
    if not passage.bytes:
        why = troubles.first or "log in hexadecimal, or say with --regex where they are"
        console.say(f"no bytes were found in {log}: {why}")
        return USAGE
    if not passage.telegrams:
        wanted = "telegram of SIS" if args.framing == SIS else "frame"
        console.say(f"{log} has {passage.bytes} byte{'' if passage.bytes == 1 else 's'}, but no {wanted}")
    return DONE


def _is_same(path: str, log: str) -> bool:
    return log != "-" and Path(path).exists() and Path(log).exists() and Path(path).samefile(log)


def _name(args: argparse.Namespace) -> str:
    return "standard input" if args.log == "-" else Path(args.log).name


def _sources(args: argparse.Namespace) -> list[str]:
    return [] if args.log == "-" else [args.log]


def _progress(console: Console, what: str, *, is_shown: bool = True) -> Callable[[float], None]:
    if not is_shown:
        return lambda _: None
    return lambda part: console.progress(f"{what}: {part:.0%}" if part < 1 else "")


def _batches(args: argparse.Namespace, source: LogSource, console: Console) -> annotating.Batches:
    """Read the log once only: it may grow meanwhile."""
    return source.lines(args.framing, _progress(console, "read"))


def _capture(args: argparse.Namespace, source: LogSource, passage: Passage, console: Console) -> str:
    """Write the capture; return what to say of it."""
    output = Output(args.capture, force=args.force, sources=_sources(args))
    try:
        output.begin()
        annotating.record(_batches(args, source, console), passage, _name(args), output.write)
        return output.written
    finally:
        output.close()


def _explain(args: argparse.Namespace, source: LogSource, passage: Passage, console: Console) -> None:
    """Write the explanation: of a file after all of it was dissected, of a pipe as it comes.

    A page also shows what only a later telegram tells, so it waits for the end of a pipe.
    """
    with ExitStack() as stack:
        tshark = stack.enter_context(Tshark())
        if not source.is_pipe or args.format == "html":
            _explain_whole(args, source, passage, console, tshark)
        else:
            running = stack.enter_context(LiveCapture(tshark, _name(args)))
            file = stack.enter_context(opened(args.output, _sources(args), force=args.force, grows=True))
            batches, annotator = _batches(args, source, console), TextAnnotator(file.write)
            annotating.annotate_live(batches, passage, running, annotator, file.flush)


def _explain_whole(
    args: argparse.Namespace, source: LogSource, passage: Passage, console: Console, tshark: Tshark
) -> None:
    with ExitStack() as stack, uncollected():
        file = stack.enter_context(opened(args.output, _sources(args), force=args.force))
        fields = Fields(tshark, (*FIELDS, *advice.FIELDS))
        capture = stack.enter_context(temporary.folder()) / "log.pcapng"
        spool = stack.enter_context(Spool())
        with opened(str(capture), cure="name a larger folder with TMPDIR") as blocks:
            annotating.record(_batches(args, source, console), passage, _name(args), blocks.write, spool)
        sayer = WholeCapture(tshark, fields, capture, args.thresholds)
        sayer.has_telegram = bool(passage.telegrams)
        annotator: Annotator = TextAnnotator(file.write)
        if args.format == "html":
            annotator = PageAnnotator(file.write, _name(args), Meanings(stack.enter_context(Tshark()), capture))
        # Not on a terminal that shows the log itself: it would stand in between.
        batches = spool.batches(_progress(console, "explained", is_shown=not file.isatty()))
        annotating.annotate_recorded(batches, sayer, annotator, file.flush)
