# SPDX-License-Identifier: GPL-2.0-or-later
"""A comparison as text for people, and as JSON for programs."""

from __future__ import annotations

import itertools
import json
from typing import Any

from sistap.commands.compare import findings
from sistap.commands.compare.differences import ComparedParameter, Comparison, Count, Times
from sistap.commands.compare.findings import CompareTable
from sistap.commands.compare.happened import Happened
from sistap.commands.compare.side import Side
from sistap.dissected.accesses.listing import Listed
from sistap.dissected.packets.distribution import Distribution
from sistap.tap.common.table import aligned


def as_text(comparison: Comparison) -> str:
    """Return a description of the sides, the summary, and the tables."""
    head = [f"good: {findings.side(comparison.good)}", f"bad:  {findings.side(comparison.bad)}", ""]
    for line in findings.lines(comparison):
        subjects = itertools.chain([line.subject], itertools.repeat(""))
        head += [f"{subject:7}  {text}" for subject, text in zip(subjects, line.found or [findings.NONE], strict=False)]
    return "\n\n".join(["\n".join(head), *map(_table, findings.tables(comparison))]) + "\n"


def _table(table: CompareTable) -> str:
    lines = aligned([table.heads, *table.rows])
    return "\n".join([table.title, "-" * len(table.title), *lines, *filter(None, [table.note])])


def as_json(comparison: Comparison) -> str:
    """Return all differences as JSON; times are in s, as their names state."""
    made = {
        "good": _side(comparison.good),
        "bad": _side(comparison.bad),
        "lines": {line.subject: line.found for line in findings.lines(comparison)},
        "differs": any(line.found for line in findings.lines(comparison)),
        "episodes": list(map(_happened, comparison.happened)),
        "stations": list(map(_count, comparison.stations)),
        "services": list(map(_count, comparison.services)),
        "parameters": list(map(_parameter, comparison.parameters)),
        "times": list(map(_times, comparison.times)),
        "settings": [setting._asdict() | {"differs": setting.differs} for setting in comparison.settings],
    }
    return json.dumps(made, indent=2, allow_nan=False) + "\n"


def _side(side: Side) -> dict[str, Any]:
    return {
        "captures": side.names,
        "seconds": side.seconds,
        "telegrams": side.telegrams,
        "uncertainty_s": side.uncertainty_s,
        "stations": {str(station): count for station, count in sorted(side.stations.items())},
    }


def _happened(one: Happened) -> dict[str, Any]:
    """Write times and packets of the bad side, or of the good one if the bad one does not have it."""
    counts = {"good": one.good, "bad": one.bad, "ratio": one.ratio if one.good else None}
    return one.episode.as_json() | counts | {"may_be_chance": one.may_be_chance, "differs": one.is_finding}


def _count(count: Count) -> dict[str, Any]:
    return {"what": count.what, "good": count.good, "bad": count.bad, "may_be_chance": count.may_be_chance}


def _parameter(parameter: ComparedParameter) -> dict[str, Any]:
    _, station, device, ident = parameter.listed.parameter
    return {
        "station": station,
        "device": device,
        "parameter": ident,
        "name": parameter.listed.name,
        "moves": parameter.moves,
        "good": _listed(parameter.good),
        "bad": _listed(parameter.bad),
    }


def _listed(listed: Listed | None) -> dict[str, Any] | None:
    if not listed:
        return None
    place = listed.written_in
    return {
        "value": listed.last,
        "written_by": listed.written_by,
        "written_in": {"file": place.file, "packet": place.packet, "epoch_s": place.epoch_s} if place else None,
    }


def _times(times: Times) -> dict[str, Any]:
    return {
        "station": times.station,
        "what": times.what,
        "good": _distribution(times.good),
        "bad": _distribution(times.bad),
        "half_within": times.middle._asdict(),
        "99_percent_within": times.tail._asdict(),
        "uncertainty_s": times.uncertainty_s,
        "differs": times.differing is not None,
    }


def _distribution(times: Distribution) -> dict[str, Any]:
    return {"count": times.count, "shortest_s": times.shortest_s, "longest_s": times.longest_s}
