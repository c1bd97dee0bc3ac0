# SPDX-License-Identifier: GPL-2.0-or-later
"""Logs what a real master says and the answers, one line each.

Stations cut telegrams by silence; the log cuts them by content, as a tap does. So it has everything that came,
including telegrams for others, damaged ones and other characters.
"""

from __future__ import annotations

from collections.abc import Iterable

from sistap.bus.playing.played import Played
from sistap.bus.wires.log import Log
from sistap.line.settings import LineSettings, Read
from sistap.records.framer import SisFramer
from sistap.records.record import Record, Type

DAMAGED = "damaged"  # mark of a telegram with a wrong checksum, and of characters outside telegrams
_LINE = 0


class Noting:
    """Logs characters and reactions in the order of their times."""

    def __init__(self, log: Log, settings: LineSettings) -> None:
        """Begin at time 0 of the bus. May raise OSError, as do the methods below."""
        self._log = log
        self._settings = settings
        self._framer = SisFramer(_LINE, settings)
        self._last_ns = 0  # time of the last characters

    def heard(self, values: bytes, time_ns: int) -> None:
        """Take characters that came together, or none: after a silence a telegram is over."""
        if values:
            self._last_ns = time_ns
            self._write(self._framer.feed(Read(_LINE, time_ns, values, bytes(len(values)))))
        else:
            self._write(self._framer.idle(time_ns - self._last_ns))

    def said(self, reaction: bytes, time_ns: int) -> None:
        """Log a reaction that begins now: everything before it is over."""
        self.end()
        self._add(reaction, time_ns + self._settings.character_ns, [])

    def change(self, settings: LineSettings) -> None:
        """Continue with other settings."""
        self.end()
        self._settings = settings
        self._framer = SisFramer(_LINE, settings)

    def end(self) -> None:
        """Log what is left."""
        self._write(self._framer.flush())

    def _write(self, records: Iterable[Record]) -> None:
        for record in records:
            good = record.type == Type.FRAME and not record.checksum_bad
            self._add(record.data, record.time_ns, [] if good else [DAMAGED])

    def _add(self, characters: bytes, time_ns: int, marks: list[str]) -> None:
        self._log.add(Played(time_ns, characters, [], marks, self._settings), [])
