# SPDX-License-Identifier: GPL-2.0-or-later
"""RTAC serial captures (LINKTYPE_RTAC_SERIAL), of an RTAC or of `sistap capture --link-type rtac`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from sistap.commands.imports.dissected import FieldRows, nanoseconds
from sistap.commands.imports.source import RECEIVED, SENT, Stated, need_rate, numbered
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag, Read
from sistap.tap.terminal.exits import Refusal

_FIELDS = ("rtacser.timestamp", "rtacser.eventtype", "data.data")
_OPTIONS = ("-d", "rtacser.data,data")  # the raw bytes, whatever the user decodes them as


class _Event(NamedTuple):
    """What an event type says about the characters beside it, or about the next ones."""

    line: int = RECEIVED
    flag: Flag = Flag(0)
    for_both: bool = False  # its characters may belong to either line


_EVENTS = {
    0x01: _Event(SENT),
    0x02: _Event(RECEIVED),
    0x03: _Event(SENT),
    0x04: _Event(RECEIVED),
    0x05: _Event(flag=Flag.LOST_BEFORE, for_both=True),
    0x07: _Event(flag=Flag.CHARACTER_ERROR),
    0x08: _Event(flag=Flag.CHARACTER_ERROR),
    0x09: _Event(flag=Flag.BREAK),
    0x0A: _Event(flag=Flag.LOST_BEFORE),
}


class RtacCapture:
    """A Source: the characters of an RTAC capture."""

    def __init__(self, tshark: Tshark, capture: Path, stated: Stated) -> None:
        """Find the lines in the capture. May raise Refusal and TsharkError."""
        self._rows = FieldRows(tshark, capture, _FIELDS, _OPTIONS)
        self.settings = stated.settings
        need_rate(self.settings, capture)
        self.settings_from = "as given"
        lines = {read.line for read in self.reads()}
        if not lines:
            raise Refusal(f"{capture} has no characters in it: capture while the bus is in use")
        self.lines = numbered(
            "serial port, received", "serial port, sent", has_received=RECEIVED in lines, has_sent=SENT in lines
        )
        self.timing = "stamps of the packets; of which character, and how exact, no document says"

    @property
    def warning(self) -> str:
        """Return what tshark said at the end of a capture that is cut off."""
        return self._rows.warning

    def reads(self) -> Iterator[Read]:
        """Yield the characters of each packet together: they share one stamp."""
        pending = {RECEIVED: Flag(0), SENT: Flag(0)}  # what is known of the next character
        for row in self._rows:
            if not row["rtacser.timestamp"]:
                continue
            event = _EVENTS.get(int(row["rtacser.eventtype"], 0), _Event())
            for line in pending if event.for_both else (event.line,):
                pending[line] |= event.flag
            characters = bytes.fromhex(row["data.data"].replace(":", ""))
            if characters:
                yield self._read(row, event.line, characters, pending[event.line])
                pending[event.line] = Flag(0)

    def _read(self, row: dict[str, str], line: int, characters: bytes, errors: Flag) -> Read:
        damaged = errors & ~Flag.LOST_BEFORE
        if damaged and len(characters) > 1:
            damaged = Flag.UNLOCATED_ERROR
        flags = bytes([damaged | errors & Flag.LOST_BEFORE]) + bytes([damaged]) * (len(characters) - 1)
        return Read(line, nanoseconds(row["rtacser.timestamp"]), characters, flags, UNCERTAINTY_UNKNOWN, self.settings)
