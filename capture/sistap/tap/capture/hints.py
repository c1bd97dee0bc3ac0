# SPDX-License-Identifier: GPL-2.0-or-later
"""Hints while capturing: the most probable cause if nothing sensible arrives."""

from __future__ import annotations

from collections.abc import Iterator

from sistap.tap.capture.rate import Scan
from sistap.tap.line import others
from sistap.tap.line.settings import LineSettings, in_ms
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Framing
from sistap.tap.sis.rates import RATES

SILENT_S = 5
ENOUGH_ERRORS = 20  # so many characters, all with errors, are no accident
ENOUGH_DAMAGED = 5  # so many telegrams, none with a line error, although parity finds most damage
ENOUGH_CHARACTERS = 500  # more than the longest telegram (263), so at least one should be complete
ENOUGH_PIECES, FEW_AMONG = 10, 10  # so many pieces of telegrams are no accident, if telegrams are not ten times as many
_SILENT = "is the master on? Is this its port? Are all wires connected (+, -, ground)?"


class Hints:
    """Gives each hint once."""

    def __init__(
        self, settings: LineSettings, framing: Framing, *, errors_reported: bool = False, port: str = ""
    ) -> None:
        """`errors_reported`: the driver of the adapter is one that reports line errors."""
        self._parity_reported = errors_reported and settings.parity != "N"
        self._settings = settings
        self._framing = framing
        self._given: set[str] = set()
        self._port = port
        self._weighed: tuple[int, ...] = ()  # counters, when pieces were weighed
        self._torn = False
        self._doubt = False, False  # quiet and torn, when other programs were looked for

    def look(self, counters: Counters, elapsed_s: float, searching: Scan | None = None) -> Iterator[str]:
        """Yield the new hints; `elapsed_s` is how long the capture has been running, `searching` whether it looks
        for settings.
        """
        hint = _diagnose_search(counters, elapsed_s, searching) if searching else self._diagnose(counters, elapsed_s)
        sharing = self.sharing(counters, elapsed_s, searching)
        if counters.ascii_between:  # nothing else is wrong, however few telegrams there are
            hint, sharing = "this is the ASCII protocol of drives: capture it with --framing ascii", ""
        for text in (sharing, hint):
            if text and text not in self._given:
                self._given.add(text)
                yield text

    def sharing(
        self, counters: Counters, elapsed_s: float, searching: Scan | None = None, *, anew: bool = False
    ) -> str:
        """Return that another program may take characters, if what comes looks like it: no telegram, or pieces.

        It is looked for when the doubt begins, and at the end once more (`anew`): then it is said again.
        """
        quiet = elapsed_s >= SILENT_S and not counters.telegrams and not counters.faulty_characters
        torn = self._is_torn(counters, searching) or (quiet and counters.pieces > 1)
        before, self._doubt = self._doubt, (quiet, torn)
        if not (quiet or torn) or (self._doubt == before and not anew):
            return ""
        found = others.look(self._port)
        return found.warning(self._port) if found.known or (torn and found.unknown) else ""

    def _is_torn(self, counters: Counters, searching: Scan | None) -> bool:
        """Tell whether telegrams come in pieces, and no line error explains it.

        Noise changes characters: twice as many telegrams as pieces are damaged.
        """
        now = counters.pieces, counters.damaged, counters.telegrams, counters.faulty_characters
        pieces, damaged, telegrams, faulty = (new - old for new, old in zip(now, self._weighed or now, strict=True))
        if searching or not self._weighed or pieces >= ENOUGH_PIECES or telegrams >= FEW_AMONG * ENOUGH_PIECES:
            self._weighed = now
            enough = max(ENOUGH_PIECES, damaged * 2 / 3, telegrams / FEW_AMONG)
            self._torn = pieces >= enough and not (faulty or searching)
        return self._torn

    def _diagnose(self, counters: Counters, elapsed_s: float) -> str | None:
        settings = self._settings
        characters = counters.characters
        all_wrong = characters > 0 and counters.faulty_characters == characters
        hint = None
        if not characters and elapsed_s >= SILENT_S:
            hint = f"nothing received for {SILENT_S} s: {_SILENT}"
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


class Exactness:
    """Says when the times of a port have become much more or less exact."""

    PATIENCE_S = 10.0  # until its first sentence; then twice as long each time, for a computer that is never quiet
    LONGEST_S = 300.0
    LEAST_NS = 1_000_000  # a smaller change decides no verdict

    def __init__(self, name: str, uncertainty_ns: int, elapsed_s: float = 0) -> None:
        """Begin with what holds now."""
        self._name = name
        self._said_ns = uncertainty_ns
        self._patience_s = self.PATIENCE_S
        self._due_s = elapsed_s + self._patience_s

    def look(self, uncertainty_ns: int, elapsed_s: float) -> str:
        """Return what is new, with the bound that holds now; "" if it is about the same, or was said just before."""
        small, large = sorted((uncertainty_ns, self._said_ns))
        if elapsed_s < self._due_s or large < 2 * small or large - small < self.LEAST_NS:
            return ""
        busy = "busier" if uncertainty_ns == large else "less busy"
        change = f"{in_ms(uncertainty_ns)} now, {in_ms(self._said_ns)} before"
        text = f"{self._name}: uncertainty {change}: this computer is {busy}"
        self._said_ns = uncertainty_ns
        self._patience_s = min(2 * self._patience_s, self.LONGEST_S)
        self._due_s = elapsed_s + self._patience_s
        return text


def _diagnose_search(counters: Counters, elapsed_s: float, scan: Scan) -> str | None:
    hint = None
    if not counters.characters and elapsed_s >= SILENT_S:
        hint = f"nothing received for {SILENT_S} s: {_SILENT} (the search goes on)"
    elif scan.in_vain and counters.telegrams:
        hint = "telegrams come, but none without line errors: try --format 8O1, then others; the search goes on"
    elif scan.in_vain:
        hint = (
            f"no valid telegram at any rate from {RATES[0]} to {RATES[-1]} Bd: + and - may be swapped, "
            "or this is another protocol; the search goes on"
        )
    return hint
