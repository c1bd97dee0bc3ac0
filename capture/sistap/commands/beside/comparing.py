# SPDX-License-Identifier: GPL-2.0-or-later
"""Two captures of the same traffic, and what Wireshark's dissector says of the limits in both."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from sistap.commands.beside.aligning import Pair, aligned, frames
from sistap.commands.beside.lateness import Lateness, measured
from sistap.dissected.captures.reading import NotCaptured
from sistap.dissected.wireshark.rows import columns, first, printing
from sistap.dissected.wireshark.tshark import Tshark, TsharkError
from sistap.tap.common.quantiles import quantile
from sistap.tap.terminal.exits import UsageError

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


SHARES = {"p50": 0.5, "p99": 0.99, "p99.9": 0.999, "longest": 1.0}


class Comparison:
    """A capture whose times are true, and another one."""

    def __init__(self, true: Path, other: Path) -> None:
        """Read and align both captures. UsageError if that is not possible."""
        self._paths = true, other
        try:
            self._true, self._other = frames(true), frames(other)
        except NotCaptured as error:
            raise UsageError(str(error)) from error
        except OSError as error:
            raise UsageError(f"cannot read {error.filename}: {error.strerror}; name two captures") from error
        self._pairs: Sequence[Pair] = aligned(self._true, self._other)
        if not self._pairs:
            raise UsageError(f"{true} and {other} have no telegram in common: are they of the same bus and time?")
        self.lateness: Lateness = measured(self._pairs)

    def lines(self) -> Iterator[str]:
        """Yield the report."""
        true, other = self._paths
        late = self.lateness
        yield f"{len(self._pairs)} telegrams in both, of {len(self._true)} in {true} and {len(self._other)} in {other}"
        yield (
            f"the clock of {other.name} is {late.offset_ns / 1e9:+.6f} s off and drifts by {late.drift_ppm:+.1f} ppm: "
            "both are taken out"
        )
        yield ""
        yield f"{len(late.characters)} characters; so late, against the quickest of them, are their times:"
        yield ""
        ordered = sorted(one.late_ns for one in late.characters)
        yield from (f"  {name:8} {quantile(ordered, share) / 1e6:10.4f} ms" for name, share in SHARES.items())
        yield ""
        yield self._outside()
        yield ""
        yield "verdicts:"
        yield ""
        yield from self._verdicts()

    def _outside(self) -> str:
        known = [one for one in self.lateness.characters if one.uncertainty_ns is not None]
        if not known:
            return "outside the uncertainty that the capture says: not known, it says none"
        outside = sum(one.is_outside for one in known)
        share = f"{100 * outside / len(known):.3g} %"
        return f"outside the uncertainty that the capture says: {outside} of {len(known)} ({share})"

    def _verdicts(self) -> Sequence[str]:
        true, other = self._paths
        try:
            with Tshark() as tshark:
                counts = compared(self._pairs, judged(tshark, true), judged(tshark, other))
        except TsharkError as error:
            return [f"  not compared: {str(error).splitlines()[-1]}"]
        return lines(counts)
