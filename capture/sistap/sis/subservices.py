# SPDX-License-Identifier: GPL-2.0-or-later
"""Several subservices in one telegram of service 0x03 (IF02 chapter 6.1).

The document allows them, "because their lengths are fixed", and does not print how. Two layouts are possible: the
address once before all of them, or before each. The layout that consumes all bytes is right.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import NamedTuple

# Bytes of data in a command; the length for a multicast group (0x06) is not documented.
SIZES: Mapping[int, int] = {0x01: 2, 0x02: 2, 0x03: 2, 0x07: 1, 0x08: 3, 0xFF: 0}


class Setting(NamedTuple):
    """A subservice of a command."""

    header: bytes  # what a reaction repeats: the address, if it precedes this subservice, and the subservice
    data: bytes

    @property
    def subservice(self) -> int:
        """Return its number."""
        return self.header[-1]


class Misfit(Enum):
    """Why a layout does not fit."""

    ADDRESS = "another address than the first"
    SUBSERVICE = "a subservice of unknown length"
    DATA = "data are missing"


class Layout(NamedTuple):
    """The result of parsing a body in a layout."""

    settings: list[Setting]
    end: int  # where it ended: after the last byte, or at what does not fit
    misfit: Misfit | None  # None: it consumed all bytes


def layouts(body: bytes) -> list[Layout]:
    """Parse the body of a command in both layouts: the address once, and before each subservice."""
    return [_read(body, each) for each in (False, True)]


def settings(body: bytes) -> list[Setting] | None:
    """Return the subservices of a command; None if no layout fits, or if both fit and differ."""
    fitting = [layout.settings for layout in layouts(body) if layout.misfit is None]
    return fitting[0] if fitting and fitting[0] == fitting[-1] else None


def _read(body: bytes, addressed_each: bool) -> Layout:
    found: list[Setting] = []
    place = 0
    while place < len(body):
        addressed = addressed_each or not found
        if addressed and body[place] != body[0]:
            return Layout(found, place, Misfit.ADDRESS)
        at = place + addressed
        if at == len(body):
            return Layout(found, at, Misfit.DATA)
        size = SIZES.get(body[at])
        if size is None:
            return Layout(found, at, Misfit.SUBSERVICE)
        end = at + 1 + size
        if end > len(body):
            return Layout(found, at, Misfit.DATA)
        found.append(Setting(body[place : at + 1], body[at + 1 : end]))
        place = end
    return Layout(found, place, None)
