# SPDX-License-Identifier: GPL-2.0-or-later
"""The log again, byte for byte, with a line under each telegram that explains it."""

from __future__ import annotations

import unicodedata
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from sistap.commands.annotate.cutting import PiecePart
from sistap.commands.annotate.textlog import LogLine
from sistap.dissected.explain.fields import EXPLANATION, Said, sentence

_WIDEST = 120  # a column further to the right is not aligned
_WAITING = 1000  # lines; one direction can be silent for the rest of the log


class Annotator(Protocol):
    """Takes lines and the explanations of their telegrams, and writes both in the order of the lines."""

    def add(self, line: LogLine, count: int) -> None:
        """Add the next line and the number of bytes that were found in it."""

    def explain(self, parts: list[PiecePart], said: Said) -> None:
        """Add the explanation of a telegram or of other characters, whose parts end in a line that was added."""

    def release(self, *, everything: bool = False) -> None:
        """Write the lines that wait for nothing more, or all lines."""

    def end(self, answer: Sequence[str] = ()) -> None:
        """Write the rest, then lines that say what happened in all of the log."""


@dataclass(slots=True, eq=False)
class Waiting:
    """A line whose bytes are not all explained."""

    line: LogLine
    unexplained: int  # bytes
    explanations: list[tuple[int, str]] = field(default_factory=list)  # column, text


class Waitings:
    """Waiting lines, in their order."""

    def __init__(self) -> None:
        self._queue: deque[Waiting] = deque()
        self._by_line: dict[int, Waiting] = {}
        self._advised: set[str] = set()

    def add(self, line: LogLine, count: int) -> None:
        """Make a line wait for this many bytes."""
        waiting = Waiting(line, count)
        self._queue.append(waiting)
        self._by_line[line.number] = waiting

    def take(self, parts: list[PiecePart]) -> Waiting | None:
        """Count newly explained bytes; return the line where they end, None if it is written already."""
        waiting = None
        for piece, first, end in parts:
            waiting = self._by_line.get(piece.line.number)
            if waiting:
                waiting.unexplained -= end - first
        return waiting

    def explanation(self, parts: list[PiecePart], said: Said, *, late: bool) -> str:
        """Explain a telegram, or other characters; `late`: its line is written already. The first one with a fault gets
        a second line, which says what to do.
        """
        stamp = parts[0].piece.stamp
        text = _note(parts, late=late) + sentence(said, stamp.resolution_ns if stamp else None)
        if not said.advice or said.advice in self._advised:
            return text
        self._advised.add(said.advice)
        return f"{text}\n{said.advice}"

    def last(self) -> Waiting | None:
        """Return the newest line."""
        return self._queue[-1] if self._queue else None

    def release(self, *, everything: bool = False) -> Iterator[Waiting]:
        """Yield the lines that wait for nothing more, or all. If too many wait, the first must go, too.

        A line without an ending stays until the end: nothing can be written after it.
        """
        while self._queue and self._queue[0].line.ending:
            if not everything and self._queue[0].unexplained and len(self._queue) <= _WAITING:
                break
            yield self._pop()

    def rest(self) -> Iterator[Waiting]:
        """Yield all lines that are left at the end."""
        while self._queue:
            yield self._pop()

    def _pop(self) -> Waiting:
        waiting = self._queue.popleft()
        del self._by_line[waiting.line.number]
        return waiting


class TextAnnotator:
    """Writes text. Without the added lines it equals the input."""

    def __init__(self, write: Callable[[bytes], object]) -> None:
        self._write = write
        self._waitings = Waitings()
        self._ending = b""  # of the first line
        self._last: LogLine | None = None

    def add(self, line: LogLine, count: int) -> None:
        """Take the next line."""
        self._ending = self._ending or line.ending or line.encode("\n")
        self._last = line
        self._waitings.add(line, count)

    def explain(self, parts: list[PiecePart], said: Said) -> None:
        """Put it below its line; if that is written already, below the newest."""
        waiting = self._waitings.take(parts)
        text = self._waitings.explanation(parts, said, late=waiting is None)
        if waiting:
            waiting.explanations.append(place(parts, text))
        elif newest := self._waitings.last():
            newest.explanations.append((0, text))
        else:
            line = parts[-1].piece.line
            for one in text.split("\n"):
                self._write(line.encode(EXPLANATION + one) + self._ending)

    def release(self, *, everything: bool = False) -> None:
        """Write lines with their explanations."""
        for waiting in self._waitings.release(everything=everything):
            self._write(self._lines(waiting))

    def end(self, answer: Sequence[str] = ()) -> None:
        """Write the rest, then the answer."""
        for waiting in self._waitings.rest():
            self._write(self._lines(waiting))
        last = self._last
        for said in (last.encode(EXPLANATION + text) for text in answer) if last else ():
            self._write(said + self._ending if last and last.ending else self._ending + said)

    def _lines(self, waiting: Waiting) -> bytes:
        line = waiting.line
        ending = line.ending or self._ending
        parts = [line.raw]
        for column, text in sorted(waiting.explanations):
            for one in text.split("\n"):
                parts += [ending, line.encode(indent(line.text, column) + EXPLANATION + one)]
        return b"".join([*parts, line.ending])


def _note(parts: list[PiecePart], *, late: bool) -> str:
    """Return a note that names its lines, if the reader cannot see which they are."""
    first, last = parts[0].piece.line.number, parts[-1].piece.line.number
    if first != last:
        return f"(lines {first} to {last}) "
    return f"(line {first}) " if late else ""


def place(parts: list[PiecePart], text: str) -> tuple[int, str]:
    """Return the column of its first byte in the line where it ends, and the text."""
    piece, first, _ = parts[-1]
    column = piece.run.start if first == 0 else piece.spans[first][0]
    return (column, text) if column <= _WIDEST else (column, f"(column {column + 1}) {text}")


def indent(text: str, column: int) -> str:
    """Return spaces and tabs up to a column."""
    if column > _WIDEST:
        return ""
    before = text[:column]
    if before.isascii() and "\t" not in before:  # as nearly always
        return " " * len(before)
    return "".join(map(_blank, before))


def _blank(character: str) -> str:
    if character == "\t":
        return character
    return "  " if unicodedata.east_asian_width(character) in "WF" else " "
