# SPDX-License-Identifier: GPL-2.0-or-later
"""Counters of a capture, for the progress line, the hints and the statistics of the file."""

from __future__ import annotations

from collections import Counter

from sistap.tap.line.drivers import NOT_REPORTED
from sistap.tap.line.settings import ERROR_FLAGS, Flag, Read
from sistap.tap.records.framer import ASCII_WORD
from sistap.tap.records.record import Framing, Record, Type, interval_text
from sistap.tap.sis.telegram import START

_IS_ERROR = bytes(bool(flag & ERROR_FLAGS) for flag in range(256))
_IS_BREAK = bytes(bool(flag & Flag.BREAK) for flag in range(256))
_IS_SOMEWHERE = bytes(bool(flag & Flag.UNLOCATED_ERROR) for flag in range(256))
_IS_GAP = bytes(bool(flag & Flag.LOST_BEFORE) for flag in range(256))


def longest_interval_ns(record: Record) -> int:
    """Return the longest interval inside a frame; the one before its first character does not count."""
    return max(record.intervals[1:], default=0)


def faulty(read: Read | Record) -> int:
    """Count the characters with any error, breaks included."""
    return sum(read.flags.translate(_IS_ERROR))


def surely_faulty(read: Read) -> int:
    """Count the characters with an error; an error with unknown place counts once."""
    somewhere = sum(read.flags.translate(_IS_SOMEWHERE))
    return faulty(read) - somewhere + bool(somewhere)


class Counters:
    """All counts since the capture started."""

    def __init__(self) -> None:
        self.characters = 0
        self.faulty_characters = 0  # with any error, breaks included
        self.breaks = 0
        self.telegrams = 0  # good ones; of 3964R, blocks and not handshakes
        self.pieces = 0  # other characters with a start character, as of telegrams without some characters
        self.damaged = 0  # telegrams with a wrong checksum
        self.longest_ns = 0  # longest interval inside any of these
        self.ascii_between = False  # whether words of the ASCII protocol were between telegrams of SIS
        # For each line, for its interface statistics:
        self.received: Counter[int] = Counter()  # records that the framer made
        self.accepted: Counter[int] = Counter()  # those that were written
        self.gaps: Counter[int] = Counter()  # places where characters were lost
        self.errors_reported = True  # whether an adapter reports line errors at all

    @property
    def written(self) -> int:
        """Return the number of records written, of all lines."""
        return self.accepted.total()

    @property
    def text(self) -> str:
        """Return telegrams and characters in words, counted as `sistap report` counts them."""
        faulty = f"{self.faulty_characters} faulty character{'' if self.faulty_characters == 1 else 's'}"
        if not (self.errors_reported or self.faulty_characters):
            faulty = NOT_REPORTED
        telegrams = f"{self.telegrams + self.damaged} telegrams, {self.damaged} of them damaged"
        return f"{telegrams}, {self.characters} characters, {faulty}"

    def add_read(self, read: Read | Record) -> None:
        """Count the characters of a read, or of a record."""
        self.characters += len(read.flags)  # each has one; the text of an event has none
        flags = read.flags
        if any(flags):
            self.faulty_characters += faulty(read)
            self.breaks += sum(flags.translate(_IS_BREAK))
            self.gaps[read.line] += sum(flags.translate(_IS_GAP))

    def add_record(self, record: Record, *, written: bool = True) -> None:
        """Count a record that the framer made, and whether it was written. An event does not count."""
        if record.type == Type.EVENT:
            return
        self.received[record.line] += 1
        self.accepted[record.line] += written
        if record.type == Type.FRAME and not record.is_handshake:
            self.telegrams += not record.checksum_bad
            self.damaged += record.checksum_bad
            self.longest_ns = max(self.longest_ns, longest_interval_ns(record))
        elif record.type == Type.OTHER and record.framing == Framing.SIS:
            self.pieces += START in record.data
            self.ascii_between = self.ascii_between or ASCII_WORD.search(record.data) is not None

    def __str__(self) -> str:
        longest = interval_text(self.longest_ns) if self.longest_ns else "not known"
        return f"{self.text}, longest interval {longest}"
