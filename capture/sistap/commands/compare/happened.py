# SPDX-License-Identifier: GPL-2.0-or-later
"""What happened on each side: its episodes, those of the same thing as one."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from sistap.commands.compare import scatter
from sistap.commands.compare.side import Side
from sistap.dissected.episodes.episode import Episode
from sistap.dissected.episodes.rules import RULES, Severity, Subject

# Their details say what happened; those of others say how long or how much.
_TOLD_APART = {
    *("changed", "error", "write", "limit_write", "master", "phase", "rate", "limits"),
    *("fault", "warning", "exchanged", "conflict", "other", "busy", "never"),
}
_ERRORS = {"error", "busy", "never"}
_WORSE = 2  # times as bad as on the good side
_ORDER = {kind: number for number, kind in enumerate(RULES)}


@dataclass(frozen=True)
class Happened:
    """A thing that happened on a side or on both."""

    episode: Episode  # all of the bad side, or of the good one if the bad one has none
    apart: Sequence[Episode]  # the same, one by one
    good: int  # episodes: hits in a burst have one cause
    bad: int
    is_worse: bool  # longer, or farther beyond its limit
    ratio: float  # as often in the same time as on the good side; 0 if that does not have it
    is_certain: bool  # that it is more often, or less

    @property
    def is_new(self) -> bool:
        """Tell whether the good side does not have it."""
        return not self.good

    @property
    def can_be_chance(self) -> bool:
        """Tell whether it is a fault that comes now and then. Nobody new asks by chance, and no cable falls off."""
        kind = self.episode.kind
        return (
            not self.is_new
            or kind in ("error", "system_error")
            or (self.episode.rule.subject == Subject.LIMITS and kind != "clock")
        )

    @property
    def is_finding(self) -> bool:
        """Tell whether the bad side alone has it, or has it surely more often, or worse."""
        return bool(self.bad) and (self.is_new or self.is_worse or (self.is_certain and self.ratio > 1))

    @property
    def may_be_chance(self) -> bool:
        """Tell whether it is a fault that comes now and then, and not surely more often than before."""
        return self.can_be_chance and not self.is_certain


def happened(good: Side, bad: Side) -> list[Happened]:
    """Return what happened on either side: first what the bad side alone has, in the order of the answer."""
    sides = _by_thing(good.episodes), _by_thing(bad.episodes)
    share = bad.seconds / ((good.seconds + bad.seconds) or 1)
    found = [_happened(sides[0].get(thing, []), sides[1].get(thing, []), share) for thing in {**sides[0], **sides[1]}]
    return sorted(found, key=_order)


_Thing = tuple[str, int | None, str, str, bool]


def _by_thing(episodes: Iterable[Episode]) -> Mapping[_Thing, list[Episode]]:
    found: defaultdict[_Thing, list[Episode]] = defaultdict(list)
    for one in episodes:
        if one.kind != "gap" and not _is_life(one):  # captures of different days have gaps between them
            found[_thing(one)].append(one)
    return found


def _is_life(episode: Episode) -> bool:
    """Tell whether it is only what a machine does all day: it stands, boots, gets a recipe."""
    return episode.severity < Severity.WARNING and not episode.rule.is_kept


def _thing(episode: Episode) -> _Thing:
    kind, hit = episode.kind, episode.hit
    parameter = hit.parameter if kind not in _ERRORS else ""  # the same error of several parameters
    what = hit.detail if kind in _TOLD_APART else ""
    return kind, episode.station, parameter, what, episode.severity >= Severity.WARNING


def _happened(good: Sequence[Episode], bad: Sequence[Episode], share: float) -> Happened:
    episode = _joined(bad or good)
    is_worse = bool(good and bad) and episode.kind not in _TOLD_APART and _worst(bad) > _WORSE * _worst(good)
    ratio = len(bad) / len(good) * (1 - share) / share if good and share else 0.0
    is_certain = scatter.counts_differ(len(good), len(bad), share)
    return Happened(episode, bad or good, len(good), len(bad), is_worse, ratio, is_certain)


def _joined(episodes: Sequence[Episode]) -> Episode:
    joined = replace(episodes[0], packets=[*episodes[0].packets])
    for one in episodes[1:]:
        joined.join(one)
    if any(one.hit.parameter != joined.hit.parameter for one in episodes):
        joined.hit = joined.hit._replace(parameter="")
    return joined


def _worst(episodes: Iterable[Episode]) -> float:
    return max(abs(one.hit.worst or 0.0) for one in episodes)


def _order(one: Happened) -> tuple[bool, bool, Subject, bool, int, float]:
    """Sort by the side, the line of the answer, and the kind; what is certain comes before what may be usual."""
    episode = one.episode
    is_certain = episode.severity >= Severity.WARNING
    return not one.bad, not one.is_finding, episode.rule.subject, not is_certain, _ORDER[episode.kind], episode.from_s
