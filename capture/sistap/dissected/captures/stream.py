# SPDX-License-Identifier: GPL-2.0-or-later
"""A capture in memory, where there is no file: the page of a browser, the library."""

from __future__ import annotations

from sistap.tap.files.output import NO_LIMITS, Output


class Stream(Output):
    """An output whose blocks somebody takes away, piece by piece."""

    def __init__(self) -> None:
        self._limits = NO_LIMITS
        self._blocks: list[bytes] = []

    def begin(self) -> None:
        """Do nothing: there is no file."""

    def write(self, block: bytes) -> None:
        """Keep a block until it is taken."""
        self._blocks.append(block)

    def take(self) -> bytes:
        """Return what was written since the last call."""
        taken, self._blocks = b"".join(self._blocks), []
        return taken

    def check(self) -> None:
        """Do nothing: memory cannot fail."""

    def close(self) -> None:
        """Do nothing: there is no file."""

    def __str__(self) -> str:
        return "memory"
