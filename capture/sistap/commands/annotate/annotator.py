# SPDX-License-Identifier: GPL-2.0-or-later
"""The log again, byte for byte, with a line under each telegram that explains it."""

from __future__ import annotations

import unicodedata
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from sistap.commands.annotate.cutting import PiecePart
from sistap.commands.annotate.textlog import LogLine
from sistap.dissected.explain.fields import EXPLANATION, Said, sentence

_WIDEST = 120  # a column further to the right is not aligned
_WAITING = 1000  # lines; one direction can be silent for the rest of the log


@dataclass(slots=True, eq=False)
class Waiting:
    """A line whose bytes are not all explained."""

    line: LogLine
    unexplained: int  # bytes
    explanations: list[tuple[int, str]] = field(default_factory=list)  # column, text


class Annotator(ABC):
    """Takes lines and the explanations of their telegrams, and writes both in the order of the lines."""

    def __init__(self, write: Callable[[bytes], object]) -> None:
        self._write = write
        self._queue: deque[Waiting] = deque()
        self._by_line: dict[int, Waiting] = {}
        self._advised: set[str] = set()

    def add(self, line: LogLine, count: int) -> None:
        """Add the next line and the number of bytes that were found in it."""
        waiting = Waiting(line, count)
        self._queue.append(waiting)
        self._by_line[line.number] = waiting

    def explain(self, parts: list[PiecePart], said: Said) -> None:
        """Add the explanation of a telegram or of other characters, whose parts end in a line that was added. The first
        one with a fault gets a second line, which says what to do.
        """
        waiting = None
        for piece, first, end in parts:
            waiting = self._by_line.get(piece.line.number)
            if waiting:
                waiting.unexplained -= end - first
        stamp = parts[0].piece.stamp
        text = _note(parts, late=waiting is None) + sentence(said, stamp.resolution_ns if stamp else None)
        if said.advice and said.advice not in self._advised:
            self._advised.add(said.advice)
            text = f"{text}\n{said.advice}"
        if waiting:
            waiting.explanations.append(place(parts, text))
        else:
            self._explain_late(parts, text)

    def release(self, *, everything: bool = False) -> None:
        """Write the lines that wait for nothing more, or all. If too many wait, the first must go, too.

        A line without an ending stays until the end: nothing can be written after it.
        """
        while self._queue and self._queue[0].line.ending:
            if not everything and self._queue[0].unexplained and len(self._queue) <= _WAITING:
                break
            self._write_first()

    def end(self, answer: Sequence[str] = ()) -> None:
        """Write the rest, then lines that say what happened in all of the log."""
        while self._queue:
            self._write_first()
        self._write_answer(answer)

    def _write_first(self) -> None:
        waiting = self._queue.popleft()
        del self._by_line[waiting.line.number]
        self._write(self._shown(waiting))

    @abstractmethod
    def _shown(self, waiting: Waiting) -> bytes:
        """Return a line with its explanations."""

    @abstractmethod
    def _explain_late(self, parts: list[PiecePart], text: str) -> None:
        """Add an explanation whose line is written already."""

    @abstractmethod
    def _write_answer(self, answer: Sequence[str]) -> None:
        """Write what happened in all of the log."""


class TextAnnotator(Annotator):
    """Writes text. Without the added lines it equals the input."""

    def __init__(self, write: Callable[[bytes], object]) -> None:
        super().__init__(write)
        self._ending = b""  # of the first line
        self._last: LogLine | None = None

    def add(self, line: LogLine, count: int) -> None:
        """Take the next line."""
        self._ending = self._ending or line.ending or line.encode("\n")
        self._last = line
        super().add(line, count)

    def _explain_late(self, parts: list[PiecePart], text: str) -> None:
        if self._queue:
            self._queue[-1].explanations.append((0, text))
        else:
            line = parts[-1].piece.line
            for one in text.split("\n"):
                self._write(line.encode(EXPLANATION + one) + self._ending)

    def _write_answer(self, answer: Sequence[str]) -> None:
        last = self._last
        for said in (last.encode(EXPLANATION + text) for text in answer) if last else ():
            self._write(said + self._ending if last and last.ending else self._ending + said)

    def _shown(self, waiting: Waiting) -> bytes:
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
