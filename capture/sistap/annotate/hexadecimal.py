# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds bytes in the text of a log: hexadecimal digits in all usual forms, decimal numbers, literals."""

from __future__ import annotations

import re
from itertools import pairwise
from typing import NamedTuple

_PREFIX = r"(?:0[xX]|\$|(?:(?i:B|BYTE)#)?16#|%|&[hH])"
_PAIR = rf"{_PREFIX}?[0-9A-Fa-f]{{1,2}}[hH]?"
_BETWEEN = r"(?:\s*[,;|]\s*|\s+|[:-]|(?=[$%])|[>\])}]\s*[<\[({](?=(?:0[xX])?[0-9A-Fa-f]{2}\b))"
_GROUP = r"(?:[0-9A-Fa-f]{2}){2,}"
# Words of a Siemens or IEC 61131 program, high byte first: W#16#02E1, DW#16#02E1_0505, 16#02E1, and KH=02E1 of an S5.
_PREFIX_OF_WORD = r"(?:(?i:D?W|D?WORD)#)?16#|KH\s*=?\s*"
_WORD = rf"(?:{_PREFIX_OF_WORD})[0-9A-Fa-f]{{4}}(?:_?[0-9A-Fa-f]{{4}})?"
_NUMBER = r"(?:1\d\d|2[0-4]\d|25[0-5]|[1-9]\d|\d)"
_BETWEEN_NUMBERS = r"(?:\s*[,;]\s*|\s+)"
_ABOVE_99 = r"(?=\d)(?=[\d\s,;]*\b[12]\d\d\b)"
# Literals of languages that print text as such: b'\x02l\x00', "\2l\0". Without an escape only with a b in front.
_ESCAPE = r"\\(?:x[0-9A-Fa-f]{2}|[0-3]?[0-7]{1,2}|[abfnrtv\\'\"])"
# Decimal, as in 2, 225, 5, 5. It looks like pairs of digits, so one number must be above 99 until a log has such a
# line.
_NUMBERS = rf"(?P<numbers>{_ABOVE_99}{_NUMBER}(?:{_BETWEEN_NUMBERS}{_NUMBER}){{7,}})(?!{_BETWEEN_NUMBERS}\d)"
_FORMS = (
    rf"(?P<words>{_WORD}(?:{_BETWEEN_NUMBERS}{_WORD})*)",
    *(
        rf"(?P<{name}>(?:(?<=\bb{quote})|(?<={quote})(?=[^{quote}\\]*\\[x0-7]))"
        rf"(?:{_ESCAPE}|[^{quote}\\\x00-\x1f\x7f-\U0010ffff])+(?={quote}))"
        for name, quote in (("single", "'"), ("double", '"'))
    ),
    _NUMBERS,
    r"(?P<decimal>\d{3}(?:[\s,;]+\d{3})*)",  # 002 225 005 005
    r"(?P<escaped>(?:\\x[0-9A-Fa-f]{2})+)",  # \x02\xE1
    rf"(?P<groups>(?:0[xX])?{_GROUP}(?:[ \t]+{_GROUP})*(?:[ \t]+[0-9A-Fa-f]{{2}})?)",  # 02E10505 or 02e1 0505 02
    rf"(?P<pairs>{_PAIR}(?:{_BETWEEN}{_PAIR})*)",  # 02 E1, 0x02,0xE1, 02h E1h, <02><E1>, 2 E1
)
_RUN = re.compile(rf"(?<![\w.#$\\/+])(?:{'|'.join(_FORMS)})(?!\w|\.\d|#)")
_DECIMAL_RUN = re.compile(_RUN.pattern.replace(_ABOVE_99, "").replace("{7,}", "{3,}"))
_LITERAL = re.compile(rf"{_ESCAPE}|.")
_LETTERS = dict(zip("abfnrtv", b"\a\b\f\n\r\t\v", strict=True))
_BYTE = {
    "words": re.compile(rf"(?:{_PREFIX_OF_WORD}|_)?([0-9A-Fa-f]{{2}})"),
    "single": _LITERAL,
    "double": _LITERAL,
    "numbers": re.compile(r"(\d+)"),
    "decimal": re.compile(r"(\d{3})"),
    "escaped": re.compile(r"\\x(..)"),
    "groups": re.compile(r"(?:\b0[xX])?([0-9A-Fa-f]{2})"),
    "pairs": re.compile(rf"{_PREFIX}?([0-9A-Fa-f]{{1,2}})[hH]?"),
    "characters": re.compile(r"."),
}
_STYLE = re.compile(rf"({_PREFIX}?)[0-9A-Fa-f]{{1,2}}([hH]?)")
_PLAIN = re.compile(r"[0-9A-Fa-f]{2}(?: [0-9A-Fa-f]{2})*")
_OPERAND = re.compile(r"(?:[ADEF]B|[ADE]D|FC) ?\d{1,3}")  # data block 10 is DB10, input byte 12 is EB12

# The usual form: pairs up to the end of the line, with nothing in front that could be bytes.
_NOTHING_ELSE = re.compile(r"[^\dA-Fa-f'\"\\$%&]*(?<![\w.#/+])([0-9A-Fa-f]{2}(?: [0-9A-Fa-f]{2})*)\s*")

BITS = re.compile(r"[01]{8}(?:\s+[01]{8})+")

# Fewer bytes than this, among other words, may be words and numbers themselves.
_ENOUGH = {"words": 4, "single": 1, "double": 1, "numbers": 8, "decimal": 4, "escaped": 1, "groups": 8, "pairs": 4}
_WIDEST = 256  # bytes in a line of a dump
_BORDERS = 6  # characters around the column
_COLUMN = re.compile(r"(?: {2,}|\t|[ \t]*\||[ \t]+(?=['\"*]))['\"*|]?")


class Run(NamedTuple):
    """A run of bytes in the text, and its place in the line."""

    start: int
    end: int
    form: str
    text: str
    data: bytes

    def spans(self) -> list[tuple[int, int]]:
        """Return where in the line each byte is written."""
        spans = [
            (self.start + match.start(), self.start + match.end()) for match in _BYTE[self.form].finditer(self.text)
        ]
        return spans + [(self.end, self.end)] * (len(self.data) - len(spans))  # the end of a line of text

    @property
    def certain(self) -> bool:
        """Tell whether this is almost certainly bytes, whatever stands beside it."""
        return len(self.data) >= _ENOUGH[self.form]

    @property
    def style(self) -> tuple[str, ...]:
        """Return how the bytes are written: all in one group or not, prefix, separator."""
        match = _STYLE.match(self.text) if self.form == "pairs" else None
        return (self.form, *(match.groups() if match else ()))

    def is_possible(self, form: str) -> bool:
        """Tell whether it can be bytes if nothing stands beside it, in a log that has bytes of this form.

        A single digit without a prefix, or three decimal ones, may be a counter. DB10 may be a data block.
        """
        if self.form in ("decimal", "numbers") or _OPERAND.fullmatch(self.text):
            return form == self.form
        if self.certain or any(self.style[1:]):
            return True
        return all(len(digits) > 1 for digits in _BYTE[self.form].findall(self.text))


def is_plain(text: str) -> bool:
    """Tell whether a line has nothing but bytes in the usual form, behind text that has no digits."""
    return _NOTHING_ELSE.fullmatch(text) is not None


def runs(text: str, style: tuple[str, ...] = ()) -> list[Run]:
    """Find all that can be bytes, without the text column of a dump and what follows it.

    `style` is that of the bytes before: if they were decimal numbers, all are.
    """
    is_decimal = style == ("numbers",)
    if not is_decimal and (match := _NOTHING_ELSE.fullmatch(text)):  # the rest would find the same, more slowly
        return [Run(match.start(1), match.end(1), "pairs", match[1], bytes.fromhex(match[1]))]
    return _runs(text, _DECIMAL_RUN if is_decimal else _RUN)


def _runs(text: str, pattern: re.Pattern[str]) -> list[Run]:
    found = []
    length = len(text.rstrip())
    for match in pattern.finditer(text):
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
    """Parse text that is known to be bytes; `start` is its place in the line. ValueError says why that fails."""
    match = _RUN.fullmatch(text)
    run = _run(match) if match else None
    if run and (run.certain or run.form != "decimal"):
        return run._replace(start=start, end=start + len(text))
    digits = re.sub(r"0[xX]|\\x|[^\w#]", "", text)
    if wrong := re.search(r"[^0-9A-Fa-f]+", digits):
        raise ValueError(f"'{wrong[0]}' is not hexadecimal")
    if not digits or len(digits) % 2:
        raise ValueError(f"an odd number of hexadecimal digits ({len(digits)})" if digits else "no data")
    return Run(start, start + len(text), "groups", text, bytes.fromhex(digits))


def _run(match: re.Match[str]) -> Run | None:
    form = match.lastgroup or ""
    start, text = match.start(), match[0]
    if form in ("single", "double"):
        data = bytes(_character(unit) for unit in _LITERAL.findall(text))
    elif form == "numbers":
        data = bytes(map(int, _BYTE[form].findall(text)))
    elif form == "decimal":
        values = [int(value) for value in text.replace(",", " ").replace(";", " ").split()]
        if max(values) > 0xFF:
            return None
        data = bytes(values)
    elif form == "groups" and BITS.fullmatch(text):
        return None
    elif _PLAIN.fullmatch(text):
        data = bytes.fromhex(text)
    else:
        if form == "pairs":
            first, end = _own(text)
            start, text = start + first, text[first:end]
        data = bytes(int(digits, 16) for digits in _BYTE[form].findall(text))
    return Run(start, start + len(text), form, text, data)


def _character(unit: str) -> int:
    """Return the byte that a literal writes like this."""
    if len(unit) == 1:
        return ord(unit)
    if unit[1] == "x":
        return int(unit[2:], 16)
    return int(unit[1:], 8) if unit[1].isdigit() else _LETTERS.get(unit[1], ord(unit[1]))


def _own(text: str) -> tuple[int, int]:
    """Return where the pairs begin and end without a number at either side that counts lines or bytes.

    Such a number has fewer digits than the bytes, or another separator. At the end of a line it must also equal their
    count.
    """
    items = list(_BYTE["pairs"].finditer(text))
    if len(items) < _ENOUGH["pairs"] + 1:
        return 0, len(text)
    padded = any(len(item[1]) == 2 and item[1][0] == "0" for item in items)
    gaps = [text[before.end() : after.start()] for before, after in pairwise(items)]
    if padded and len(items[0][1]) == 1 or gaps[0] != gaps[1] and gaps[0].strip(" ") and len(set(gaps[1:])) == 1:
        items = items[1:]
    counts = items[-1][1] == str(len(items) - 1) and gaps[-1] != gaps[-2]
    if padded and len(items[-1][1]) == 1 or counts:
        items = items[:-1]
    return items[0].start(), items[-1].end()


def _before_column(text: str, length: int, run: Run) -> int | None:
    """Return where the bytes end if the text behind them, or the end of the run, shows the same bytes as characters."""
    if run.form not in ("pairs", "groups") or len(run.data) > _WIDEST:
        return None
    spans = None
    # The column is no wider than the number of bytes, and ends the line.
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
