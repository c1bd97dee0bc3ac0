# SPDX-License-Identifier: GPL-2.0-or-later
"""The times of a bus, as service 0x03 sets them (IF02 chapter 6)."""

from __future__ import annotations

from typing import NamedTuple

from sistap.line.settings import LineSettings


class Times(NamedTuple):
    """The times that the master sets with service 0x03, in ms."""

    trs: int  # slave reaction time
    tza: int  # character interval
    tmas: int  # cycle of the master control word

    @classmethod
    def for_line(cls, settings: LineSettings) -> Times:
        """Return times that the line can keep: TzA 5 ms, or four characters of a slow line."""
        tza = max(5, -(-4 * settings.character_ns // 1_000_000))
        return cls(10 * tza, tza, 100 * tza)
