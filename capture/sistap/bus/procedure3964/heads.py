# SPDX-License-Identifier: GPL-2.0-or-later
"""The Indramat extension: the head before the data of a first telegram. All words are high byte first."""

from __future__ import annotations

import struct
from typing import NamedTuple

from sistap.bus.devices.parameters import ident

_LAYOUT = struct.Struct(">HBBH")  # info access, axis, parameter type, parameter
SIZE = _LAYOUT.size
_WRITE, _LAST = 0x01, 0x02  # bits of the info access; without _LAST a "current transmission" follows


class Head(NamedTuple):
    """The contents of a head; `parameter` is type and number, as in SIS (chapter 8.1) but high byte first."""

    write: bool
    last: bool
    axis: int
    parameter: bytes

    @classmethod
    def of(cls, name: str, axis: int, *, write: bool, last: bool = True) -> Head:
        """Return the head of a parameter such as "S-0-0237". ValueError for anything else."""
        kind, low, high = ident(name)
        return cls(write, last, axis, bytes([kind, high, low]))

    @classmethod
    def read(cls, data: bytes) -> Head:
        """Parse a head. ValueError if it is incomplete."""
        if len(data) < SIZE:
            raise ValueError("the head is cut")
        access, axis, _, _ = _LAYOUT.unpack_from(data)
        return cls(bool(access & _WRITE), bool(access & _LAST), axis, data[3:SIZE])

    def __bytes__(self) -> bytes:
        access = (_WRITE if self.write else 0) | (_LAST if self.last else 0)
        return struct.pack(">HB", access, self.axis) + self.parameter
