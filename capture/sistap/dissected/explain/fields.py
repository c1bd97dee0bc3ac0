# SPDX-License-Identifier: GPL-2.0-or-later
"""The fields by which tshark explains a record, and the sentence made of them."""

from __future__ import annotations

import re
import tempfile
from typing import NamedTuple

from sistap.dissected.explain.advice import advice
from sistap.dissected.wireshark import rows
from sistap.dissected.wireshark.rows import INFO_FIELDS, NECESSARY, NO_DISSECTOR, first, info
from sistap.dissected.wireshark.trouble import unknown_fields
from sistap.dissected.wireshark.tshark import Tshark, TsharkError

EXPLANATION = "^-- "  # stands before each explanation in a log
_REACTION, _UNANSWERED = "sis.reaction_time", "sis.command.unanswered"
_FIELDS = (*INFO_FIELDS, NECESSARY, _REACTION, _UNANSWERED)
_INFO_COLUMN = ("-o", 'gui.column.format:"Info","%i"')  # the user's own columns may lack it
_COARSE_NS = 100_000_000  # stamps with larger steps say nothing about the time between two telegrams
_TAKEN = re.compile(r"(, (?:reached|failed)) after [\d.]+ s")


class Said(NamedTuple):
    """What the dissector says about a record."""

    info: str
    is_telegram: bool
    reaction_s: float | None  # time after its command, from packet to packet
    unanswered: bool
    advice: str = ""  # a line that says what to do about its fault, if the fields show one


class Fields:
    """The fields of an explanation that this tshark knows."""

    def __init__(self, tshark: Tshark, more: tuple[str, ...] = ()) -> None:
        """Ask tshark for its fields, including other ones. TsharkError if it has no dissector for SIS."""
        self._names = list(dict.fromkeys((*_FIELDS, *more)))
        with tempfile.TemporaryFile() as nothing:
            unknown = unknown_fields(tshark.run(["-r", "-", *self.arguments], stdin=nothing).stderr)
        if NECESSARY in unknown:
            raise TsharkError(NO_DISSECTOR)
        self._names = [name for name in self._names if name not in unknown]

    @property
    def arguments(self) -> list[str]:
        """Return the options that make tshark print them."""
        return [*_INFO_COLUMN, *rows.printing(self._names)]

    def columns(self, line: str) -> dict[str, str]:
        """Split what it prints for one packet; JOINT joins several values."""
        return rows.columns(self._names, line)

    def said(self, line: str) -> Said:
        """Parse what it prints for one record."""
        return said(self.columns(line))


def said(columns: dict[str, str]) -> Said:
    """Return what it says about one record."""
    reaction = first(columns.get(_REACTION, ""))
    return Said(
        info(columns),
        bool(columns.get(NECESSARY)),
        float(reaction) if reaction else None,
        bool(columns.get(_UNANSWERED)),
        advice(columns),
    )


def sentence(said: Said, resolution_ns: int | None) -> str:
    """Describe a record in a line. Times have the precision of the stamps; without stamps there are none."""
    text = said.info.replace("\n", " ").replace("\r", " ")
    if said.unanswered and "[no reaction]" not in text:
        text += "  [no reaction]"
    if resolution_ns is None or resolution_ns > _COARSE_NS:
        return _TAKEN.sub(r"\1", text)
    if said.reaction_s is not None:
        digits = min(3, 7 - len(str(resolution_ns)))  # digits of ms
        text += f"  {said.reaction_s * 1e3:.{max(0, digits)}f} ms after the command"
    return text
