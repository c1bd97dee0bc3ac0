# SPDX-License-Identifier: GPL-2.0-or-later
"""The answer in five lines: what happened, with times and stations."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from sistap.common.calendar import local
from sistap.episodes.causes import SOON_S
from sistap.episodes.episode import ARROW, Episode
from sistap.episodes.rules import RULES, SUBJECTS, Severity, Subject
from sistap.episodes.silence import seconds

NOT_OK = "NOT OK"
_ALONE = 3  # episodes of a kind that are told one by one
_PHRASES = 10  # in a line
_DAY_S = 86_400
_PAIRED = {"phase", "rate"}  # there and back is one phrase
_STATIONS = 4  # that are named
_LONG_HEX = re.compile(r"\b0x0+(?=[0-9A-F]{5}\b)")  # a drive displays its diagnostic numbers with five digits
_ZEROS = re.compile(r"(?<=\d)(\.\d*?)0+(?!\d)")

# How an episode is told.
_TOLD = {
    "bus_silent": "Bus silent {when}, all stations: cable or master off?",
    "rhythm": "Bus silent {count} times in a rhythm {when}, {short}",
    "adapter": "adapter lost {when}",
    "gap": "nothing was captured {when}",
    "silent": "{who} {silence}{more}",
    "changed": "{who} {short} {when}{more}",
    "step": "{who} {short} {when}{more}",
    "drift": "{who} {short}",
    "write": "{by} wrote {who} {values} at {at}{more}",
    "master": "{who} {short} {when}",
    "phase": "{who} phase {short} {when}",
    "rate": "{short} {when}",
    "limits": "{who} {short} {when}",
    "clock": "clock {short} at {at}",
}
# How many are told, where that is not "... times (worst: ...)".
_OFTEN = {"bus_silent": "Bus silent {count} times, longest {lasted} ({when}), all stations: cable or master off?"}
# What is only counted: one, and several.
_COUNTED = {
    "error": ("error code", "error codes"),
    "system_error": ("telegram of a station with an error", "telegrams of stations with an error"),
    "late": ("reaction later than TrS", "reactions later than TrS"),
    "interval": ("interval longer than TzA", "intervals longer than TzA"),
    "cycle": ("master control word later than Tmas", "master control words later than Tmas"),
    "damaged": ("damaged telegram", "damaged telegrams"),
    "line_error": ("line error", "line errors"),
    "lost": ("loss of characters", "losses of characters"),
    "repeated": ("command sent again", "commands sent again"),
    "unanswered": ("command without a reaction", "commands without a reaction"),
}


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
    note: str = ""  # what nobody can tell

    @property
    def text(self) -> str:
        """Return it in words."""
        said = "; ".join([*(phrase.text for phrase in self.phrases), *self.rest])
        if self.verdict:
            text = f"{self.verdict}. {said}" if said else self.verdict
        else:
            text = f"{self.subject}: {said or 'nothing'}"
        return text if text.endswith("?") else f"{text}."

    @property
    def rest(self) -> list[str]:
        """Return what is said after the phrases."""
        return [*([f"and {self.left_out} more"] if self.left_out else []), *([self.note] if self.note else [])]


def verdict(episodes: Iterable[Episode], *, is_judged: bool = True) -> str:
    """Tell whether something has to be looked at. To find nothing is good only if all was judged."""
    worst = max((episode.severity for episode in episodes), default=Severity.INFO)
    if worst >= Severity.WARNING:
        return NOT_OK
    return "No fault is certain" if worst == Severity.NOTE else "OK" if is_judged else "No fault found"


def lines(episodes: Sequence[Episode], begin_s: float, end_s: float, unjudged: Sequence[str] = ()) -> list[Line]:
    """Return the five lines on a capture from one time to the other, in s since 1970.

    `unjudged` are times whose limit nobody knows.
    """
    date, clock = clock_of(begin_s, end_s), clock_of(begin_s, end_s, most_s=_DAY_S)
    first = f"{verdict(episodes, is_judged=not unjudged)}, {date(begin_s)} to {date(end_s)}"
    not_judged = f"not judged: {', '.join(unjudged)}" if unjudged else ""
    made = []
    for subject, name in zip(Subject, SUBJECTS, strict=True):
        found = [episode for episode in episodes if episode.rule.subject == subject]
        phrases = list(_phrases([one for one in found if not _is_explained(one, found)], clock))
        left_out = len(phrases) - _PHRASES
        note = not_judged if subject == Subject.LIMITS else ""
        made.append(Line(name, "" if subject else first, phrases[:_PHRASES], max(left_out, 0), note))
    return made


def clock_of(begin_s: float, end_s: float, *, most_s: float = 0.0) -> Callable[[float], str]:
    """Return what writes a time of day between two times; with the date where that is needed.

    That is if the day changes, but for times less than `most_s` apart.
    """
    begin, end = local(begin_s), local(end_s)
    is_same = begin is None or end is None or begin.date() == end.date() or end_s - begin_s < most_s
    day = "" if is_same else "%Y-%m-%d "

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
    return (other for other in others if abs(other.from_s - episode.from_s) < SOON_S)


def _phrases(episodes: Sequence[Episode], clock: Callable[[float], str]) -> Iterator[Phrase]:
    """Yield the certain ones first, and last what perhaps is none; many of one kind are one phrase."""
    for found in sorted(_groups(episodes), key=_rank):
        kind = found[0].kind
        if kind in _COUNTED:
            yield _counted(found, clock)
            continue
        told = list(_pairs(found)) if kind in _PAIRED else [_Told(one, one) for one in found]
        if len(told) <= _ALONE:
            yield from (Phrase(_text(one, clock), episode) for one, episode in told)
        else:
            worst, count = _worst(found), sum(one.count for one in found)
            more = {"title": worst.rule.title, "count": str(count), "told": _text(worst, clock)}
            often = _OFTEN.get(kind, "{title} {count} times (worst: {told})")
            yield Phrase(often.format(**_words(worst, clock) | more), worst)


def _groups(episodes: Iterable[Episode]) -> Sequence[Sequence[Episode]]:
    """Return the episodes by kind, in the order of RULES; and by whether they are certain, unless they are counted."""
    groups: dict[tuple[str, bool], list[Episode]] = {(kind, sure): [] for kind in RULES for sure in (True, False)}
    for one in episodes:
        groups[one.kind, one.severity >= Severity.WARNING or one.kind in _COUNTED].append(one)
    return [found for found in groups.values() if found]


def _rank(found: Sequence[Episode]) -> tuple[bool, bool]:
    is_note = _worst(found).severity < Severity.WARNING
    return is_note, is_note and found[0].kind in _COUNTED


def _worst(episodes: Iterable[Episode]) -> Episode:
    return max(episodes, key=lambda one: (one.severity, one.hit.worst or 0))


class _Told(NamedTuple):
    """What is told of an episode."""

    told: Episode
    episode: Episode  # which a phrase leads to


def _pairs(episodes: Sequence[Episode]) -> Iterator[_Told]:
    """Yield changes; one that goes on where the last one of the station ended is one with it."""
    waiting: dict[int | None, Episode] = {}
    for one in episodes:
        first = waiting.pop(one.station, None)
        if first and _ends(first)[1] == _ends(one)[0]:
            yield _Told(_pair(first, one), first)
        else:
            waiting[one.station] = one
            if first:
                yield _Told(first, first)
    yield from (_Told(one, one) for one in waiting.values())


def _ends(change: Episode) -> Sequence[str]:
    """Return before and after, without a unit."""
    return [text.split()[0] for text in change.hit.detail.split(ARROW)]


def _pair(one: Episode, two: Episode) -> Episode:
    """Return two changes as one; of a rate that was as before, the one between."""
    (before, between), (_, after) = _ends(one), _ends(two)
    is_rate_back = one.kind == "rate" and after == before
    detail = f"{between} Bd" if is_rate_back else ARROW.join([before, between, after])
    return replace(one, hit=one.hit._replace(detail=detail), to_s=two.to_s)


def _counted(episodes: Sequence[Episode], clock: Callable[[float], str]) -> Phrase:
    """Tell how many there are; of one, all; of several, the worst time or the stations."""
    worst = _worst(episodes)
    certain = [one for one in episodes if one.severity >= Severity.WARNING]
    undecided = sum(one.count for one in episodes) - sum(one.count for one in certain)
    count = sum(one.count for one in certain) or undecided
    what = f"{'' if certain else 'perhaps '}{count} {_COUNTED[worst.kind][count > 1]}"
    more = f", perhaps {undecided} more" if certain and undecided else ""
    who = "" if worst.station is None else f"station {worst.station}"
    is_timed = worst.rule.severity == Severity.ERROR and worst.hit.worst is not None
    if count == 1:
        how = [who, worst.hit.parameter, worst.hit.detail.removeprefix("perhaps: "), clock(worst.hit.from_s)]
    elif is_timed:
        how = [f"worst {(worst.hit.worst or 0) * 1e3:.4g} ms", who, clock(worst.hit.from_s)]
    else:
        how = [_stations(certain)]
    said = ", ".join(filter(None, how))
    return Phrase(f"{what}{more}{f' ({said})' if said else ''}", worst)


def _stations(episodes: Iterable[Episode]) -> str:
    numbers = sorted({one.station for one in episodes if one.station is not None})
    if len(numbers) > _STATIONS:
        return f"{len(numbers)} stations"
    return f"station{'s' * (len(numbers) > 1)} {', '.join(map(str, numbers))}" if numbers else ""


def _text(episode: Episode, clock: Callable[[float], str]) -> str:
    return " ".join(_TOLD[episode.kind].format(**_words(episode, clock)).split())


def _words(episode: Episode, clock: Callable[[float], str]) -> dict[str, str]:
    """Return what the texts above may have."""
    hit = episode.hit
    values, _, by = hit.detail.rpartition(" by ")
    lasted = seconds(episode.to_s - episode.from_s)
    is_new = episode.severity < Severity.WARNING  # it never answered
    return {
        "who": " ".join(filter(None, ["" if hit.station is None else f"station {hit.station}", hit.parameter])),
        "at": clock(episode.from_s),
        "when": when(episode, clock),
        "count": str(episode.count),
        "short": _LONG_HEX.sub("", re.split(r" \(|; ", hit.detail)[0]),
        "by": by,
        "values": values if hit.worst is None else _numbers(values),
        "lasted": lasted,
        "more": "".join(f", {_ZEROS.sub(_point, one)}" for one in (episode.cause, episode.outcome) if one),
        "silence": hit.detail if is_new else f"from {clock(episode.from_s)} ({lasted})",
    }


def _numbers(values: str) -> str:
    """Write numbers without their last zeros, and their unit once."""
    before, arrow, after = (_ZEROS.sub(_point, part) for part in values.partition(ARROW))
    unit = after.partition(" ")[2]
    return f"{before.removesuffix(f' {unit}') if unit else before}{arrow}{after}"


def _point(decimals: re.Match[str]) -> str:
    return decimals[1].removesuffix(".")


def when(episode: Episode, clock: Callable[[float], str]) -> str:
    """Write the time of an episode, and its end if it lasted."""
    return f"{clock(episode.from_s)} to {clock(episode.to_s)}" if episode.lasts else clock(episode.from_s)
