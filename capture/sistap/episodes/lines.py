# SPDX-License-Identifier: GPL-2.0-or-later
"""The answer in five lines: what happened, with times and stations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

from sistap.episodes.episode import Episode
from sistap.episodes.rules import RULES, SUBJECTS, Severity, Subject
from sistap.wireshark.rows import local

NOT_OK = "NOT OK"
_ALONE = 3  # episodes of a kind that are told one by one; of those against limits, one
_PHRASES = 8  # in a line
_LONG_S = 1.0  # an episode that lasts longer has an end
_DAY_S = 86_400
_SAME_S = 60.0  # within which a drive's values change together
_UNTITLED = {"silent", "changed", "write", "master"}  # their words say what they are


class Phrase(NamedTuple):
    """A part of a line."""

    text: str
    episode: Episode  # the worst that it tells


class Line(NamedTuple):
    """A line of the answer."""

    subject: str
    verdict: str  # of the first line
    phrases: Sequence[Phrase]
    left_out: int  # episodes

    @property
    def text(self) -> str:
        """Return it in words."""
        more = f"; and {self.left_out} more" if self.left_out else ""
        said = "; ".join(phrase.text for phrase in self.phrases) + more
        if self.verdict:
            return f"{self.verdict}. {said}." if said else f"{self.verdict}."
        return f"{self.subject}: {said or 'nothing'}."


def verdict(episodes: Iterable[Episode]) -> str:
    """Tell whether something has to be looked at."""
    worst = max((episode.severity for episode in episodes), default=Severity.INFO)
    return NOT_OK if worst >= Severity.WARNING else "No fault is certain" if worst == Severity.NOTE else "OK"


def lines(episodes: Sequence[Episode], begin_s: float, end_s: float) -> list[Line]:
    """Return the five lines on a capture from one time to the other, in s since 1970."""
    clock = clock_of(begin_s, end_s)
    first = f"{verdict(episodes)}, {clock(begin_s)} to {clock(end_s)}"
    made = []
    for subject, name in zip(Subject, SUBJECTS, strict=True):
        found = [episode for episode in episodes if episode.rule.subject == subject]
        phrases = list(_phrases([one for one in found if not _is_explained(one, found)], clock))
        left_out = len(phrases) - _PHRASES
        made.append(Line(name, "" if subject else first, phrases[:_PHRASES], max(left_out, 0)))
    return made


def clock_of(begin_s: float, end_s: float) -> Callable[[float], str]:
    """Return what writes a time of day between two times; with the day where they are far apart."""
    day = "%Y-%m-%d " if end_s - begin_s >= _DAY_S else ""

    def clock(epoch_s: float) -> str:
        then = local(epoch_s)
        return then.strftime(f"{day}%H:%M:%S") if then else "a time in no calendar"

    return clock


def _is_explained(episode: Episode, others: Iterable[Episode]) -> bool:
    """Tell whether a step comes with another value of the same drive that tells more, or with a larger one."""
    if episode.kind == "master":
        return any(other.kind == "write" and other.station == episode.station for other in _near(episode, others))
    if episode.kind != "step":
        return False
    near = [other for other in _near(episode, others) if other.station == episode.station]
    return any(other.kind == "changed" for other in near)


def _near(episode: Episode, others: Iterable[Episode]) -> Iterator[Episode]:
    return (other for other in others if abs(other.from_s - episode.from_s) < _SAME_S)


_ORDER = {kind: number for number, kind in enumerate(RULES)}


def _phrases(episodes: Sequence[Episode], clock: Callable[[float], str]) -> Iterator[Phrase]:
    """Yield the certain ones first; many of one kind are one phrase."""
    ordered = sorted(episodes, key=lambda one: (one.severity < Severity.WARNING, _ORDER[one.kind]))
    for _, group in groupby(ordered, key=lambda one: (one.severity < Severity.WARNING, one.kind)):
        found = list(group)
        if len(found) <= (1 if found[0].rule.subject == Subject.LIMITS else _ALONE):
            yield from (Phrase(_told(one, clock), one) for one in found)
        else:
            worst = max(found, key=lambda one: (one.severity, one.hit.worst or 0))
            count = sum(one.count for one in found)
            yield Phrase(f"{worst.rule.title} {count} times (worst: {_told(worst, clock, is_titled=False)})", worst)


def _told(episode: Episode, clock: Callable[[float], str], *, is_titled: bool = True) -> str:
    title = episode.rule.title if is_titled and episode.kind not in _UNTITLED else ""
    station = "" if episode.station is None else f"station {episode.station}"
    times = f"({episode.count} times)" if episode.count > 1 else ""
    who = " ".join(filter(None, [title, station, episode.hit.parameter]))
    what = " ".join(filter(None, [when(episode, clock), times]))
    return ", ".join(filter(None, [who, episode.hit.detail, what]))


def when(episode: Episode, clock: Callable[[float], str]) -> str:
    """Write the time of an episode, and its end if it lasted."""
    if episode.to_s - episode.from_s < _LONG_S:
        return clock(episode.from_s)
    return f"{clock(episode.from_s)} to {clock(episode.to_s)}"
