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

    baud: int | None  # None: look for it


class Remote(Protocol):
    """The program. By reading no more, it ends the capture."""

    def requests(self) -> Iterable[Marker | Rate]:
        """Return what was asked for since this was last called."""

    def show(self, counters: Counters, settings: LineSettings) -> None:
        """Take what was seen so far, and with which settings the line is read now."""
