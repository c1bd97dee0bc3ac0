# SPDX-License-Identifier: GPL-2.0-or-later
"""Who sent: the marks by which programs tell the two directions of a line apart."""

from __future__ import annotations

import re

# The line numbers of the record (plugin/README.md).
SHARED, RECEIVED, SENT = 0, 1, 2

_WORDS = {
    SENT: "tx txd snd send sent sending transmit transmitted out outbound outgoing write wr w o req request "
    "gesendet senden sende 发",
    RECEIVED: "rx rxd rcv recv rcvd receive received receiving in inbound incoming read rd r i rsp resp response reply "
    "empfangen empfang empfange 收",
}
_ARROWS = {SENT: "→ -> --> => ==> >> >>> >", RECEIVED: "← <- <-- <= <== << <<< <"}

_LINE_OF = {mark: line for table in (_WORDS, _ARROWS) for line, marks in table.items() for mark in marks.split()}
_WORD = "|".join(sorted(" ".join(_WORDS.values()).split(), key=len, reverse=True))
_ARROW = "|".join(re.escape(arrow) for arrow in sorted(" ".join(_ARROWS.values()).split(), key=len, reverse=True))
# A word may have the number of a port behind it, as in "RX1"; an arrow is no part of a bracket around the data.
_MARK = re.compile(rf"(?<![\w<>=-])(?:(?i:({_WORD}))\d?(?!\w)|({_ARROW})(?=[\s\]:◇◆]|$))|(发|收)")

# Where two ports were tapped, their names are the marks.
_PORT = re.compile(r"(?<![\w/])(?:/dev/[\w./-]+|(?i:COM)\d+|tty[A-Z]+\d+)(?![\w/])")


class Marks:
    """Finds the marks of one log. Ports are told apart by their order: the first is line 1, the second line 2."""

    def __init__(self) -> None:
        """No port has been named."""
        self._ports: dict[str, int] = {}

    def find(self, text: str) -> tuple[int, int, int] | None:
        """Find the last mark in a text: its line, and where it begins and ends."""
        last = None
        for match in _MARK.finditer(text):
            last = match
        if last:
            return _LINE_OF[(last[1] or last[2] or last[3]).lower()], last.start(), last.end()
        port = _PORT.search(text)
        if port:
            number = self._ports.setdefault(port[0], len(self._ports) + 1)
            return (number if number <= SENT else SHARED), port.start(), port.end()
        return None


def direction(mark: str) -> int | None:
    """Read a mark that stands alone, None if it is none: also the I and O, < and > of text2pcap."""
    return _LINE_OF.get(mark.strip().strip("[]():").lower())
