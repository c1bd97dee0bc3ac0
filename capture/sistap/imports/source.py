# SPDX-License-Identifier: GPL-2.0-or-later
"""What a file that can be imported is to the rest: characters with their times, like those of a reader."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple, Protocol

from sistap.line.settings import LineSettings, Read
from sistap.terminal.exits import UsageError

NS = 1_000_000_000
SHARED, RECEIVED, SENT = 0, 1, 2  # lines: the only one, or the two directions


class Told(NamedTuple):
    """What the user says because the file may not; None: nothing."""

    baud: int | None = None
    format: str | None = None
    samplerate: int | None = None  # Hz
    device: str | None = None  # "BUS.ADDRESS"

    @property
    def settings(self) -> LineSettings:
        """Rate 0 where none is told, and the format of the specification. ValueError if the format is none."""
        return LineSettings.parse(self.baud or 0, self.format or "8E1")


class Source(Protocol):
    """The characters of one file."""

    @property
    def lines(self) -> Mapping[int, str]:
        """Number and description of each line."""

    @property
    def settings(self) -> LineSettings:
        """Those to begin with."""

    @property
    def settings_from(self) -> str:
        """Where they come from: "as the adapter was set"."""

    @property
    def timing(self) -> str:
        """One phrase: where the times come from."""

    @property
    def warning(self) -> str:
        """One line, after the last character: what could not be read; empty if all could."""

    def reads(self) -> Iterator[Read]:
        """Return all characters, in the order of their times. May raise TsharkError."""


def numbered(received: str, sent: str, *, has_sent: bool, has_received: bool = True) -> dict[int, str]:
    """Describe the lines of a file: two directions, or the only one as what it is, a line that all share."""
    if has_sent and has_received:
        return {RECEIVED: received, SENT: sent}
    return {SHARED: sent if has_sent else received}


def need_rate(settings: LineSettings, name: object, why: str = "") -> None:
    """Refuse to go on without a rate: the times inside a transfer, and what a record says, depend on it.

    `why` it is not said, in brackets, if that is known.
    """
    if not settings.baud:
        reason = f" ({why})" if why else ""
        raise UsageError(f"{name} does not say at which rate the line ran{reason}: add it, such as --baud 9600")
