# SPDX-License-Identifier: GPL-2.0-or-later
"""What another program writes to its standard error."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable

_MOST = 1 << 16  # bytes that are kept
_LAST_WORDS_S = 2.0  # what the program has started may hold its standard error for longer


class Complaints:
    """The end of what a program writes to `stream`, its stderr: all of it could fill a disk. Use it in a `with`."""

    def __init__(self, begin: Callable[[], object] = lambda: None) -> None:
        """Read in a thread, which calls `begin` first. Close `stream` when the program has it."""
        self._reading, writing = os.pipe()
        self.stream = open(writing, "wb", buffering=0)  # noqa: SIM115 - closed by __exit__ at the latest
        self._said = b""
        self._begin = begin
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def __enter__(self) -> Complaints:
        return self

    def __exit__(self, *error: object) -> None:
        """Let the thread end with the program."""
        self.stream.close()

    def text(self) -> str:
        """Return the last words of a program that has ended."""
        self._thread.join(_LAST_WORDS_S)
        return self._said.decode(errors="replace").strip()

    def _read(self) -> None:
        self._begin()
        with open(self._reading, "rb", buffering=0) as stream:
            while data := stream.read(_MOST):
                self._said = (self._said + data)[-_MOST:]
