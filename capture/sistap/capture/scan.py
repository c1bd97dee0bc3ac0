# SPDX-License-Identifier: GPL-2.0-or-later
"""Searches for the settings of a line by listening, as a station does that has heard nothing for TDF (IF02 chapter
2.4).

It stays where a whole telegram comes without an error. It moves on after errors, or after characters without a
telegram.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from sistap.line.settings import LineSettings, Read
from sistap.records.counters import faulty, surely_faulty
from sistap.records.record import Record
from sistap.sis.rates import RATES
from sistap.sis.telegram import MAX_LENGTH

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
        errors = self.surely_faulty >= ENOUGH_ERRORS and self.surely_faulty * ACCIDENT > self.characters
        garbage = self.characters >= ENOUGH_CHARACTERS
        patience_ns = PAUSE_NS if self.characters else silence_ns
        silence = now_ns - (self.last_ns or self.since_ns or now_ns) >= patience_ns
        return errors or garbage or silence


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
