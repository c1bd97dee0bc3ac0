# SPDX-License-Identifier: GPL-2.0-or-later
"""What sistap says on standard error: lines, and on a terminal a progress line that they do not tear."""

from __future__ import annotations

import contextlib
import sys

_ERASE = "\r\x1b[K"


class Console:
    """Standard error. That it cannot be written to must never end a capture."""

    def __init__(self) -> None:
        """Start with no progress line shown."""
        self._progress = False

    @property
    def is_terminal(self) -> bool:
        """Whether somebody watches."""
        return sys.stderr.isatty()

    def say(self, text: str) -> None:
        """Print one line."""
        self._print((_ERASE if self._progress else "") + f"sistap: {text}\n")
        self._progress = False

    def progress(self, text: str) -> None:
        """Show a line in place of the one before."""
        self._print(_ERASE + text)
        self._progress = True

    def _print(self, text: str) -> None:
        with contextlib.suppress(OSError):
            sys.stderr.write(text)
            sys.stderr.flush()
