# SPDX-License-Identifier: GPL-2.0-or-later
"""What Wireshark's dissector says of the limits, in both captures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from sistap.beside.aligning import Pair
from sistap.wireshark.rows import columns, first, printing
from sistap.wireshark.tshark import Tshark

LIMITS = {"TzA": "sis.tza.verdict", "TrS": "sis.trs.verdict"}
WORDS = {"0": "ok", "1": "exceeded", "2": "unresolved", "": "none"}
UNRESOLVED = "unresolved"

_FIELDS = ["frame.number", *LIMITS.values()]

Judged = dict[int, dict[str, str]]  # the verdict on each limit, by packet


def judged(tshark: Tshark, capture: Path) -> Judged:
    """Return the verdicts on the packets of a capture. Raise TsharkError."""
    rows = (columns(_FIELDS, row) for row in tshark.lines(["-2", "-r", str(capture), *printing(_FIELDS)]))
    return {
        int(row["frame.number"]): {
            limit: WORDS.get(first(row.get(field, "")), "none") for limit, field in LIMITS.items()
        }
        for row in rows
    }


def compared(pairs: Iterable[Pair], true: Judged, other: Judged) -> dict[str, Counter[tuple[str, str]]]:
    """Count, for each limit, each pair of verdicts in both captures."""
    counts: dict[str, Counter[tuple[str, str]]] = {limit: Counter() for limit in LIMITS}
    for one, another in pairs:
        for limit, count in counts.items():
            both = true.get(one.number, {}).get(limit, "none"), other.get(another.number, {}).get(limit, "none")
            if both != ("none", "none"):
                count[both] += 1
    return counts


def lines(counts: dict[str, Counter[tuple[str, str]]]) -> Sequence[str]:
    """Return the counts as lines; mark the wrong verdicts."""
    said = []
    for limit, count in counts.items():
        for (true, other), number in sorted(count.items()):
            mark = "" if true == other else "  open" if UNRESOLVED in (true, other) else "  DIFFERENT"
            said.append(f"  {limit}  {true:10}  {other:10}  {number:8}{mark}")
    return ["  limit  true        other          times", *said] if said else ["  none: no limit was set"]
