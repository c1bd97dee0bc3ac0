# SPDX-License-Identifier: GPL-2.0-or-later
"""An adapter that can be unplugged: a pseudo terminal behind a name that stays, as below /dev/serial/by-id."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import sys
import termios
import tty
from pathlib import Path

PATIENCE_S = 120


class Adapter:
    """At first it is unplugged, and so it is in the end."""

    def __init__(self, name: Path) -> None:
        self.name = name
        self._ends: tuple[int, int] | None = None

    def __enter__(self) -> Adapter:
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()

    def plug(self) -> None:
        """Make the port."""
        self._ends = pty.openpty()
        tty.setraw(self._ends[1])
        os.set_blocking(self._ends[0], False)
        self.name.symlink_to(os.ttyname(self._ends[1]))

    def unplug(self) -> None:
        """Remove the port; what is on the way is lost."""
        if self._ends:
            self.name.unlink()
            for end in self._ends:
                os.close(end)
        self._ends = None

    @property
    def waiting(self) -> int:
        """The number of characters that have arrived and that nobody has read."""
        assert self._ends
        return int.from_bytes(fcntl.ioctl(self._ends[1], termios.FIONREAD, bytes(4)), sys.byteorder)

    def send(self, data: bytes) -> None:
        """Send all of it, as fast as somebody reads. TimeoutError if nobody does."""
        assert self._ends
        while data:
            if not select.select([], [self._ends[0]], [], PATIENCE_S)[1]:
                raise TimeoutError("nobody reads the port")
            try:
                data = data[os.write(self._ends[0], data) :]
            except BlockingIOError:
                continue
