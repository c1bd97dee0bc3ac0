# SPDX-License-Identifier: GPL-2.0-or-later
"""A program that reads a capture while it runs, and controls it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple, Protocol

from sistap.line.settings import LineSettings
from sistap.records.counters import Counters


class Marker(NamedTuple):
    """A request for a marker in the capture."""

    text: str


class Rate(NamedTuple):
    """A request for another rate."""

    baud: int | None  # None: search for it


class Remote(Protocol):
    """The program. It ends the capture by no longer reading."""

    def requests(self) -> Iterable[Marker | Rate]:
        """Return the requests since the last call."""

    def show(self, counters: Counters, settings: LineSettings) -> None:
        """Show the counters, and the settings with which the line is read now."""
