# SPDX-License-Identifier: GPL-2.0-or-later
"""The list of parameters: how often each was read and written, its values, and the writes that changed it."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from sistap.dissected.accesses.access import Access, Parameter

MOST = 10_000  # parameters in the list
_LONG = 32  # digits of a value from which on only its digest is kept


class AccessPlace(NamedTuple):
    """A packet of a capture."""

    file: str
    packet: int
    epoch_s: float


class ChangedValue(NamedTuple):
    """An accepted write that changed something, or may have."""

    place: AccessPlace
    access: Access
    before: str | None  # the value known from a read or a write; None: unknown


@dataclass
class Present:
    """The present value of a parameter."""

    parameter: Parameter
    value: str | None = None  # None: unknown
    whole: str = ""  # all of it, or the digest of all

    def follow(self, access: Access) -> bool:
        """Take what an access tells of it; tell whether it is a write that changed it, or may have. All of the value is
        compared: what is shown may be cut off.
        """
        is_known, before, whole = self.value is not None, self.whole, access.whole
        if whole is not None:
            self.value, self.whole = access.value, whole if len(whole) < _LONG else _digest(whole)
        elif access.is_write:
            self.value = None  # a part of it
        return access.is_write and not (whole is not None and is_known and self.whole == before)


@dataclass
class Listed(Present):
    """What is known about a parameter."""

    name: str = ""
    unit: str = ""
    minimum: str = ""  # elements of the parameter, as they were read
    maximum: str = ""
    reads: int = 0
    writes: int = 0
    errors: int = 0  # refused reads and writes
    first: str = ""
    last: str = ""
    least: Access | None = None
    greatest: Access | None = None
    raw: int = 0  # values that are bytes, so they are not among these
    written_by: int | None = None  # the station that wrote it last
    written_in: AccessPlace | None = None

    def add(self, place: AccessPlace, access: Access) -> ChangedValue | None:
        """Count an access; return the change that it made."""
        self.name = access.name or self.name
        self.unit = access.unit or self.unit
        self.minimum = access.minimum or self.minimum
        self.maximum = access.maximum or self.maximum
        if access.error:
            self.errors += 1
            return None
        if access.is_write:
            self.writes += 1
            self.written_by, self.written_in = access.master, place
        else:
            self.reads += 1
        if access.value:
            self._add_value(access)
        before = self.value
        return ChangedValue(place, access, before) if self.follow(access) else None

    def _add_value(self, access: Access) -> None:
        self.first = self.first or access.value
        self.last = access.value
        self.raw += access.is_raw
        number = access.number
        if number is None:
            return
        if self.least is None or number < (self.least.number or 0):
            self.least = access
        if self.greatest is None or number > (self.greatest.number or 0):
            self.greatest = access


class Listing:
    """All parameters, in bounded memory."""

    def __init__(self) -> None:
        self._listed: dict[Parameter, Listed] = {}
        self.left_out = 0  # accesses to parameters that did not fit

    def add(self, place: AccessPlace, access: Access) -> ChangedValue | None:
        """Count an access; return the change that it made."""
        listed = self._listed.get(access.parameter)
        if listed is None:
            if len(self._listed) == MOST:
                self.left_out += 1
                return None
            listed = self._listed[access.parameter] = Listed(access.parameter)
        return listed.add(place, access)

    def __iter__(self) -> Iterator[Listed]:
        """Yield all parameters: by port, station, device and ident."""
        yield from sorted(self._listed.values(), key=lambda listed: order(listed.parameter))

    def __len__(self) -> int:
        return len(self._listed)


def _digest(whole: str) -> str:
    """Return what stands for a long value."""
    return hashlib.blake2b(whole.encode(), digest_size=_LONG // 2).hexdigest()


def order(parameter: Parameter) -> tuple[str, list[int], int, str]:
    """Return the key by which parameters are sorted: port, station, device and ident."""
    return parameter.port, [int(number) for number in re.findall(r"\d+", parameter.station)], *parameter[2:]
