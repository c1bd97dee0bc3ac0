# SPDX-License-Identifier: GPL-2.0-or-later
"""What is wrong with a telegram or a record: as the colours and buttons of the profile.

Made by plugin/protocol/generate.py from faults.toml: edit there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class Fault(NamedTuple):
    """A fault and its tests, of which one must hold: FIELD (it is there), FIELD == NUMBER, or FIELD > NUMBER."""

    name: str
    short: str  # in a few words
    title: str
    tests: Sequence[str]
    live: Sequence[str] = ()  # tests in their place while a capture runs: what later packets tell is not known then

    @property
    def filter(self) -> str:
        """Return the display filter that finds it."""
        return " || ".join(self.tests)

    @property
    def live_tests(self) -> Sequence[str]:
        """Return its tests while a capture runs."""
        return self.live or self.tests

    @property
    def word(self) -> str:
        """Return its name in that of a file."""
        return self.name.replace("_", "-")


# In the order of the report; where several hold, the first names the packet.
FAULTS = (
    Fault(
        "tza_exceeded",
        "TzA exceeded",
        "Interval in a telegram longer than TzA",
        ("sis.tza.verdict == 1",),
    ),
    Fault(
        "trs_exceeded",
        "TrS exceeded",
        "Reaction later than TrS",
        ("sis.trs.verdict == 1",),
    ),
    Fault(
        "tmas_exceeded",
        "Tmas exceeded",
        "Master control word later than Tmas",
        ("sis.tmas.verdict == 1",),
    ),
    Fault(
        "unanswered",
        "no reaction",
        "Command without a reaction",
        ("sis.command.unanswered",),
        ("sis.unanswered_before",),
    ),
    Fault(
        "error_reaction",
        "reactions with an error",
        "Reaction with an error",
        ("sis.status > 0", "sis.control.status.error", "sisascii.kind == 7"),
    ),
    Fault(
        "system_error",
        "system error",
        "Telegram of a station that has an error",
        ("sis.control.error.set",),
    ),
    Fault(
        "damaged",
        "damaged",
        "Damaged telegram",
        ("sis.checksum.status == 0", "sis.length.differ", "sis.length.short", "sis.length.header", "sis.start.missing"),
    ),
    Fault(
        "line_error",
        "line error",
        "Error or break on the line",
        ("sertap.error.character", "sertap.error.break", "sertap.error.unlocated"),
    ),
    Fault(
        "lost",
        "lost",
        "Characters or the adapter lost",
        ("sertap.error.lost", "sertap.event.expert"),
    ),
    Fault(
        "repeated",
        "repeated",
        "Command sent again",
        ("sis.repeat_of",),
    ),
)

# No fault, but found in the same way.
WRITE = Fault(
    "write",
    "written",
    "Parameter written",
    (
        "sis.service == 0x1e",
        "sis.service == 0x1f",
        "sis.service == 0x8e",
        "sis.service == 0x8f",
        "sis.service == 0x9e",
        "sis.service == 0x9f",
        "sis.service == 0xce",
        "sis.service == 0xcf",
    ),
)
