# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameters of a station and the rules of access to their elements (IF02 chapter 8, error codes of fig. 8-48).

Everything is little endian. Text goes as a SERCOS list: actual and maximum length, two bytes each, then the characters.
"""

from __future__ import annotations

import enum
import re
import struct
from dataclasses import dataclass

from sistap.dissected.telegrams.attribute import LENGTH_WORDS, READ_ONLY, Attribute, Format

SET, ENABLED = 0x1, 0x2  # bits of the written value, and of the data status
_NOT_YET_EXECUTED, _NOT_POSSIBLE = 0x4, 0x8
_MS = 1_000_000


class ProcedureCommand:
    """Its progress. Written values are 0 (clear), 1 (interrupt) and 3 (set and enable)."""

    def __init__(self, takes_ms: int = 0, fails: bool = False) -> None:
        """Set how long it takes, and whether it fails in the end."""
        self._takes_ns = takes_ms * _MS
        self.fails = fails
        self._written = 0
        self._left_ns = self._takes_ns
        self._since_ns = 0  # start of the run

    def write(self, value: int, now_ns: int) -> None:
        """Act on a written value."""
        if self._running:
            self._left_ns = max(0, self._left_ns - (now_ns - self._since_ns))
        if not value & SET:
            self._left_ns = self._takes_ns
        self._written = value
        self._since_ns = now_ns

    def status(self, now_ns: int) -> int:
        """Return bits 0 to 3 of the data status."""
        if not self._written & SET:
            return 0
        elapsed_ns = now_ns - self._since_ns if self._running else 0
        if elapsed_ns < self._left_ns or (self._left_ns and not self._running):
            return self._written & (SET | ENABLED) | _NOT_YET_EXECUTED
        if self.fails:
            return SET | ENABLED | _NOT_YET_EXECUTED | _NOT_POSSIBLE
        return self._written & (SET | ENABLED)

    @property
    def _running(self) -> bool:
        return self._written & (SET | ENABLED) == SET | ENABLED


_KINDS = {"S": (0, 0x0000), "P": (0, 0x8000), "A": (1, 0x0000), "C": (2, 0x0000)}  # type byte, bit 15 of the number


class Element(enum.IntEnum):
    """The elements of a parameter, as numbered in the control byte (fig. 8-1)."""

    CHANNEL = 0
    IDENT_NUMBER = 1
    NAME = 2
    ATTRIBUTE = 3
    UNIT = 4
    MINIMUM = 5
    MAXIMUM = 6
    DATA = 7


LAST = 0x04  # bit 2 of the control byte: no more follows (fig. 8-1)

PARAMETER_MODE = 2  # the phase
_INVALID = 0x0100  # of the data status: operating data invalid

# Second half of a code of fig. 8-48; the first digit is the element.
NOT_AVAILABLE = 0x001
TOO_SHORT, TOO_LONG = 0x002, 0x003
UNCHANGEABLE, PROTECTED = 0x004, 0x005
BELOW_MINIMUM, ABOVE_MAXIMUM = 0x006, 0x007
NOT_CORRECT = 0x008
WRONG_ACCESS = 0x009
OUTSIDE_MODULO = 0x00C
LENGTH_PROTECTED, LENGTH_FIXED = 0x00D, 0x00E
NO_SUCH_ELEMENT = 0x00F


class AccessError(Exception):
    """An access failed; `code` is the error code of fig. 8-48."""

    def __init__(self, code: int) -> None:
        super().__init__(f"0x{code:04X}")
        self.code = code

    @classmethod
    def of(cls, element: Element, what: int) -> AccessError:
        """Return the error of an element."""
        return cls(element << 12 | what)


def ident(text: str) -> bytes:
    """Return type and number of a parameter (fig. 8-3) for its name, such as "S-0-0044" or "P-2-0012"."""
    match = re.fullmatch(r"([SPAC])-([0-7])-(\d{4})", text)
    if not match or int(match[3]) > 0xFFF:
        raise ValueError(f"'{text}' is not a parameter such as S-0-0044")
    kind, bit_15 = _KINDS[match[1]]
    number = bit_15 | int(match[2]) << 12 | int(match[3])
    return bytes([kind]) + number.to_bytes(2, "little")


def control(element: Element) -> int:
    """Return the control byte (fig. 8-1) for an access in one telegram."""
    return element << 3 | LAST


def text(characters: str) -> bytes:
    """Return a list of characters."""
    return as_list(characters.encode("ascii"))


def as_list(elements: bytes, room: int = 0) -> bytes:
    """Put actual and maximum length before the elements of a list; `room` is the maximum in bytes, if it is larger."""
    return len(elements).to_bytes(2, "little") + max(len(elements), room).to_bytes(2, "little") + elements


def number(value: int) -> bytes:
    """Return a value of four bytes, with sign."""
    return value.to_bytes(4, "little", signed=True)


@dataclass
class Parameter:
    """One parameter; missing elements are None."""

    ident: str
    name: str | None
    attribute: Attribute
    data: bytes
    unit: str | None = None
    minimum: bytes | None = None
    maximum: bytes | None = None
    valid: bool = True
    fixed_length: bool = False  # of a list
    procedure: ProcedureCommand | None = None
    refuse: int | None = None  # an access to the element of this code is refused with it

    def __post_init__(self) -> None:
        """Make a plain command a procedure that is done at once."""
        if self.attribute.is_command and self.procedure is None:
            self.procedure = ProcedureCommand()

    def read(self, element: Element) -> bytes:
        """Return an element. May raise AccessError."""
        elements = {
            Element.IDENT_NUMBER: ident(self.ident)[1:],
            Element.NAME: None if self.name is None else text(self.name),
            Element.ATTRIBUTE: self.attribute.bits.to_bytes(4, "little"),
            Element.UNIT: None if self.unit is None else text(self.unit),
            Element.MINIMUM: self.minimum,
            Element.MAXIMUM: self.maximum,
            Element.DATA: self.data,
        }
        self._check_refused(element, NOT_AVAILABLE)
        if element not in elements:
            raise AccessError.of(element, WRONG_ACCESS)
        data = elements[element]
        if data is None:
            raise AccessError.of(element, NOT_AVAILABLE)
        return data

    def write(self, element: Element, data: bytes, phase: int, now_ns: int = 0) -> bytes:
        """Write an element; return the data status if it is the ident number. May raise AccessError."""
        self._check_refused(element)
        if element == Element.IDENT_NUMBER:
            # Data for the ident number are optional (fig. 8-42).
            if data not in (b"", ident(self.ident)[1:]):
                raise AccessError.of(element, WRONG_ACCESS)
            return self.data_status(now_ns).to_bytes(2, "little")
        self.check_writable(element, phase)
        self._check_length(data, phase)
        self._check_value(data)
        self.data = data
        self.valid = True
        if self.procedure:
            self.procedure.write(int.from_bytes(data, "little"), now_ns)
        return b""

    def data_status(self, now_ns: int) -> int:
        """Return the data status (fig. 8-44)."""
        return (self.procedure.status(now_ns) if self.procedure else 0) | (0 if self.valid else _INVALID)

    def read_segment(self, offset: int, length: int) -> bytes:
        """Return a part of a list, as far as it goes; it counts bytes from the first element. May raise AccessError."""
        elements = self.data[LENGTH_WORDS:]
        self.check_list()
        self._check_offset(offset, len(elements))
        return elements[offset : offset + length]

    def write_segment(self, offset: int, data: bytes, phase: int) -> None:
        """Write a part of a list. May raise AccessError."""
        elements = self.data[LENGTH_WORDS:]
        self.check_list()
        self.check_writable(Element.DATA, phase)
        self._check_offset(offset, len(elements))
        if len(data) % self.attribute.size:
            raise AccessError.of(Element.DATA, TOO_SHORT)
        if offset + len(data) > len(elements):
            raise AccessError.of(Element.DATA, TOO_LONG)
        self.data = self.data[:LENGTH_WORDS] + elements[:offset] + data + elements[offset + len(data) :]

    def resize(self, lengths: bytes, phase: int) -> None:
        """Write the two lengths alone: add elements of 0, or drop elements. May raise AccessError.

        The station defines the maximum, which stays. The length changes in every phase: a known client of IndraDrive
        writes lists like this in phase 4, and no document forbids it.
        """
        self.check_list()
        self.check_writable(Element.DATA, phase)
        if len(lengths) != LENGTH_WORDS:
            raise AccessError.of(Element.DATA, TOO_SHORT if len(lengths) < LENGTH_WORDS else TOO_LONG)
        actual, room = int.from_bytes(lengths[:2], "little"), int.from_bytes(self.data[2:LENGTH_WORDS], "little")
        self._check_actual(actual, room)
        self.data = as_list(self.data[LENGTH_WORDS:][:actual].ljust(actual, b"\0"), room)

    def check_list(self) -> None:
        """Raise AccessError if it has no parts, or refuses access to them."""
        self._check_refused(Element.DATA)
        if not self.attribute.is_list:
            raise AccessError.of(Element.DATA, NO_SUCH_ELEMENT)

    def check_writable(self, element: Element, phase: int) -> None:
        """Raise AccessError if it cannot be written in this phase."""
        if element != Element.DATA:
            raise AccessError.of(element, UNCHANGEABLE if element else WRONG_ACCESS)
        if self.attribute.is_read_only:
            raise AccessError.of(element, UNCHANGEABLE)
        if self.attribute.bits & READ_ONLY & 1 << (26 + phase):  # bits 28, 29, 30: phases 2, 3, 4
            raise AccessError.of(element, PROTECTED)

    def value(self, data: bytes) -> float:
        """Return the number of a value in its format, ignoring decimals."""
        if self.attribute.format == Format.FLOAT:
            return float(struct.unpack("<f", data)[0])
        return int.from_bytes(data, "little", signed=self.attribute.format == Format.SIGNED)

    def _check_refused(self, element: Element, *only: int) -> None:
        """Raise the configured code if it is for this element or the channel, or is one of `only`."""
        if self.refuse is None:
            return
        named, what = self.refuse >> 12, self.refuse & 0xFFF
        if named in (0, 8) or (named == element and (what in only or not only)):
            raise AccessError(self.refuse)

    def _check_length(self, data: bytes, phase: int) -> None:
        if self.attribute.is_list:
            self._check_list(data, phase)
        elif len(data) != self.attribute.size:
            raise AccessError.of(Element.DATA, TOO_SHORT if len(data) < self.attribute.size else TOO_LONG)

    def _check_list(self, data: bytes, phase: int) -> None:
        """Check the two lengths before the elements; the station alone defines the maximum."""
        actual, room = int.from_bytes(data[:2], "little"), int.from_bytes(self.data[2:4], "little")
        if len(data) < LENGTH_WORDS + actual:
            raise AccessError.of(Element.DATA, TOO_SHORT)
        if len(data) > LENGTH_WORDS + actual:
            raise AccessError.of(Element.DATA, TOO_LONG)
        self._check_actual(actual, room)
        if phase != PARAMETER_MODE and actual != int.from_bytes(self.data[:2], "little"):
            raise AccessError.of(Element.DATA, LENGTH_PROTECTED)

    def _check_actual(self, actual: int, room: int) -> None:
        """Check a new length of the list, in bytes."""
        if actual > room:
            raise AccessError.of(Element.DATA, TOO_LONG)
        if actual % self.attribute.size:
            raise AccessError.of(Element.DATA, NOT_CORRECT)
        if self.fixed_length and actual != int.from_bytes(self.data[:2], "little"):
            raise AccessError.of(Element.DATA, LENGTH_FIXED)

    def _check_value(self, data: bytes) -> None:
        if self.attribute.is_list:
            return
        if self.minimum is not None and self.value(data) < self.value(self.minimum):
            raise AccessError.of(Element.DATA, BELOW_MINIMUM)
        if self.maximum is not None and self.value(data) > self.value(self.maximum):
            raise AccessError.of(Element.DATA, ABOVE_MAXIMUM)
        if self.attribute.is_command and int.from_bytes(data, "little") & ~(SET | ENABLED):
            raise AccessError.of(Element.DATA, NOT_CORRECT)

    def _check_offset(self, offset: int, length: int) -> None:
        if not 0 <= offset < length or offset % self.attribute.size:
            raise AccessError.of(Element.DATA, NO_SUCH_ELEMENT)
