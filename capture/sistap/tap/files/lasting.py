# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes written data reach the disk soon, so that a power cut costs no more than the last second.

A thread does it: the disk may be slow, and a reader must not wait.
"""

from __future__ import annotations

import errno
import os
import threading
from collections import deque
from contextlib import suppress
from pathlib import Path

PROMISED_S = 1.0  # nothing older than this is lost
PERIOD_S = PROMISED_S / 2  # what just missed one round waits for the next, and the disk needs time, too
PATIENCE_S = 2.0  # at the end, for a disk that does not answer

_NOTHING_TO_SYNC = (errno.EINVAL, errno.ENOTSUP, errno.EROFS)  # of the file system, not of the disk


class _SyncedFile:
    """A file with a descriptor of its own: the writer may close its own at any time."""

    def __init__(self, descriptor: int, path: Path) -> None:
        self._descriptor = os.dup(descriptor)
        self._folder = path.parent
        self._is_named = False  # whether its name is on the disk, too

    def sync(self) -> None:
        """Wait until all written data are on the disk. May raise OSError."""
        getattr(os, "fdatasync", os.fsync)(self._descriptor)  # macOS has no fdatasync
        if not self._is_named:
            self._is_named = True
            with suppress(OSError):  # an unreadable folder: most file systems store the name with the file
                folder = os.open(self._folder, os.O_RDONLY)
                try:
                    os.fsync(folder)
                finally:
                    os.close(folder)

    def close(self) -> None:
        os.close(self._descriptor)


class Lasting:
    """The files of a capture, one after the other. `follow` and `note` never wait for the disk."""

    def __init__(self) -> None:
        """Start the thread with the priority of its starter, so that it never delays the starter."""
        self.trouble = ""  # of the disk, in the system's words
        self._written = False  # since the last round
        self._files: deque[_SyncedFile] = deque()  # the last is that of now
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def follow(self, descriptor: int, path: str) -> None:
        """Continue with this file. Data of the one before are still synced."""
        self._files.append(_SyncedFile(descriptor, Path(path)))
        self._written = True

    def note(self) -> None:
        """Note that something was written."""
        self._written = True

    def end(self) -> None:
        """Sync the rest, then end."""
        self._ended.set()
        self._thread.join(PATIENCE_S)

    def _run(self) -> None:
        while not self._ended.wait(PERIOD_S):
            self._round()
        self._round()
        while self._files:
            self._files.popleft().close()

    def _round(self) -> None:
        while len(self._files) > 1:
            full = self._files.popleft()
            self._sync(full)
            full.close()
        if self._files and self._written:
            self._written = False
            self._sync(self._files[0])

    def _sync(self, file: _SyncedFile) -> None:
        try:
            file.sync()
        except OSError as error:
            if error.errno not in _NOTHING_TO_SYNC:
                self.trouble = error.strerror or str(error)
