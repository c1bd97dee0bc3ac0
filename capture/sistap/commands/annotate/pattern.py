# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds what a line holds by a regular expression with the named groups of text2pcap."""

from __future__ import annotations

import re
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from sistap.commands.annotate import marks, notations
from sistap.commands.annotate.reading import Carried, Contents, is_explanation
from sistap.commands.annotate.stamps import TimestampParser
from sistap.commands.annotate.textlog import LogLine
from sistap.tap.terminal.exits import Refusal

LONGEST_S = 2.0  # for a line


@contextmanager
def _time_limit(line: LogLine) -> Iterator[None]:
    """Raise Refusal after LONGEST_S, if the system has timers: an expression can take years for a line."""
    if sys.platform == "win32" or threading.current_thread() is not threading.main_thread():
        yield
        return

    def give_up(*_: object) -> None:
        raise Refusal(f"line {line.number}: the expression takes longer than {LONGEST_S:g} s; make it simpler")

    before = signal.signal(signal.SIGALRM, give_up)
    signal.setitimer(signal.ITIMER_REAL, LONGEST_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


class PatternReader:
    """Reads lines by a regular expression with the groups of text2pcap: data, time and dir."""

    notation = ""
    is_trusted = True

    def __init__(self, pattern: str) -> None:
        """Compile the expression. ValueError says what is wrong with it."""
        try:
            self._pattern = re.compile(re.sub(r"\(\?<(?=[A-Za-z_])", "(?P<", pattern))
        except re.error as error:
            raise ValueError(f"'{pattern}' is not a regular expression: {error}") from None
        names = self._pattern.groupindex
        if "data" not in names:
            raise ValueError(f"'{pattern}' has no group (?<data>...) for the bytes")
        if unknown := names.keys() - {"data", "time", "dir"}:
            raise ValueError(f"'{pattern}': groups are data, time and dir, not {', '.join(sorted(unknown))}")
        self._timestamps = TimestampParser()
        self._state = Carried()

    def contents(self, line: LogLine) -> Contents:
        """Find the bytes of a line at each match of the expression. May raise Refusal."""
        pieces = []
        trouble = ""
        if not is_explanation(line.text):
            with _time_limit(line):
                matches = list(self._pattern.finditer(line.text))
            for match in matches:
                groups = match.groupdict()
                trouble = self._set(groups) or trouble
                try:
                    run = notations.parse(groups["data"] or "", match.start("data"))
                except ValueError as error:
                    trouble = str(error)
                else:
                    pieces.append(self._state.piece(line, run))
        return Contents(pieces, trouble)

    def _set(self, groups: dict[str, str | None]) -> str:
        """Take over time and direction; return what is wrong with them."""
        trouble = ""
        if time := groups.get("time"):
            stamps = self._timestamps.find(time)
            if stamps:
                self._state.stamp = stamps[0].stamp
            else:
                trouble = f"'{time}' is not a time"
        if mark := groups.get("dir"):
            line = marks.direction(mark)
            if line is None:
                return f"'{mark}' is not a direction"
            self._state.direction = line
        return trouble
