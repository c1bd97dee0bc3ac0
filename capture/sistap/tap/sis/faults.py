# SPDX-License-Identifier: GPL-2.0-or-later
"""What is wrong with a telegram or a record: as the colours and buttons of the profile.

Made by plugin/protocol/generate.py from faults.toml and experts.toml: edit there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple


class Fault(NamedTuple):
    """A fault and its tests, of which one must hold: FIELD (it is there), FIELD == NUMBER, or FIELD > NUMBER."""

    name: str
    short: str  # in a few words
    title: str
    tests: Sequence[str]
    live: Sequence[str] = ()  # tests in their place while a capture runs: what later packets tell is not known then
    do: str = ""  # what to do about it

    @property
    def filter(self) -> str:
        """Return the display filter that finds it."""
        return " || ".join(self.tests)

    @property
    def live_tests(self) -> Sequence[str]:
        """Return its tests while a capture runs."""
        return self.live or self.tests


# In the order of the report; where several hold, the first names the packet.
FAULTS = (
    Fault(
        "tza_exceeded",
        "TzA exceeded",
        "Interval in a telegram longer than TzA",
        ("sis.tza.verdict == 1",),
        do="Look which station talks, and at which character. Reduce its load, or set a longer TzA.",
    ),
    Fault(
        "trs_exceeded",
        "TrS exceeded",
        "Reaction later than TrS",
        ("sis.trs.verdict == 1",),
        do="Look which station is late, and in which service. Set a longer TrS in the master if the station may "
        "be that slow.",
    ),
    Fault(
        "tmas_exceeded",
        "Tmas exceeded",
        "Master control word later than Tmas",
        ("sis.tmas.verdict == 1",),
        do="Look what kept the master from writing S-0-0134.",
    ),
    Fault(
        "unanswered",
        "no reaction",
        "Command without a reaction",
        ("sis.command.unanswered",),
        ("sis.unanswered_before",),
        do="Look whether this station answers at other times. If never: address, cable, power. If sometimes: "
        "compare its reaction times with the master's time-out.",
    ),
    Fault(
        "error_reaction",
        "reactions with an error",
        "Reaction with an error",
        ("sis.status > 0", "sis.control.status.error", "sisascii.kind == 7"),
        do="Read the error code in the reaction.",
    ),
    Fault(
        "system_error",
        "system error",
        "Telegram of a station that has an error",
        ("sis.control.error.set",),
        do="Read the diagnosis of that device, such as S-0-0390 or S-0-0095.",
    ),
    Fault(
        "damaged",
        "damaged",
        "Damaged telegram",
        ("sis.checksum.status == 0", "sis.length.differ", "sis.length.short", "sis.length.header", "sis.start.missing"),
        do="Look at line errors and losses at this packet. Check cable, termination, ground and baud rate.",
    ),
    Fault(
        "line_error",
        "line error",
        "Error or break on the line",
        ("sertap.error.character", "sertap.error.break", "sertap.error.unlocated"),
        do="Check baud rate and format first, then cable, termination and ground.",
    ),
    Fault(
        "lost",
        "lost",
        "Characters or the adapter lost",
        ("sertap.error.lost", "sertap.event.expert"),
        do="Close other programs, or use an adapter with a larger buffer: sistap doctor.",
    ),
    Fault(
        "repeated",
        "repeated",
        "Command sent again",
        ("sis.repeat_of",),
        do="Look at the command before it: was it damaged, not answered, or answered too late?",
    ),
)

# What to do where a verdict is unresolved.
UNRESOLVED = (
    "Make the times more exact: instead of a log, capture with sistap, with the latency timer of an FTDI "
    "adapter at 1 ms. sistap doctor says how. A logic analyser decides to a microsecond. If it depends on"
    " where TzA begins to count and you know it, set the preference sis.tza_from."
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

# Expert items that tell an episode by themselves, and its kind.
SIGNS: Mapping[str, str] = {
    "sis.list.recursion": "against",
    "sis.reaction.again": "again",
    "sis.body.missing": "against",
    "sis.body.unexpected": "against",
    "sis.length.long": "against",
    "sis.control.warning.set": "warning_bit",
    "sis.sender.invalid": "against",
    "sis.receiver.reserved": "against",
    "sis.receiver.level_broadcast": "against",
    "sis.reaction.unexpected": "unexpected",
    "sis.twm.early": "early",
}
