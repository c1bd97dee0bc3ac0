# SPDX-License-Identifier: GPL-2.0-or-later
"""Values beside those of a good capture: levels that it does not have."""

from __future__ import annotations

from collections.abc import Iterator

from sistap.dissected.episodes.episode import Hit
from sistap.dissected.episodes.masters import station_of
from sistap.dissected.episodes.rules import Severity
from sistap.dissected.episodes.standard import FOLLOWS
from sistap.dissected.episodes.values import Values


def unlike(good: Values, bad: Values) -> Iterator[Hit]:
    """Yield the levels of the bad side that are far from all of the good one. Other work may have other levels."""
    # Ports are left out: the tap may be at another port today.
    usual = {parameter._replace(port=""): followed for parameter, followed in good.followed()}
    for parameter, followed in bad.followed():
        before = usual.get(parameter._replace(port=""))
        if before is None or before.is_written or followed.is_written:
            continue
        if (before.command is None) != (followed.command is None) or before.unit != followed.unit:
            continue  # only one side tells what it follows, or how large it is
        if followed.levels.drift():
            continue  # that is told
        beside = "" if followed.command is None else f" beside {FOLLOWS[parameter.ident]}"
        for level in followed.levels.unlike(before.levels):
            detail = f"{level.value:.5g} {followed.unit}{beside}, {before.levels.usual:.5g} in the good capture"
            where = station_of(parameter), parameter.ident, detail.replace("  ", " ")
            place = "step", level.packet, level.from_s, level.to_s
            yield Hit(*place, *where, level.value, Severity.NOTE, parameter.port, str(parameter))
