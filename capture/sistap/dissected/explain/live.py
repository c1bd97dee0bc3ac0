# SPDX-License-Identifier: GPL-2.0-or-later
"""Shows a capture as text: the lines of `sistap log`, while the records come."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from typing import NamedTuple

from sistap.dissected.explain import entries
from sistap.dissected.explain.fields import Fields, said, sentence
from sistap.dissected.explain.plain import PlainText
from sistap.dissected.explain.relay import Columns, Entry, JudgedEntry, Relay
from sistap.dissected.explain.running import Running, ordinary_children
from sistap.dissected.wireshark.rows import passes, tested
from sistap.dissected.wireshark.tshark import Tshark, TsharkError
from sistap.tap.files.output import Output
from sistap.tap.files.pcapng import Interface
from sistap.tap.files.writer import Blocks
from sistap.tap.records.before import heard
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Record, Type
from sistap.tap.sis.faults import FAULTS

PATIENCE_S = 5.0  # longest wait for tshark at the end: the user may be waiting
_NS = 1  # resolution of the times
_FAULTS = [test for fault in FAULTS for test in fault.live_tests]
_NEEDED = ("frame.number", "sis.control.reaction", *tested(_FAULTS))


class Colours(NamedTuple):
    """The escape sequences of a terminal's colours; empty without colours."""

    trouble: str = ""
    command: str = ""
    reaction: str = ""
    other: str = ""
    dim: str = ""  # the bytes
    end: str = ""


PLAIN = Colours()
IN_COLOUR = Colours("\x1b[1;31m", "\x1b[36m", "\x1b[32m", "\x1b[33m", "\x1b[2m", "\x1b[0m")


def colours(stream: int = 1, environment: Mapping[str, str] = os.environ, system: str = sys.platform) -> Colours:
    """Return colours for a terminal that has them, unless NO_COLOR (no-color.org) is set."""
    has_them = environment.get("TERM", "") not in ("", "dumb") or (system == "win32" and "WT_SESSION" in environment)
    try:
        is_terminal = os.isatty(stream)
    except OSError:
        is_terminal = False
    return IN_COLOUR if is_terminal and has_them and not environment.get("NO_COLOR") else PLAIN


class LiveText:
    """Prints each record with its explanation, as soon as tshark has one. Events go to standard error."""

    def __init__(
        self,
        output: Output,
        tshark: Tshark,
        interfaces: Mapping[int, Interface],
        say: Callable[[str], None],
        colours: Colours = PLAIN,
    ) -> None:
        """Ask tshark for its fields. TsharkError if it has no dissector for SIS."""
        self._output = output
        self._tshark = tshark
        self._colours = colours
        self._blocks = Blocks(interfaces)
        self._fields = Fields(tshark, _NEEDED)
        self._relay = Relay(self._start, self._fields.columns, say, finds=False)

    def begin(self, *started: Record) -> None:
        """Begin with events that describe how the capture is taken."""
        self._relay.begin(self._blocks, self._blocks.section(), started)

    def write(self, record: Record) -> bool:
        """Take a record; print what is explained by now."""
        if interface := self._blocks.interface(record.line):
            self._relay.put(Entry(record.time_ns, interface, is_packet=False))
        is_event = record.type == Type.EVENT
        line = "" if is_event else _line(record)
        self._relay.put(Entry(record.time_ns, self._blocks.packet(record), heard(record), line=line))
        self._print_some()
        return not is_event

    def look(self, time_ns: int) -> None:
        """Print what is explained by now."""
        self._print_some()

    def end(self, time_ns: int) -> None:
        """Print the rest."""
        for judged in self._relay.finish(PATIENCE_S):
            self._print(judged)

    def summary(self, counters: Counters) -> str:
        """Return what was heard."""
        return str(counters)

    def close(self) -> None:
        """End tshark."""
        self._relay.close()

    def _print_some(self) -> None:
        for judged in self._relay.look():
            self._print(judged)

    def _print(self, judged: JudgedEntry) -> None:
        if line := judged.entry.line:
            self._output.write(self._text(line, judged.columns).encode())

    def _text(self, line: str, columns: Columns | None) -> str:
        head, _, characters = line.rpartition("  ")
        head = f"{head}  " if head else ""
        colours = self._colours
        text = f"{head}{colours.dim}{characters}{colours.end}\n"
        if columns:
            explained = entries.under(head, f"{self._colour(columns)}{sentence(said(columns), _NS)}{colours.end}")
            text += explained
        return text

    def _colour(self, columns: Columns) -> str:
        if passes(_FAULTS, columns):
            return self._colours.trouble
        if not said(columns).is_telegram:
            return self._colours.other
        is_reaction = columns.get("sis.control.reaction") in ("1", "True")
        return self._colours.reaction if is_reaction else self._colours.command

    def _start(self, token: bytes | None) -> Running:
        return Running(self._tshark, self._fields.arguments)


def _line(record: Record) -> str:
    stamp = entries.stamp(*divmod(record.time_ns, 1_000_000_000))
    return entries.head(stamp, record.line) + record.data.hex(" ").upper()


@contextmanager
def explained(
    output: Output, interfaces: Mapping[int, Interface], say: Callable[[str], None]
) -> Iterator[LiveText | PlainText]:
    """Begin such a text; plain text, and a message, where there is no tshark with the dissector."""
    with ExitStack() as stack:
        try:
            with ordinary_children():
                tshark = stack.enter_context(Tshark())
                text = LiveText(output, tshark, interfaces, say, colours())
        except (TsharkError, OSError) as error:
            say(f"{error}. Until then telegrams are not explained")
            yield PlainText(output)
        else:
            stack.callback(text.close)
            yield text
