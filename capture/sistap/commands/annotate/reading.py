# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds what a line of a log holds: bytes, their time and their sender.

The name of the program does not matter. Each line is taken apart in the same order: time stamps, the offset of a dump,
bytes, the direction mark in front of them. What a line does not state is carried over from the line before.
"""

from __future__ import annotations

import re
from collections import defaultdict, deque
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import NamedTuple, Protocol

from sistap.commands.annotate import marks
from sistap.commands.annotate.marks import MASK, PORT, Marks
from sistap.commands.annotate.notations import NOTATIONS, PAIRS, Notation, Numbers, Run, narrow, plain
from sistap.commands.annotate.stamps import Stamp, Stamped, TimestampParser
from sistap.commands.annotate.textlog import LogLine
from sistap.dissected.explain.fields import EXPLANATION

# Lines that annotate or log added, after spaces, are never read.
_EXPLANATION = re.compile(rf"\s*{re.escape(EXPLANATION)}")
_BRACKETS = "<[{"  # directly in front of bytes these are not marks; a letter in front of ( is none, either
_WAY_BACK = re.compile(r"IRP_MJ_WRITE\W+UP\b")  # Windows' drivers pass a request down, then up with the same bytes
_COLOUR = re.compile(r"\x1b\[[\d;]*[A-Za-z]")  # of a terminal
# What may stand beside a mark in a line of its own: its name, and a count.
_KEY = re.compile(r"(?<![A-Za-z])[A-Za-z]{1,20}\W{0,9}[:=]\W{0,9}")
_REST = re.compile(rf"(?i){PORT.pattern}|\b(?:hex|data|daten)\b|\b\d+ ?(?:bytes?|characters?|chars?|zeichen)\b")
_NEAR = 80  # characters in front of bytes tell which they are: a line can be long
_NUMBER = re.compile(rf"[^\W{MASK}]*\d[^\W{MASK}]*")
_GAP = re.compile(rf"[{MASK}\s]+")
_TEXT = re.compile(r"<(?:STX|NUL|SOH|ETX|EOT|ENQ|ACK|BEL|BS|DLE|ESC|CR|LF)>", re.IGNORECASE)
_ODD = re.compile(r"(?<!\w)(?:[0-9A-Fa-f]{2}){8,}[0-9A-Fa-f](?!\w)")


@dataclass(eq=False)
class Piece:
    """Consecutive bytes of one line."""

    line: LogLine
    run: Run
    direction: int  # SHARED, RECEIVED or SENT
    stamp: Stamp | None
    continues: bool  # the stamp belongs to the piece before

    @cached_property
    def spans(self) -> list[tuple[int, int]]:
        """Return where in the line each byte is written."""
        return self.run.spans()


def is_explanation(text: str) -> bool:
    """Tell whether a line was added by annotate or log."""
    return _EXPLANATION.match(text) is not None


class Contents(NamedTuple):
    """What was found in a line."""

    pieces: list[Piece]
    trouble: str = ""  # why some of it could not be read


class LogReader(Protocol):
    """Reads the lines of one log, in order."""

    @property
    def notation(self) -> str:
        """Name how the bytes are written, for a message; nothing if it is usual or known."""

    @property
    def is_trusted(self) -> bool:
        """Whether a damaged telegram is one, and not bytes of another protocol."""

    def contents(self, line: LogLine) -> Contents:
        """Find what a line holds."""


class Carried:
    """What is carried over from line to line."""

    def __init__(self) -> None:
        self.direction = marks.SHARED
        self.stamp: Stamp | None = None
        self._used: Stamp | None = None

    def piece(self, line: LogLine, run: Run) -> Piece:
        """Make a piece of bytes, with their time and sender as far as known."""
        continues = self.stamp is not None and self.stamp is self._used
        self._used = self.stamp
        return Piece(line, run, self.direction, self.stamp, continues)


ANYWHERE = "*"  # is no place: the numbers of such a notation are all bytes


class Choice(NamedTuple):
    """How a log writes bytes, and where."""

    notations: tuple[Notation, ...]
    places: frozenset[tuple[str, str]] = frozenset()  # notation, and what stands in front of a few bytes
    reads_few: bool = True  # a few bytes are read, too, if a line has nothing else
    name: str = ""  # for a message, if it is not the usual one

    def joined(self, other: Choice) -> Choice:
        """Return both."""
        notations = dict.fromkeys((*self.notations, *other.notations))
        name = "; ".join(dict.fromkeys(name for name in (self.name, other.name) if name))
        return Choice((*notations,), self.places | other.places, name=name)


ANYTHING = Choice(tuple(notation for notation in NOTATIONS if notation.is_plain))


class Prepared(NamedTuple):
    """A line without what is certainly not data."""

    line: LogLine
    masked: str
    stamps: list[Stamped]


class ChosenReader:
    """Reads the lines of a log whose notation is known."""

    def __init__(self, choice: Choice) -> None:
        """Read what this choice says."""
        self.choice = choice
        self._timestamps = TimestampParser()
        self.marks = Marks()
        self._state = Carried()
        self._above: int | None = None  # what the line directly above seems to say about the direction
        # By notation: what stood in front of bytes.
        self._places: defaultdict[str, set[str]] = defaultdict(set)

    def prepare(self, line: LogLine) -> Prepared | None:
        """Mask the stamps of a line; None if it repeats what others say."""
        text = narrow(line.text)
        if is_explanation(text) or ("IRP_MJ_" in text and _WAY_BACK.search(text)):
            return None
        if "\x1b" in text:
            text = _COLOUR.sub(lambda match: " " * len(match[0]), text)
        stamps = self._timestamps.find(text)
        return Prepared(line, _mask(text, stamps), stamps)

    def contents(self, line: LogLine) -> Contents:
        """Find the bytes of a line."""
        prepared = self.prepare(line)
        return self.read(prepared) if prepared else Contents([])

    def read(self, prepared: Prepared) -> Contents:
        """Find the bytes of a line."""
        line, masked, stamps = prepared
        data = self._data(masked)
        if not data:
            self._heading(masked, stamps)
            return Contents([], _trouble(masked))
        state = self._state
        if stamps and stamps[0].start > data[-1].start:
            state.stamp = stamps[0].stamp  # the stamp stands behind the bytes
        pieces = []
        end = 0
        left = deque(stamps)
        for run in data:
            while left and left[0].start < run.start:
                state.stamp = left.popleft().stamp
            if mark := self.marks.find(masked[end : run.start].rstrip(_BRACKETS)):
                state.direction = mark[0]
            elif self._above is not None:
                state.direction = self._above
            self._above = None
            pieces.append(state.piece(line, run))
            end = run.end
        return Contents(pieces, _foreign(masked, data) if len(data) > 1 else "")

    def _data(self, masked: str) -> list[Run]:
        """Return the bytes of a line, which are all in one notation."""
        notations = self.choice.notations
        if PAIRS in notations and (run := plain(masked)) and PAIRS.is_wide(run, masked):
            self._places[PAIRS.name].add(_place(masked[: run.start]))
            return [run]
        best: list[Run] = []
        for notation in notations:
            runs, end = notation.runs(masked)
            data = self._among(masked, notation, runs, end) if runs else []
            if sum(len(run.data) for run in data) > sum(len(run.data) for run in best):
                best = data
        return best

    def _among(self, masked: str, notation: Notation, runs: list[Run], end: int) -> list[Run]:
        """Return which of these are bytes: many side by side; a few where this log has bytes; or all of the line."""
        chosen = {place for name, place in self.choice.places if name == notation.name}
        if ANYWHERE in chosen:
            return runs
        known = self._places[notation.name]
        wide = [notation.is_wide(run, masked) for run in runs]
        is_looked = chosen or known or any(wide)
        places = [*places_of(masked, runs, wide)] if is_looked else [""] * len(runs)
        are_words = isinstance(notation, Numbers) and _has_letters(masked[runs[-1].end : end])
        new = {place for place, is_wide in zip(places, wide, strict=True) if is_wide}
        known |= new
        wanted = chosen | new if are_words else chosen | known
        found = [run for run, place in zip(runs, places, strict=True) if place in wanted]
        is_likely = isinstance(notation, Numbers) and self.choice.reads_few and not are_words
        return found or (runs if is_likely and _is_alone(masked, runs) else [])

    def _heading(self, masked: str, stamps: list[Stamped]) -> None:
        """Keep the time and sender that a line without bytes states for the following lines."""
        if stamps:
            self._state.stamp = stamps[-1].stamp
            direction = self._marked(masked[stamps[-1].end :], shows=True) or self._marked(masked[: stamps[0].start])
        else:
            if any(character.isdigit() for character in masked):
                self._timestamps.find_date(masked)
            direction = self._marked(masked)
        if direction := direction or marks.joined(masked):
            self._state.direction = direction
        if masked.strip():
            self._above = None if direction else marks.beginning(masked)

    def _marked(self, text: str, *, shows: bool = False) -> int | None:
        """Return the direction of a text that says nothing else. With `shows`, characters may follow an arrow."""
        mark = self.marks.find(text)
        if not mark:
            return None
        line, start, end = mark
        if _has_letters(_KEY.sub("", text[:start], count=1)):
            return None
        is_word = text[start:end].isalnum() and text[start:end].isascii()
        rest = _REST.sub("", text[end:])
        return None if _has_words(rest) and (is_word or not shows) else line


@lru_cache(256)  # the texts in front of the bytes of a log repeat, once their stamps are masked
def _place(before: str) -> str:
    """Return what stands in front of bytes, without its numbers, times and marks."""
    return _GAP.sub(" ", _NUMBER.sub("0", marks.without(before))).strip()[-_NEAR // 2 :]


def _mask(text: str, stamps: list[Stamped]) -> str:
    parts = []
    end = 0
    for stamped in stamps:
        parts += [text[end : stamped.start], MASK * (stamped.end - stamped.start)]
        end = stamped.end
    return "".join([*parts, text[end:]]) if parts else text


def places_of(masked: str, runs: list[Run], wide: list[bool]) -> Iterator[str]:
    """Yield what stands in front of each run. Other numbers and bytes there are like any number."""
    before, end = "", 0
    for run, is_wide in zip(runs, wide, strict=True):
        before = (before + masked[end : run.start])[-_NEAR:]
        yield _place(before)
        before, end = "0" if is_wide else f"{before}0", run.end


def _is_alone(masked: str, runs: list[Run]) -> bool:
    """Tell whether nothing but times and marks stands in front of bytes."""
    ends = [0, *(run.end for run in runs)]
    return not any(_has_words(marks.without(masked[end : run.start])) for end, run in zip(ends, runs, strict=False))


def _has_words(text: str) -> bool:
    return any(character.isalnum() and character.isascii() for character in text)


def _has_letters(text: str) -> bool:
    return any(character.isalpha() and character.isascii() for character in text)


def _trouble(masked: str) -> str:
    """Return why a line that should have bytes has none; empty if it need not have any."""
    if _TEXT.search(masked):
        return "characters are shown as text, which loses most of them: log in hexadecimal"
    if odd := _ODD.search(masked):
        return f"an odd number of hexadecimal digits ({len(odd[0])})"
    return ""


def _foreign(masked: str, data: list[Run]) -> str:
    """Name text between bytes that is not a byte."""
    for before, after in pairwise(data):
        gap = masked[before.end : after.start].strip()
        if re.fullmatch(r"\w{1,3}", gap):
            return f"'{gap}' is not a byte"
    return ""
