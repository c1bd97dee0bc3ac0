# SPDX-License-Identifier: GPL-2.0-or-later
"""The lines of a log, as bytes to write again exactly and as text to read, in any encoding."""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Protocol

# UTF-16 only with a byte order mark, as Windows programs write it. Longer marks would come first.
_MARKS = {codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be", codecs.BOM_UTF8: "utf-8"}
_LONGEST_MARK = 3
UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_UTF_8, _LATIN_1, _GB = "utf-8", "latin-1", "gb18030"
_CHINESE = re.compile(rb"(?:[\x00-\x7f]|[\xa1-\xf7][\xa1-\xfe])+")


@dataclass(slots=True, eq=False)
class LogLine:
    """One line; `raw` + `ending` are its bytes, including a byte order mark."""

    number: int  # from 1
    raw: bytes
    ending: bytes  # empty at the end of a file without one
    text: str  # decoded raw
    encoding: str

    def encode(self, text: str) -> bytes:
        """Return text as bytes in the encoding of this line."""
        return text.encode(self.encoding, "backslashreplace")


class Cutter(Protocol):
    """Cuts pieces of a log into lines."""

    def feed(self, piece: bytes) -> Iterator[LogLine]:
        """Take the next bytes; return the lines that they complete."""

    def end(self) -> Iterator[LogLine]:
        """Yield what is left."""


class LineCutter:
    """Cuts pieces of a log into lines. If a line is not UTF-8, the rest of the log is Chinese if that line can be,
    otherwise Latin-1: hex is the same in all.
    """

    def __init__(self) -> None:
        self._rest = b""
        self._number = 0
        self._encoding = ""
        self._mark = b""

    def feed(self, piece: bytes) -> Iterator[LogLine]:
        """Take the next bytes; return the lines that they complete."""
        self._rest += piece
        if not self._encoding and len(self._rest) >= _LONGEST_MARK:
            self._recognize()
        if self._encoding:
            *whole, self._rest = self._split(self._rest)
            yield from map(self._line, whole)

    def end(self) -> Iterator[LogLine]:
        """Yield what is left: a last line without an ending."""
        if not self._encoding:
            self._recognize()
        *whole, last = self._split(self._rest)
        self._rest = b""
        yield from map(self._line, [*whole, last] if last else whole)

    def _recognize(self) -> None:
        for mark, encoding in _MARKS.items():
            if self._rest.startswith(mark):
                self._encoding, self._mark = encoding, mark
                return
        self._encoding = _UTF_8

    def _split(self, data: bytes) -> list[bytes]:
        """Split after each line ending; the last piece has none, and may be empty."""
        end = "\n".encode(self._encoding)
        if len(end) == 1:
            pieces = data.split(end)
            return [piece + end for piece in pieces[:-1]] + pieces[-1:]
        pieces, start, at = [], 0, data.find(end)
        while at >= 0:
            if at % 2 == 0:  # the same two bytes can be halves of two characters
                pieces.append(data[start : at + 2])
                start = at + 2
            at = data.find(end, at + 1)
        return [*pieces, data[start:]]

    def _line(self, data: bytes) -> LogLine:
        self._number += 1
        ending = b""
        for text in ("\r\n", "\n"):
            end = text.encode(self._encoding)
            if data.endswith(end):
                ending = end
                break
        raw = data[: len(data) - len(ending)]
        shown = raw.removeprefix(self._mark) if self._number == 1 else raw
        return LogLine(self._number, raw, ending, self._decode(shown), self._encoding)

    def _decode(self, data: bytes) -> str:
        try:
            return data.decode(self._encoding, "strict" if self._encoding == _UTF_8 else "replace")
        except UnicodeDecodeError:
            self._encoding = _GB if _CHINESE.fullmatch(data) else _LATIN_1
            return data.decode(self._encoding, "replace")


def lines(pieces: Iterable[bytes]) -> Iterator[LogLine]:
    """Yield all lines of a complete log."""
    cutter = LineCutter()
    for piece in pieces:
        yield from cutter.feed(piece)
    yield from cutter.end()
