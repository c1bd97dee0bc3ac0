# SPDX-License-Identifier: GPL-2.0-or-later
"""A raw log: the bytes of the line as they came, as PuTTY saves them, without times and directions.

Each record becomes a line of text with its bytes in hexadecimal. The heading of a PuTTY session stays as it is.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from sistap.commands.annotate.annotating import Passage
from sistap.commands.annotate.choosing import AnyReader
from sistap.commands.annotate.marks import SHARED
from sistap.commands.annotate.notations import PAIRS, Run
from sistap.commands.annotate.reading import Contents, LogReader, Piece
from sistap.commands.annotate.textlog import Cutter, LineCutter, LogLine, lines
from sistap.tap.line.settings import Flag, LineSettings, Read
from sistap.tap.records.cut import Cut
from sistap.tap.records.record import Framing, Record

_HEADING = re.compile(rb"(?:=~)+=? PuTTY log [\d. :]+ (?:=~)+=?\r?\n")
CONTROLS = bytes({*range(0x20), 0x7F} - {*b"\t\n\f\r\x1b"})  # hardly any text has them
_PIECE = 4096  # bytes; with more a framer takes longer for each
_SETTINGS = LineSettings(baud=0)  # a log does not state the settings


def is_raw(beginning: bytes, framing: Cut) -> bool:
    """Tell whether a log is raw: more telegrams are found in its bytes than in its text.

    Frames between silences need times, so a log of them is text.
    """
    if framing.framing == Framing.SILENCE or beginning == beginning.translate(None, CONTROLS):
        return False
    return _telegrams(beginning, RawCutter(framing), RawReader(), framing) > _telegrams(
        beginning, LineCutter(), AnyReader([*lines([beginning])], framing), framing
    )


def _telegrams(beginning: bytes, cutter: Cutter, reader: LogReader, framing: Cut) -> int:
    """Count good telegrams. Handshakes of 3964R are any control characters."""
    passage = Passage(reader, framing=framing)
    cuts = [cut for line in (*cutter.feed(beginning), *cutter.end()) for cut in passage.feed(line).cuts]
    return sum(cut.record.is_good_frame and not cut.record.is_handshake for cut in cuts + passage.end())


class RawCutter:
    """Cuts pieces of a raw log into lines, one for each record."""

    def __init__(self, framing: Cut) -> None:
        """Nothing has come yet; `framing` says what a frame is."""
        self._framer = framing.framer(SHARED, _SETTINGS)
        self._number = 0

    def feed(self, piece: bytes) -> Iterator[LogLine]:
        """Take the next bytes; return the lines that they complete."""
        if not self._number and (heading := _HEADING.match(piece)):
            yield self._line(heading[0].decode().rstrip())
            piece = piece[heading.end() :]
        for start in range(0, len(piece), _PIECE):
            data = piece[start : start + _PIECE]
            yield from self._lines(self._framer.feed(Read(SHARED, 0, data, bytes([Flag.INTERVAL_UNKNOWN]) * len(data))))

    def end(self) -> Iterator[LogLine]:
        """Yield what is left."""
        yield from self._lines(self._framer.flush())

    def _lines(self, records: list[Record]) -> Iterator[LogLine]:
        return (self._line(record.data.hex(" ").upper()) for record in records)

    def _line(self, text: str) -> LogLine:
        self._number += 1
        return LogLine(self._number, text.encode(), b"\n", text, "utf-8")


class RawReader:
    """Reads the lines of a raw log."""

    notation = ""
    is_trusted = True

    def contents(self, line: LogLine) -> Contents:
        """Return all bytes of a line."""
        try:
            run = Run(0, len(line.text), PAIRS.name, line.text, bytes.fromhex(line.text))
        except ValueError:  # a heading
            return Contents([])
        return Contents([Piece(line, run, SHARED, None, continues=False)])
