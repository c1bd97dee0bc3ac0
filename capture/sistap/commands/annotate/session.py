# SPDX-License-Identifier: GPL-2.0-or-later
"""A session of the ASCII protocol as a terminal program shows or logs it: each line is characters of the line.

A time may stand in front of them, and a word or an arrow that says who sent them.
"""

from __future__ import annotations

import re

from sistap.commands.annotate import marks
from sistap.commands.annotate.notations import Run
from sistap.commands.annotate.reading import Carried, Contents, is_explanation
from sistap.commands.annotate.stamps import TimestampParser
from sistap.commands.annotate.textlog import LogLine, lines

_PROTOCOL = re.compile(r"BCD:\d|E\d{1,3}:>|[SP]-[0-7]-\d{4}(?:\.\d+\.\d+)?,[1-7],[RrWw]")
_PROMPT = re.compile(r"E\d{1,3}:>|\?")  # complete without an end
_MARK = re.compile(r"[\])]?[\s:]*(?:[\[(]?([A-Za-z]+|[<>=-]{1,4})[\])]?:?\s+)?")


def is_session(beginning: bytes) -> bool:
    """Tell whether a log has lines of the ASCII protocol in plain text."""
    return any(_PROTOCOL.search(line.text) for line in lines([beginning]))


class SessionReader:
    """Reads the lines of a session."""

    notation = ""
    is_trusted = True

    def __init__(self) -> None:
        """Nothing has come yet."""
        self._timestamps = TimestampParser()
        self._state = Carried()

    def contents(self, line: LogLine) -> Contents:
        """Return the characters of a line, and its end, which the log shows as a new line."""
        text = line.text
        if is_explanation(text):
            return Contents([])
        start = self._start(text)
        said = text[start:]
        if not said.strip():
            return Contents([])
        end = "" if _PROMPT.fullmatch(said) else "\r\n" if line.ending else "\r"
        data = (said + end).encode("latin-1", "replace")
        return Contents([self._state.piece(line, Run(start, len(text), "characters", said, data))])

    def _start(self, text: str) -> int:
        """Return where the characters begin; note the time and the sender in front of them."""
        start = 0
        stamps = self._timestamps.find(text) if ":" in text else []
        if stamps and ":" in text[stamps[0].start : stamps[0].end] and not text[: stamps[0].start].strip(" \t[("):
            self._state.stamp = stamps[0].stamp
            start = stamps[0].end
        found = _MARK.match(text, start)
        direction = marks.direction(found[1]) if found and found[1] else None
        if found and direction is not None:
            self._state.direction = direction
            return found.end()
        return start + len(text[start:]) - len(text[start:].lstrip(" \t])")) if start else 0
