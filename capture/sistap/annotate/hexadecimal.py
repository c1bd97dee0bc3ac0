# SPDX-License-Identifier: GPL-2.0-or-later
"""Bytes in the text of a log: pairs of hex digits in all the ways in which programs write them, or decimal triples."""

from __future__ import annotations

import re
from typing import NamedTuple

_PAIR = r"(?:0[xX]|\$|16#|%|&[hH])?[0-9A-Fa-f]{1,2}[hH]?"
_BETWEEN = r"(?:\s*[,;|]\s*|\s+|[:-]|[>\])}]\s*[<\[({](?=(?:0[xX])?[0-9A-Fa-f]{2}\b))"
_GROUP = r"(?:[0-9A-Fa-f]{2}){2,}"
_FORMS = (
    r"(?P<decimal>\d{3}(?:[\s,;]+\d{3})*)",  # 002 225 005 005
    r"(?P<escaped>(?:\\x[0-9A-Fa-f]{2})+)",  # \x02\xE1
    rf"(?P<groups>(?:0[xX])?{_GROUP}(?:[ \t]+{_GROUP})*(?:[ \t]+[0-9A-Fa-f]{{2}})?)",  # 02E10505 or 02e1 0505 02
    rf"(?P<pairs>{_PAIR}(?:{_BETWEEN}{_PAIR})*)",  # 02 E1, 0x02,0xE1, 02h E1h, <02><E1>, 2 E1
)
_RUN = re.compile(rf"(?<![\w.#$\\/+])(?:{'|'.join(_FORMS)})(?!\w|\.\d)")
_BYTE = {
    "decimal": re.compile(r"(\d{3})"),
    "escaped": re.compile(r"\\x(..)"),
    "groups": re.compile(r"(?:\b0[xX])?([0-9A-Fa-f]{2})"),
    "pairs": re.compile(r"(?:0[xX]|\$|16#|%|&[hH])?([0-9A-Fa-f]{1,2})[hH]?"),
}
_PLAIN = re.compile(r"[0-9A-Fa-f]{2}(?:\s+[0-9A-Fa-f]{2})*")

BITS = re.compile(r"[01]{8}(?:\s+[01]{8})+")

# Fewer bytes than these, among other words, may be words and numbers themselves.
_ENOUGH = {"decimal": 4, "escaped": 1, "groups": 8, "pairs": 4}
_WIDEST = 256  # bytes in a line of a dump
_BORDERS = 6  # characters around the column
_COLUMN = re.compile(r"(?: {2,}|\t|[ \t]*\||[ \t]+(?=['\"*]))['\"*|]?")


class Run(NamedTuple):
    """Bytes that are written in one go, and the place of this text in its line."""

    start: int
    end: int
    form: str
    text: str
    data: bytes

    def spans(self) -> list[tuple[int, int]]:
        """Say where in the line each byte is written."""
        return [
            (self.start + match.start(), self.start + match.end()) for match in _BYTE[self.form].finditer(self.text)
        ]

    @property
    def certain(self) -> bool:
        """Whether this can hardly be anything but bytes, whatever stands beside it."""
        return len(self.data) >= _ENOUGH[self.form]

    def is_possible(self, form: str) -> bool:
        """Tell whether it can be bytes where nothing stands beside it, in a log that has bytes of such a form.

        A digit alone, or three decimal ones, may count something.
        """
        if self.form == "decimal":
            return form == self.form
        return self.certain or all(len(digits) > 1 for digits in _BYTE[self.form].findall(self.text))


def runs(text: str) -> list[Run]:
    """Find all that can be bytes; without the column in which a dump shows them as characters, and what follows it."""
    found = []
    length = len(text.rstrip())
    for match in _RUN.finditer(text):
        run = _run(match)
        if run is None:
            continue
        end = _before_column(text, length, run)
        if end is None:
            found.append(run)
            continue
        if shorter := _RUN.match(text[:end], run.start):
            run = _run(shorter)
            found += [run] if run else []
        break
    return found


def parse(text: str, start: int = 0) -> Run:
    """Read what is said to be bytes; `start` is its place in the line. ValueError says why it cannot be."""
    match = _RUN.fullmatch(text)
    run = _run(match) if match else None
    if run and (run.certain or run.form != "decimal"):
        return run._replace(start=start, end=start + len(text))
    digits = re.sub(r"0[xX]|\\x|[^\w]", "", text)
    if wrong := re.search(r"[^0-9A-Fa-f]+", digits):
        raise ValueError(f"'{wrong[0]}' is not hexadecimal")
    if not digits or len(digits) % 2:
        raise ValueError(f"an odd number of hexadecimal digits ({len(digits)})" if digits else "no data")
    return Run(start, start + len(text), "groups", text, bytes.fromhex(digits))


def _run(match: re.Match[str]) -> Run | None:
    form = match.lastgroup or ""
    text = match[0]
    if form == "decimal":
        values = [int(value) for value in text.replace(",", " ").replace(";", " ").split()]
        if max(values) > 0xFF:
            return None
        data = bytes(values)
    elif form == "groups" and BITS.fullmatch(text):
        return None
    elif _PLAIN.fullmatch(text):
        data = bytes.fromhex(text)
    else:
        data = bytes(int(digits, 16) for digits in _BYTE[form].findall(text))
    return Run(match.start(), match.end(), form, text, data)


def _before_column(text: str, length: int, run: Run) -> int | None:
    """Say where the bytes end if what follows, or the end of the run, is the same bytes as characters."""
    if run.form not in ("pairs", "groups") or len(run.data) > _WIDEST:
        return None
    spans = None
    # It is no wider than there are bytes, and ends the line.
    for gap in _COLUMN.finditer(text, max(run.start, length - len(run.data) - _BORDERS)):
        column = text[gap.end() :].rstrip().rstrip("|'\"*").rstrip()
        if not column or len(column) > len(run.data):
            continue
        spans = spans or run.spans()
        count = sum(end <= gap.start() for _, end in spans)
        if len(column) <= count and _shows(column.ljust(count), run.data[:count]):
            return spans[count - 1][1]
    return None


def _shows(column: str, data: bytes) -> bool:
    """Tell whether these characters show these bytes."""
    for character, byte in zip(column, data, strict=True):
        if 0x20 <= byte < 0x7F:
            if character not in (chr(byte), "."):
                return False
        elif character.isascii() and character.isalnum():
            return False
    return True
