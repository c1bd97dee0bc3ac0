# SPDX-License-Identifier: GPL-2.0-or-later
"""The answer in five lines: what happened, with times and stations. What is worst, and what lasts, comes first."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from datetime import datetime, timedelta
from typing import NamedTuple

from sistap.dissected.episodes.episode import ARROW, Episode, numbers
from sistap.dissected.episodes.faults import PERHAPS
from sistap.dissected.episodes.rules import RULES, SUBJECTS, Severity, Subject
from sistap.dissected.episodes.silence import seconds
from sistap.tap.common.calendar import local

NOT_OK = "NOT OK"
_ALONE = 3  # episodes of a kind that are told one by one
_PHRASES = 10  # in a line
_NOTES = 3  # in a line: phrases about the life of a machine
_TIMES = 6  # that are named
_DAY_S = 86_400
_PAIRED = {"phase", "rate"}  # there and back is one phrase
_STATIONS = 8  # that are named
_LONG_HEX = re.compile(r"\b0x0+(?=[0-9A-F]{5}\b)")  # a drive displays its diagnostic numbers with five digits
_ZEROS = re.compile(r"(?<=\d)(\.\d*?)0+(?!\d)")

# How an episode is told.
_TOLD = {
    "foreign": "{short}",
    "bus_silent": "Bus silent {when}, all stations: cable or master off?",
    "unreadable": "bus unreadable {when}: wrong rate, or a short circuit?",
    "rhythm": "Bus silent {count} times in a rhythm {when}, {short}",
    "adapter": "adapter lost {when}",
    "gap": "nothing was captured {when}",
    "estop": "emergency stop, fault {short} of {who} {when}{more}",
    "off": "machine off and on again {when}: {short}",
    "boot": "initialised at {at}: {short}",
    "stopped": "machine stopped {when}",
    "silent": "{who} {silence}{more}",
    "vanished": "{short}, since {at}",
    "restart": "{who} restarted at {at}: {short}",
    "fault": "{who} fault {short} {when}{more}",
    "homing": "{who} not referenced any more {when}{more}",
    "warning": "{who} warning {short} {when}{more}",
    "stuck": "{who} {short} since {at}",
    "beyond": "{who} {short} {when}",
    "apart": "{who} {short} {when}{more}",
    "chatter": "{who} {short} {when}",
    "slower": "{who} answers slower, {short}",
    "changed": "{who} {short} {when}{more}",
    "blip": "{who} {short} {when}",
    "step": "{who} {short} {when}{more}",
    "drift": "{who} {short}",
    "conflict": "{who} is written by two masters {when}: {short}{times}{more}",
    "limit_write": "{by} wrote the limit {who} {values} at {at}{more}",
    "exchanged": "{who} is another device since {at}: {short}",
    "other": "{who} {values} at {at}, nobody on this bus wrote it",
    "write": "{by} wrote {who} {values} at {at}{more}",
    "master": "new {short} {when}",
    "phase": "{who} phase {short} {when}",
    "rate": "{short} {when}",
    "limits": "{who} {short} {when}",
    "recipe": "{short} at {at}",
    "clock": "clock {short} at {at}",
}
# What is only counted: one, and several.
_COUNTED = {
    "system_error": ("telegram of a station with an error", "telegrams of stations with an error"),
    "warning_bit": ("telegram with a warning bit", "telegrams with a warning bit"),
    "error": ("error code", "error codes"),
    "busy": ("reaction of a busy station", "reactions of busy stations"),
    "never": ("request for what a station does not know", "requests for what a station does not know"),
    "again": ("second answer: two stations at one address?", "second answers: two stations at one address?"),
    "late": ("reaction later than TrS", "reactions later than TrS"),
    "interval": ("interval longer than TzA", "intervals longer than TzA"),
    "cycle": ("master control word later than Tmas", "master control words later than Tmas"),
    "unexpected": ("answer to a broadcast", "answers to broadcasts"),
    "early": ("command sent again before TrS was over", "commands sent again before TrS was over"),
    "damaged": ("damaged telegram", "damaged telegrams"),
    "line_error": ("line error", "line errors"),
    "lost": ("loss of characters", "losses of characters"),
    "repeated": ("command sent again", "commands sent again"),
    "unanswered": ("command without a reaction", "commands without a reaction"),
    "against": ("telegram against the rules", "telegrams against the rules"),
}
_UNDESCRIBED = "parameters without a description: {}; sistap parameters --from FILE.par names them"
_IN_MS = {"late", "interval", "cycle"}  # the worst is a time


class Phrase(NamedTuple):
    """A part of a line."""

    text: str
    episode: Episode  # the worst that it tells
    others: Sequence[Episode] = ()  # that it tells, too


class AnswerLine(NamedTuple):
    """A line of the answer."""

    subject: str
    verdict: str  # of the first line
    phrases: Sequence[Phrase]
    left_out: int  # phrases
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
    """Answer in a few words. OK without a restriction is only what was judged."""
    found = list(episodes)
    if any(episode.severity == Severity.ERROR for episode in found):
        return NOT_OK
    look = things(found)
    more = f", {look} thing{'s' * (look > 1)} to look at" if look else ""
    return f"OK{more}" if is_judged else f"OK as far as it was judged{more}"


def things(episodes: Iterable[Episode]) -> int:
    """Return how many things are to be looked at; what is only counted is one."""
    found = [episode for episode in episodes if episode.severity == Severity.WARNING]
    alone = sum(episode.kind not in _COUNTED for episode in found)
    return alone + len({episode.kind for episode in found if episode.kind in _COUNTED})


def lines(
    episodes: Sequence[Episode], begin_s: float, end_s: float, unjudged: Sequence[str] = (), undescribed: int = 0
) -> list[AnswerLine]:
    """Return the five lines on a capture from one time to the other, in s since 1970.

    `unjudged` are times whose limit nobody knows, `undescribed` parameters of which only bytes are known.
    """
    date, clock = clock_of(begin_s, end_s), clock_of(begin_s, end_s, most_s=_DAY_S)
    first = f"{verdict(episodes, is_judged=not unjudged)}, {date(begin_s)} to {date(end_s)}{_summary(episodes)}"
    notes = {
        Subject.LIMITS: f"not judged: {', '.join(unjudged)}" if unjudged else "",
        Subject.DRIVES: _UNDESCRIBED.format(undescribed) if undescribed else "",
    }
    made = []
    for subject, name in zip(Subject, SUBJECTS, strict=True):
        phrases = list(_phrases([one for one in episodes if one.rule.subject == subject], clock))
        certain = [one for one in phrases if one.episode.severity >= Severity.WARNING]
        life = [one for one in phrases if one.episode.severity < Severity.WARNING]
        shown = [*certain, *life[:_NOTES]][:_PHRASES]
        note = notes.get(subject, "")
        made.append(AnswerLine(name, "" if subject else first, shown, max(len(certain) - len(shown), 0), note))
    return made


def _summary(episodes: Sequence[Episode]) -> str:
    """Write what is still so at the end, and what else is wrong, in a few words."""
    bad = [one for one in episodes if one.severity >= Severity.WARNING]
    lasting = [one for one in bad if one.rule.subject != Subject.CHANGED and _is_lasting(one)]
    errors = [one for one in bad if one.severity == Severity.ERROR and one not in lasting]
    now = [f"now {', '.join(_titles(lasting))}"] if lasting else []
    look = things(episodes) if errors or any(one.severity == Severity.ERROR for one in lasting) else 0
    more = [f"{look} thing{'s' * (look > 1)} to look at"] if look else []
    rest = [", ".join([*_titles(errors), *more])] if errors or more else []
    return f": {'; '.join([*now, *rest])}" if now or rest else ""


def _is_lasting(episode: Episode) -> bool:
    """Tell whether it is still so at the end."""
    return episode.outcome.startswith(("still", "not heard"))


def _titles(episodes: Iterable[Episode]) -> list[str]:
    """Write each kind once, with its stations; a code of a drive is a kind of its own."""
    found: dict[str, set[int]] = {}
    for one in episodes:
        code = f" {one.hit.topic}" if one.kind in ("fault", "warning") else ""
        title = one.rule.title[:1].lower() + one.rule.title[1:] + code
        found.setdefault(title, set()).update(one.stations)
    return [f"{title}{f' ({numbers(stations)})' if stations else ''}" for title, stations in found.items()]


def clock_of(begin_s: float, end_s: float, *, most_s: float = 0.0) -> Callable[[float], str]:
    """Return what writes a time of day between two times; with the date where that is needed.

    That is if the day changes, but for times less than `most_s` apart. Where the clock is put back or forward between
    them, it says by how much it differs from UTC: 02:55:00 UTC+2 is before 02:10:00 UTC+1.
    """
    begin, end = local(begin_s), local(end_s)
    is_put = begin is not None and end is not None and begin.utcoffset() != end.utcoffset()
    is_same = begin is None or end is None or begin.date() == end.date() or end_s - begin_s < most_s
    day = "" if is_same else "%Y-%m-%d "

    def clock(epoch_s: float) -> str:
        then = local(epoch_s)
        if then is None:
            return "a time in no calendar"
        return then.strftime(f"{day}%H:%M:%S") + (_zone(then) if is_put else "")

    return clock


def _zone(then: datetime) -> str:
    """Write by how much a clock differs from UTC."""
    minutes = round((then.utcoffset() or timedelta()).total_seconds() / 60)
    hours, rest = divmod(abs(minutes), 60)
    return f" UTC{'-' if minutes < 0 else '+'}{hours}" + (f":{rest:02d}" if rest else "")


def _phrases(episodes: Sequence[Episode], clock: Callable[[float], str]) -> Iterator[Phrase]:
    """Yield the worst first, then what lasts to the end; many of one kind are one phrase."""
    made = [phrase for found in _groups(episodes) for phrase in _of_kind(found, clock)]
    yield from sorted(made, key=_rank)


def _rank(phrase: Phrase) -> tuple[int, bool, bool, float]:
    """Return what sorts phrases: severity, certainty, whether it is still so, and of values that moved, how far."""
    episode = phrase.episode
    far = -(episode.hit.worst or 0.0) if episode.kind in ("step", "drift") else 0.0
    is_perhaps = episode.hit.detail.startswith(PERHAPS)
    return -episode.severity, is_perhaps, not _is_lasting(episode), far


def _groups(episodes: Iterable[Episode]) -> Sequence[Sequence[Episode]]:
    """Return the episodes by kind, in the order of RULES; and by severity, unless they are counted."""
    groups: dict[tuple[str, int], list[Episode]] = {(kind, rank): [] for kind in RULES for rank in Severity}
    for one in episodes:
        groups[one.kind, Severity.NOTE if one.kind in _COUNTED else one.severity].append(one)
    return [found for found in groups.values() if found]


def _of_kind(found: Sequence[Episode], clock: Callable[[float], str]) -> Iterator[Phrase]:
    kind, worst = found[0].kind, _worst(found)
    if kind in _COUNTED:
        yield _counted(found, clock)
        return
    told = list(_pairs(found)) if kind in _PAIRED else [_Account(one, one) for one in found]
    is_note = worst.severity < Severity.WARNING
    if len(told) <= _ALONE or not (is_note or kind in _JOINED):
        yield from (Phrase(_text(one, clock), episode) for one, episode in told)
        return
    if kind in ("step", "blip", "drift", "changed"):
        ranked = sorted(told, key=lambda one: -(one.told.hit.worst or 0.0))
        yield from (Phrase(_text(one, clock), episode) for one, episode in ranked)
        return
    alike: dict[tuple[object, ...], list[_Account]] = {}
    for one in told:
        what = one.told.hit.topic if kind in ("fault", "warning") else ""
        alike.setdefault((*sorted(one.told.stations), what), []).append(one)
    yield from (_often(same, clock) for same in alike.values())


# Many of these at a station are one phrase.
_JOINED = {
    "fault",
    "warning",
    "bus_silent",
    "silent",
    "restart",
    "write",
    "limit_write",
    "phase",
    "gap",
    "adapter",
    "exchanged",
    "limits",
}


def _often(same: Sequence[_Account], clock: Callable[[float], str]) -> Phrase:
    """Tell what happened again and again, with the longest or worst, and when."""
    episodes = [one.told for one in same]
    longest = max(episodes, key=lambda one: (one.severity, one.to_s - one.from_s))
    if len(same) == 1:
        return Phrase(_text(longest, clock), same[0].episode)
    is_span = longest.kind == "stopped"
    times = ", ".join(when(one, clock) if is_span else clock(one.from_s) for one in episodes[:_TIMES])
    more = f" and {len(episodes) - _TIMES} more" if len(episodes) > _TIMES else ""
    code = f" {longest.hit.topic}" if longest.kind in ("fault", "warning") else ""
    title = f"{longest.rule.title}{code}"
    who = f", {numbers(longest.stations)}" if longest.stations else ""
    lasted = longest.to_s - longest.from_s
    is_long = longest.lasts and longest.kind not in ("recipe", "stopped")
    worst = f"longest {seconds(lasted)} at {clock(longest.from_s)}; " if is_long else ""
    told = f"{title} {len(same)} times{who} ({worst}{times}{more})"
    return Phrase(told, same[0].episode, [one.episode for one in same])


def _worst(episodes: Iterable[Episode]) -> Episode:
    return max(episodes, key=lambda one: (one.severity, one.hit.worst or 0))


class _Account(NamedTuple):
    """What is told of an episode."""

    told: Episode
    episode: Episode  # which a phrase leads to


def _pairs(episodes: Sequence[Episode]) -> Iterator[_Account]:
    """Yield changes; one that goes on where the last one of the station ended is one with it."""
    waiting: dict[int | None, Episode] = {}
    for one in episodes:
        first = waiting.pop(one.station, None)
        if first and _ends(first)[1] == _ends(one)[0]:
            yield _Account(_pair(first, one), first)
        else:
            waiting[one.station] = one
            if first:
                yield _Account(first, first)
    yield from (_Account(one, one) for one in waiting.values())


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
    """Tell how many there are, at which stations, the worst time, and when."""
    worst = _worst(episodes)
    is_timed = worst.kind in _IN_MS
    certain = [one for one in episodes if not is_timed or one.severity >= Severity.WARNING]
    undecided = sum(one.count for one in episodes) - sum(one.count for one in certain)
    count = sum(one.count for one in certain) or undecided
    what = f"{'' if certain else 'perhaps '}{count} {_COUNTED[worst.kind][count > 1]}"
    more = f", perhaps {undecided} more" if certain and undecided else ""
    how = [*_each_station(certain or episodes), _span(certain or episodes, clock)]
    if is_timed and count > 1:
        longest = worst.hit.worst
        how.insert(0, f"worst {longest * 1e3:.4g} ms at {clock(worst.hit.from_s)}" if longest else "not measured")
    elif count == 1 or worst.kind in ("error", "never"):
        how.insert(0, _each_detail(certain or episodes))
    return Phrase(f"{what}{more} ({', '.join(filter(None, how))})", worst, episodes)


def _each_detail(episodes: Sequence[Episode]) -> str:
    """Write what they are about: the most frequent first; of many, the first."""
    ranked = sorted(episodes, key=lambda one: -one.count)
    texts = [" ".join(filter(None, [one.hit.parameter, one.hit.detail.removeprefix(PERHAPS)])) for one in ranked]
    different = list(dict.fromkeys(filter(None, texts)))
    more = f" and {len(different) - _ALONE} more" if len(different) > _ALONE else ""
    return ", ".join(different[:_ALONE]) + more


def _each_station(episodes: Sequence[Episode]) -> Sequence[str]:
    """Write the stations; if several have a time each, with their worst."""
    stations = sorted({station for one in episodes for station in one.stations})
    if len(stations) > _STATIONS:
        return [f"{len(stations)} stations"]
    if len(stations) < 2 or episodes[0].kind not in _IN_MS:  # noqa: PLR2004 - several
        return [numbers(stations)]
    worst = {station: max(one.hit.worst or 0.0 for one in episodes if station in one.stations) for station in stations}
    if not all(worst.values()):  # not measured
        return [numbers(stations)]
    return [f"station {station} up to {time_s * 1e3:.4g} ms" for station, time_s in worst.items()]


def _span(episodes: Sequence[Episode], clock: Callable[[float], str]) -> str:
    """Write when they were: each of few, else from the first to the last."""
    times = list(dict.fromkeys(clock(one.from_s) for one in episodes))
    if len(times) <= _ALONE and all(not one.lasts for one in episodes):
        return ", ".join(times)
    return f"{times[0]} to {clock(max(one.to_s for one in episodes))}"


def _text(episode: Episode, clock: Callable[[float], str]) -> str:
    return " ".join(_TOLD[episode.kind].format(**_words(episode, clock)).split())


def _words(episode: Episode, clock: Callable[[float], str]) -> dict[str, str]:
    """Return what the texts above may have."""
    hit = episode.hit
    values, _, by = hit.detail.rpartition(" by ")
    values = values or hit.detail.split(", nobody")[0]
    lasted = seconds(episode.to_s - episode.from_s)
    never = episode.severity < Severity.ERROR  # it never answered
    return {
        "who": episode.who,
        "at": clock(episode.from_s),
        "when": when(episode, clock),
        "count": str(episode.count),
        "times": f" ({episode.count} times)" if episode.count > 1 else "",
        "short": _LONG_HEX.sub("", re.split(r" \(|; ", hit.detail)[0]),
        "by": by,
        "values": _numbers(values) if hit.worst is not None else values,
        "more": "".join(f", {_ZEROS.sub(_point, one)}" for one in (episode.cause, episode.outcome) if one),
        "silence": hit.detail if never else f"from {clock(episode.from_s)} ({lasted})",
    }


def _numbers(values: str) -> str:
    """Write numbers without their last zeros, and their unit once."""
    before, arrow, after = (_ZEROS.sub(_point, part) for part in values.partition(ARROW))
    unit = after.partition(" ")[2]
    return f"{before.removesuffix(f' {unit}') if unit else before}{arrow}{after}"


def _point(decimals: re.Match[str]) -> str:
    return decimals[1].removesuffix(".")


def when(episode: Episode, clock: Callable[[float], str]) -> str:
    """Write the time of an episode, and its end if it lasted; with dates if that is on another day."""
    if not episode.lasts:
        return clock(episode.from_s)
    own = clock_of(episode.from_s, episode.to_s)
    return " to ".join(max(clock(time_s), own(time_s), key=len) for time_s in (episode.from_s, episode.to_s))
