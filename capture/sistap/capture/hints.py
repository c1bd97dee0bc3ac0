# SPDX-License-Identifier: GPL-2.0-or-later
"""Hints while capturing: the most probable cause if nothing sensible arrives."""

from __future__ import annotations

from collections.abc import Iterator

from sistap.capture.rate import Scan
from sistap.line.settings import LineSettings
from sistap.records.counters import Counters
from sistap.records.record import Framing
from sistap.sis.rates import RATES

SILENT_S = 5
ENOUGH_ERRORS = 20  # so many characters, all with errors, are no accident
ENOUGH_DAMAGED = 5  # so many telegrams, none with a line error, although parity finds most damage
ENOUGH_CHARACTERS = 500  # more than the longest telegram (263), so at least one should be complete


class Hints:
    """Gives each hint once."""

    def __init__(self, settings: LineSettings, framing: Framing, *, errors_reported: bool = False) -> None:
        """`errors_reported`: the driver of the adapter is one that reports line errors."""
        self._parity_reported = errors_reported and settings.parity != "N"
        self._settings = settings
        self._framing = framing
        self._given: set[str] = set()

    def look(self, counters: Counters, elapsed_s: float, searching: Scan | None = None) -> Iterator[str]:
        """Yield the new hints; `elapsed_s` is how long the capture has been running, `searching` whether it looks
        for settings.
        """
        hint = _diagnose_search(counters, elapsed_s, searching) if searching else self._diagnose(counters, elapsed_s)
        if counters.ascii_between:  # nothing else is wrong, however few telegrams there are
            hint = "this is the ASCII protocol of drives: capture it with --framing ascii"
        if hint and hint not in self._given:
            self._given.add(hint)
            yield hint

    def _diagnose(self, counters: Counters, elapsed_s: float) -> str | None:
        settings = self._settings
        characters = counters.characters
        all_wrong = characters > 0 and counters.faulty_characters == characters
        hint = None
        if not characters and elapsed_s >= SILENT_S:
            hint = f"nothing received for {SILENT_S} s: check the wiring (+, - and ground) and the port"
        # A wrong parity makes no break and spoils no telegram; swapped wires and a wrong rate do both.
        elif all_wrong and characters >= ENOUGH_ERRORS and (counters.telegrams or not counters.breaks):
            other = "8E1" if settings.parity == "N" else "8N1"
            hint = f"every character has an error with {settings.format}: try --format {other}, then --baud auto"
        elif all_wrong and characters >= ENOUGH_ERRORS:
            hint = "only breaks and framing errors: + and - may be swapped, or the rate is wrong: try --baud auto"
        elif self._framing == Framing.SIS and characters >= ENOUGH_CHARACTERS and not counters.telegrams:
            hint = (
                f"{ENOUGH_CHARACTERS} characters and no valid telegram at {settings.baud} Bd: "
                "try --baud auto; if it finds nothing, this is another protocol"
            )
        elif self._parity_reported and counters.damaged >= ENOUGH_DAMAGED and not counters.faulty_characters:
            hint = (
                f"{ENOUGH_DAMAGED} damaged telegrams, and not one line error: they were sent so, or the adapter "
                "reports none, as some copies of the CP2102: try another adapter"
            )
        return hint


def _diagnose_search(counters: Counters, elapsed_s: float, scan: Scan) -> str | None:
    hint = None
    if not counters.characters and elapsed_s >= SILENT_S:
        hint = f"nothing received for {SILENT_S} s: check the wiring (+, - and ground) and the port; the search goes on"
    elif scan.in_vain and counters.telegrams:
        hint = "telegrams come, but none without line errors: try --format 8O1, then others; the search goes on"
    elif scan.in_vain:
        hint = (
            f"no valid telegram at any rate from {RATES[0]} to {RATES[-1]} Bd: + and - may be swapped, "
            "or this is another protocol; the search goes on"
        )
    return hint
