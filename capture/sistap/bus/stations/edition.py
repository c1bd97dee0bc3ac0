# SPDX-License-Identifier: GPL-2.0-or-later
"""The differences between the documents that describe SIS."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from sistap.bus.service import Status

_SYSTEM_ERROR = 0x80  # bit 7 of the telegram control

# ECODRIVE03: bits 7, 6, 5 of the telegram control of a reaction, by the error code in it.
_STATE_ERROR = 0b110
_STATES = {0x8001: 0b001, 0x800C: 0b010}


def _diagnosis(body: bytes, error: bool) -> int:
    """Return the system diagnosis of the station (IF02)."""
    return _SYSTEM_ERROR if error else 0


def _state(body: bytes, error: bool) -> int:
    """Return what became of the request (ECODRIVE03)."""
    if body[0] == Status.OK:
        return 0
    return _STATES.get(int.from_bytes(body[-2:], "little"), _STATE_ERROR) << 5


class Edition(NamedTuple):
    """A document that a station follows."""

    longest: int  # bytes of data in the reaction to a read parameter
    point_to_point: int | None  # the receiver address that every station answers
    groups: range  # receiver addresses of groups
    lists: bool  # whether there is service 0x04
    no_shutdown: Mapping[int, int]  # error byte of shutdown and reboot for each phase
    control: Callable[[bytes, bool], int]  # bits 5 to 7 of the telegram control, by body and error of the station
    channel_status: int = Status.CHANNEL_ERROR  # the status before a code of the channel to a parameter
    crc32: bool = False  # returned by 0x97 of service 0x02
    length_words: bool = False  # the list offset of 0x11 and 0x1E counts from the two lengths before the elements


EDITIONS = {
    "IF02": Edition(236, 128, range(200, 254), True, {3: 0x03, 4: 0x04}, _diagnosis),
    "IndraDrive": Edition(
        245,
        128,
        range(200, 254),
        True,
        {3: 0x10, 4: 0x10},
        _diagnosis,
        channel_status=Status.EXECUTION_ERROR,
        crc32=True,
        length_words=True,
    ),
    "ECODRIVE03": Edition(236, None, range(128, 255), False, {3: 0x03, 4: 0x04}, _state),
}
