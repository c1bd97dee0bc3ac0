# SPDX-License-Identifier: GPL-2.0-or-later
"""Several subservices in one telegram of service 0x03 (IF02 chapter 6.1).

The document allows them, "because their lengths are fixed", and does not print how. Two layouts are possible: the
address once, before all of them, or before each. The one that consumes all bytes is taken.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from sistap.bus.service import ServiceRefused, Status


class Setting(NamedTuple):
    """A subservice of a command."""

    header: bytes  # what a reaction repeats of it: the address, where it stands before it, and the subservice
    data: bytes

    @property
    def subservice(self) -> int:
        """Its number."""
        return self.header[-1]


class _Reading(NamedTuple):
    """What a layout makes of a body."""

    settings: list[Setting]
    end: int  # where it ended: behind the last byte, or at what it cannot read
    status: int | None  # why it cannot; None: it consumed all bytes


def settings(body: bytes, sizes: Mapping[int, int]) -> list[Setting]:
    """Take a body apart; `sizes` has the bytes of data of each subservice.

    ServiceRefused where no layout consumes all bytes, with the status of the one that went further; and where both
    do and differ: then nobody can tell what was meant.
    """
    readings = [_read(body, sizes, each) for each in (False, True)]
    good = [reading.settings for reading in readings if reading.status is None]
    if not good:
        further = max(readings, key=lambda reading: reading.end)
        raise ServiceRefused(further.status or Status.INVALID_TELEGRAM)
    if good[0] != good[-1]:
        raise ServiceRefused(Status.INVALID_TELEGRAM)
    return good[0]


def _read(body: bytes, sizes: Mapping[int, int], addressed_each: bool) -> _Reading:
    found: list[Setting] = []
    place = 0
    while place < len(body):
        addressed = addressed_each or not found
        if addressed and body[place] != body[0]:
            return _Reading(found, place, Status.INVALID_ADDRESS)
        at = place + addressed
        if at == len(body):
            return _Reading(found, at, Status.DATA_MISSING)
        size = sizes.get(body[at])
        if size is None:
            return _Reading(found, at, Status.INVALID_SUBSERVICE)
        end = at + 1 + size
        if end > len(body):
            return _Reading(found, at, Status.DATA_MISSING)
        found.append(Setting(body[place : at + 1], body[at + 1 : end]))
        place = end
    return _Reading(found, place, None)
