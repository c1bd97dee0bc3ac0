# SPDX-License-Identifier: GPL-2.0-or-later
"""Chooses the settings with which the lines of a capture are read: found by a search, or following rate changes.

The search listens, as a station does that has heard nothing for TDF (IF02 chapter 2.4). It stays where a whole telegram
comes without an error. It moves on after errors, or after characters without a telegram.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.counters import faulty, surely_faulty
from sistap.tap.records.record import Record
from sistap.tap.sis.initialization import Follow, RateChange
from sistap.tap.sis.rates import RATES
from sistap.tap.sis.telegram import MAX_LENGTH

AUTO = "auto"  # instead of a rate: search for it
FORMATS = ("8E1", "8N1")  # that of the specification, and a frequent setting of drives in the field

ENOUGH_ERRORS = 8
# One error in this many characters may be an accident. With 8E1 read as 8N1, or the reverse, about half are wrong. But
# in some short telegrams none is.
ACCIDENT = 16
ENOUGH_CHARACTERS = 2 * MAX_LENGTH  # the rest of the telegram under way, and a whole one
PAUSE_NS = 1_000_000_000  # a telegram does not continue after such a pause
# On a silent line the search moves on after a time, which doubles in each round. Otherwise a bus that rarely sends
# would always meet the same few settings.
SILENCE_NS = 3_000_000_000
LONGEST_SILENCE_NS = 60_000_000_000


ALIKE = 0.05  # largest deviation of a measured rate, as a share


@dataclass
class _Try:
    """What was received with a setting."""

    settings: LineSettings
    since_ns: int | None  # None: the time on the line is not known yet
    last_ns: int | None = None  # time of the last character
    characters: int = 0
    faulty: int = 0  # upper bound: too many mean that these settings are not right
    surely_faulty: int = 0  # lower bound: too many mean that these settings are wrong

    def in_vain(self, now_ns: int, silence_ns: int) -> bool:
        """Tell whether to move on; a line without a character gets `silence_ns`."""
        if self.surely_faulty >= ENOUGH_ERRORS and self.surely_faulty * ACCIDENT > self.characters:
            return True
        if self.characters >= ENOUGH_CHARACTERS:
            return True
        if self.last_ns is not None:
            return now_ns - self.last_ns >= PAUSE_NS
        return self.since_ns is not None and now_ns - self.since_ns >= silence_ns


class Scan:
    """Searches on the line or lines of a bus. All times are those of its characters, in ns."""

    def __init__(self, formats: Sequence[str] = FORMATS, measure: Callable[[], float | None] = lambda: None) -> None:
        """Begin with 9600 Bd, the rate of all stations after power-on (chapter 2.5). `measure` returns the rate, if it
        can.

        If so, only the format must be searched for.
        """
        self._measure = measure
        self._all = [LineSettings.parse(baud, text) for baud in RATES for text in formats]
        self._tries = 1
        self._silence_ns = SILENCE_NS
        self._brought = 0  # consecutive settings that received characters
        self._try = _Try(self._all[0], None)
        self.found = False
        self.in_vain = False  # all settings received characters, but no telegram

    @property
    def settings(self) -> LineSettings:
        """Return the settings under test."""
        return self._try.settings

    def take(self, read: Read, records: Sequence[Record]) -> None:
        """Take what was read, and the records completed by it or by silence."""
        now = self._try
        if read.settings not in (None, now.settings):
            return  # it was read with the settings before
        if read.data:
            now.characters += len(read.data)
            now.faulty += faulty(read)
            now.surely_faulty += surely_faulty(read)
            now.last_ns = read.time_ns
        good = any(record.settings == now.settings and record.is_good_frame and not record.errors for record in records)
        self.found = good and now.faulty * ACCIDENT <= now.characters

    def look(self, now_ns: int) -> LineSettings | None:
        """Return the settings to go on with, None to stay."""
        now = self._try
        if now.since_ns is None:
            now.since_ns = now_ns
        if self.found or not now.in_vain(now_ns, self._silence_ns):
            return None
        self._brought = self._brought + 1 if now.characters else 0
        self.in_vain = self.in_vain or self._brought >= len(self._all)
        baud = self._measured()
        candidates = [one for one in self._all if baud in (None, one.baud)]
        self._try = _Try(candidates[self._tries % len(candidates)], now_ns)
        self._tries += 1
        if self._tries % len(self._all) == 1:
            self._silence_ns = min(2 * self._silence_ns, LONGEST_SILENCE_NS)
        return self.settings

    def _measured(self) -> int | None:
        """Return the rate nearest to the measured one; None: unknown."""
        measured = self._measure()
        return next((baud for baud in RATES if measured and abs(measured - baud) <= baud * ALIKE), None)


PATIENCE_NS = 5_000_000_000  # longest wait for a valid telegram after a rate change


class Step(NamedTuple):
    """Read the lines with these settings; if they are so already, they are right."""

    settings: LineSettings
    why: str


class Steering:
    """The lines of one bus, which share their settings. Times are those of the characters, in ns."""

    def __init__(
        self,
        settings: LineSettings,
        formats: Sequence[str] = (),
        *,
        follow: bool = False,
        measure: Callable[[], float | None] = lambda: None,
    ) -> None:
        """Begin with `settings`; search for a rate and one of `formats`, if there are any; `follow` the bus.

        `measure` returns the rate of the line, if it can be measured.
        """
        self._settings = settings
        self._formats = formats
        self._measure = measure
        self._scan = Scan(formats, measure) if formats else None
        self._follows = follow
        self._follow: Follow | None = None
        self._changed: RateChange | None = None  # followed, and no valid telegram since
        self._changed_ns = 0
        self._characters = 0  # since then
        self._doubted = False  # the doubt was reported
        self._hint: str | None = None  # not yet reported

    @property
    def searching(self) -> Scan | None:
        """Return the search, None if there is none or it has ended."""
        return None if self._scan is None or self._scan.found else self._scan

    def take(self, read: Read, records: Sequence[Record]) -> Iterator[Step]:
        """Take what was read, and the records that it completed."""
        scan = self.searching
        if scan:
            scan.take(read, records)
            if scan.found:
                yield self._step(scan.settings, "found, by a valid telegram")
        elif self._follows:
            yield from self._take_followed(read, records)

    def look(self, now_ns: int) -> Iterator[Step]:
        """Yield the steps that are due by time."""
        scan = self.searching
        settings = scan.look(now_ns) if scan else None
        if settings:
            yield self._step(settings, "looking for the rate")
        if self._follow and (change := self._follow.due(now_ns)):
            yield from self._changes(change, now_ns)
        if self._changed and now_ns - self._changed_ns >= PATIENCE_NS:
            yield from self._doubt(self._changed)

    def take_hint(self) -> str | None:
        """Return, once, a hint for the user."""
        hint, self._hint = self._hint, None
        return hint

    @property
    def due_ns(self) -> int | None:
        """Return the latest time of the next look()."""
        return self._follow.due_ns if self._follow else None

    def _take_followed(self, read: Read, records: Sequence[Record]) -> Iterator[Step]:
        self._characters += len(read.data)
        for record in records:
            if not record.is_good_frame:
                continue
            self._changed = None
            if self._follow is None:
                self._follow = Follow(record.settings.baud)
            if change := self._follow.take(record.data, record.end_ns):
                yield from self._changes(change, record.end_ns)

    def _changes(self, change: RateChange, now_ns: int) -> Iterator[Step]:
        if change.baud != self._settings.baud:
            self._changed, self._changed_ns, self._characters, self._doubted = change, now_ns, 0, False
            yield self._step(self._settings._replace(baud=change.baud), change.why)

    def _doubt(self, change: RateChange) -> Iterator[Step]:
        """React to a rate change without valid telegrams since. The bus may be silent, but not damaged."""
        search = bool(self._formats) and self._characters > 0
        if search or not self._doubted:
            brought = "no valid telegram" if self._characters else "nothing received"
            cure = "looking for it again" if search else "try --baud auto" if not self._formats else "waiting"
            self._hint = f"{brought} since the rate changed ({change.why}): {cure}"
            self._doubted = True
        if search:
            self._changed = self._follow = None
            self._scan = Scan(self._formats, self._measure)
            yield self._step(self._scan.settings, "looking for the rate again")

    def _step(self, settings: LineSettings, why: str) -> Step:
        self._settings = settings
        return Step(settings, why)
