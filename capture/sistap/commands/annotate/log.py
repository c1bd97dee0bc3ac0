# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap log`: a capture as a log, to read without Wireshark or to send by mail.

It looks like the output of annotate: a line with time, direction and bytes, and its explanation below.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path

from sistap.dissected.explain import entries
from sistap.dissected.explain.fields import EXPLANATION, Fields, said, sentence
from sistap.dissected.wireshark.rows import BEFORE, EVENT, JOINT, first
from sistap.dissected.wireshark.trouble import damage
from sistap.dissected.wireshark.tshark import Tshark, TsharkError
from sistap.tap.common.packed import untold
from sistap.tap.common.writing import opened
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.exits import DONE, USAGE, Refusal, why
from sistap.tap.terminal.writing import FORCE

DESCRIPTION = """\
Write a capture as a log: one line of text for each telegram with its time, direction and bytes, and its explanation
below. `sistap annotate` reads such a log and finds the same telegrams at the same times. Of a capture of a network, the
log has the packets of the connections with SIS. The bytes of Telnet are in it, and annotate takes them for characters.
The explanations come from Wireshark's dissector: install tshark with the plugin or sis.lua.
"""

EPILOG = """\
Times are local, with their zone. RX and TX are the two directions of a full-duplex tap; an RS485 bus has none. In a
network, TX goes to the lower port number; of messages, TX are the master's. A log has no line errors and no times
inside a telegram, so keep the capture as well.

examples:
  sistap log day.pcapng                  to standard output
  sistap log day.pcapng -o day.txt       to a file, for example to mail it

exit status:
  0  done; a message on standard error says if the end of the capture is missing
  1  failed while running: tshark or the plugin is missing, disk full
  2  wrong usage, a CAPTURE that cannot be read or has no records of sistap, or a FILE that cannot be written
"""

_TIME, _TYPE, _LINE, _CHARACTER = "frame.time_epoch", "sertap.type", "sertap.line", "sertap.character"
_PROTOCOLS, _STREAM, _SENT = "frame.protocols", "tcp.stream", "frame.packet_flags_direction"
_PORTS = (("tcp.srcport", "tcp.dstport"), ("udp.srcport", "udp.dstport"))
_BYTES = ("tcp.payload", "udp.payload", "exported_pdu.exported_pdu")  # of a packet that is no record
_OURS = frozenset("sis sisascii 3964r rk512i arcnet7f synaxpk synaxpcp synaxobj synaxpd".split())
_CURE = "; `sistap import` reads captures of USB adapters and an RTAC, Decode As in Wireshark names a network's port"
_NS = 1  # resolution of the times


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("capture", metavar="CAPTURE", type=Path, help="a capture that sistap wrote, or of a network")
    parser.add_argument("-o", dest="output", metavar="FILE", help="write to FILE (default: standard output)")
    parser.add_argument("--force", action="store_true", help=FORCE)


def run(args: argparse.Namespace) -> int:
    """Write the log; return the exit code."""
    console = Console()
    written, left_out = _write(args, console)
    if left_out:
        packets = "1 packet without SIS is" if left_out == 1 else f"{left_out} packets without SIS are"
        console.say(f"{args.capture}: {packets} not in the log{'' if written else _CURE}")
    return DONE if written or not left_out else USAGE


def _write(args: argparse.Namespace, console: Console) -> tuple[int, int]:
    """Write the log; return how many packets are in it, and how many are not."""
    _check(args, console.say)
    written = left_out = 0
    with Tshark() as tshark, opened(args.output, [args.capture], force=args.force) as file:
        for line in _lines(tshark, args.capture, console.say):
            written += bool(line)
            left_out += not line
            file.write(line.encode())
    return written, left_out


def _check(args: argparse.Namespace, say: Callable[[str], None]) -> None:
    if args.capture.exists() and not (args.capture.is_file() or args.capture.is_dir()):
        raise Refusal(f"{args.capture} is not a file: it is read twice, so save the capture first")
    try:
        if warning := untold(args.capture):
            say(warning)
    except OSError as error:
        raise Refusal(f"cannot read {args.capture}: {why(error)}; name a capture file") from None
    if args.output and Path(args.output).exists() and args.capture.samefile(args.output):
        raise Refusal(f"{args.output} is the capture itself; name another file with -o")


def _lines(tshark: Tshark, capture: Path, say: Callable[[str], None]) -> Iterator[str]:
    """Yield the lines of each packet; an empty text for a packet that is not a record."""
    ports = (port for ends in _PORTS for port in ends)
    more = (_TIME, _TYPE, _LINE, _CHARACTER, _PROTOCOLS, _STREAM, _SENT, *_BYTES, *ports)
    fields = Fields(tshark, more)
    streams: set[str] = set()
    came = False
    try:
        for line in tshark.lines(["-r", str(capture), "-2", *fields.arguments]):
            came = True
            columns = fields.columns(line)
            yield _entry(columns) if _is_of_ours(columns, streams) else ""
    except TsharkError as error:
        say(f"{capture}: the log is of what comes before the damage: {damage(capture, error, came)}")


def _is_of_ours(columns: dict[str, str], streams: set[str]) -> bool:
    """Tell whether a packet belongs into the log. `streams`: the TCP connections that do."""
    stream = columns.get(_STREAM, "")
    if columns.get(_TYPE) or not _OURS.isdisjoint(columns[_PROTOCOLS].split(":")):
        streams.add(stream)
        return True
    return bool(stream) and stream in streams and bool(columns.get(_BYTES[0]))  # a part of a telegram


def _entry(columns: dict[str, str]) -> str:
    """Return the line of a packet and its explanation. An event, or what was told before, has only an explanation."""
    seconds, _, decimals = (columns[_TIME] or "0").partition(".")  # a packet may have no time
    stamp = entries.stamp(int(seconds), int(decimals.ljust(9, "0")))
    text = sentence(said(columns), _NS if stamp else None)
    characters = _characters(columns)
    if columns.get(_TYPE) in (str(EVENT), str(BEFORE)) or not characters:
        return f"{EXPLANATION}{stamp}{text}\n"
    head = entries.head(stamp, _line(columns))
    return f"{head}{characters}\n{entries.under(head, text)}"


def _characters(columns: dict[str, str]) -> str:
    """Return the bytes; empty if no field has them."""
    if columns.get(_TYPE):
        return columns.get(_CHARACTER, "").replace("0x", "").replace(JOINT, " ").upper()
    found = next((columns[name] for name in _BYTES if columns.get(name)), "")
    return bytes.fromhex(first(found).replace(":", "")).hex(" ").upper()


def _line(columns: dict[str, str]) -> int:
    """Return the direction: 1 received, 2 sent, 0 not known."""
    if columns.get(_TYPE):
        return int(columns.get(_LINE) or 0)
    for source, target in _PORTS:
        if columns.get(source):
            return 1 if int(first(columns[source])) < int(first(columns[target])) else 2
    return int(columns.get(_SENT) or "0", 0)  # inbound is 1, outbound 2
