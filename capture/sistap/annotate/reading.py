# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds what a line of a log holds: bytes, their time and their sender.

The name of the program does not matter. Each line is taken apart in the same order: time stamps, the offset of a dump,
bytes, the direction mark in front of them. What a line does not state is carried over from the line before.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

from sistap.annotate import hexadecimal, marks
from sistap.annotate.hexadecimal import Run
from sistap.annotate.marks import MASK, PORT, Marks
from sistap.annotate.stamps import Stamp, Stamped, TimestampParser
from sistap.annotate.textlog import LogLine
from sistap.explain.fields import EXPLANATION

# Lines that annotate or log added, after spaces, are never read.
_EXPLANATION = re.compile(rf"\s*{re.escape(EXPLANATION)}")
# In front of the bytes of a dump: "0010:", "12)", or a number without a mark that advances in steps of eight.
_OFFSET = re.compile(r"(?:(?:0x)?[0-9A-Fa-f]{1,8} ?[:)](?=\s)|(0[0-9A-Fa-f]{3,7})(?=\s+[0-9A-Fa-f]{2}\b))")
_LAST_OFFSET = re.compile(r"\s*[0-9A-Fa-f]{6,8}\s*$")
_BRACKETS = "<[({"  # directly in front of bytes these are not marks
_MASKED = re.compile(rf"\A.*{MASK}\w*")
# In front of an offset, after the stamps: nothing, or a word such as "TX".
_LEAD = re.compile(r"\s*(?:[\[(]?[A-Za-z]+[\])]?:?\s+)?")
_COLOUR = re.compile(r"\x1b\[[\d;]*[A-Za-z]")  # of a terminal
_LABEL = re.compile(r"(?i)\b(?:hex|data|daten|payload|d?word|byte)\b")
_COUNT = re.compile(r"[\[(]\d+[\])](?=:|\s+\w)|(?<=\w)\[\d+\](?!\s*\[)")
_COUNT_IN_WORDS = re.compile(
    r"(?i)\b(?:len|length|count|size|dlc)\b\s*[:=]?\s*\d+|\b\d+ ?(?:bytes?|characters?|chars?|zeichen)\b"
)
# Each of its words has one of these. They are quick to find, and hardly any line has one.
_IN_COUNTS = ("len", "count", "ze", "dlc", "byte", "char")
# What a line is set to: COM3: 9600,e,8,1 or 19200 8E1.
_SETTINGS = re.compile(
    rf"(?i)(?:(?:{PORT.pattern})[\s:,(]*)?(?<!\w)(?:[36]|12|24|48|96|144|192|288|384|576|1152|2304|4608|9216)00"
    r"(?: ?(?:bd|baud|bps))?[\s,/-]{1,3}(?:[neoms][\s,/-]{0,2}[5-8]|[5-8][\s,/-]{0,2}[neoms])[\s,/-]{0,2}[12]"
    r"(?:\.5)?(?!\w)"
)
# Where a Siemens control has data: %DB10.DBB 0, DW 5, MB12. A data block or an index in front of bytes.
_TWO_BYTES = r"\s+[0-9A-Fa-f]{2}\s+[0-9A-Fa-f]{2}\b"
_ADDRESS = re.compile(
    r"(?<![\w.#$])(?:"
    rf"%?(?:D[BIX] *\d{{1,5}}\.)?(?:DB[BDWX]|D[LRW]|[IMPQ][BDW])(?:\d{{1,5}}| +\d{{1,5}}(?!{_TWO_BYTES}))(?:\.\d)?"
    rf"|DB\d{{1,5}}(?=:?{_TWO_BYTES})"
    r"|\d+(?=\s+(?:0[xX]|\$|&[hH]|(?:\w+#)?16#))"
    r")(?![\w.])"
)
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

    def contents(self, line: LogLine) -> Contents:
        """Find what a line holds."""


class State:
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


class AnyReader:
    """Reads lines of any form."""

    def __init__(self) -> None:
        self._timestamps = TimestampParser()
        self._marks = Marks()
        self._state = State()
        self._dumped = False  # whether the line before belonged to a dump
        self._style: tuple[str, ...] = ("",)  # style of the last bytes

    def contents(self, line: LogLine) -> Contents:
        """Find the bytes of a line."""
        text = line.text
        if is_explanation(text):
            return Contents([])
        if "\x1b" in text:
            text = _COLOUR.sub(lambda match: " " * len(match[0]), text)
        stamps = self._timestamps.find(text)
        masked = self._mask_offset(_mask_counts(_mask(text, stamps)), stamps)
        if not hexadecimal.is_plain(masked):
            masked = _mask_names(masked)
        found = hexadecimal.runs(masked, self._style)
        data = self._certain(masked, found)
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
            if mark := self._marks.find(masked[end : run.start].rstrip(_BRACKETS)):
                state.direction = mark[0]
            pieces.append(state.piece(line, run))
            end = run.end
        return Contents(pieces, _foreign(masked, found, data) if len(found) > 1 else "")

    def _certain(self, masked: str, found: list[Run]) -> list[Run]:
        """Return the runs that are certainly bytes: by themselves, or because the line has nothing else."""
        certain = [run for run in found if run.certain]
        if len(found) == 1:
            data = certain or [
                run for run in found if _is_clean(masked[: run.start]) and run.is_possible(self._style[0])
            ]
        elif certain:
            data = self._alike(masked, found, certain)
        else:
            gaps = [*_gaps(masked, found)]
            data = [run for run in found if run.is_possible(self._style[0])] if all(map(_is_clean, gaps)) else []
        if data:
            self._style = data[-1].style
        return data

    def _alike(self, masked: str, found: list[Run], certain: list[Run]) -> list[Run]:
        """Return the runs in the style of this log's bytes. Numbers beside them are counters or names.

        A few bytes need a mark in front of them, or a time in front and nothing behind.
        """
        before = [*_gaps(masked, found)]
        behind = [*before[1:], masked[found[-1].end :]]
        marked = {run for run, gap in zip(found, before, strict=True) if _is_marked(gap)}
        timed = {
            run
            for run, gap, rest in zip(found, before, behind, strict=True)
            if MASK in gap and not _has_words(gap) and not _has_words(rest)
        }
        style = max(certain, key=lambda run: (run.style == self._style, run in marked, len(run.data))).style
        return [
            run
            for run in found
            if run.style == style and (run.certain or (run in marked | timed and run.is_possible(style[0])))
        ]

    def _mask_offset(self, text: str, stamps: list[Stamped]) -> str:
        """Mask the offset of a dump, also the one that ends it."""
        match = _OFFSET.match(text, len(text) - len(text.lstrip()))
        if not match and (lead := _LEAD.match(text, stamps[-1].end if stamps else 0)):
            match = _OFFSET.match(text, lead.end())
        if self._dumped and not match:
            match = _LAST_OFFSET.match(text)
        self._dumped = match is not None and not (match.lastindex and int(match[1], 16) % 8)
        if not match or not self._dumped:
            return text
        return text[: match.start()] + MASK * (match.end() - match.start()) + text[match.end() :]

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

    def _marked(self, text: str, *, shows: bool = False) -> int | None:
        """Return the direction of a text that says nothing else. With `shows`, characters may follow an arrow."""
        mark = self._marks.find(text)
        if not mark:
            return None
        line, start, end = mark
        if _has_letters(text[:start]):
            return None
        is_word = text[start:end].isalnum() and text[start:end].isascii()
        rest = marks.PORT.sub("", _LABEL.sub("", text[end:]))
        return None if _has_words(rest) and (is_word or not shows) else line


def _mask(text: str, stamps: list[Stamped]) -> str:
    parts = []
    end = 0
    for stamped in stamps:
        parts += [text[end : stamped.start], MASK * (stamped.end - stamped.start)]
        end = stamped.end
    return "".join([*parts, text[end:]]) if parts else text


def _mask_counts(text: str) -> str:
    lower = text.lower()
    if any(part in lower for part in _IN_COUNTS):
        text = _COUNT_IN_WORDS.sub(_masked, text)
    return _COUNT.sub(_masked, text)


def _mask_names(text: str) -> str:
    """Mask settings of the line, and addresses in a control."""
    return _ADDRESS.sub(_masked, _SETTINGS.sub(_masked, text))


def _masked(match: re.Match[str]) -> str:
    return MASK * len(match[0])


def _gaps(text: str, found: list[Run]) -> Iterator[str]:
    """Yield the text before and between runs."""
    end = 0
    for run in found:
        yield text[end : run.start]
        end = run.end


def _has_words(text: str) -> bool:
    return any(character.isalnum() and character.isascii() for character in text)


def _has_letters(text: str) -> bool:
    return any(character.isalpha() and character.isascii() for character in text)


def _is_marked(gap: str) -> bool:
    """Tell whether a direction mark stands directly in front of bytes."""
    gap = gap.rstrip(_BRACKETS)
    mark = Marks().find(gap)
    return mark is not None and not _has_words(_LABEL.sub("", gap[mark[2] :]))


def _is_clean(gap: str) -> bool:
    """Tell whether nothing but stamps, marks and labels stands in front of bytes."""
    rest = _LABEL.sub("", _MASKED.sub("", gap, count=1))
    return not _has_words(rest) or _is_marked(rest)


def _trouble(masked: str) -> str:
    """Return why a line that should have bytes has none; empty if it need not have any."""
    if _TEXT.search(masked):
        return "characters are shown as text, which loses most of them: log in hexadecimal"
    if hexadecimal.BITS.search(masked):
        return "bytes are shown as bits: log in hexadecimal"
    if odd := _ODD.search(masked):
        return f"an odd number of hexadecimal digits ({len(odd[0])})"
    return ""


def _foreign(masked: str, found: list[Run], data: list[Run]) -> str:
    """Name text between bytes that is not a byte."""
    for before, after in zip(found, found[1:], strict=False):
        gap = masked[before.end : after.start].strip()
        is_short = re.fullmatch(r"\w{1,3}", gap) is not None
        if is_short and before.style == after.style and (before in data or after in data):
            return f"'{gap}' is not a byte"
    return ""
