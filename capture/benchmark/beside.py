# SPDX-License-Identifier: GPL-2.0-or-later
"""Are the times of an adapter true? Compares its capture with that of a logic analyser, of the same bus and time.

    beside.py ANALYSER.pcapng ADAPTER.pcapng

Telegrams are matched by their contents. A bus repeats itself. So the first step finds the offset of the two clocks that
most telegrams agree on; if several are as good, the smallest. From there on, one telegram follows the other in both
captures. Where contents or times differ, telegrams of one capture are skipped until the next ones match at the same
offset. This distinguishes a missing telegram from a late one.

The quickest character counts as in time, so a delay that all share is not seen. The drift of one clock against the
other is removed: it is the straight line below all characters and nearest to them (an edge of their convex hull).
"""

from __future__ import annotations

import sys
from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from itertools import takewhile
from pathlib import Path
from statistics import median
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from sistap.dissected.captures.reading import packets, record_of  # noqa: E402 - of the checkout
from sistap.tap.common.quantiles import quantile  # noqa: E402
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag  # noqa: E402
from sistap.tap.records.record import Record, Type  # noqa: E402
from sistap.tap.terminal.exits import NotCaptured  # noqa: E402 - of the checkout

SHARES = {"p50": 0.5, "p99": 0.99, "p99.9": 0.999, "longest": 1.0}

PROBES = 400  # consecutive telegrams by which the offset is found
MOST = 2000  # places of one telegram that are examined
BIN_NS = 50_000_000
AS_GOOD = 0.95  # of the votes of the best offset
CLOSE_NS = 20_000_000  # a telegram that is late by less is never in doubt
SKIPPED, AHEAD = 64, 16  # most telegrams missing in one capture, and telegrams used to judge that
ENOUGH = 3  # consecutive matches that are no accident
_SLOW = 16  # telegrams until the offset follows a change


class Frame(NamedTuple):
    """A telegram as one capture has it."""

    number: int  # number of its packet in Wireshark
    data: bytes
    times_ns: Sequence[int]  # as they are in the capture
    latest_ns: Sequence[int]  # latest arrival of each character: of several in a read, the last came last
    uncertainty_ns: int

    @property
    def time_ns(self) -> int:
        """Return the time of its first character."""
        return self.times_ns[0]


Pair = tuple[Frame, Frame]


def frames(path: Path) -> list[Frame]:
    """Read the telegrams of a capture. Raise OSError or NotCaptured."""
    records = []
    for number, packet in enumerate(packets(path), 1):
        try:
            if one := record_of(packet):
                records.append((number, one))
        except (ValueError, IndexError) as error:
            raise NotCaptured(f"{path} has a damaged record: {error}; leave it out in Wireshark") from error
    latest = latest_times([one for _, one in records])
    found = [
        Frame(number, one.data, _times(one), times, one.uncertainty_ns)
        for (number, one), times in zip(records, latest, strict=True)
        if one.type == Type.FRAME
    ]
    return sorted(found, key=lambda frame: frame.time_ns)


def aligned(true: Sequence[Frame], other: Sequence[Frame]) -> list[Pair]:
    """Return the common telegrams of both, in order; empty if the captures have different traffic."""
    places: dict[bytes, list[Frame]] = defaultdict(list)
    for frame in true:
        places[frame.data].append(frame)
    pairs: list[Pair] = []
    here = there = 0
    while here < len(true) and there < len(other):
        offset_ns = _offset_ns(places, other[there : there + PROBES])
        if offset_ns is not None:
            first_ns = other[there].time_ns - offset_ns - BIN_NS
            here = max(here, bisect_left(true, first_ns, key=lambda frame: frame.time_ns))
            here, there, found = _walk(true, other, here, there, offset_ns)
            pairs += found
            if found:
                continue
        there += PROBES
    return pairs


def _offset_ns(places: dict[bytes, list[Frame]], probes: Sequence[Frame]) -> float | None:
    """Return the offset that most probes agree on: how much later their times are than the true ones."""
    found = [probe.time_ns - one.time_ns for probe in probes for one in places.get(probe.data, [])[:MOST]]
    bins = Counter(offset // BIN_NS for offset in found)
    if sum(bins.values()) < min(ENOUGH, len(probes)):
        return None
    votes = {bin_: bins[bin_] + bins[bin_ + 1] for bin_ in bins}
    enough = max(votes.values()) * AS_GOOD
    best = min((bin_ for bin_, count in votes.items() if count >= enough), key=lambda bin_: (abs(bin_), -votes[bin_]))
    return median(offset for offset in found if best <= offset // BIN_NS <= best + 1)


def _walk(
    true: Sequence[Frame], other: Sequence[Frame], here: int, there: int, offset_ns: float
) -> tuple[int, int, list[Pair]]:
    """Pair the telegrams from here on, until many have no partner. Return the ends and the pairs."""
    pairs: list[Pair] = []
    at = there
    while here < len(true) and at < len(other) and at - there < PROBES:
        off_ns = _off_ns(true[here], other[at], offset_ns)
        if true[here].data != other[at].data or abs(off_ns) > CLOSE_NS:
            skipped = _skipped(true[here : here + SKIPPED + AHEAD], other[at : at + SKIPPED + AHEAD], offset_ns)
            if skipped is None:
                at += 1
                continue
            here, at = here + skipped[0], at + skipped[1]
            off_ns = _off_ns(true[here], other[at], offset_ns)
        pairs.append((true[here], other[at]))
        offset_ns += max(-CLOSE_NS, min(off_ns, CLOSE_NS)) / _SLOW
        here, at = here + 1, at + 1
        there = at
    return here, there, pairs


def _skipped(true: Sequence[Frame], other: Sequence[Frame], offset_ns: float) -> tuple[int, int] | None:
    """Return how many telegrams are missing in the other capture, and in the true one."""
    best: tuple[float, int] | None = None
    chosen = None
    for skips in _SKIPS:
        if skips[0] >= len(true) or skips[1] >= len(other) or true[skips[0]].data != other[skips[1]].data:
            continue
        run = _alike(true[skips[0] :], other[skips[1] :])
        if run < min(ENOUGH, len(true) - skips[0], len(other) - skips[1]):
            continue
        # A late telegram is followed by others that are in time again.
        off_ns = _off_ns(true[skips[0] + run - 1], other[skips[1] + run - 1], offset_ns)
        judged = abs(off_ns) // CLOSE_NS, sum(skips)
        if best is None or judged < best:
            best, chosen = judged, skips
    return chosen


def _alike(true: Sequence[Frame], other: Sequence[Frame]) -> int:
    """Count the telegrams that match from the first on."""
    pairs = zip(true[:AHEAD], other[:AHEAD], strict=False)
    return sum(1 for _ in takewhile(lambda pair: pair[0].data == pair[1].data, pairs))


def _off_ns(true: Frame, other: Frame, offset_ns: float) -> float:
    return other.time_ns - true.time_ns - offset_ns


_SKIPS = sorted(((one, another) for one in range(SKIPPED) for another in range(SKIPPED)), key=sum)[: SKIPPED * 8]


def _times(record: Record) -> list[int]:
    times = [record.time_ns]
    for interval in record.intervals[1:]:
        times.append(times[-1] + interval)
    return times


def latest_times(records: Sequence[Record]) -> list[list[int]]:
    """Return the latest times of each record. A read can continue in the next record of its line."""
    latest: list[list[int]] = [[]] * len(records)
    behind: Counter[int] = Counter()  # for each line: characters of the same read that came later
    for index in reversed(range(len(records))):
        record = records[index]
        times = _times(record)
        for place in reversed(range(len(record.flags))):
            times[place] -= behind[record.line] * record.settings.character_ns
            same_read = record.flags[place] & Flag.SAME_READ
            behind[record.line] = behind[record.line] + 1 if same_read else 0
        latest[index] = times
    return latest


LARGEST_PPM = 500  # more is not drift of two clocks, but chance in a short capture

_Point = tuple[int, int]  # a true time, and how much later the other time is


class Late(NamedTuple):
    """One character."""

    true_ns: int
    late_ns: float  # its time in the capture
    latest_ns: float  # latest possible arrival, according to the capture
    uncertainty_ns: int | None  # of both captures; None: not known

    @property
    def is_outside(self) -> bool:
        """Tell whether it came outside the bounds that the capture states."""
        return self.uncertainty_ns is not None and self.latest_ns > self.uncertainty_ns


class Lateness(NamedTuple):
    """All characters, in their order."""

    characters: Sequence[Late]
    offset_ns: float  # of the clocks, at the first character
    drift_ppm: float


def measured(pairs: Sequence[Pair]) -> Lateness:
    """Measure the characters of these telegrams (at least one)."""
    begin_ns = pairs[0][0].time_ns
    points = sorted(
        (true_ns - begin_ns, latest_ns - true_ns)
        for true, other in pairs
        for true_ns, latest_ns in zip(true.times_ns, other.latest_ns, strict=True)
    )
    (x, y), slope = _below(points)
    characters = []
    for true, other in pairs:
        known = UNCERTAINTY_UNKNOWN not in (true.uncertainty_ns, other.uncertainty_ns)
        uncertainty_ns = true.uncertainty_ns + other.uncertainty_ns if known else None
        for true_ns, latest_ns, time_ns in zip(true.times_ns, other.latest_ns, other.times_ns, strict=True):
            clock_ns = y + slope * (true_ns - begin_ns - x)
            late_ns, latest_late_ns = time_ns - true_ns - clock_ns, latest_ns - true_ns - clock_ns
            characters.append(Late(true_ns, late_ns, latest_late_ns, uncertainty_ns))
    return Lateness(characters, y - slope * x, slope * 1e6)


def _below(points: Sequence[_Point]) -> tuple[_Point, float]:
    """Return a point and the slope of the line below these sorted points that is nearest to all of them."""
    mean = sum(x for x, _ in points) / len(points)
    hull: list[_Point] = []
    for point in points:
        while len(hull) > 1 and _turns_right(hull[-2], hull[-1], point):
            hull.pop()
        hull.append(point)
    for left, right in zip(hull, hull[1:], strict=False):
        if left[0] <= mean <= right[0] and left[0] < right[0]:
            slope = (right[1] - left[1]) / (right[0] - left[0])
            if abs(slope) * 1e6 <= LARGEST_PPM:
                return left, slope
    return min(points, key=lambda point: point[1]), 0.0


def _turns_right(first: _Point, second: _Point, third: _Point) -> bool:
    """Tell whether the second point lies on or above the line between the others."""
    return (second[0] - first[0]) * (third[1] - first[1]) <= (second[1] - first[1]) * (third[0] - first[0])


def lines(true: Path, other: Path) -> Iterator[str]:
    """Yield the report. OSError, NotCaptured, or ValueError if the captures have nothing in common."""
    ours, theirs = frames(true), frames(other)
    pairs = aligned(ours, theirs)
    if not pairs:
        raise ValueError(f"{true} and {other} have no telegram in common: are they of the same bus and time?")
    late = measured(pairs)
    yield f"{len(pairs)} telegrams in both, of {len(ours)} in {true} and {len(theirs)} in {other}"
    yield f"the clock of {other.name} is {late.offset_ns / 1e9:+.6f} s off and drifts by {late.drift_ppm:+.1f} ppm"
    ordered = sorted(one.late_ns for one in late.characters)
    yield f"{len(ordered)} characters; so late, against the quickest of them, are their times:"
    yield from (f"  {name:8} {quantile(ordered, share) / 1e6:10.4f} ms" for name, share in SHARES.items())
    known = [one for one in late.characters if one.uncertainty_ns is not None]
    outside = sum(one.is_outside for one in known)
    yield f"outside the uncertainty that the capture says: {outside} of {len(known)}, not known of the others"


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    try:
        print(*lines(Path(sys.argv[1]), Path(sys.argv[2])), sep="\n")
    except (OSError, NotCaptured, ValueError) as error:
        sys.exit(f"beside.py: {error}")
