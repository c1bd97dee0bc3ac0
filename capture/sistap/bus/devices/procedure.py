# SPDX-License-Identifier: GPL-2.0-or-later
"""A procedure command of a drive: writes to its parameter start, interrupt and clear it (fig. 8-44)."""

from __future__ import annotations

SET, ENABLED = 0x1, 0x2  # bits of the written value, and of the data status
_NOT_YET_EXECUTED, _NOT_POSSIBLE = 0x4, 0x8
_MS = 1_000_000


class Procedure:
    """Its progress. Written values are 0 (clear), 1 (interrupt) and 3 (set and enable)."""

    def __init__(self, takes_ms: int = 0, fails: bool = False) -> None:
        """Set how long it takes, and whether it fails in the end."""
        self._takes_ns = takes_ms * _MS
        self.fails = fails
        self._written = 0
        self._left_ns = self._takes_ns
        self._since_ns = 0  # start of the run

    def write(self, value: int, now_ns: int) -> None:
        """Act on a written value."""
        if self._running:
            self._left_ns = max(0, self._left_ns - (now_ns - self._since_ns))
        if not value & SET:
            self._left_ns = self._takes_ns
        self._written = value
        self._since_ns = now_ns

    def status(self, now_ns: int) -> int:
        """Return bits 0 to 3 of the data status."""
        if not self._written & SET:
            return 0
        elapsed_ns = now_ns - self._since_ns if self._running else 0
        if elapsed_ns < self._left_ns or (self._left_ns and not self._running):
            return self._written & (SET | ENABLED) | _NOT_YET_EXECUTED
        if self.fails:
            return SET | ENABLED | _NOT_YET_EXECUTED | _NOT_POSSIBLE
        return self._written & (SET | ENABLED)

    def done(self, now_ns: int) -> bool:
        """Tell whether it has been executed."""
        return self.status(now_ns) == SET | ENABLED

    @property
    def _running(self) -> bool:
        return self._written & (SET | ENABLED) == SET | ENABLED
