# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads parameter backups of drives: "SERCOS-ASCII", the .par files of IndraWorks.

Such a file has one drive or several, each with a head of five lines. A line "|" begins each parameter.
"""

from __future__ import annotations

import re
import stat
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from sistap.dissected.telegrams.attribute import Attribute
from sistap.dissected.telegrams.values import Unreadable, encoded
from sistap.tap.terminal.console import visible
from sistap.tap.terminal.exits import Refusal, why

MARK = "SERCOS-ASCII"
NOTHING = "--"  # in place of a unit, a limit or a value
CP850, LATIN_1 = "CP850", "Latin-1"  # encodings, also by their names in Python

_LARGEST = 32 << 20  # bytes of a file; a drive has less than one MB
_BEGIN = "|"
_HEAD = ("date and time", "name", "type", "address")
_PARTS = ("ident", "name", "attribute", "unit", "minimum", "maximum", "value")
_IDENT = re.compile(r"([SP]-[0-7]-\d{4})(\.\d{1,3}\.\d{1,3})?")
_TEXT = re.compile(r"(\d+) (\d+)(?: (.*))?", re.DOTALL)
_MOST_STATIONS = 8  # in a route
_UNITS = re.compile(rb"^\|\r?\n(?:.*\n){3}(.*)", re.MULTILINE)
# What speaks for an encoding: degree, square and cube in units, umlauts anywhere. FC is a cube or an umlaut.
_SIGNS = {
    CP850: (re.compile(rb"[\xf8\xfd]|\xfc(?![a-z])"), re.compile(rb"[\x84\x94\x81\x8e\x99\x9a]")),
    LATIN_1: (re.compile(rb"[\xb0\xb2\xb3]"), re.compile(rb"[\xe4\xf6\xdf\xc4\xd6\xdc]")),
}


class Saved(NamedTuple):
    """A parameter in a backup. Unknown texts are empty."""

    ident: str  # "S-0-0001", or with a structure "S-0-0390.0.136"
    name: str
    attribute: Attribute
    unit: str
    minimum: str
    maximum: str
    values: Sequence[str]  # of a list: its elements; of a text: the text
    data: bytes | None  # None: its value is not known, or nobody knows how it is written


class Drive(NamedTuple):
    """A drive in a backup."""

    name: str
    type: str  # firmware, power section and more
    address: str
    parameters: Sequence[Saved]
    encoding: str = LATIN_1  # of the texts in the file


def is_station(text: str) -> bool:
    """Tell whether this is a station, perhaps behind routers: "3", "3/2/8"."""
    stations = text.split("/")
    return len(stations) <= _MOST_STATIONS and all(
        re.fullmatch(r"\d{1,3}", one, re.ASCII) and int(one) <= 255 for one in stations
    )


def drives(path: Path, unreadable: Callable[[str], None] | None = None) -> list[Drive]:
    """Read a backup. Raise Refusal.

    A value that cannot be read is damage, too. Or, if someone wants to know of such values (`unreadable`), it is None.
    """
    content = _content(path)
    encoding = encoding_of(content)
    text = content.decode(encoding)
    reader = _Reader(path, text, encoding, unreadable)
    if not text.startswith(MARK):
        raise Refusal(f"{path} is no backup: its first line is not {MARK}; save the parameters as .par with IndraWorks")
    found = []
    while reader.has_more:
        found.append(_drive(reader))
    return found


def encoding_of(content: bytes) -> str:
    """Return the encoding of a backup, as more of its bytes say; Latin-1 if none says anything."""
    units = b"\n".join(_UNITS.findall(content))
    votes = {name: len(sign.findall(units)) + len(letter.findall(content)) for name, (sign, letter) in _SIGNS.items()}
    return CP850 if votes[CP850] > votes[LATIN_1] else LATIN_1


def _content(path: Path) -> bytes:
    try:
        about = path.stat()
        if not stat.S_ISREG(about.st_mode) or about.st_size > _LARGEST:  # a pipe would wait, a device never end
            raise Refusal(f"{path} is not a file, or larger than {_LARGEST >> 20} MB: name a backup of a drive")
        return path.read_bytes()
    except OSError as error:
        raise Refusal(f"cannot read {path}: {why(error)}; name a backup of a drive") from None


class _Reader:
    """The lines of a file, and where it is damaged."""

    def __init__(self, path: Path, text: str, encoding: str, unreadable: Callable[[str], None] | None) -> None:
        self.encoding = encoding
        self._path = path
        self._unreadable = unreadable
        self._lines = re.split(r"\r?\n", text.rstrip("\r\n"))
        self._at = 0

    @property
    def has_more(self) -> bool:
        """Tell whether a line is left."""
        return self._at < len(self._lines)

    @property
    def has_several(self) -> bool:
        """Tell whether there are several drives."""
        return self._lines.count(MARK) > 1

    @property
    def line(self) -> str:
        """Return the next line; empty at the end."""
        return self._lines[self._at] if self.has_more else ""

    def take(self, what: str) -> str:
        """Return the next line and go on."""
        if not self.has_more or self.line in (_BEGIN, MARK):
            raise self.damaged(f"{what} is missing")
        self._at += 1
        return self._lines[self._at - 1]

    def skip(self, line: str) -> None:
        """Go behind this line."""
        if self.line != line:
            raise self.damaged(f"this is not {line}")
        self._at += 1

    def rest(self) -> list[str]:
        """Return the lines up to the next parameter or drive."""
        lines = []
        while self.has_more and self.line not in (_BEGIN, MARK):
            lines.append(self.take("value"))
        return lines

    def damaged(self, why: str, back: int = 0) -> Refusal:
        """Return the error of this line, or of one before it."""
        return Refusal(f"{self._told(why, back)}; save the backup again")

    def unreadable(self, why: str, back: int) -> None:
        """Tell of a value that cannot be read. Raise Refusal if nobody wants to know."""
        told = self._told(why, back)
        if self._unreadable is None:
            raise Refusal(f"{told}; save the backup again, or delete this parameter from a copy of it")
        self._unreadable(told)

    def _told(self, why: str, back: int) -> str:
        return f"{self._path}, line {self._at + 1 - back}: {visible(why)}"


def _drive(reader: _Reader) -> Drive:
    reader.skip(MARK)
    _, name, kind, address = (reader.take(what).strip() for what in _HEAD)
    if reader.has_several and not is_station(address):
        raise reader.damaged(f"'{address}' is not the address of a drive, 0 to 255", 1)
    parameters = []
    while reader.has_more and reader.line != MARK:
        reader.skip(_BEGIN)
        if reader.has_more and reader.line != MARK:  # some backups end with a line "|"
            parameters.append(_saved(reader))
    return Drive(name, kind, address, parameters, reader.encoding)


def _saved(reader: _Reader) -> Saved:
    ident, name, bits, unit, minimum, maximum = (reader.take(what) for what in _PARTS[:-1])
    found = _IDENT.fullmatch(ident)
    if not found:
        raise reader.damaged(f"'{ident}' is not an ident such as S-0-0001.0.0", len(_PARTS) - 1)
    if not re.fullmatch("[01]{32}", bits):
        raise reader.damaged("an attribute has 32 binary digits", len(_PARTS) - 3)
    attribute = Attribute(int(bits, 2))
    structure = "" if found[2] in (None, ".0.0") else found[2]
    values, data = _value(reader, attribute)
    unit, minimum, maximum = ("" if text == NOTHING else text.rstrip() for text in (unit, minimum, maximum))
    return Saved(found[1] + structure, name, attribute, unit, minimum, maximum, values, data)


def _value(reader: _Reader, attribute: Attribute) -> tuple[list[str], bytes | None]:
    lines = reader.rest()
    if attribute.is_text:
        return _text(reader, lines)
    if attribute.is_list:
        return _list(reader, lines, attribute)
    if len(lines) != 1:
        raise reader.damaged(f"a value has one line, not {len(lines)}", len(lines))
    return lines, _encoded(reader, attribute, lines[0], 1)


def _text(reader: _Reader, lines: Sequence[str]) -> tuple[list[str], bytes | None]:
    """Read actual and maximum length and the text, which all stand in one line."""
    found = _TEXT.fullmatch("\n".join(lines))
    length, text = (int(found[1]), found[3] or "") if found else (0, "")
    if not found or len(text) < length or text[length:] not in ("", " "):  # some fill it up to an even length
        raise reader.damaged("the text does not have its length", len(lines))
    text = text[:length]
    # Drives send Latin-1. Which bytes a text in CP850 has on the bus, no document says.
    is_known = reader.encoding == LATIN_1 or text.isascii()
    return [text], text.encode(LATIN_1) if is_known else None


def _list(reader: _Reader, lines: Sequence[str], attribute: Attribute) -> tuple[list[str], bytes | None]:
    """Read actual and maximum length, each in a line, then an element a line."""
    elements = list(lines[2:])
    if len(lines) < 2 or lines[0] != str(len(elements) * attribute.size):
        raise reader.damaged("the list does not have its length", len(lines))
    data = [_encoded(reader, attribute, text, len(elements) - i) for i, text in enumerate(elements)]
    return elements, b"".join(one for one in data if one is not None) if None not in data else None


def _encoded(reader: _Reader, attribute: Attribute, text: str, back: int) -> bytes | None:
    if text == NOTHING:
        return None
    try:
        return encoded(attribute, text)
    except Unreadable as error:
        reader.unreadable(str(error), back)
        return None
