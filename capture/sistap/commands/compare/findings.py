# SPDX-License-Identifier: GPL-2.0-or-later
"""A comparison in words: lines by subject, then tables; the same for text and for the page."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from sistap.commands.compare import scatter
from sistap.commands.compare.differences import SMALL, ComparedParameter, Comparison, Count, Quantile, Times
from sistap.commands.compare.happened import Happened
from sistap.commands.compare.side import Side
from sistap.dissected.accesses.listing import Listed
from sistap.dissected.episodes.lines import clock_of, when
from sistap.dissected.episodes.masters import station_of
from sistap.dissected.episodes.rules import SUBJECTS, Subject
from sistap.tap.common.calendar import local
from sistap.tap.records.record import ms

TIMES = "Times"
NONE = "nothing differs"
CHANCE = "may be chance"
_NAMED = 3  # episodes of the same thing that are told with their own times


class CompareTable(NamedTuple):
    """A heading, the heads of its columns, and rows of text."""

    title: str
    heads: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    note: str = ""


class SummaryLine(NamedTuple):
    """A line of the summary: its subject, and the findings."""

    subject: str
    found: Sequence[str]


def side(one: Side) -> str:
    """Describe a side."""
    first = one.names[0] if one.names else ""
    more = f" and {len(one.names) - 1} more" if len(one.names) > 1 else ""
    begin = local(one.begin_s) if one.begin_s else None
    since = begin.strftime(" from %Y-%m-%d %H:%M:%S") if begin else ""
    return f"{first}{more}: {one.telegrams} telegrams in {one.seconds:.1f} s{since}"


def lines(comparison: Comparison) -> list[SummaryLine]:
    """Return the summary: the lines of the answer, on what the bad side alone has, and the times."""
    found: dict[str, list[str]] = {subject: [] for subject in (*SUBJECTS, TIMES)}
    for one in comparison.happened:
        if one.is_finding:
            found[SUBJECTS[one.episode.rule.subject]].append(_happened(one, comparison.bad))
    found[SUBJECTS[Subject.SILENT]] += _members("gone", comparison.stations)
    found[SUBJECTS[Subject.CHANGED]] += _changed(comparison)
    found[TIMES] += _times(comparison)
    return [SummaryLine(subject, texts) for subject, texts in found.items()]


def _happened(one: Happened, bad: Side) -> str:
    before = "" if one.is_new else f"; episodes: {one.bad}, was {one.good} ({one.ratio:.1f} times as often)"
    chance = f" ({CHANCE})" if one.may_be_chance else ""
    return f"{one.episode.text}, {_when(one, bad)}{before}{chance}"


def _when(one: Happened, side: Side) -> str:
    """Write the times of each, or the time of many."""
    clock = clock_of(side.begin_s, side.end_s)
    return ", ".join(when(each, clock) for each in (one.apart if len(one.apart) <= _NAMED else [one.episode]))


def _changed(comparison: Comparison) -> list[str]:
    """Return what is no episode: who answers now, which services, the format, values that changed in between."""
    masters = {f"station {master}" for master in comparison.bad.masters}  # those have an episode
    came = [one for one in comparison.stations if one.is_new and one.what not in masters]
    told = {one.episode.kind for one in comparison.happened if one.is_finding}
    setting = comparison.settings[0]
    format_ = [f"{setting.what} {setting.bad}, was {setting.good}"] if setting.differs and "rate" not in told else []
    services = [*_members("new", comparison.services), *_members("gone", comparison.services)]
    return [*(f"new: {one.what}, {_times_over(one.bad)}" for one in came), *services, *format_, *_values(comparison)]


def _members(what: str, counts: Sequence[Count]) -> list[str]:
    """Return members that surely came or went; rare ones need not come again."""
    told = [count for count in counts if count.is_new == (what == "new") and not count.may_be_chance]
    return [f"{what}: {one.what}, {_times_over(one.good or one.bad)}" for one in told]


def _times_over(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _values(comparison: Comparison) -> list[str]:
    """Return values that differ although neither side has written them. The writes are episodes."""
    told = {(one.episode.station, one.episode.hit.parameter) for one in comparison.happened if one.is_finding}
    return [
        f"{name(bad)} {_value(bad)}, was {_value(good)}"
        for good, bad, moves in comparison.parameters
        if good and bad and not (moves or good.writes or bad.writes)
        if (station_of(bad.parameter), bad.parameter.ident) not in told
    ]


def name(listed: Listed) -> str:
    """Name a parameter and its station."""
    _, station, device, ident = listed.parameter
    place = f"station {station}" + (f" device {device}" if str(device) != station else "")
    return f"{place} {ident}{f' ({listed.name})' if listed.name else ''}"


def _value(listed: Listed | None) -> str:
    return (listed.last or "unknown") if listed else "not seen"


def _who(listed: Listed | None) -> str:
    if not listed or listed.written_by is None or not listed.written_in:
        return ""
    return f"{listed.written_by} in packet {listed.written_in.packet} of {listed.written_in.file}"


def _times(comparison: Comparison) -> list[str]:
    differing = [(times, one) for times in comparison.times if (one := times.differing)]
    return [_time(times, one) for times, one in sorted(differing, key=lambda pair: -abs(math.log(pair[1].ratio or 1)))]


def _time(times: Times, one: Quantile) -> str:
    longer = "slower" if one.bad_s > one.good_s else "faster"
    share = "half" if one == times.middle else "99 %"
    change = f"{longer}: {share} within {ms(one.bad_s)}, was {ms(one.good_s)}"
    return f"station {times.station} {times.what} {change} ({one.ratio:.2f} times)"


def tables(comparison: Comparison) -> list[CompareTable]:
    """Return all tables that have rows."""
    made = [
        CompareTable("What happened", _HAPPENED, [_happened_row(one, comparison) for one in comparison.happened]),
        CompareTable(
            "Stations and services on one side alone", _COUNTS, _rows([*comparison.stations, *comparison.services])
        ),
        CompareTable(
            "Parameters whose last value differs",
            ("Parameter", "Good", "Bad", "Good: written by", "Bad: written by", ""),
            [_parameter(parameter) for parameter in comparison.parameters],
        ),
        CompareTable("Times", _TIMES, [_time_row(times) for times in comparison.times], _TIMES_NOTE),
        CompareTable("Line and limits", ("", "Good", "Bad"), [tuple(setting) for setting in comparison.settings]),
        CompareTable("Stations", ("Station", "Good: telegrams", "Bad: telegrams"), _stations(comparison)),
    ]
    return [table for table in made if table.rows]


_HAPPENED = ("What", "Good", "Bad", "Ratio", "", "Times", "Display filter")
_COUNTS = ("What", "Good", "Bad", "")
_TIMES = (
    *("Station", "What", "Good: half within", "Bad: half within", "Ratio"),
    *("Good: 99 % within", "Bad: 99 % within", "Ratio", "Differs"),
)
_TIMES_NOTE = (
    f"A time differs if the difference is larger than what the pieces of one capture explain ({scatter.FAR} times "
    f"their scatter), than the uncertainty of both captures, and than {SMALL:.0%} of the time."
)


def _happened_row(one: Happened, comparison: Comparison) -> tuple[str, ...]:
    side = comparison.bad if one.bad else comparison.good
    filter_ = one.episode.filter if len(side.names) == 1 else one.episode.filter_by_time
    ratio = f"{one.ratio:.1f}" if one.good and one.bad else ""
    chance = CHANCE if one.may_be_chance else ""
    return one.episode.text, str(one.good), str(one.bad), ratio, chance, _when(one, side), filter_


def _rows(counts: Iterable[Count]) -> list[tuple[str, ...]]:
    return [(one.what, str(one.good), str(one.bad), CHANCE if one.may_be_chance else "") for one in counts]


def _parameter(parameter: ComparedParameter) -> tuple[str, ...]:
    good, bad = parameter.good, parameter.bad
    moves = "moves by itself" if parameter.moves else ""
    return name(parameter.listed), _value(good), _value(bad), _who(good), _who(bad), moves


def _time_row(times: Times) -> tuple[str, ...]:
    cells = [(ms(one.good_s), ms(one.bad_s), f"{one.ratio:.2f}") for one in (times.middle, times.tail)]
    return str(times.station), times.what, *cells[0], *cells[1], "yes" if times.differing else ""


def _stations(comparison: Comparison) -> list[tuple[str, ...]]:
    good, bad = comparison.good.stations, comparison.bad.stations
    return [(str(station), str(good[station]), str(bad[station])) for station in sorted({*good, *bad})]
