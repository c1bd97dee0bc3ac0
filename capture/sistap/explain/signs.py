# SPDX-License-Identifier: GPL-2.0-or-later
"""The fields that mark a record as unusual, and the name of each reason.

Only fields of a live dissection: what a later packet tells is not known yet.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from sistap.wireshark.rows import JOINT


class Sign(NamedTuple):
    """A reason and its tests, of which one must match: FIELD (it is there), FIELD == NUMBER, or FIELD > NUMBER."""

    reason: str
    tests: Sequence[str]


# As the colours of the profile.
FAULTS = (
    Sign(
        "damaged",
        ("sis.checksum.status == 0", "sis.length.differ", "sis.length.short", "sis.length.header", "sis.start.missing"),
    ),
    Sign("gap", ("sertap.error.lost", "sertap.event.expert")),
    Sign("line-error", ("sertap.error.character", "sertap.error.break", "sertap.error.unlocated")),
    Sign("slow-characters", ("sis.tza.verdict == 1",)),
    Sign("late-reaction", ("sis.trs.verdict == 1",)),
    Sign("late-cycle", ("sis.tmas.verdict == 1",)),
    Sign("error", ("sis.status > 0", "sis.control.error.set", "sis.control.status.error")),
    Sign("unanswered", ("sis.unanswered_before",)),
    Sign("repeated", ("sis.repeat_of",)),
)
WRITES = (Sign("write", tuple(f"sis.service == {service:#x}" for service in (0x1E, 0x1F, 0x8E, 0x8F, 0x9E, 0x9F))),)


def expression(signs: Iterable[Sign]) -> str:
    """Return the display filter that finds them."""
    return " || ".join(test for sign in signs for test in sign.tests)


def fields(signs: Iterable[Sign]) -> list[str]:
    """Return the fields of their tests."""
    return list(dict.fromkeys(test.split()[0] for sign in signs for test in sign.tests))


def reason(signs: Iterable[Sign], columns: Mapping[str, str]) -> str:
    """Return the first reason that the fields of a packet show; empty if none."""
    return next((sign.reason for sign in signs if any(_holds(test, columns) for test in sign.tests)), "")


def _holds(test: str, columns: Mapping[str, str]) -> bool:
    field, *rest = test.split()
    values = [value for value in columns.get(field, "").split(JOINT) if value]
    if not rest:
        return bool(values)
    operator, number = rest[0], int(rest[1], 0)
    return any(int(value, 0) == number if operator == "==" else int(value, 0) > number for value in values)
