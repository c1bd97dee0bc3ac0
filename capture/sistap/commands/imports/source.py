# SPDX-License-Identifier: GPL-2.0-or-later
"""What all sources have in common: their interface, and the lines of a table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple, Protocol

from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.cut import SIS, Cut
from sistap.tap.terminal.exits import Refusal

NS = 1_000_000_000
SHARED, RECEIVED, SENT = 0, 1, 2  # lines: the only one, or the two directions


class Stated(NamedTuple):
    """What the user states because the file may not; None: nothing."""

    baud: int | None = None
    format: str | None = None
    samplerate: int | None = None  # Hz
    device: str | None = None  # "BUS.ADDRESS"
    cut: Cut = SIS  # what the characters are, for a file that can be read in several ways

    @property
    def settings(self) -> LineSettings:
        """Return the settings: rate 0 if none is given, and the default format. ValueError if the format is unknown."""
        return LineSettings.parse(self.baud or 0, self.format or "8E1")


class Source(Protocol):
    """The characters of one file."""

    @property
    def lines(self) -> Mapping[int, str]:
        """Return number and description of each line."""

    @property
    def settings(self) -> LineSettings:
        """Return the settings at the beginning."""

    @property
    def settings_from(self) -> str:
        """Return where the settings come from: "as the adapter was set"."""

    @property
    def timing(self) -> str:
        """Return where the times come from, in one phrase."""

    @property
    def warning(self) -> str:
        """Return, after the last character, a line about what could not be read; empty if all could."""

    def reads(self) -> Iterator[Read]:
        """Return all characters, in the order of their times. May raise TsharkError."""


def numbered(received: str, sent: str, *, has_sent: bool, has_received: bool = True) -> dict[int, str]:
    """Return the lines of a file with descriptions: two directions, or one shared line."""
    if has_sent and has_received:
        return {RECEIVED: received, SENT: sent}
    return {SHARED: sent if has_sent else received}


def need_rate(settings: LineSettings, name: object, why: str = "") -> None:
    """Refuse to continue without a rate: the times inside a transfer and the records depend on it.

    `why` is the reason for the missing rate, in brackets, if it is known.
    """
    if not settings.baud:
        reason = f" ({why})" if why else ""
        raise Refusal(f"{name} does not say at which rate the bus ran{reason}: add it, such as --baud 9600")


_LONGEST = 1_000_000  # characters; a file without any end of line must not fill the memory


def lines(path: Path) -> Iterator[str]:
    """Yield the lines with their ends. OSError; Refusal if a line is too long."""
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
        number = 0
        while line := file.readline(_LONGEST):
            number += 1
            if len(line) == _LONGEST:
                raise Refusal(f"{path}:{number}: the line has more than {_LONGEST} characters: this is no table")
            yield line
