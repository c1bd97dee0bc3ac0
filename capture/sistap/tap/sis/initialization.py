# SPDX-License-Identifier: GPL-2.0-or-later
"""Service 0x03, which sets rates and limits of a bus (IF02 chapter 6): its subservices, the rate, what was agreed.

Several subservices may be in one telegram (chapter 6.1). The document allows them, "because their lengths are fixed",
and does not print how. Two layouts are possible: the address once before all of them, or before each. The layout that
consumes all bytes is right.

A rate is set (0x07) for one station after the other or for all. It becomes valid when it is accepted (0xFF): for all at
once by broadcast; for one station with its reaction, which already comes at the new rate. A timed test (0x08) begins
after the reaction and ends by itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import NamedTuple

from sistap.tap.sis import telegram
from sistap.tap.sis.codes import LAYOUTS
from sistap.tap.sis.rates import rate_of
from sistap.tap.sis.telegram import BROADCAST, LEVEL_BROADCAST, Header, least

# Bytes of data in a command; the length for a multicast group (0x06) is not documented.
SIZES: Mapping[int, int] = {subservice: least(layout.command) for subservice, layout in LAYOUTS[0x03].items()}


class Setting(NamedTuple):
    """A subservice of a command."""

    header: bytes  # what a reaction repeats: the address, if it precedes this subservice, and the subservice
    data: bytes

    @property
    def subservice(self) -> int:
        """Return its number."""
        return self.header[-1]


class Misfit(IntEnum):
    """Why a layout does not fit: the status of a reaction that says so (fig. 2-18)."""

    DATA = 0xFA  # data are missing
    SUBSERVICE = 0xFB  # of unknown length
    ADDRESS = 0xFC  # another one than the first


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


def certain(body: bytes) -> list[Setting]:
    """Return what a command sets; if no layout of several subservices fits, only the first is certain."""
    if (said := settings(body)) is not None:
        return said
    return layouts(body)[0].settings[:1]


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


INITIALIZATION = 0x03
SET_RATE, TEST_RATE, ACCEPT = 0x07, 0x08, 0xFF
_GOOD = 0x00
_MS = 1_000_000


class Change(NamedTuple):
    """The new rate of the bus, in Bd, and the reason."""

    baud: int
    why: str


class Follow:
    """Follows the rate that one bus was told, in its good telegrams. Times are those of the telegrams, in ns."""

    def __init__(self, baud: int) -> None:
        self._valid = baud  # without a test
        self._set: dict[int, int] = {}  # rates not accepted yet, by the station that got them, or BROADCAST
        self._command: Header | None = None  # a command of this service to one station, not answered yet
        self._test_end_ns: int | None = None

    def take(self, data: bytes, end_ns: int) -> Change | None:
        """Take a good telegram, whose last character came at `end_ns`; return what it changes."""
        header = telegram.parse(data)
        command, self._command = self._command, None
        if header.service != INITIALIZATION or header.subaddresses:  # another bus is behind a router
            return None
        if not header.reaction:
            if header.receiver == LEVEL_BROADCAST:
                header = header._replace(receiver=BROADCAST)
            return self._take_command(header, end_ns)
        answers = command and (header.sender, header.receiver) == (command.sender, command.receiver)
        if command and answers and header.body[:1] == bytes([_GOOD]) and header.body[1:3] == command.body[:2]:
            return self._obeyed(command, end_ns)
        return None

    def due(self, now_ns: int) -> Change | None:
        """Return a change that is due by time."""
        if self._test_end_ns is None or now_ns < self._test_end_ns:
            return None
        self._test_end_ns = None
        return Change(self._valid, "the timed test is over")

    @property
    def due_ns(self) -> int | None:
        """Return the time of the next change by time."""
        return self._test_end_ns

    def _take_command(self, header: Header, end_ns: int) -> Change | None:
        said = certain(header.body)
        # A station that accepts already answers at the new rate.
        if header.receiver == BROADCAST or any(setting.subservice == ACCEPT for setting in said):
            return self._obeyed(header, end_ns)
        self._command = header
        return None

    def _obeyed(self, command: Header, end_ns: int) -> Change | None:
        """Take what a station has confirmed, or all were told; of several changes the last one counts."""
        changes = [self._do(setting, command, end_ns) for setting in certain(command.body)]
        return next(filter(None, reversed(changes)), None)

    def _do(self, setting: Setting, command: Header, end_ns: int) -> Change | None:
        data = setting.data
        if setting.subservice == SET_RATE:
            self._set.pop(command.receiver, None)
            if baud := rate_of(data[0]):
                self._set[command.receiver] = baud
        elif setting.subservice == TEST_RATE:
            return self._tested(command, int.from_bytes(data[:2], "little"), rate_of(data[2]), end_ns)
        elif setting.subservice == ACCEPT:
            return self._accepted(command)
        return None

    def _accepted(self, command: Header) -> Change | None:
        everyone = command.receiver == BROADCAST
        told = [baud for whom, baud in self._set.items() if everyone or whom in (command.receiver, BROADCAST)]
        if not told:
            return None
        if everyone:
            self._set.clear()
        else:
            self._set.pop(command.receiver, None)
        self._valid, self._test_end_ns = told[-1], None
        return Change(self._valid, f"{command.sender} let {_whom(command)} accept {self._valid} Bd")

    def _tested(self, command: Header, duration_ms: int, baud: int | None, end_ns: int) -> Change | None:
        if baud is None or not duration_ms:
            return None
        self._test_end_ns = end_ns + duration_ms * _MS
        return Change(baud, f"{command.sender} lets {_whom(command)} test {baud} Bd for {duration_ms} ms")


def _whom(command: Header) -> str:
    return "all" if command.receiver == BROADCAST else str(command.receiver)


SET_LIMITS = {0x01: "TrS", 0x02: "TzA", 0x03: "Tmas"}  # subservices, chapter 6.1
