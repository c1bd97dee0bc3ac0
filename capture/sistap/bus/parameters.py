# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameters of a station and the rules of access to their elements (IF02 chapter 8, error codes of fig. 8-48).

Everything is little endian. Text goes as a SERCOS list: actual and maximum length, two bytes each, then the characters.
"""

from __future__ import annotations

import enum
import re
from dataclasses import dataclass

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


class Format(enum.IntEnum):
    """How operating data are shown, bits 20 to 22 of the attribute."""

    BINARY = 0
    UNSIGNED = 1
    SIGNED = 2
    HEXADECIMAL = 3
    TEXT = 4


class Length(enum.IntEnum):
    """The length of operating data, bits 16 to 18 of the attribute."""

    TWO_BYTES = 1
    FOUR_BYTES = 2
    LIST_OF_BYTES = 4


_SIZES = {Length.TWO_BYTES: 2, Length.FOUR_BYTES: 4}

# Write protection by phase, bits 28 to 30 of the attribute.
READ_ONLY = 0x70000000
PARAMETER_MODE_ONLY = 0x60000000
_PROCEDURE_COMMAND = 0x00080000


class AccessError(Exception):
    """An access failed; `code` is the error code of fig. 8-48."""

    def __init__(self, code: int) -> None:
        """Say which code."""
        super().__init__(f"0x{code:04X}")
        self.code = code


def ident(text: str) -> bytes:
    """Make type and number of a parameter (fig. 8-3) from its name, such as "S-0-0044" or "P-2-0012"."""
    match = re.fullmatch(r"([SPAC])-([0-7])-(\d{4})", text)
    if not match or int(match[3]) > 0xFFF:
        raise ValueError(f"'{text}' is not a parameter such as S-0-0044")
    kind, bit_15 = _KINDS[match[1]]
    number = bit_15 | int(match[2]) << 12 | int(match[3])
    return bytes([kind]) + number.to_bytes(2, "little")


def control(element: Element) -> int:
    """Make the control byte (fig. 8-1) for an access in one telegram: bit 2 says that it is the last."""
    return element << 3 | 0x04


def attribute(
    length: Length, format: Format, decimals: int = 0, protection: int = 0, *, command: bool = False
) -> bytes:
    """Make an attribute, with a conversion factor of 1."""
    bits = 1 | length << 16 | format << 20 | decimals << 24 | protection
    return (bits | (_PROCEDURE_COMMAND if command else 0)).to_bytes(4, "little")


def text(characters: str) -> bytes:
    """Make a list of characters."""
    length = len(characters).to_bytes(2, "little")
    return length + length + characters.encode("ascii")


def number(value: int) -> bytes:
    """Make a value of four bytes, with sign."""
    return value.to_bytes(4, "little", signed=True)


@dataclass
class Parameter:
    """One parameter; elements it does not have are None."""

    ident: str
    name: str
    attribute: bytes
    data: bytes
    unit: str | None = None
    minimum: bytes | None = None
    maximum: bytes | None = None
    data_status: int = 0  # fig. 8-44

    def read(self, element: Element) -> bytes:
        """Give an element. May raise AccessError."""
        elements = {
            Element.IDENT_NUMBER: ident(self.ident)[1:],
            Element.NAME: text(self.name),
            Element.ATTRIBUTE: self.attribute,
            Element.UNIT: None if self.unit is None else text(self.unit),
            Element.MINIMUM: self.minimum,
            Element.MAXIMUM: self.maximum,
            Element.DATA: self.data,
        }
        if element not in elements:
            raise AccessError(0x0009)
        data = elements[element]
        if data is None:
            raise AccessError(element << 12 | 0x001)  # not available
        return data

    def write(self, element: Element, data: bytes, phase: int) -> bytes:
        """Write an element; gives the data status if it is the ident number. May raise AccessError."""
        if element == Element.IDENT_NUMBER:
            return self.data_status.to_bytes(2, "little")
        if element != Element.DATA:
            raise AccessError(element << 12 | 0x004 if element else 0x0009)  # cannot be changed
        self._check(data, phase)
        self.data = data
        if self._attribute & _PROCEDURE_COMMAND:
            self.data_status = int.from_bytes(data, "little") & 3  # set and enabled: done at once
        return b""

    @property
    def _attribute(self) -> int:
        return int.from_bytes(self.attribute, "little")

    def _check(self, data: bytes, phase: int) -> None:
        protection = self._attribute & READ_ONLY
        if protection == READ_ONLY:
            raise AccessError(0x7004)
        if protection & 1 << (26 + phase):  # bits 28, 29, 30: phases 2, 3, 4
            raise AccessError(0x7005)
        size = _SIZES.get(Length(self._attribute >> 16 & 7))
        if size is not None and len(data) != size:
            raise AccessError(0x7002 if len(data) < size else 0x7003)
        if self.minimum is not None and self._value(data) < self._value(self.minimum):
            raise AccessError(0x7006)
        if self.maximum is not None and self._value(data) > self._value(self.maximum):
            raise AccessError(0x7007)

    def _value(self, data: bytes) -> int:
        return int.from_bytes(data, "little", signed=self._attribute >> 20 & 7 == Format.SIGNED)
