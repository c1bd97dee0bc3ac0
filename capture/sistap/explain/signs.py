# SPDX-License-Identifier: GPL-2.0-or-later
"""The fields that mark a record as unusual, and the name of each reason.

Only fields of a live dissection: what a later packet tells is not known yet.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from sistap.sis import faults
from sistap.wireshark.rows import field_of, holds


class Sign(NamedTuple):
    """A reason and its tests, of which one must match: FIELD (it is there), FIELD == NUMBER, or FIELD > NUMBER."""

    reason: str
    tests: Sequence[str]


FAULTS = [Sign(fault.name.replace("_", "-"), fault.live or fault.tests) for fault in faults.FAULTS]
WRITES = [Sign("write", [f"sis.service == {service:#x}" for service in faults.WRITES])]


def expression(signs: Iterable[Sign]) -> str:
    """Return the display filter that finds them."""
    return " || ".join(test for sign in signs for test in sign.tests)


def fields(signs: Iterable[Sign]) -> list[str]:
    """Return the fields of their tests."""
    return list(dict.fromkeys(field_of(test) for sign in signs for test in sign.tests))


def reason(signs: Iterable[Sign], columns: Mapping[str, str]) -> str:
    """Return the first reason that the fields of a packet show; empty if none."""
    return next((sign.reason for sign in signs if any(holds(test, columns) for test in sign.tests)), "")
