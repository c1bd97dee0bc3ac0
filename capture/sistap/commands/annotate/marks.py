# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds who sent the bytes: the marks by which programs tell the two directions of a line apart."""

from __future__ import annotations

import re
from functools import lru_cache

# The line numbers of the record (plugin/docs/record.md).
SHARED, RECEIVED, SENT = 0, 1, 2

_WORDS = {
    SENT: "tx txd snd send sent sending transmit transmitted out outbound outgoing write written wrote wr w o req "
    "request gesendet senden sende anfrage 发",
    RECEIVED: "rx rxd rcv recv rcvd receive received receiving in inbound incoming read rd r i rsp resp response reply "
    "answer empfangen empfang empfange antwort 收",
}
_ARROWS = {SENT: "→ -> --> => ==> >> >>> >", RECEIVED: "← <- <-- <= <== << <<< <"}

_LINE_OF = {mark: line for table in (_WORDS, _ARROWS) for line, marks in table.items() for mark in marks.split()}
MASK = "\u3164"  # replaces recognised text. It is in no log, and it is part of a word, so no bytes begin behind it

_NAMES = sorted(" ".join(_WORDS.values()).split(), key=len, reverse=True)
_WORD = "|".join(name for name in _NAMES if len(name) > 1)
_LETTER = "".join(name for name in _NAMES if len(name) == 1 and name.isascii())
_ARROW = "|".join(re.escape(arrow) for arrow in sorted(" ".join(_ARROWS.values()).split(), key=len, reverse=True))
_ARROW = rf"(?:{_ARROW})(?=[\s\]:◇◆]|$)"

# A word may be joined to others, as in "IRP_MJ_READ" or "readyRead", or be followed by a port number, as in "RX1",
# or by an arrow, which means less. A letter stands directly in front of the bytes: elsewhere, I and W are levels of a
# log. An arrow is not part of a bracket around the data.
_MARK = re.compile(
    rf"(?:(?<![^\W_{MASK}])(?<![</-])|(?<=[a-z])(?=[A-Z]))(?i:({_WORD}))\d?(?![^\W_{MASK}]|/)(?:\s*{_ARROW})?"
    rf"|(?<![^\W_{MASK}])(?:(?<![<>=-])(?i:([{_LETTER}]))(?! *\()(?=[\W\d{MASK}]*$)"
    rf"|(?<![<>=\"'/-])({_ARROW})(?! *\())|(发|收)"
)

_BEGINS = re.compile(rf"(?:^|[:)>|\]{MASK}])\s*[A-Za-z]*$")
_NEAR = 40  # characters: a line can be long

# If two ports were tapped, their names are the marks.
PORT = re.compile(r"(?<![\w/])(?:/dev/[\w./-]+|(?i:COM)\d+|tty[A-Z]+\d+)(?![\w/])")


class Marks:
    """Finds the marks of one log. Two ports are told apart by their order: the first is line 1, the second line 2."""

    def __init__(self) -> None:
        self._ports: dict[str, int] = {}

    def note(self, text: str) -> None:
        """Note the ports in a text. A single one tells nothing about who sent."""
        for port in PORT.findall(text):
            self._ports.setdefault(port, len(self._ports) + 1)

    def find(self, text: str) -> tuple[int, int, int] | None:
        """Find the last mark in a text; return its line, and where it begins and ends."""
        if mark := _last_mark(text):
            return mark
        self.note(text)
        if len(self._ports) > 1 and (port := PORT.search(text)):
            number = self._ports[port[0]]
            return (number if number <= SENT else SHARED), port.start(), port.end()
        return None


# The texts in front of the bytes of a log repeat, once their stamps are masked.
@lru_cache(256)
def _last_mark(text: str) -> tuple[int, int, int] | None:
    last = None
    for match in _MARK.finditer(text):
        last = match
    return (_line(last), *last.span(last.lastindex or 0)) if last else None


def _line(match: re.Match[str]) -> int:
    return _LINE_OF[match[match.lastindex or 0].lower()]


def joined(text: str) -> int | None:
    """Find the first mark that is joined to other words, as in "IRP_MJ_READ". Other text has such marks in any
    sentence.
    """
    for match in _MARK.finditer(text) if "_" in text else ():
        if "_" in text[match.start() - 1 : match.start()] + text[match.end() : match.end() + 1]:
            return _line(match)
    return None


def beginning(text: str) -> int | None:
    """Find the first mark that begins a text, or a part of it: "[1] port: read request"."""
    found = (one for one in _MARK.finditer(text) if _BEGINS.search(text, max(0, one.start() - _NEAR), one.start()))
    return next(map(_line, found), None)


def without(text: str) -> str:
    """Return a text without its marks."""
    return _MARK.sub(" ", text)


def direction(mark: str) -> int | None:
    """Return the direction of a mark that stands alone; None if it is none. It may be I, O, < or > of text2pcap."""
    return _LINE_OF.get(mark.strip().strip("[]():").lower())
