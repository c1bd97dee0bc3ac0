# SPDX-License-Identifier: GPL-2.0-or-later
"""How late the times of a capture are, compared with true times of another clock.

The offset of the two clocks is unknown. So the quickest character counts as in time, and a delay that all share is not
seen. The drift of one clock against the other is removed: it is the straight line below all characters and nearest to
them (an edge of their convex hull).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from sistap.beside.aligning import Pair
from sistap.line.settings import UNCERTAINTY_UNKNOWN

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


def quantile(ordered: Sequence[float], share: float) -> float:
    """Return the smallest of the sorted values that is not below `share` of them."""
    return ordered[max(0, math.ceil(share * len(ordered)) - 1)]


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
