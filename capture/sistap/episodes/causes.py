# SPDX-License-Identifier: GPL-2.0-or-later
"""What perhaps brought an episode about: a drive whose values change soon after a write to it."""

from __future__ import annotations

from collections.abc import Sequence

from sistap.episodes.episode import Episode

SOON_S = 60.0  # within which the values of a drive change together
_EFFECTS = {"changed", "step"}


def find_causes(episodes: Sequence[Episode]) -> None:
    """Name the last write to the same station shortly before each change of its values."""
    writes = [one for one in episodes if one.kind == "write"]
    for effect in (one for one in episodes if one.kind in _EFFECTS):
        for write in writes:
            is_same = (write.hit.port, write.station) == (effect.hit.port, effect.station)
            if is_same and 0 <= effect.from_s - write.from_s < SOON_S:
                effect.cause = f"soon after the write of {write.hit.parameter}"
