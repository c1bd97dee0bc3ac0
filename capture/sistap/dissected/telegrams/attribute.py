# SPDX-License-Identifier: GPL-2.0-or-later
"""The attribute of a parameter: how its values are stored and shown, and who may write them (IEC 61491)."""

from __future__ import annotations

import enum
from typing import NamedTuple

LENGTH_WORDS = 4  # bytes before the elements of a list: its actual and its maximum length

# Bits of an attribute. READ_ONLY has one for each of phases 2, 3 and 4.
PROCEDURE_COMMAND = 0x0008_0000
READ_ONLY = 0x7000_0000

_SIZES = (0, 2, 4, 8, 1, 2, 4, 8)  # of a value in bytes, by the code of its length
_FIRST_LIST = 4  # of these codes


class Format(enum.IntEnum):
    """How values are shown."""

    BINARY = 0
    UNSIGNED = 1
    SIGNED = 2
    HEXADECIMAL = 3
    TEXT = 4
    IDENT_NUMBER = 5
    FLOAT = 6
    TIME = 7


class Attribute(NamedTuple):
    """The attribute of a parameter."""

    bits: int

    @classmethod
    def of(cls, size: int, format: Format, *, is_list: bool = False, more: int = 0) -> Attribute:
        """Return that of values of so many bytes, with a conversion factor of 1; `more` are other bits."""
        return cls(1 | _SIZES.index(size, _FIRST_LIST if is_list else 1) << 16 | format << 20 | more)

    @property
    def size(self) -> int:
        """Return the bytes of a value, or of an element of a list."""
        return _SIZES[self.bits >> 16 & 7]

    @property
    def is_list(self) -> bool:
        """Tell whether there are several values."""
        return self.bits >> 16 & 7 >= _FIRST_LIST

    @property
    def is_command(self) -> bool:
        """Tell whether it is a procedure command."""
        return bool(self.bits & PROCEDURE_COMMAND)

    @property
    def format(self) -> int:
        """Return how values are shown."""
        return self.bits >> 20 & 7

    @property
    def is_text(self) -> bool:
        """Tell whether the list is a text."""
        return self.is_list and self.format == Format.TEXT

    @property
    def has_unit(self) -> bool:
        """Tell whether values are numbers with a unit."""
        return self.format in (Format.UNSIGNED, Format.SIGNED, Format.FLOAT)

    @property
    def is_read_only(self) -> bool:
        """Tell whether nobody can write it, in whatever phase."""
        return self.bits & READ_ONLY == READ_ONLY

    @property
    def decimals(self) -> int:
        """Return the decimal places."""
        return self.bits >> 24 & 15

    @property
    def factor(self) -> int:
        """Return what the number on the bus is multiplied by."""
        return max(self.bits & 0xFFFF, 1)
