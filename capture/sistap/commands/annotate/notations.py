# SPDX-License-Identifier: GPL-2.0-or-later
"""How logs write bytes: a table of notations. Which of them a log has is chosen by many lines (choosing).

A notation is numbers, which stand in runs with the same separator between all of them, or text with escapes.
"""

from __future__ import annotations

import re
from base64 import b64decode
from collections.abc import Iterator
from itertools import groupby, pairwise
from typing import Any, NamedTuple

from sistap.commands.annotate.marks import MASK

_HH = "[0-9A-Fa-f]{2}"
_H = "[0-9A-Fa-f]{1,2}"
# Not within a number, a name or a path. What begins with a mark may follow another: $02$6C.
_BEFORE, _AFTER = r"(?:(?<![\w.#/+\\$])|(?=[$%\\]))", r"(?!\w|\.\d|#)"
_MARK = r"0[xX]|&[hH]|[$%]|\\x|(?:(?i:B|BYTE)#)?16#"
# Words of a Siemens or IEC 61131 program, high byte first: W#16#02E1, DW#16#02E1_0505, 16#02E1, and KH=02E1 of an S5;
# and \x02E1 of a data base.
_MARK_OF_WORD = r"(?:(?i:D?W|D?WORD)#)?16#|KH\s*(?:=\s*)?|0[xX]|\\x"
_GAP = re.compile(r"[ \t]+|(?!:\s)[^\w.\x00-\x08]{0,5}")  # between two numbers of a run
_BITS = re.compile(r"[01]{8}(?: [01]{8})+")
_SWAPPED = "words, low byte first"
_WIDEST = 256  # bytes in a line of a dump
_BORDERS = 6  # characters around the column
_COLUMN = re.compile(r"(?: {2,}|\t|[ \t]*\||[ \t]+(?=['\"*]))['\"*|]?")
_SEPARATORS = {" ": "spaces", ",": "commas", ";": "semicolons", "-": "dashes", ":": "colons", "\t": "tabs", "": ""}
_CONTROL_NAMES = (
    "NUL SOH STX ETX EOT ENQ ACK BEL BS HT/TAB LF VT FF CR SO SI DLE DC1/XON DC2 DC3/XOFF DC4 NAK SYN ETB CAN EM SUB "
    "ESC FS GS RS US SP"
)
_CONTROLS = {name: number for number, names in enumerate(_CONTROL_NAMES.split()) for name in names.split("/")}
del _CONTROLS["FF"]  # more likely a byte
# Full-width forms, as a Chinese or Japanese keyboard writes them, and their blank: one character for one.
_FULL_WIDTH = {**{code: code - 0xFEE0 for code in range(0xFF01, 0xFF5F)}, 0x3000: 0x20}


class Run(NamedTuple):
    """A run of bytes in the text, and its place in the line."""

    start: int
    end: int
    form: str  # name of the notation
    text: str
    data: bytes

    def spans(self) -> list[tuple[int, int]]:
        """Return where in the line each byte is written."""
        if self.form == BASE64.name:  # three bytes in four characters
            firsts = (self.start + at * 4 // 3 for at in range(len(self.data)))
            return [(first, first + 2) for first in firsts]
        spans = [(self.start + one.start(), self.start + one.end()) for one in _BYTE[self.form].finditer(self.text)]
        spans = _swapped(spans) if self.form == _SWAPPED else spans
        return spans + [(self.end, self.end)] * (len(self.data) - len(spans))  # the end of a line of text


class Numbers(NamedTuple):
    """Each byte is a number, or several are joined."""

    name: str
    hint: re.Pattern[str]  # each log of this notation has it
    number: re.Pattern[str]
    byte: re.Pattern[str]  # group 1: its digits
    enough: int  # fewer bytes, among other words, may be words and numbers themselves
    is_plain: bool = True  # its bytes are explained in a log that has no right telegram, too
    base: int = 16
    is_joined: bool = False  # several bytes stand side by side

    def runs(self, text: str, *, has_column: bool = True) -> tuple[list[Run], int]:
        """Find runs of numbers with the same separator, and where a text column begins that shows the same bytes."""
        found: list[Run] = []
        text = text.rstrip()
        numbers = [*self.number.finditer(text)] if self.hint.search(text) else []
        for first, last in _evenly(text, numbers, by_length=self.is_joined):
            if self.is_joined and first < last and len(numbers[first][0]) == len("02"):
                continue
            run = self.run(text, numbers[first].start(), numbers[last].end())
            if has_column and (end := _before_column(text, run)) is not None:
                return self.runs(text[:end], has_column=False)[0], end
            if self.base == 2 or not _BITS.fullmatch(run.text):
                found.append(run)
        return found, len(text)

    def run(self, text: str, start: int, end: int) -> Run:
        """Return a part of a text as a run."""
        part = text[start:end]
        data = [int(digits, self.base) & 0xFF for digits in self.byte.findall(part)]
        return Run(start, end, self.name, part, bytes(_swapped(data) if self.name == _SWAPPED else data))

    def is_wide(self, run: Run, _: str) -> bool:
        """Tell whether a run is bytes, whatever stands beside it."""
        return len(run.data) >= self.enough

    def separated(self, run: Run) -> str:
        """Say what stands between the bytes of a run."""
        first, *rest = self.number.finditer(run.text)
        gap = run.text[first.end() : rest[0].start()] if rest else ""
        gap = gap.strip(" ") or gap[:1]
        return f", separated by {_SEPARATORS.get(gap, repr(gap))}" if gap else ""


class TextNotation(NamedTuple):
    """Bytes are characters; those that cannot be shown are escapes."""

    name: str
    hint: re.Pattern[str]
    said: re.Pattern[str]  # finds such texts; its group `said` are the characters
    byte: re.Pattern[str]  # its groups: hex, octal, decimal, letter, char
    is_plain: bool = False
    ends_line: bool = False  # such a text is the rest of its line

    def runs(self, text: str) -> tuple[list[Run], int]:
        """Find such texts; there is no column behind them."""
        return [
            Run(one.start("said"), one.end("said"), self.name, one["said"], bytes(map(_value, found)))
            for one in self.said.finditer(text)
            if not (self.ends_line and one.end() < len(text)) and (found := [*self.byte.finditer(one["said"])])
        ], len(text)

    def is_wide(self, run: Run, text: str) -> bool:
        """Tell whether it has the number of a character, or is of Python's type for bytes. Paths have other escapes."""
        is_bytes = text[max(0, run.start - 2) : run.start - 1] == "b"
        return is_bytes or any(one.lastgroup in _BASES for one in self.byte.finditer(run.text))


class Base64(NamedTuple):
    """Texts of base64, of which a telegram begins with A and one of sixteen letters."""

    name: str = "base64"
    hint: re.Pattern[str] = re.compile(r"A[g-v]")
    is_plain: bool = False
    text: re.Pattern[str] = re.compile(r"(?<![\w.+/=-])(?:[A-Za-z0-9+/]{2,}|[A-Za-z0-9_-]{2,})={0,2}(?![\w+/=-])")

    def runs(self, text: str) -> tuple[list[Run], int]:
        """Find such texts; there is no column behind them."""
        found = [(one, _of_base64(one[0])) for one in self.text.finditer(text)]
        return [Run(one.start(), one.end(), self.name, one[0], data) for one, data in found if data], len(text)

    def is_wide(self, run: Run, _: str) -> bool:
        """Tell whether it begins as a telegram does. A word may have such letters, too."""
        return len(run.data) >= _LEAST and self.hint.match(run.text) is not None


def _of_base64(text: str) -> bytes:
    """Decode base64, also that of addresses, also without its end; empty if it is none."""
    text = text.rstrip("=").replace("-", "+").replace("_", "/")
    return b64decode(text + "=" * (-len(text) % 4)) if len(text) % 4 != 1 else b""


Notation = Numbers | TextNotation | Base64

_LEAST = 8  # bytes of a telegram
BASE64 = Base64()
_BASES = {"hex": 16, "octal": 8, "decimal": 10}
_LETTERS = dict(zip("0abefnrtvslp", b"\0\a\b\x1b\f\n\r\t\v \n\f", strict=True))


def _value(one: re.Match[str]) -> int:
    """Return the byte that a text writes like this."""
    kind = one.lastgroup or ""
    said = one[kind]
    if kind in _BASES:
        return int(said, _BASES[kind]) & 0xFF
    if kind == "control":
        return _CONTROLS[said.upper()]
    return _LETTERS.get(said.lower(), ord(said)) if kind == "letter" else ord(said)


def _numbers(name: str, hint: str, number: str, byte: str, enough: int, **kinds: Any) -> Numbers:
    return Numbers(name, re.compile(hint), re.compile(_BEFORE + number + _AFTER), re.compile(byte), enough, **kinds)


def _text(name: str, hint: str, escapes: str, said: str, **kinds: Any) -> TextNotation:
    return TextNotation(name, re.compile(hint), re.compile(said), re.compile(rf"{escapes}|(?P<char>.)"), **kinds)


def _quoted(escape: str) -> str:
    return rf"(?<!{escape})(?P<quote>['\"])(?P<said>(?:{escape}[ -~]|(?!{escape}|(?P=quote))[ -~])*)(?P=quote)"


PAIRS = _numbers("pairs of hexadecimal digits", _HH, _HH, f"({_HH})", 4)
_JOINED = _numbers("hexadecimal digits side by side", _HH * 2, rf"(?:{_HH})+", f"({_HH})", 8, is_joined=True)
_DECIMAL = r"(?:-(?:12[0-8]|1[01]\d|\d?\d)|25[0-5]|2[0-4]\d|[01]?\d?\d)"
_CONTROL = "|".join(_CONTROLS)
_GAPS = r"[ \t,;]+"
_WORD = rf"[<\[]?(?:(?i:{_CONTROL})|{_HH})[>\]]?"
_NAMED = rf"(?=(?:{_HH}{_GAPS}){{0,7}}[<\[]?(?i:{_CONTROL})\b)"  # one of the first is a name
NOTATIONS: tuple[Notation, ...] = (
    PAIRS,
    _text(
        "text with escapes of C or Python",
        r"\\[x0-7]|\bb['\"]",
        rf"\\x(?P<hex>{_HH})|\\(?P<octal>[0-3]?[0-7]{{1,2}})|\\(?P<letter>[^x0-7])",
        _quoted(r"\\"),
        is_plain=True,
    ),
    _numbers(
        "hexadecimal with a mark",
        r"[xX$%&\\#]|[0-9A-Fa-f][hH]",
        f"(?:(?:{_MARK}){_H}|{_HH}[hH])",
        f"(?:{_MARK})?({_H})[hH]?",
        4,
    ),
    _numbers(
        "words", r"16#|KH|0[xX]|\\x", rf"(?:{_MARK_OF_WORD}){_HH}(?:_?{_HH})+", rf"(?:{_MARK_OF_WORD}|_)?({_HH})", 4
    ),
    _JOINED,
    _numbers("pairs joined by underscores", rf"{_HH}_{_HH}", rf"{_HH}(?:_{_HH})+", f"({_HH})", _LEAST, is_joined=True),
    TextNotation(
        "hexadecimal with names of control characters",
        re.compile(rf"\b(?i:{_CONTROL})\b"),
        re.compile(rf"{_BEFORE}{_NAMED}(?P<said>{_WORD}(?:{_GAPS}{_WORD}){{3,}})(?!\w)"),
        re.compile(rf"\b(?:(?P<hex>{_HH})|(?P<control>(?i:{_CONTROL})))\b"),
        is_plain=True,
    ),
    _numbers("bits", "[01]{8}", "[01]{8}", "([01]{8})", 4, base=2),
    _numbers(_SWAPPED, _HH * 2, _HH * 2, f"({_HH})", 4, is_plain=False),
    _numbers("hexadecimal without leading zeros", _H, _H, f"({_H})", 8, is_plain=False),
    _numbers("decimal", r"\d", _DECIMAL, r"((?:(?<!\d)-)?\d+)", 8, base=10, is_plain=False),
    _text("text with escapes of JSON", r"\\u00", rf"\\u00(?P<hex>{_HH})|\\(?P<letter>[bfnrt\\/\"])", _quoted(r"\\")),
    _text("text with escapes of LabVIEW", rf"\\{_HH}", rf"\\(?P<hex>{_HH})|\\(?P<letter>[bfnrst\\])", _quoted(r"\\")),
    _text(
        "text with escapes of IEC 61131",
        rf"\${_HH}",
        rf"\$(?P<hex>{_HH})|\$(?P<letter>[LNPRTlnprt$'\"])",
        _quoted(r"\$"),
    ),
    _text(
        "text with numbers of characters in <>",
        f"<0x{_HH}>",
        f"<0x(?P<hex>{_HH})>",
        rf"(?:(?<={MASK}\] )|(?<={MASK} )|(?=<0x))(?P<said>[ -~]+)",
        ends_line=True,
    ),
    _text(
        "text with numbers of characters of Delphi",
        r"#\d",
        r"#(?P<decimal>\d{1,3})|'?(?P<quoted>[^'])'?",
        r"(?P<said>(?:#\d{1,3}|'[^']*')+)",
    ),
    _text(
        "characters of od -c",
        r"(?m)^[0-7]{7} ",
        r"  \\(?P<letter>[0abfnrtv])| (?P<octal>[0-7]{3})|   (?P<quoted>.)",
        r"^[0-7]{7}(?P<said>(?:  \\[0abfnrtv]| [0-7]{3}|   [ -~])+)$",
    ),
    BASE64,
)
BY_NAME = {notation.name: notation for notation in NOTATIONS}
_BYTE = {one.name: one.byte for one in NOTATIONS if not isinstance(one, Base64)} | {"characters": re.compile(".")}

# The usual form: pairs up to the end of the line, with nothing in front that could be bytes.
_NOTHING_ELSE = re.compile(r"[^\dA-Fa-f'\"\\$%&]*(?<![\w.#/+])([0-9A-Fa-f]{2}(?: [0-9A-Fa-f]{2})*)\s*")


def _swapped(items: list[Any]) -> list[Any]:
    """Swap each two."""
    return [item for at in range(0, len(items), 2) for item in reversed(items[at : at + 2])]


def narrow(text: str) -> str:
    """Return a text of the same length without full-width characters."""
    return text if text.isascii() else text.translate(_FULL_WIDTH)


def plain(text: str) -> Run | None:
    """Return the bytes of a line that has nothing else, in the usual form: quickly."""
    found = _NOTHING_ELSE.fullmatch(text)
    return Run(found.start(1), found.end(1), PAIRS.name, found[1], bytes.fromhex(found[1])) if found else None


def parse(text: str, start: int = 0) -> Run:
    """Parse text that is known to be bytes; `start` is its place in the line. ValueError says why that fails."""
    text = narrow(text)
    for notation in NOTATIONS:
        for run in notation.runs(text)[0][:1]:
            if notation.is_plain and run.text == text:
                return run._replace(start=start, end=start + len(text))
    digits = re.sub(r"0[xX]|\\x|[^\w#]", "", text)
    if wrong := re.search(r"[^0-9A-Fa-f]+", digits):
        raise ValueError(f"'{wrong[0]}' is not hexadecimal")
    if not digits or len(digits) % 2:
        raise ValueError(f"an odd number of hexadecimal digits ({len(digits)})" if digits else "no data")
    return Run(start, start + len(text), _JOINED.name, text, bytes.fromhex(digits))


def _evenly(text: str, numbers: list[re.Match[str]], *, by_length: bool) -> Iterator[tuple[int, int]]:
    """Yield the first and last number of each run: the same stands between all of them.

    A number between two separators belongs to the longer run: of 11:00 02 56, 11 is the number of the line.
    """
    gaps = [text[one.end() : other.start()] for one, other in pairwise(numbers)]
    links = [
        (gap.strip(" ") or gap[:1], len(one[0]) if by_length else 0) if _GAP.fullmatch(gap) else None
        for gap, one in zip(gaps, numbers, strict=False)
    ]
    strengths: list[tuple[int, int]] = []
    for link, alike in groupby(links):
        count = len([*alike])
        strengths += [(count, -len(link[0].strip())) if link else (0, 0)] * count
    first = 0
    for last in range(len(numbers)):
        if last == len(links) or not _joins(links, strengths, last):
            yield first, last
            first = last + 1


def _joins(links: list[tuple[str, int] | None], strengths: list[tuple[int, int]], at: int) -> bool:
    """Tell whether a link holds: no other link of its two numbers is stronger."""
    link, strength = links[at], strengths[at]
    left = at == 0 or links[at - 1] == link or strengths[at - 1] < strength
    right = at + 1 == len(links) or links[at + 1] == link or strengths[at + 1] <= strength
    return link is not None and left and right


def _before_column(text: str, run: Run) -> int | None:
    """Return where the bytes end if the text behind them, or the end of the run, shows the same bytes as characters."""
    if len(run.data) > _WIDEST:
        return None
    length, spans = len(text), None
    # The column is no wider than the number of bytes, each with a blank, and ends the line.
    for gap in _COLUMN.finditer(text, max(run.start, length - 2 * len(run.data) - _BORDERS)):
        column = text[gap.end() :].rstrip("|'\"*").rstrip()
        if not column:
            continue
        spans = spans or run.spans()
        count = sum(end <= gap.start() for _, end in spans)
        if not count or any(map(str.isalnum, text[spans[count - 1][1] : gap.start()])):
            continue  # no bytes, or others, stand in front of it
        if any(len(one) <= count and _shows(one.ljust(count), run.data[:count]) for one in _columns(column)):
            return spans[count - 1][1]
    return None


def _columns(column: str) -> list[str]:
    """Return the characters of a column: all, without a blank in front of it, and without one in front of each."""
    return [column, column.removeprefix(" "), *([] if column[::2].strip() else [column[1::2]])]


def _shows(column: str, data: bytes) -> bool:
    """Tell whether these characters show these bytes."""
    for character, byte in zip(column, data, strict=True):
        if 0x20 <= byte < 0x7F:
            if character not in (chr(byte), "."):
                return False
        elif character.isascii() and character.isalnum():
            return False
    return True
