# SPDX-License-Identifier: GPL-2.0-or-later
"""How late the times of a capture are, compared with true times of another clock.

The offset of the two clocks is unknown. So the quickest character counts as in time, and a delay that all share is not
seen. The drift of one clock against the other is removed: it is the straight line below all characters and nearest to
them (an edge of their convex hull).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from sistap.commands.beside.aligning import Pair
from sistap.dissected.draw.panel import Axis, Dots, Drawing, Line, Panel, linear
from sistap.tap.common.quantiles import quantile
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN

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


# -- The plot --------------------------------------------------------------------------------------------------------

_WIDE_IN, _HIGH_IN = 10.0, 4.0
_ACROSS, _UP = 1000, 300  # cells of the picture; characters in the same one are one dot
_SHARES = 200  # points of the distribution


def drawing(lateness: Lateness) -> Drawing:
    """Draw the lateness of each character over time, and its distribution."""
    return Drawing("How late the times are", _WIDE_IN, _HIGH_IN, lambda: [[_over_time(lateness), _shares(lateness)]])


def _over_time(lateness: Lateness) -> Panel:
    characters = lateness.characters
    begin_ns = characters[0].true_ns

    def at_s(one: Late) -> float:
        return (one.true_ns - begin_ns) / 1e9

    panel = Panel(linear(0, max(map(at_s, characters)), label="seconds since the first character"), _late(lateness))
    panel.y.label = "late by ms, against the quickest"
    bounds = ((at_s(one), one.uncertainty_ns / 1e6) for one in characters if one.uncertainty_ns)
    panel.add(Dots(_thinned(bounds, panel), "line", 1.0))
    key = [("line", "uncertainty")]
    for is_outside, role, name in ((False, "command", "inside"), (True, "bad", "outside")):
        chosen = [(at_s(one), one.latest_ns / 1e6) for one in characters if one.is_outside == is_outside]
        panel.add(Dots(_thinned(chosen, panel), role, 3.0))
        key.append((role, f"{name}: {len(chosen)}"))
    panel.key = key
    return panel


def _shares(lateness: Lateness) -> Panel:
    ordered = sorted(one.latest_ns / 1e6 for one in lateness.characters)
    shares = [number / _SHARES for number in range(_SHARES + 1)]
    panel = Panel(linear(0, 100, 4, "% of the characters"), _late(lateness))
    panel.add(Line([(100 * share, quantile(ordered, share)) for share in shares], "command"))
    return panel


def _late(lateness: Lateness) -> Axis:
    shown = [one.latest_ns for one in lateness.characters]
    shown += [one.uncertainty_ns for one in lateness.characters if one.uncertainty_ns]
    return linear(min(shown) / 1e6, max(shown) / 1e6)


def _thinned(points: Iterable[tuple[float, float]], panel: Panel) -> list[tuple[float, float]]:
    """Return one point of each cell, so that hours of characters make a small picture."""
    return list(
        {(round(panel.x.place(x) * _ACROSS), round(panel.y.place(y) * _UP)): (x, y) for x, y in points}.values()
    )
