# SPDX-License-Identifier: GPL-2.0-or-later
"""What a file begins with that continues another: the telegrams of each bus that explain later ones (sis/told.py)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.records.record import Event, Framing, Record, Type, event
from sistap.tap.sis.told import Said, Told

MOST_BYTES = 4_000_000  # of them all; above this, the oldest are left out
_A_CHARACTER = 6  # bytes of a file: itself, its interval, its flags
_SHORTEST_FRAME = 8  # fewer other characters are usual when a line changes direction
_PATIENCE_NS = 1_000_000_000  # a reaction that comes later is not waited for
_NOTHING_LOST = bytes(flag for flag in range(256) if not flag & Flag.LOST_BEFORE)


class Heard(NamedTuple):
    """What a record says of its bus."""

    line: int
    settings: LineSettings
    end_ns: int
    telegram: bytes  # a good one; empty: none
    is_disturbed: bool  # a telegram may have been lost
    limits: str = ""  # told by the user
    is_before: bool = False  # from before this file


def heard(record: Record) -> Heard:
    """Return what a record says of its bus."""
    time_ns, kind, line, settings, data, intervals, flags, _, framing, code, is_bad = record
    telegram = data if kind in (Type.FRAME, Type.BEFORE) and framing == Framing.SIS and not is_bad else b""
    if kind == Type.FRAME:
        is_disturbed = is_bad
    elif kind == Type.OTHER:
        is_disturbed = len(data) >= _SHORTEST_FRAME
    else:
        is_disturbed = code in (Event.CHARACTERS_LOST, Event.ADAPTER_LOST)
    if flags.translate(None, _NOTHING_LOST):
        is_disturbed = True
    limits = data.decode(errors="replace") if code == Event.LIMITS_TOLD else ""
    return Heard(line, settings, time_ns + sum(intervals[1:]), telegram, is_disturbed, limits, kind == Type.BEFORE)


def bus_of(line: int) -> int:
    """Return the bus of a line: the two directions of a full-duplex tap are one."""
    return 1 if line == 2 else line


class Before:
    """What explains later telegrams, of all buses of a capture."""

    def __init__(self) -> None:
        self._buses: dict[int, Told] = {}
        self._settings: dict[int, LineSettings] = {}  # of each line, now
        self._limits: dict[tuple[int, str], LineSettings] = {}  # of lines that appeared during the capture
        self._end_ns = 0  # of the last record

    def take(self, heard: Heard) -> None:
        """Take the next record."""
        line = heard.line
        bus = bus_of(line)
        told = self._buses.get(bus)
        if told is None:
            told = self._buses[bus] = Told()
        self._settings[line] = heard.settings
        self._end_ns = heard.end_ns
        if heard.limits:
            self._limits[line, heard.limits] = heard.settings
        if heard.is_disturbed:
            told.disturb()
        if heard.telegram:
            told.take(heard.telegram, heard.end_ns, line, is_before=heard.is_before)

    def is_under_way(self, now_ns: int) -> bool:
        """Tell whether a command waits for its reaction, or more pieces follow; never after a long silence."""
        is_recent = 0 <= now_ns - self._end_ns < _PATIENCE_NS
        return is_recent and any(told.is_under_way for told in self._buses.values())

    def records(self, time_ns: int, most: int = MOST_BYTES) -> Iterator[Record]:
        """Yield the records for a file that begins at this time, with up to so many bytes.

        If nothing was told on a bus, an empty record says that the file continues another.
        """
        for (line, limits), settings in self._limits.items():
            yield event(time_ns, line, settings, Event.LIMITS_TOLD, limits)
        for bus, told in self._buses.items():
            room = min(most, MOST_BYTES) // len(self._buses) // _A_CHARACTER
            for line, telegram in told.telegrams(room) or [self._nothing(bus)]:
                count = len(telegram)
                unknown = bytes([Flag.INTERVAL_UNKNOWN]) * count
                yield Record(time_ns, Type.BEFORE, line, self._settings[line], telegram, (0,) * count, unknown)

    def _nothing(self, bus: int) -> Said:
        return Said(next(line for line in self._settings if bus_of(line) == bus), b"")
