# SPDX-License-Identifier: GPL-2.0-or-later
"""A comparison in words: five lines, then tables; the same for text and for the page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from sistap.accesses.listing import Listed
from sistap.compare.differences import Comparison, Count, Parameter, Quantile, Times
from sistap.compare.side import Side

_NAMED = 3  # things named in a line; the others are counted


class Table(NamedTuple):
    """A heading, the heads of its columns, and rows of text."""

    title: str
    heads: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    note: str = ""


class Line(NamedTuple):
    """One of the five lines: its subject, and the findings."""

    subject: str
    text: str
    is_finding: bool


def side(one: Side) -> str:
    """Describe a side."""
    first = one.names[0] if one.names else ""
    more = f" and {len(one.names) - 1} more" if len(one.names) > 1 else ""
    return f"{first}{more}: {one.telegrams} telegrams in {one.seconds:.1f} s"


def lines(comparison: Comparison) -> list[Line]:
    """Return the five lines."""
    made = [
        ("Stations, services", _members([*comparison.stations, *comparison.services])),
        ("Parameters", _parameters(comparison)),
        ("Times", _times(comparison)),
        ("Errors", _errors(comparison.failures, comparison.faults)),
        ("Line, limits", [f"{one.what} {one.bad}, was {one.good}" for one in comparison.settings if one.differs]),
    ]
    none = "nothing differs"
    return [Line(subject, _first(found) or none, bool(found)) for subject, found in made]


def _first(texts: Sequence[str]) -> str:
    more = f"; and {len(texts) - _NAMED} more" if len(texts) > _NAMED else ""
    return "; ".join(texts[:_NAMED]) + more


def _members(counts: Sequence[Count]) -> list[str]:
    """Return members that are certain, and new ones that may be chance. Rare members of the good side need not come
    again.
    """
    told = [count for count in counts if count.is_certain or count.is_new]
    return [
        f"{'new' if one.is_new else 'gone'}: {one.what}, {_times_over(one.good or one.bad)} ({by_chance(one.chance)})"
        for one in sorted(told, key=lambda one: one.chance)
    ]


def _times_over(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _parameters(comparison: Comparison) -> list[str]:
    """Return the changes: first what somebody new wrote, then what was written, then others."""

    def order(parameter: Parameter) -> tuple[bool, bool]:
        writer = parameter.bad.written_by if parameter.bad else None
        return writer is None or writer in comparison.good.masters, not _who(parameter.bad)

    found = [parameter for parameter in comparison.parameters if parameter.bad and not parameter.moves]
    return [_changed(parameter) for parameter in sorted(found, key=order)]


def _changed(parameter: Parameter) -> str:
    value, before = _value(parameter.bad), _value(parameter.good)
    who = _who(parameter.bad)
    return f"{name(parameter.listed)} {value}, was {before}{f', written by {who}' if who else ''}"


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
    differing = sorted((times for times in comparison.times if times.differing), key=lambda times: -times.ratio)
    return [_time(times, times.differing) for times in differing if times.differing]


def _time(times: Times, one: Quantile) -> str:
    longer = "slower" if one.bad_s > one.good_s else "faster"
    share = "half" if one == times.middle else "99 %"
    change = f"{longer}: {share} within {ms(one.bad_s)}, was {ms(one.good_s)}"
    return f"station {times.station} {times.what} {change} ({by_chance(one.chance)})"


def _errors(failures: Iterable[Count], faults: Iterable[Count]) -> list[str]:
    """Return errors that are certain, and new ones that may be chance. New codes come first: they say most."""
    codes = sorted((count for count in failures if count.is_new and count.bad), key=lambda count: count.chance)
    others = [count for count in (*faults, *failures) if count not in codes]
    told = [count for count in others if count.is_certain or (count.is_new and count.bad)]
    return [
        f"{count.what} {count.bad}, was {count.good} ({by_chance(count.chance)})"
        for count in [*codes, *sorted(told, key=lambda count: count.chance)]
    ]


def by_chance(likely: float) -> str:
    """Describe how likely chance makes this."""
    if likely > 0.2:
        return "may be chance"
    return f"by chance 1 in {1 / likely:.0f}" if likely > 1e-6 else "not by chance"


def ms(time_s: float) -> str:
    """Write a time as the dissector writes it."""
    return f"{time_s * 1e3:.3f} ms"


def tables(comparison: Comparison) -> list[Table]:
    """Return all tables that have rows."""
    made = [
        Table("Stations and services on one side alone", _COUNTS, _rows([*comparison.stations, *comparison.services])),
        Table(
            "Parameters whose last value differs",
            ("Parameter", "Good", "Bad", "Good: written by", "Bad: written by", ""),
            [_parameter(parameter) for parameter in comparison.parameters],
        ),
        Table("Times", _TIMES, [_time_row(times) for times in comparison.times], _TIMES_NOTE),
        Table("Reactions with an error", _COUNTS, _rows(comparison.failures)),
        Table(
            "Faults",
            (*_COUNTS, "Display filter"),
            [(*row, one.filter) for row, one in zip(_rows(comparison.faults), comparison.faults, strict=True)],
        ),
        Table("Line and limits", ("", "Good", "Bad"), [tuple(setting) for setting in comparison.settings]),
        Table("Stations", ("Station", "Good: telegrams", "Bad: telegrams"), _stations(comparison)),
    ]
    return [table for table in made if table.rows]


_COUNTS = ("What", "Good", "Bad", "Chance")
_TIMES = (
    *("Station", "What", "Good: half within", "Bad: half within", "Chance"),
    *("Good: 99 % within", "Bad: 99 % within", "Chance", "Differs"),
)
_TIMES_NOTE = (
    "Chance: how likely it makes such a difference, corrected for all that was compared. A time differs if that is "
    "less than 1 in 100, and the difference is larger than the uncertainty of both captures, and than 5 %."
)


def _rows(counts: Iterable[Count]) -> list[tuple[str, ...]]:
    return [
        (count.what, str(count.good), str(count.bad), _likely(count.chance) if count.good or count.bad else "")
        for count in counts
    ]


def _likely(likely: float) -> str:
    return f"{likely:.2g}" if likely > 1e-6 else "0"


def _parameter(parameter: Parameter) -> tuple[str, ...]:
    good, bad = parameter.good, parameter.bad
    moves = "moves by itself" if parameter.moves else ""
    return name(parameter.listed), _value(good), _value(bad), _who(good), _who(bad), moves


def _time_row(times: Times) -> tuple[str, ...]:
    cells = [(ms(one.good_s), ms(one.bad_s), _likely(one.chance)) for one in (times.middle, times.tail)]
    return str(times.station), times.what, *cells[0], *cells[1], "yes" if times.differing else ""


def _stations(comparison: Comparison) -> list[tuple[str, ...]]:
    good, bad = comparison.good.stations, comparison.bad.stations
    return [(str(station), str(good[station]), str(bad[station])) for station in sorted({*good, *bad})]
