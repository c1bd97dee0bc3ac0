# SPDX-License-Identifier: GPL-2.0-or-later
"""The values of a parameter as levels: where each begins, which are unusual, and the drift of all."""

from __future__ import annotations

import math
import statistics
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from sistap.dissected.episodes.rules import THRESHOLDS, Severity, Thresholds
from sistap.dissected.episodes.trend import Slots, Trend, quartiles, scatter, trend

_RECENT = 32  # values that make the present level
_LEAST = 8
_FADING = 0.97  # of the usual scatter, for each _LEAST values: a drive that stands still is not the usual
_MOVING = 0.25  # strays, and the time with so many: in between, a value that moves only seems to rest
_GOES_ON = 0.4  # of the slope of all, in the second half: else it levels out
_BLIPS = 40  # that are remembered
_RARE = 0.02  # of the values are alone outside
_SWINGS = 0.03  # of the values are strays: it swings as far in each cycle
_RESOLUTION = 0.005  # of the level: what scatters less is a constant


@dataclass
class Level:
    """Values in a row that are alike."""

    from_s: float
    to_s: float
    packet: int  # the first
    value: float = 0.0  # the middle of the last ones
    count: int = 0
    strays: int = 0  # values in between that are not alike
    is_lasting: bool = False  # it was told that it is

    @property
    def seconds(self) -> float:
        """Return its duration."""
        return self.to_s - self.from_s


class Levels:
    """The values of one parameter."""

    def __init__(self, thresholds: Thresholds = THRESHOLDS) -> None:
        """Begin with none."""
        self._thresholds = thresholds
        self._levels: list[Level] = []
        self._recent: deque[float] = deque(maxlen=_RECENT)
        self._outside: list[tuple[float, float, int]] = []
        self._slots = Slots()
        self._scatter = 0.0
        self.scale = 0.0  # of the quantity, where the values are only a part of it
        self._since = 0  # values since the level was last computed
        self._strays = 0  # values that were alone outside of a level
        self._stray_range = (math.inf, -math.inf)
        self._blips: list[Level] = []  # these values
        self.count = 0

    def add(self, time_s: float, value: float, packet: int) -> bool:
        """Add a value; tell whether a level is now one that lasts."""
        self.count += 1
        if len(self._levels) > self._thresholds.lively:
            self._forget(time_s)
            return False
        if not self._levels:
            self._levels.append(Level(time_s, time_s, packet, value))
        if self._is_inside(value):
            if self._outside:
                self._stray()
            self._take(time_s, value)
        else:
            self._outside.append((time_s, value, packet))
            if len(self._outside) == self._thresholds.level_values:
                self._next()
                self._forget(time_s)
        level = self._levels[-1]
        if level.is_lasting or level.seconds < self._thresholds.level_s:
            return False
        level.is_lasting = True
        return True

    def _stray(self) -> None:
        """Count values that were outside for a moment only."""
        values = [value for _, value, _ in self._outside]
        self._levels[-1].strays += len(values)
        self._strays += len(values)
        low, high = self._stray_range
        self._stray_range = min(low, *values), max(high, *values)
        first, last = self._outside[0], self._outside[-1]
        if len(self._blips) < _BLIPS:
            self._blips.append(Level(first[0], last[0], first[2], values[0], len(values)))
        self._outside.clear()

    def _forget(self, now_s: float) -> None:
        """Forget levels of long ago."""
        while len(self._levels) > 1 and self._levels[0].to_s < now_s - self._thresholds.memory_s:
            del self._levels[0]

    def _is_inside(self, value: float) -> bool:
        if len(self._recent) < _LEAST and len(self._levels) == 1:
            return True
        level = self._levels[-1].value
        return abs(value - level) <= self._thresholds.level_noise * max(self._scatter, _RESOLUTION * abs(level), 1e-9)

    def _take(self, time_s: float, value: float) -> None:
        self._slots.add(time_s, value)
        self._recent.append(value)
        self._levels[-1].count += 1
        self._levels[-1].to_s = max(time_s, self._levels[-1].to_s)
        self._since += 1
        if self._since >= _LEAST:
            self._compute()

    def _compute(self) -> None:
        self._since = 0
        level = self._levels[-1].value = statistics.median(self._recent)
        if len(self._recent) >= _LEAST:
            self._scatter = max(scatter(self._recent, level), _FADING * self._scatter)

    def _next(self) -> None:
        """Begin a level with the values outside of the last one."""
        outside, self._outside = self._outside, []
        from_s, _, packet = outside[0]
        self._levels.append(Level(from_s, from_s, packet))
        self._recent.clear()
        for time_s, value, _ in outside:
            self._take(time_s, value)
        self._compute()
        self._scatter = max(self._scatter, min(scatter(self._recent, self._levels[-1].value), 2 * self._scatter))

    @property
    def began_s(self) -> float:
        """Return when the last level began."""
        return self._levels[-1].from_s if self._levels else -math.inf

    @property
    def usual(self) -> float:
        """Return the level that holds longest."""
        return max(self._levels, key=lambda level: level.seconds).value

    def unusual(self) -> Iterator[tuple[Level, Severity]]:
        """Yield the levels that are far from all others, or that a value has that rarely changes."""
        levels = self._lasting()
        if len(levels) < 2:
            return
        values = self._without_drift(levels)
        usual = max(zip(values, levels, strict=True), key=lambda pair: pair[1].seconds)[0]
        lowest, highest = self._range(values, levels)
        for value, level in zip(values, levels, strict=True):
            if not self._was_seen(level):
                continue
            if not lowest <= value <= highest:
                yield level, Severity.WARNING
            elif self._rarely_changes(levels) and abs(value - usual) > self._least(usual):
                yield level, Severity.NOTE

    def blips(self) -> Sequence[Level]:
        """Return short peaks of a value that hardly ever leaves its level: too short for a level, but it was far."""
        is_calm = self._strays < _RARE * self.count
        return [one for one in self._blips if abs(one.value - self.usual) > self._least(self.usual)] if is_calm else []

    def unlike(self, good: Levels) -> Iterator[Level]:
        """Yield the levels that are far from all of a good time, and not unusual beside their neighbours."""
        usual = good._lasting()
        if not usual:
            return
        lowest, highest = good._range([level.value for level in usual], usual)
        noise = self._thresholds.level_noise * self._scatter
        told = [level for level, _ in self.unusual()]
        for level in self._lasting():
            if level not in told and not lowest - noise <= level.value <= highest + noise:
                yield level

    def _lasting(self) -> list[Level]:
        """Return the levels that are not only a ramp; none of a value that just moves."""
        moving_s = sum(level.seconds for level in self._levels if level.strays > level.count * _MOVING)
        all_s = sum(level.seconds for level in self._levels)
        if len(self._levels) > self._thresholds.lively or moving_s > all_s * _MOVING:
            return []
        return [level for level in self._levels if level.seconds >= self._thresholds.level_s]

    def _was_seen(self, level: Level) -> bool:
        """Tell whether the value was read shortly before or after it, too. Else it may have moved slowly."""
        place = self._levels.index(level)
        before, after = self._levels[max(place - 1, 0)], self._levels[min(place + 1, len(self._levels) - 1)]
        edges_s = [level.from_s - one.to_s for one in (before,) if one is not level]
        edges_s += [one.from_s - level.to_s for one in (after,) if one is not level]
        return any(edge_s <= self._thresholds.level_edge_s for edge_s in edges_s)

    def _rarely_changes(self, levels: Sequence[Level]) -> bool:
        return len(levels) <= self._thresholds.few_levels and self._strays < _SWINGS * self.count

    def _least(self, usual: float) -> float:
        return self._thresholds.level_least * max(abs(usual), self.scale)

    def _range(self, values: Sequence[float], levels: Sequence[Level]) -> tuple[float, float]:
        """Return from where to where levels with these values are not far."""
        low, high = quartiles([(value, level.seconds) for value, level in zip(values, levels, strict=True)])
        least = self._least(max(zip(values, levels, strict=True), key=lambda pair: pair[1].seconds)[0])
        far = max(self._thresholds.level_far * (high - low), least, self._thresholds.level_noise * self._scatter)
        if self._strays < _SWINGS * self.count:
            return low - far, high + far
        return min(low - far, self._stray_range[0]), max(high + far, self._stray_range[1])

    def _without_drift(self, levels: Sequence[Level]) -> list[float]:
        """Return their values as if they had not drifted."""
        drift = self.drift()
        slope = drift[1].slope if drift else 0.0
        return [level.value - slope * (level.to_s - levels[-1].to_s) for level in levels]

    def drift(self, since_s: float = -math.inf) -> tuple[Sequence[tuple[float, float]], Trend] | None:
        """Return the points and the line, if there is a drift from a time on."""
        points = [point for point in self._slots.points() if point[0] >= since_s]
        if len(points) < _LEAST * 2 or points[-1][0] - points[0][0] < self._thresholds.drift_s:
            return None
        found = trend(points)
        moved = abs(found.slope) * (points[-1][0] - points[0][0])
        middle = statistics.median(value for _, value in points)
        least = self._thresholds.drift_least * max(abs(middle), self.scale)
        is_far = moved >= max(least, self._thresholds.drift_noise * found.scatter, 1e-9)
        if not is_far or found.chance >= self._thresholds.drift_chance:
            return None
        return (points, found) if goes_on(points, found) else None


def goes_on(points: Sequence[tuple[float, float]], found: Trend) -> bool:
    """Tell whether a trend goes on to the end. What warms up levels out: that is no drift."""
    return trend(points[len(points) // 2 :]).slope / found.slope >= _GOES_ON
