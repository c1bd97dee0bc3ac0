# SPDX-License-Identifier: GPL-2.0-or-later
"""Which times nobody can judge: neither the bus nor a person has told their limit. To find nothing is no verdict."""

from __future__ import annotations

from sistap.commands.report.figures import Figures, Limit
from sistap.tap.sis.limits import NAMES

_TIMES = {"trs": "reaction times", "tza": "intervals in telegrams"}


def unjudged(figures: Figures) -> list[str]:
    """Return them in words, each with the limit that is missing; of some stations, if others have it."""
    return [text for name, times in _TIMES.items() if (text := _without(name, times, figures))]


def _without(name: str, times: str, figures: Figures) -> str:
    missing = f"(no {NAMES[name]})"
    if is_unknown(figures.limits[name]):
        return f"{times} {missing}"
    stations = [number for number, one in sorted(figures.stations.items()) if is_unknown(getattr(one, name))]
    of = f"station{'s' * (len(stations) > 1)} {', '.join(map(str, stations))}"
    return f"{times} of {of} {missing}" if stations else ""


def is_unknown(limit: Limit) -> bool:
    """Tell whether there were times, but never a limit for them."""
    return limit.verdicts[None] > 0 and not limit.limits_s
