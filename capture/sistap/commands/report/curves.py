# SPDX-License-Identifier: GPL-2.0-or-later
"""Values of parameters along the time of a capture, in bounded memory, for curves."""

from __future__ import annotations

import statistics
from collections.abc import Iterator
from dataclasses import dataclass

from sistap.dissected.accesses.access import Access, Parameter

MOST_CURVES = 200
MOST_POINTS = 600  # of a curve; more are joined, neighbour with neighbour
_LEAST_S = 0.001  # width of a slot; each later one is twice as wide
_LONG = 10  # times the usual time between two values: then nothing was read for long
_VISIBLE = 0.02  # and this part of the whole time


@dataclass
class CurvePoint:
    """A value, or several that came soon after one another. Times in s since the first packet."""

    begin_s: float
    end_s: float
    first: float
    last: float
    least: float
    greatest: float
    is_written: bool  # any of them

    def join(self, other: CurvePoint) -> None:
        """Take in the one after it."""
        self.end_s, self.last = other.end_s, other.last
        self.least, self.greatest = min(self.least, other.least), max(self.greatest, other.greatest)
        self.is_written |= other.is_written


class Curve:
    """The values of a parameter."""

    def __init__(self) -> None:
        """Begin with none."""
        self.points: list[CurvePoint] = []
        self.count = 0  # of values
        self.is_written = False
        self._width_s = 0.0  # of a slot, the values of which are joined

    def add(self, time_s: float, number: float, *, is_written: bool) -> None:
        """Add a value."""
        self.count += 1
        self.is_written |= is_written
        self._put(self.points, CurvePoint(time_s, time_s, number, number, number, number, is_written))
        while len(self.points) > MOST_POINTS:
            self._widen()

    def _put(self, points: list[CurvePoint], point: CurvePoint) -> None:
        if points and self._width_s and self._slot(points[-1]) == self._slot(point):
            points[-1].join(point)
        else:
            points.append(point)

    def _slot(self, point: CurvePoint) -> int:
        return int(point.begin_s / self._width_s)  # around 0 both signs: times may go back, and it has to end

    def _widen(self) -> None:
        self._width_s = max(self._width_s * 2, _LEAST_S)
        joined: list[CurvePoint] = []
        for point in self.points:
            self._put(joined, point)
        self.points = joined

    @property
    def moved(self) -> bool:
        """Whether the value was not the same all the time."""
        return min(point.least for point in self.points) < max(point.greatest for point in self.points)

    def pieces(self, duration_s: float) -> Iterator[list[CurvePoint]]:
        """Yield the points between which no long time was without a value; `duration_s` is that of the capture."""
        pauses = [after.begin_s - before.end_s for before, after in zip(self.points, self.points[1:], strict=False)]
        long_s = max(_LONG * statistics.median(pauses), _VISIBLE * duration_s) if pauses else 0.0
        begin = 0
        for index, pause_s in enumerate(pauses, 1):
            if pause_s > long_s:
                yield self.points[begin:index]
                begin = index
        yield self.points[begin:]


class Curves:
    """Those of the first parameters that have numbers."""

    def __init__(self) -> None:
        """Begin with none."""
        self._curves: dict[Parameter, Curve] = {}

    def add(self, time_s: float, access: Access) -> None:
        """Add a value, if it is a number."""
        if access.number is None:
            return
        curve = self._curves.get(access.parameter)
        if curve is None:
            if len(self._curves) == MOST_CURVES:
                return
            curve = self._curves[access.parameter] = Curve()
        curve.add(time_s, access.number, is_written=access.is_write)

    def moved(self) -> dict[Parameter, Curve]:
        """Return those whose value was not the same all the time: the written ones first, then the often read."""
        found = [(parameter, curve) for parameter, curve in self._curves.items() if curve.moved]
        return dict(sorted(found, key=lambda item: (not item[1].is_written, -item[1].count)))
