# SPDX-License-Identifier: GPL-2.0-or-later
"""What every reader is, and how it fails."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from sistap.line.settings import LineSettings, Read

READ_SIZE = 4096  # as much as the line discipline of Linux holds
STEP_MS = 10  # so long, at most, is a sleep: one that was longer shows that the process had been stopped


class PortError(Exception):
    """A port cannot be opened; the text is one line that names the cure."""


class PortLost(Exception):
    """A port was lost while it was read; the text is one line that names the cure."""

    def __init__(self, text: str, line: int = 0) -> None:
        super().__init__(text)
        self.line = line


class Reader(Protocol):
    """A source of characters."""

    name: str  # what the user called it, e.g. "/dev/ttyUSB0"
    adapter: str  # e.g. "FT232R USB UART (ftdi_sio, latency timer 16 ms)"
    timing: str  # one phrase: how the times are bounded
    notes: tuple[str, ...]  # lines for the user: what makes the times worse than they could be, and the cure
    settings: LineSettings
    line: int

    def read(self, timeout_s: float) -> Read | None:
        """Return what arrived, None if nothing did in that time. May raise PortLost."""

    def change(self, settings: LineSettings) -> None:
        """Read with other settings from now on. Read first what is there: it came with the old ones.

        PortError if the port cannot do them: then the old ones stay.
        """

    def close(self) -> None:
        """Let the port go."""


@runtime_checkable
class OwnTime(Reader, Protocol):
    """A reader with times of another clock: that of a virtual bus, or of another computer."""

    def now_ns(self) -> int:
        """Return what time it is there, in ns since 1970."""


@runtime_checkable
class Distant(OwnTime, Protocol):
    """A tap on another computer."""

    settings_are_told: bool  # by the other computer; nobody changes them here


@runtime_checkable
class Measuring(Protocol):
    """A reader that sees the line itself, and so its rate."""

    def measured_baud(self) -> float | None:
        """Return the rate that the line has, in Bd; None: too little was heard."""
