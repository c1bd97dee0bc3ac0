# SPDX-License-Identifier: GPL-2.0-or-later
"""Looks for the settings of a line by listening, as a station does that has heard nothing for TDF (IF02 chapter 2.4).

It stays where a whole telegram comes without an error, and goes on where errors come, or characters that are none.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from sistap.line.settings import LineSettings, Read
from sistap.records.counters import faulty, surely_faulty
from sistap.records.record import Record
from sistap.sis.rates import RATES
from sistap.sis.telegram import MAX_LENGTH

AUTO = "auto"  # in place of a rate: look for it
FORMATS = ("8E1", "8N1")  # of the specification, and what drives in the field are often set to

ENOUGH_ERRORS = 8
# One in so many may be an accident. Of 8E1 read as 8N1, or the other way round, about half are wrong, but short
# telegrams exist in which none is.
ACCIDENT = 16
ENOUGH_CHARACTERS = 2 * MAX_LENGTH  # the rest of the telegram that was going on, and a whole one
PAUSE_NS = 1_000_000_000  # after it what has come is no telegram any more
# A line on which nothing comes is given up for the next settings, in each round after twice the time: a bus that speaks
# only now and then would otherwise always meet the same few.
SILENCE_NS = 3_000_000_000
LONGEST_SILENCE_NS = 60_000_000_000


ALIKE = 0.05  # so much, as a share, may a rate be off that was measured


@dataclass
class _Try:
    """What some settings have brought."""

    settings: LineSettings
    since_ns: int | None  # None: it is not known yet what time it is on the line
    last_ns: int | None = None  # when the last character came
    characters: int = 0
    faulty: int = 0  # all that can be: these settings are not right
    surely_faulty: int = 0  # those that are: these settings are wrong

    def in_vain(self, now_ns: int, silence_ns: int) -> bool:
        """Tell whether to go on; a line without a character gets `silence_ns`."""
        errors = self.surely_faulty >= ENOUGH_ERRORS and self.surely_faulty * ACCIDENT > self.characters
        garbage = self.characters >= ENOUGH_CHARACTERS
        patience_ns = PAUSE_NS if self.characters else silence_ns
        silence = now_ns - (self.last_ns or self.since_ns or now_ns) >= patience_ns
        return errors or garbage or silence


class Scan:
    """A bus, be it of one line or two. All times are those of its characters, in ns."""

    def __init__(self, formats: Sequence[str] = FORMATS, measure: Callable[[], float | None] = lambda: None) -> None:
        """Begin with 9600 Bd: all stations have it after power-on (chapter 2.5). `measure` tells the rate, if it can.

        Where it does, only the format is left to look for.
        """
        self._measure = measure
        self._all = [LineSettings.parse(baud, text) for baud in RATES for text in formats]
        self._tries = 1
        self._silence_ns = SILENCE_NS
        self._brought = 0  # how many settings, one after the other, have brought something
        self._try = _Try(self._all[0], None)
        self.found = False
        self.in_vain = False  # all settings have brought something, and none a telegram

    @property
    def settings(self) -> LineSettings:
        """The settings that are tried now."""
        return self._try.settings

    def take(self, read: Read, records: Sequence[Record]) -> None:
        """Take what was read and the records that it, or silence, completed."""
        now = self._try
        if read.settings not in (None, now.settings):
            return  # it was on its way when they changed
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
        """Return the rate nearest to what is measured; None: it is not known."""
        measured = self._measure()
        return next((baud for baud in RATES if measured and abs(measured - baud) <= baud * ALIKE), None)
