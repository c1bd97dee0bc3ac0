# SPDX-License-Identifier: GPL-2.0-or-later
"""What a picture shows, in the units of its data."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

# By role, on white paper. The page gives each role another colour in the dark. Blue, green and vermilion can be told
# apart by people who do not see red or green; red things have words beside them as well.
COLOURS = {
    "ink": "#1d2733",
    "line": "#8b95a1",
    "command": "#0072b2",
    "reaction": "#009e73",
    "other": "#9aa0a6",
    "bad": "#d1350f",
}

# The calendar repeats every 400 years. Windows has no time after the year 3000.
_CALENDAR_S = 146_097 * 86_400

Points = Sequence[tuple[float, float]]


class Area(NamedTuple):
    """A filled area below points, down to a base."""

    points: Points
    base: float
    role: str


class Bar(NamedTuple):
    """A filled box, or its outline."""

    begin: float
    end: float
    base: float
    height: float
    role: str
    opacity: float = 1.0
    is_outline: bool = False
    link: str = ""
    tip: str = ""  # shown beside the mouse


class Strokes(NamedTuple):
    """Upright strokes: there can be thousands."""

    at: Sequence[float]
    base: float
    height: float
    role: str
    width_pt: float


class Polyline(NamedTuple):
    """A line through points."""

    points: Points
    role: str
    width_pt: float = 1.0
    is_dashed: bool = False
    has_ticks: bool = False  # a small stroke at each point


class Dots(NamedTuple):
    """Dots at points."""

    points: Points
    role: str
    size_pt: float


class Text(NamedTuple):
    """Words at a point; `up` is their distance above it, in points."""

    x: float
    y: float
    words: str
    role: str = "ink"
    size_pt: float = 8.0
    up: float = 0.0
    right: float = 0.0
    in_front: bool = False  # at the left edge, whatever x is


Mark = Area | Bar | Strokes | Polyline | Dots | Text


class Tick(NamedTuple):
    """A number at an axis."""

    value: float
    words: str


@dataclass
class Axis:
    """One axis."""

    low: float = 0.0
    high: float = 1.0
    is_log: bool = False
    label: str = ""
    ticks: Sequence[Tick] = ()

    def since(self, begin: float) -> Axis:
        """Return it for values that are counted from `begin` on; its numbers stay."""
        ticks = [Tick(tick.value - begin, tick.words) for tick in self.ticks]
        return replace(self, low=self.low - begin, high=self.high - begin, ticks=ticks)

    def place(self, value: float) -> float:
        """Return where a value stands, 0 to 1; outside of the axis it is less or more."""
        if not self.is_log:
            return (value - self.low) / (self.high - self.low)
        low, high = math.log10(self.low), math.log10(self.high)
        return (math.log10(max(value, 1e-300)) - low) / (high - low)


@dataclass
class Panel:
    """A picture in a rectangle with two axes."""

    x: Axis = field(default_factory=Axis)
    y: Axis = field(default_factory=Axis)
    marks: list[Mark] = field(default_factory=list)
    title: Sequence[str] = ()
    key: Sequence[tuple[str, str]] = ()  # role and words
    height: float = 1.0  # beside other panels
    size_pt: float = 10.0  # of its numbers

    def add(self, *marks: Mark) -> None:
        """Draw over what is there."""
        self.marks += marks

    def name_lanes(self, names: Sequence[str]) -> None:
        """Give lanes at 0, -1, -2 ... their names and a ground line each."""
        self.y = Axis(0.7 - len(names), 0.95, ticks=[Tick(0.4 - lane, name) for lane, name in enumerate(names)])

    @property
    def lanes(self) -> int:
        """Return the number of lanes; 0 for an axis with numbers."""
        return len(self.y.ticks) if self.y.ticks and self.y.high == 0.95 else 0


@dataclass(frozen=True)
class Drawing:
    """A picture: rows of panels of one width each."""

    title: str
    width_in: float
    height_in: float
    draw: Callable[[], Sequence[Sequence[Panel]]]
    is_wide: bool = True  # it needs the width of a page


def linear(low: float, high: float, count: int = 6, label: str = "") -> Axis:
    """Return an axis with round numbers."""
    if not low < high:
        low, high = low - abs(low) / 10 - 1e-9, high + abs(high) / 10 + 1e-9
    power = 10 ** math.floor(math.log10((high - low) / count))
    step = next(factor * power for factor in (1, 2, 2.5, 5, 10) if factor * power * count >= high - low)
    values = [number * step for number in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]
    return Axis(low, high, label=label, ticks=[Tick(value, f"{value:.10g}") for value in values])


def milliseconds(shown_s: Iterable[float], label: str) -> Axis:
    """Return a logarithmic axis of times that has at least a decade, so that it has numbers. The values are in s."""
    shown = list(shown_s)
    low, high = min(shown), max(shown)
    middle, half = math.sqrt(low * high), max(math.sqrt(high / low) * 1.3, 10**0.6)
    return logarithmic(middle / half, middle * half, label, 1e3, (1.0, 2.0, 5.0) if half < 30 else (1.0,))


def logarithmic(low: float, high: float, label: str, scale: float = 1.0, factors: Sequence[float] = (1.0,)) -> Axis:
    """Return a logarithmic axis; its numbers are `scale` times the values."""
    decades = range(math.floor(math.log10(low * scale)), math.ceil(math.log10(high * scale)) + 1)
    values = [factor * 10.0**decade / scale for decade in decades for factor in factors]
    ticks = [Tick(value, f"{value * scale:.10g}") for value in values if low <= value <= high]
    return Axis(low, high, True, label, ticks)


def times_of_day(begin_s: float, end_s: float) -> Axis:
    """Return an axis of local times of day; the values are s since 1970."""
    steps = (1, 2, 5, 10, 30, 60, 120, 300, 600, 1800, 3600, 7200, 14400, 21600, 43200, 86400)
    step = next(
        (step for step in steps if (end_s - begin_s) / step <= 8), 86400 * math.ceil((end_s - begin_s) / 691200)
    )
    shift_s = _shift_s(begin_s)
    first = math.ceil((begin_s + shift_s) / step)
    values = [number * step - shift_s for number in range(first, math.floor((end_s + shift_s) / step) + 1)]
    pattern = "%d.%m. %H:%M" if end_s - begin_s > 86400 else "%H:%M:%S" if step < 60 else "%H:%M"
    ticks = [Tick(value, time.strftime(pattern, time.gmtime((value + shift_s) % _CALENDAR_S))) for value in values]
    return Axis(begin_s, max(end_s, begin_s + 1e-3), ticks=ticks)


def _shift_s(epoch_s: float) -> int:
    """Return how much local time is ahead of UTC; 0 for a time in no calendar."""
    try:
        return time.localtime(epoch_s).tm_gmtoff
    except (ValueError, OverflowError, OSError):
        return 0
