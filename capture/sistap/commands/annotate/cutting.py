# SPDX-License-Identifier: GPL-2.0-or-later
"""Cuts the bytes of a log into telegrams with the framer of a capture, and remembers where in the log they stand.

The log limits how exact the times are. Its stamps advance in steps, and nothing tells whether a stamp belongs to the
first or the last character of a line. So the uncertainty is one step plus the time of the longest line at the slowest
rate.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from sistap.commands.annotate.reading import Piece
from sistap.tap.line import settings as serial
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag, LineSettings
from sistap.tap.records.cut import SIS, Cut
from sistap.tap.records.record import Record
from sistap.tap.sis.rates import RATES
from sistap.tap.sis.telegram import is_whole

_SETTINGS = LineSettings(baud=0)  # a log does not state the settings
_SLOWEST_CHARACTER_NS = LineSettings(min(RATES)).character_ns
_NEW_TIME_NS = 1_000_000_000  # a clock that goes back by more than this starts again


class PiecePart(NamedTuple):
    """Bytes of a piece, from `first` up to but not including `end`."""

    piece: Piece
    first: int
    end: int

    @property
    def data(self) -> bytes:
        """Return the bytes."""
        return self.piece.run.data[self.first : self.end]


class Pieces:
    """The pieces of one direction that are not in a record yet, in order."""

    def __init__(self) -> None:
        self._parts: deque[PiecePart] = deque()

    def add(self, piece: Piece) -> None:
        """Take the next piece."""
        self._parts.append(PiecePart(piece, 0, len(piece.run.data)))

    def take(self, count: int) -> list[PiecePart]:
        """Remove the next bytes and return where they stand."""
        parts = []
        while count:
            piece, first, end = self._parts.popleft()
            taken = min(count, end - first)
            parts.append(PiecePart(piece, first, first + taken))
            if first + taken < end:
                self._parts.appendleft(PiecePart(piece, first + taken, end))
            count -= taken
        return parts


class LogRecord(NamedTuple):
    """A record, and the bytes of the log that it is made of."""

    record: Record
    parts: list[PiecePart]


class _Stream:
    """The bytes of one direction."""

    def __init__(self, direction: int, framing: Cut) -> None:
        self.framing = framing
        self.framer = framing.framer(direction, _SETTINGS)
        self.time_ns = 0
        self._pieces = Pieces()

    def add(self, piece: Piece, uncertainty_ns: int) -> tuple[serial.Read, list[LogRecord]]:
        """Take a piece; return it as a read, and what it completes."""
        count = len(piece.run.data)
        self._pieces.add(piece)
        if piece.stamp is None:
            flags = bytes([Flag.INTERVAL_UNKNOWN]) * count
        else:
            flags = bytes([Flag.SAME_READ if piece.continues else 0]) + bytes(count - 1)
            self.time_ns = piece.stamp.time_ns
        read = serial.Read(self.framer.line, self.time_ns, piece.run.data, flags, uncertainty_ns)
        # What a whole telegram follows is complete, or its end was lost.
        records = self.framer.flush() if self.framing == SIS and is_whole(piece.run.data) else []
        records += self.framer.feed(read)
        if not self.framer.empty:
            records += self.framer.settle()
        return read, self.cuts(records)

    def cuts(self, records: list[Record]) -> list[LogRecord]:
        return [LogRecord(record, self._pieces.take(len(record.data))) for record in records]


class RecordCutter:
    """Makes records of pieces. Each direction is cut by itself: a telegram goes one way only."""

    def __init__(self, framing: Cut = SIS) -> None:
        """Nothing has come yet; `framing` says what a frame is."""
        self._framing = framing
        self._streams: dict[int, _Stream] = {}
        self._longest = 0
        self.uncertainty_ns = 0  # of the worst time so far

    def feed(self, piece: Piece) -> list[LogRecord]:
        """Take what a line has; return what it completes. A second without a character completes a record, too."""
        self._longest = max(self._longest, len(piece.run.data))
        cuts = self._silent(piece)
        stream = self._streams.setdefault(piece.direction, _Stream(piece.direction, self._framing))
        read, completed = stream.add(piece, self._uncertainty_ns(piece))
        others = (other for other in self._streams.values() if other is not stream)
        return cuts + completed + [cut for other in others for cut in other.cuts(other.framer.beside(read))]

    def end(self) -> list[LogRecord]:
        """Return what is left at the end of the log."""
        return [cut for stream in self._streams.values() for cut in stream.cuts(stream.framer.flush())]

    def _uncertainty_ns(self, piece: Piece) -> int:
        if piece.stamp is None:
            return UNCERTAINTY_UNKNOWN
        ns = min(piece.stamp.resolution_ns + self._longest * _SLOWEST_CHARACTER_NS, UNCERTAINTY_UNKNOWN - 1)
        self.uncertainty_ns = max(self.uncertainty_ns, ns)
        return ns

    def _silent(self, piece: Piece) -> list[LogRecord]:
        """Return what no longer waits for its rest, in both directions. The time can also have been set back."""
        cuts = []
        if piece.stamp:
            for direction, stream in list(self._streams.items()):
                pause_ns = piece.stamp.time_ns - stream.time_ns
                if pause_ns < -_NEW_TIME_NS:
                    cuts += stream.cuts(stream.framer.flush())
                    del self._streams[direction]
                elif not stream.framer.empty:
                    cuts += stream.cuts(stream.framer.idle(pause_ns - self._uncertainty_ns(piece)))
        return cuts
