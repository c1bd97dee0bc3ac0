# SPDX-License-Identifier: GPL-2.0-or-later
"""A hit, an episode, and how an episode is written for programs."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any, NamedTuple

from sistap.dissected.episodes.rules import RULES, Rule, Severity

ARROW = " -> "  # from one value to the next, in the words of a hit
PACKETS = 10  # numbers that an episode keeps; then only the last one is replaced

_LASTS_S = 1.0
_CLOSE_S = 2e-6  # a number with decimals may be that far from the time of a packet


class Hit(NamedTuple):
    """Something unusual; times in s since 1970."""

    kind: str
    packet: int  # 0: all that have the parameter
    from_s: float
    to_s: float
    station: int | None = None
    parameter: str = ""
    detail: str = ""  # words about it
    worst: float | None = None  # how bad: a time in s, or a value
    severity: Severity | None = None  # where it is not that of the rule
    port: str = ""
    topic: str = ""  # hits with another one are another episode
    outcome: str = ""  # what became of it until the end


def severity_of(hit: Hit) -> Severity:
    """Return how bad it is."""
    return RULES[hit.kind].severity if hit.severity is None else hit.severity


@dataclass
class Episode:
    """Hits that belong together."""

    hit: Hit  # the worst
    severity: Severity
    from_s: float
    to_s: float
    count: int
    packets: list[int]
    outcome: str = ""  # what became of it until the end
    cause: str = ""  # what perhaps brought it about
    stations: set[int] = field(default_factory=set)

    @classmethod
    def of(cls, hit: Hit) -> Episode:
        """Begin one."""
        packets = [hit.packet] if hit.packet else []
        stations = set() if hit.station is None else {hit.station}
        return cls(hit, severity_of(hit), hit.from_s, hit.to_s, 1, packets, hit.outcome, stations=stations)

    def join(self, other: Episode) -> None:
        """Take in another one, perhaps of another station."""
        self.stations |= other.stations
        if (other.severity, other.hit.worst or 0) > (self.severity, self.hit.worst or 0):
            self.severity, self.hit = other.severity, other.hit
        self.from_s, self.to_s = min(self.from_s, other.from_s), max(self.to_s, other.to_s)
        self.count += other.count
        self.outcome = other.outcome
        self.packets = sorted({*self.packets, *other.packets})
        self.packets[PACKETS - 1 : -1] = []

    @property
    def kind(self) -> str:
        """Return its kind, a key of RULES."""
        return self.hit.kind

    @property
    def station(self) -> int | None:
        """Return whose it is; None: of the bus, or of several."""
        return self.hit.station if len(self.stations) < 2 else None

    @property
    def who(self) -> str:
        """Return the stations and the parameter it is about."""
        return " ".join(filter(None, [numbers(self.stations), self.hit.parameter]))

    @property
    def rule(self) -> Rule:
        """Return the rule of its kind."""
        return RULES[self.kind]

    @property
    def subject(self) -> str:
        """Return its title, with whom it is about."""
        stations = numbers(self.stations)
        return " ".join(filter(None, [f"{self.rule.title}{',' if stations else ''}", stations, self.hit.parameter]))

    @property
    def text(self) -> str:
        """Return a sentence."""
        times = f" ({self.count} times)" if self.count > 1 else ""
        return f"{self.subject}{': ' if self.detail else ''}{self.detail}{times}"

    @property
    def detail(self) -> str:
        """Return words about it."""
        return "; ".join(filter(None, [self.hit.detail, self.cause, self.outcome]))

    @property
    def lasts(self) -> bool:
        """Tell whether it has an end."""
        return self.to_s - self.from_s >= _LASTS_S

    @property
    def filter(self) -> str:
        """Return the display filter that finds its packets."""
        if not self.packets:
            return self._filter_of_values
        if len(self.packets) == 1 and self.lasts and self.rule.filter:
            return self.filter_by_time
        if len(self.packets) < PACKETS or not self.rule.filter:
            return f"frame.number in {{{', '.join(map(str, self.packets))}}}"
        return f"frame.number >= {self.packets[0]} && frame.number <= {self.packets[-1]} && ({self.rule.filter})"

    @property
    def _filter_of_values(self) -> str:
        talkers = " || ".join(f"sis.talker == {station}" for station in sorted(self.stations))
        if not self.hit.parameter:
            return self.filter_by_time
        return " && ".join(filter(None, [f'sis.parameter == "{self.hit.parameter}"', f"({talkers})", "sis.value"]))

    @property
    def filter_by_time(self) -> str:
        """Return the display filter that finds its time, in whichever file."""
        during = f"frame.time_epoch >= {self.from_s - _CLOSE_S:.6f} && frame.time_epoch <= {self.to_s + _CLOSE_S:.6f}"
        return f"{during} && ({self.rule.filter})" if self.rule.filter else during

    def as_json(self) -> dict[str, Any]:
        """Return it for programs."""
        return {
            "kind": self.kind,
            "severity": self.severity.name.lower(),
            "station": self.station,
            "stations": sorted(self.stations),
            "parameter": self.hit.parameter or None,
            "from": utc(self.from_s),
            "to": utc(self.to_s),
            "count": self.count,
            "worst": self.hit.worst,
            "packets": self.packets,
            "text": self.text,
            "do": self.rule.do,
        }


def numbers(stations: Collection[int]) -> str:
    """Write which stations: "station 3", "stations 3, 4"; nothing for none."""
    return f"station{'s' * (len(stations) > 1)} {', '.join(map(str, sorted(stations)))}" if stations else ""


def utc(epoch_s: float) -> str | None:
    """Write a time as ISO 8601 in UTC; None if no calendar has it."""
    try:
        return datetime.fromtimestamp(epoch_s, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
    except (ValueError, OverflowError, OSError):
        return None
