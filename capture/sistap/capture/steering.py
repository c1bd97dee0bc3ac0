# SPDX-License-Identifier: GPL-2.0-or-later
"""Chooses the settings with which the lines of a capture are read: found by a search, or following rate changes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from sistap.capture.scan import Scan
from sistap.line.settings import LineSettings, Read
from sistap.records.record import Record
from sistap.sis.follow import Change, Follow

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
        self._changed: Change | None = None  # followed, and no valid telegram since
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

    def _changes(self, change: Change, now_ns: int) -> Iterator[Step]:
        if change.baud != self._settings.baud:
            self._changed, self._changed_ns, self._characters, self._doubted = change, now_ns, 0, False
            yield self._step(self._settings._replace(baud=change.baud), change.why)

    def _doubt(self, change: Change) -> Iterator[Step]:
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
