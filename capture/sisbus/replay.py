# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap replay`: plays a capture, character by character, with its original timing."""

from __future__ import annotations

import argparse
import heapq
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from sisbus.playing.characters import Played, SentCharacter
from sisbus.wires import place
from sisbus.wires.place import play
from sisbus.wires.wire import Pace
from sistap.dissected.captures.reading import records
from sistap.tap.line.settings import ERROR_FLAGS, Flag, LineSettings
from sistap.tap.records.record import Record, Type
from sistap.tap.terminal.exits import NotCaptured, Refusal, why

DESCRIPTION = """\
Play a capture that sistap wrote: every character at its time. It goes to a pseudo terminal, to a socket, or, with
--transmit, to a real port. Playing begins when a program listens.
"""

EPILOG = """\
Characters that arrived in one read are played at once. Characters of two directions (RS422, RS232) are played in the
order of their times. A socket also carries line errors and the number of the line (1 or 2). A pseudo terminal and a
port carry the values alone; a message at the end says how many errors there were. A capture of the replay at a socket
has the characters, intervals and errors of the original.

examples:
  sistap replay day.pcapng                                 at a pseudo terminal; its name is printed
  sistap replay day.pcapng --listen 127.0.0.1:5000         for `sistap capture -i bus://127.0.0.1:5000`
  sistap replay day.pcapng --listen ./bus --fast           as fast as the listener reads
  sistap replay day.pcapng --port /dev/ttyUSB0 --transmit  on a real bus: disconnect the machine first

exit status:
  0  done; also when stopped by Ctrl-C or SIGTERM
  1  failed while running
  2  wrong usage, or a CAPTURE that cannot be read
  3  the port cannot be opened
"""

_UNKNOWN_RATE = 9600  # for a record without a rate


class Content(NamedTuple):
    """What a capture contains."""

    settings: LineSettings  # of its first characters
    begin_ns: int  # since 1970, of the first character
    lines: frozenset[int]
    characters: int
    errors: int  # characters with a line error


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("capture", type=Path, metavar="CAPTURE", help="a capture that sistap wrote")
    place.add_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Play the capture until its end or a signal; return the exit code. May raise PortError or PortLost."""
    return place.refusing("replay", lambda: _play(args))


def _play(args: argparse.Namespace) -> None:
    try:
        place.settle(args)
        place.check(args)
        content = look(args.capture)
    except ValueError as error:
        raise Refusal(str(error)) from error
    except OSError as error:
        raise Refusal(f"cannot read {args.capture}: {why(error)}; name a capture file") from error
    pace = Pace(simulated=args.fast)
    wire = place.opened(args, content.settings, pace)
    print(f"sistap replay: {content.characters} characters at {content.settings}", file=sys.stderr)
    play(wire, pace, played(args.capture, content))
    if content.errors and not args.listen:
        print(
            f"sistap replay: {content.errors} line errors were left out: only a socket carries them (--listen)",
            file=sys.stderr,
        )


def look(path: Path) -> Content:
    """Read a capture once, to check that it can be played. Raise OSError or NotCaptured."""
    first: Record | None = None
    lines: set[int] = set()
    characters = errors = 0
    for record in _with_characters(path):
        first = first or record
        lines.add(record.line)
        characters += len(record.data)
        errors += sum(bool(flag & ERROR_FLAGS) for flag in record.flags)
    if first is None:
        raise NotCaptured(f"{path} has no characters, only events: nothing to play")
    return Content(_settings(first), first.time_ns, frozenset(lines), characters, errors)


def played(path: Path, content: Content) -> Iterator[Played]:
    """Return all reads of all lines in the order of their times, from time 0 on."""
    begin_ns = content.begin_ns - content.settings.character_ns
    lines = (_reads(path, line, begin_ns) for line in sorted(content.lines))
    return iter(heapq.merge(*lines, key=lambda one: one.time_ns))


def _reads(path: Path, line: int, begin_ns: int) -> Iterator[Played]:
    """Yield what came in one read; a read can span several records."""
    read: Played | None = None
    for record in _with_characters(path):
        if record.line != line:
            continue
        settings, time_ns = _settings(record), record.time_ns - begin_ns
        for index, (value, interval, flags) in enumerate(zip(record.data, record.intervals, record.flags, strict=True)):
            time_ns += interval if index else 0
            if read and not flags & Flag.SAME_READ:
                yield read
                read = None
            read = read or Played(time_ns, b"", [], [], settings, line, record.uncertainty_ns)
            read.characters.append(SentCharacter(time_ns, value, flags & Flag.FROM_READER))
            # A record has the largest uncertainty of its reads, so the smaller one belongs to this read.
            uncertainty_ns = min(read.uncertainty_ns, record.uncertainty_ns)
            read = read._replace(sent=read.sent + bytes([value]), uncertainty_ns=uncertainty_ns)
    if read:
        yield read


def _with_characters(path: Path) -> Iterator[Record]:
    return (record for record in records(path) if record.type in (Type.FRAME, Type.OTHER) and record.data)


def _settings(record: Record) -> LineSettings:
    return record.settings if record.settings.baud else record.settings._replace(baud=_UNKNOWN_RATE)
