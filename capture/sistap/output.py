# SPDX-License-Identifier: GPL-2.0-or-later
"""Where a capture goes, block by block: a file, a pipe, or a row of files named as dumpcap names them.

Each block is one write without a buffer, so that whatever happens to this process, whole blocks are there.
"""

from __future__ import annotations

import contextlib
import errno
import os
import select
import stat
import sys
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

if sys.platform == "win32":
    import msvcrt

STANDARD_OUTPUT = "-"
FILE_NUMBERS = 100_000  # five digits in the name, then again from 0, as in dumpcap


class OutputError(Exception):
    """Nothing more can be written; str() is the one line to show."""


class OutputRefused(Exception):
    """It cannot be written to at all; str() is the one line to show."""


class Limits(NamedTuple):
    """When a file is full, and how many there may be; None: no limit."""

    size: int | None = None  # bytes of a file
    duration_s: float | None = None  # of a file
    several: bool = False  # go on with the next file when one is full
    keep: int | None = None  # of several files, delete the oldest above this number
    files: int | None = None  # stop after so many


NO_LIMITS = Limits()


def file_name(path: str, number: int, seconds: float) -> str:
    """Name one of several files: BASE_00001_YYYYMMDDHHMMSS.EXT, local time."""
    stamp = time.strftime("%Y%m%d%H%M%S", time.localtime(seconds))
    plain = Path(path)
    return str(plain.with_name(f"{plain.stem}_{number % FILE_NUMBERS:05d}_{stamp}{plain.suffix}"))


class Output:
    """Opens at once, so that what is wrong with a path is said before anything else happens; truncates in `begin`."""

    def __init__(
        self,
        path: str,
        limits: Limits = NO_LIMITS,
        stopped: Callable[[], bool] = lambda: False,
    ) -> None:
        """Open the (first) file. `stopped` tells when not to wait any longer for the reader of a pipe."""
        self._base = path
        self._limits = limits
        self._stopped = stopped
        self._number = 0
        self._written: deque[str] = deque()
        # Of the file that is open:
        self.path = path
        self._descriptor = -1
        self._created = False
        self._regular = False
        self._size = 0
        self._begun = 0.0
        self._poll: select.poll | None = None
        self._open()

    @property
    def full(self) -> bool:
        """Whether the file has reached a limit."""
        size, duration_s = self._limits.size, self._limits.duration_s
        return (size is not None and self._size >= size) or (
            duration_s is not None and time.monotonic() - self._begun >= duration_s
        )

    @property
    def done(self) -> bool:
        """Whether the last file is full."""
        return self.full and (not self._limits.several or self._number == self._limits.files)

    def begin(self) -> None:
        """Start the file: empty it, if it is one."""
        if self._regular and self._base != STANDARD_OUTPUT:
            os.ftruncate(self._descriptor, 0)
        self._begun = time.monotonic()

    def write(self, block: bytes) -> None:
        """Write one block. OutputError if that fails: then the file has been cut back to the block before."""
        while self._poll and not self._poll.poll(100):
            if self._stopped():  # must not hang on a reader of a pipe that does not read
                raise OutputError(f"{self} is not being read; the last records are missing in it")
        written = 0
        try:
            while written < len(block):
                written += os.write(self._descriptor, block[written:])
        except OSError as error:
            if self._regular:
                with contextlib.suppress(OSError):
                    os.ftruncate(self._descriptor, os.fstat(self._descriptor).st_size - written)
            raise OutputError(self._reason(error)) from error
        self._size += written

    def check(self) -> None:
        """Tell while there is nothing to write whether a pipe still has a reader; OutputError if not."""
        if self._poll and any(events & select.POLLERR for _, events in self._poll.poll(0)):
            raise OutputError(self._reason(BrokenPipeError(errno.EPIPE, "")))

    def next_file(self) -> None:
        """Go on with the next of several files; delete the oldest if there are too many."""
        full = self._descriptor
        try:
            self._open()
            os.close(full)
            self.begin()
            if self._limits.keep and len(self._written) > self._limits.keep:
                Path(self._written.popleft()).unlink(missing_ok=True)
        except (OSError, OutputRefused) as error:
            raise OutputError(str(error)) from error

    def close(self) -> None:
        """Close the file."""
        os.close(self._descriptor)

    def discard(self) -> None:
        """Close without having begun: leave no empty file behind."""
        os.close(self._descriptor)
        if self._created:
            Path(self.path).unlink(missing_ok=True)

    def __str__(self) -> str:
        """Name it for people."""
        if self._base == STANDARD_OUTPUT:
            return "standard output"
        return f"{self.path} (file {self._number})" if self._limits.several else self.path

    def _open(self) -> None:
        self._number += 1
        self._size = 0
        self._begun = time.monotonic()
        self.path = self._base
        if self._limits.several:
            self.path = file_name(self._base, self._number, time.time())
        try:
            self._descriptor, self._created = _open(self.path)
        except OSError as error:
            raise OutputRefused(
                f"{self.path} cannot be written: {error.strerror}; choose another file with -w"
            ) from error
        self._written.append(self.path)
        self._regular = stat.S_ISREG(os.fstat(self._descriptor).st_mode)
        self._poll = None
        if not self._regular and hasattr(select, "poll"):  # Windows has none
            self._poll = select.poll()
            self._poll.register(self._descriptor, select.POLLOUT)

    def _reason(self, error: OSError) -> str:
        if error.errno == errno.EPIPE:
            return f"the reader of {self} is gone; the capture has ended"
        return f"{self}: {error.strerror}; everything before it is saved"


def _open(path: str) -> tuple[int, bool]:
    """Open for writing without touching the content: descriptor, and whether the file is new."""
    if path == STANDARD_OUTPUT:
        if sys.platform == "win32":
            msvcrt.setmode(1, os.O_BINARY)
        return os.dup(1), False
    flags = os.O_WRONLY | os.O_CREAT | getattr(os, "O_NOCTTY", 0) | getattr(os, "O_BINARY", 0)
    try:
        return os.open(path, flags | os.O_EXCL, 0o666), True
    except FileExistsError:
        return os.open(path, flags, 0o666), False
