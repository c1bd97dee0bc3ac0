# SPDX-License-Identifier: GPL-2.0-or-later
"""The interface of all readers, and their errors."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.terminal.exits import FAILED, PORT, Refusal

READ_SIZE = 4096  # as much as the line discipline of Linux holds
STEP_MS = 10  # longest sleep; a longer one means that the process was suspended


class PortError(Refusal):
    """A port cannot be opened; the text is one line that names the cure."""

    code = PORT


def needs_rate(port: str) -> PortError:
    """Return the error of a port without a rate."""
    return PortError(f"{port} needs a rate: give it with --baud")


class PortLost(Refusal):
    """A port was lost while it was read; the text is one line that names the cure."""

    code = FAILED

    def __init__(self, text: str, line: int = 0) -> None:
        super().__init__(text)
        self.line = line


class Reader(Protocol):
    """A source of characters."""

    name: str  # as the user wrote it, e.g. "/dev/ttyUSB0"
    adapter: str  # e.g. "FT232R USB UART (ftdi_sio, latency timer 16 ms)"
    timing: str  # one phrase: the bounds of the times
    notes: tuple[str, ...]  # messages for the user: what makes the times less exact, and the cure
    settings: LineSettings
    line: int

    def read(self, timeout_s: float) -> Read | None:
        """Return what arrived; None if nothing arrived in that time. May raise PortLost."""

    def change(self, settings: LineSettings) -> None:
        """Read with other settings from now on. First read what is there: it came with the old settings.

        PortError if the port does not support them: then the old settings stay.
        """

    def close(self) -> None:
        """Release the port."""


@runtime_checkable
class OwnTime(Reader, Protocol):
    """A reader with times of another clock: that of a virtual bus."""

    def now_ns(self) -> int:
        """Return the time there, in ns since 1970."""


@runtime_checkable
class Measuring(Protocol):
    """A reader that samples the line itself, and so can measure its rate."""

    def measured_baud(self) -> float | None:
        """Return the measured rate of the line in Bd; None: too little was heard."""


@runtime_checkable
class Exact(Protocol):
    """A reader that knows how late characters may be seen."""

    @property
    def uncertainty_ns(self) -> int:
        """Return the bound that holds now, in ns."""
