# SPDX-License-Identifier: GPL-2.0-or-later
"""The parameters that have a curve: their filter in Wireshark, and what happened to them."""

from __future__ import annotations

from collections.abc import Iterator

from sistap.commands.report.gather import Report
from sistap.dissected.accesses.access import Parameter
from sistap.dissected.accesses.listing import Listed
from sistap.dissected.episodes.masters import station_of

MOST = 24  # curves
EPISODES = 1000  # more are not on the page
ANCHOR = "parameter"


def parameters(report: Report) -> list[Listed]:
    """Return the parameters whose value moved; what something happened to and what was written goes first."""
    moved = report.figures.curves.moved()
    told = {parameter for parameter in moved if any(happened(report, parameter))}
    chosen = set(sorted(moved, key=lambda parameter: parameter not in told)[:MOST])
    return [listed for listed in report.figures.parameters if listed.parameter in chosen]


def happened(report: Report, parameter: Parameter) -> Iterator[int]:
    """Yield the places of the episodes of a parameter."""
    own, station = (parameter.port, parameter.ident), station_of(parameter)
    for number, episode in enumerate(report.episodes[:EPISODES]):
        if (episode.hit.port, episode.hit.parameter) == own and station in episode.stations:
            yield number


def places(report: Report) -> dict[Parameter, str]:
    """Return where on the page each curve is."""
    return {listed.parameter: f"{ANCHOR}{number}" for number, listed in enumerate(parameters(report))}


def wireshark_filter(listed: Listed) -> str:
    """Return the display filter that finds its values, of which the average is the curve.

    Whoever reads it hears the values from the station; what is only written comes from a master.
    """
    who = "talker" if listed.reads else "station"
    return f'sis.{who} == {station_of(listed.parameter)} && sis.parameter == "{listed.parameter.ident}"'
