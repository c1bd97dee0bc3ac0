# SPDX-License-Identifier: GPL-2.0-or-later
"""What to do about what is wrong with a record, as its expert item says it."""

from __future__ import annotations

from collections.abc import Mapping

from sistap.dissected.wireshark import rows
from sistap.tap.sis.faults import FAULTS, UNRESOLVED

# Tests, and a line for what passes one of them. Damage comes first: the status of a damaged telegram may be anything.
_ADVICE = [
    *(
        ((*fault.tests, *fault.live), f"What to do: {fault.do}")
        for fault in sorted(FAULTS, key=lambda fault: fault.name != "damaged")
    ),
    (
        ("sis.tza.verdict == 2", "sis.trs.verdict == 2", "sis.tmas.verdict == 2"),
        f"Unresolved, whether a limit was kept. {UNRESOLVED}",
    ),
]
FIELDS = rows.tested(test for tests, _ in _ADVICE for test in tests)


def advice(columns: Mapping[str, str]) -> str:
    """Return a line for the first fault that the fields of a packet show; empty if they show none."""
    return next((text for tests, text in _ADVICE if rows.passes(tests, columns)), "")
