# SPDX-License-Identifier: GPL-2.0-or-later
"""What differs between two sides, and whether it may be chance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

from sistap.commands.compare import scatter
from sistap.commands.compare.happened import Happened, happened
from sistap.commands.compare.samples import Samples
from sistap.commands.compare.side import LIMITS, ServiceOfSide, Side
from sistap.dissected.accesses.listing import Listed
from sistap.dissected.packets.distribution import Distribution
from sistap.tap.sis.limits import limit_text
from sistap.tap.sis.telegram import service_name

SMALL = 0.05  # times that differ by less than this part count as equal


@dataclass(frozen=True)
class Count:
    """How often something came on each side."""

    what: str
    good: int
    bad: int
    may_be_chance: bool

    @property
    def is_new(self) -> bool:
        """Tell whether it is on the bad side alone."""
        return not self.good


class Quantile(NamedTuple):
    """A time that a given part of all times do not exceed, on each side, in s."""

    good_s: float
    bad_s: float
    may_be_chance: bool

    def differs(self, uncertainty_s: float) -> bool:
        """Tell whether the difference exceeds the uncertainty of the clocks, SMALL, and chance."""
        apart_s = abs(self.bad_s - self.good_s)
        return apart_s > max(uncertainty_s, SMALL * self.good_s) and not self.may_be_chance

    @property
    def ratio(self) -> float:
        """Return the bad side's time as a multiple of the good one's; 0 if that is 0."""
        return self.bad_s / self.good_s if self.good_s else 0.0


@dataclass(frozen=True)
class Times:
    """Reaction times of a service, or intervals in the telegrams of a station."""

    what: str
    station: int
    good: Distribution
    bad: Distribution
    middle: Quantile
    tail: Quantile
    uncertainty_s: float  # of a difference

    @property
    def differing(self) -> Quantile | None:
        """Return the quantile of both that differs, if any."""
        return next((one for one in (self.middle, self.tail) if one.differs(self.uncertainty_s)), None)


class ComparedParameter(NamedTuple):
    """A parameter whose last value differs; None: this side does not have it."""

    good: Listed | None
    bad: Listed | None
    moves: bool  # changes by itself, without being written

    @property
    def listed(self) -> Listed:
        """Return the side that knows it."""
        found = self.bad or self.good
        assert found is not None
        return found


class ComparedSetting(NamedTuple):
    """A property of the line or a limit."""

    what: str
    good: str
    bad: str

    @property
    def differs(self) -> bool:
        """Tell whether both sides differ."""
        return self.good != self.bad


@dataclass
class Comparison:
    """All differences, and what is equal."""

    good: Side
    bad: Side
    happened: list[Happened]
    stations: list[Count]  # that are on one side only
    services: list[Count]  # as well
    times: list[Times]
    parameters: list[ComparedParameter]
    settings: list[ComparedSetting]


def compare(good: Side, bad: Side) -> Comparison:
    """Compare two sides."""
    return Comparison(
        good,
        bad,
        happened=happened(good, bad),
        stations=list(_one_sided(good.stations, bad.stations, _sent(good, bad), lambda station: f"station {station}")),
        services=list(_one_sided(good.services, bad.services, _sent(good, bad), service_text)),
        times=list(_times(good, bad)),
        parameters=list(_parameters(good, bad)),
        settings=list(_settings(good, bad)),
    )


def service_text(service: ServiceOfSide) -> str:
    """Name a service and its station."""
    return f"{service_name(service.number)} (0x{service.number:02x}) of station {service.station}"


def _sent(good: Side, bad: Side) -> float:
    """Return the bad side's share of all telegrams."""
    return bad.telegrams / ((good.telegrams + bad.telegrams) or 1)


def _one_sided(good: Counter[Any], bad: Counter[Any], share: float, text: Callable[[Any], str]) -> Iterator[Count]:
    for what in sorted(good.keys() ^ bad.keys()):
        is_certain = scatter.counts_differ(good[what], bad[what], share)
        yield Count(text(what), good[what], bad[what], may_be_chance=not is_certain)


def _times(good: Side, bad: Side) -> Iterator[Times]:
    # A time is the difference of two stamps that may each be late, and the other side's time is, too.
    uncertainty_s = good.uncertainty_s + bad.uncertainty_s
    for service in sorted(good.reactions.keys() & bad.reactions.keys()):
        what = f"answers {service_name(service.number)} (0x{service.number:02x})"
        yield _pair(what, service.station, good.reactions[service], bad.reactions[service], uncertainty_s)
    for station in sorted(good.intervals.keys() & bad.intervals.keys()):
        what = "from character to character"
        yield _pair(what, station, good.intervals[station], bad.intervals[station], uncertainty_s)


def _pair(what: str, station: int, good: Samples, bad: Samples, uncertainty_s: float) -> Times:
    def quantile(share: float, *, is_certain: bool) -> Quantile:
        return Quantile(good.whole.within_s(share), bad.whole.within_s(share), may_be_chance=not is_certain)

    middle = quantile(0.5, is_certain=scatter.middles_differ(good, bad))
    tail = quantile(scatter.TAIL, is_certain=scatter.tails_differ(good, bad))
    return Times(what, station, good.whole, bad.whole, middle, tail, uncertainty_s)


def _parameters(good: Side, bad: Side) -> Iterator[ComparedParameter]:
    # Ports are left out: the tap may be at another port today.
    sides = [{listed.parameter._replace(port=""): listed for listed in side.parameters} for side in (good, bad)]
    for key in dict.fromkeys([*sides[0], *sides[1]]):
        before, after = (side.get(key) for side in sides)
        if before and after:
            if _differ(before, after):
                yield ComparedParameter(before, after, _moves(before) or _moves(after))
        elif (one := before or after) and one.writes:
            yield ComparedParameter(before, after, moves=False)


def _differ(before: Listed, after: Listed) -> bool:
    if before.value is not None and after.value is not None:
        return before.whole != after.whole
    return bool(before.last and after.last and before.last != after.last)


def _moves(listed: Listed) -> bool:
    """Tell whether it changed by itself. An actual position does, so its last value tells nothing."""
    numbers = {access.number for access in (listed.least, listed.greatest) if access}
    return not listed.writes and (listed.first != listed.last or len(numbers) > 1)


def _settings(good: Side, bad: Side) -> Iterator[ComparedSetting]:
    yield ComparedSetting("Rate and format", *(", ".join(sorted(side.settings)) or "not known" for side in (good, bad)))
    for name, title in LIMITS.items():
        yield ComparedSetting(title, *(_limits(side.limits[name]) for side in (good, bad)))


def _limits(limits: Iterable[float]) -> str:
    return ", ".join(map(limit_text, sorted(limits))) or "none"
