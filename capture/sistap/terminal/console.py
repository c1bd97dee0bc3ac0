# SPDX-License-Identifier: GPL-2.0-or-later
"""Messages on standard error: lines, and on a terminal a progress line that the lines do not tear."""

from __future__ import annotations

import contextlib
import os
import select
import sys
import weakref
from typing import Protocol

from sistap.terminal.streams import PIECE, never_waiting
from sistap.terminal.visible import visible

_ERASE = "\r\x1b[K"
_WAIT_MS = 100  # for a terminal to take a line; then the line is dropped


class Audience(Protocol):
    """The receiver of a capture's messages: a user at a terminal, or a program with windows of its own."""

    @property
    def shows_progress(self) -> bool:
        """Tell whether progress() shows anything."""

    def say(self, text: str) -> None:
        """Show one line."""

    def alarm(self, text: str) -> None:
        """Show why the capture or a part of it has ended, in one line."""

    def progress(self, text: str) -> None:
        """Show a progress line instead of the one before."""


class Console:
    """Standard error. Failing or blocked output (Ctrl-S, a hung ssh) must never end or delay a capture."""

    def __init__(self, stream: int = 2) -> None:
        """Start without a progress line; `stream` is the descriptor of standard error."""
        self._progress = False
        # Not through sys.stderr: Python would try again at its end to write what is left in the buffer.
        self._stream = stream
        self._descriptor = never_waiting(stream)
        weakref.finalize(self, os.close, self._descriptor)
        self._poll: select.poll | None = None
        if sys.platform != "win32":
            self._poll = select.poll()
            self._poll.register(self._descriptor, select.POLLOUT)

    @property
    def shows_progress(self) -> bool:
        """Tell whether it is a terminal that can overwrite a line."""
        return os.isatty(self._descriptor) and os.environ.get("TERM") != "dumb"

    def say(self, text: str) -> None:
        """Print one line."""
        self._print((_ERASE if self._progress else "") + f"sistap: {visible(text)}\n", _WAIT_MS)
        self._progress = False

    def alarm(self, text: str) -> None:
        """Print it like any line."""
        self.say(text)

    def progress(self, text: str) -> None:
        """Show a line instead of the one before, cut to the width of the terminal."""
        text = visible(text)
        with contextlib.suppress(OSError):
            columns = os.get_terminal_size(self._stream).columns  # Windows knows it for the standard streams only
            text = text[: columns - 1] if columns else text
        self._print(_ERASE + text, 0)
        self._progress = True

    def _print(self, text: str, wait_ms: int) -> None:
        data = text.encode(sys.stderr.encoding, "backslashreplace")
        with contextlib.suppress(OSError):
            while data and (not self._poll or self._poll.poll(wait_ms)):
                data = data[os.write(self._descriptor, data[:PIECE]) :]
