# SPDX-License-Identifier: GPL-2.0-or-later
"""The destination of a capture: a file, a pipe, a series of files named as dumpcap names them, or memory.

A file gets each block with one unbuffered write, so that it has whole blocks whatever happens to this process. A pipe
or a terminal gets pieces that do not block, so that a reader that does not read never delays a stop.
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
from collections.abc import Callable, Collection, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from sistap.tap.files.lasting import PROMISED_S, Lasting
from sistap.tap.terminal.advice import shell_word
from sistap.tap.terminal.console import PIECE, STANDARD_OUTPUT, is_reader_gone, never_waiting
from sistap.tap.terminal.exits import FAILED, Refusal, why
from sistap.tap.terminal.programs import typed
from sistap.tap.terminal.writing import WINDOWS_PIPES, lock, mode_like, no_link

if sys.platform == "win32":
    import msvcrt

FILE_NUMBERS = 100_000  # five digits in the name, then from 0 again, as in dumpcap
_WAIT_MS = 100  # upper bound on the time to stop
_PAUSE_S = 0.01  # a terminal may report room and then not accept anything


class OutputError(Refusal):
    """No more can be written; str() is the line to show."""

    code = FAILED


class ReaderGone(OutputError):
    """Nobody reads the pipe any more."""


class OutputRefused(Refusal):
    """The output cannot be written to; str() is the line to show, of a command."""

    def __init__(self, what: str, cure: str = "; choose another file with -w") -> None:
        """Say what is wrong, and what to do."""
        super().__init__(what + cure)
        self.what = what


class FileLimits(NamedTuple):
    """When a file is full, and how many files there may be; None: no limit."""

    size: int | None = None  # bytes of a file
    duration_s: float | None = None  # of a file
    several: bool = False  # continue with the next file when one is full
    keep: int | None = None  # keep only this many of several files
    files: int | None = None  # stop after this many files


NO_LIMITS = FileLimits()


def file_name(path: str, number: int, seconds: float) -> str:
    """Return the name of one of several files: BASE_00001_YYYYMMDDHHMMSS.EXT, local time. Refuse a folder."""
    plain = Path(path)
    if plain.is_dir():
        return path
    stamp = time.strftime("%Y%m%d%H%M%S", time.localtime(seconds))
    return str(plain.with_name(f"{plain.stem}_{number % FILE_NUMBERS:05d}_{stamp}{plain.suffix}"))


class Output:
    """The output. It opens at once, so that errors of the path come first, and truncates in `begin`."""

    def __init__(  # noqa: PLR0913 - where to, how much, and whom to ask and to tell
        self,
        path: str,
        limits: FileLimits = NO_LIMITS,
        stopped: Callable[[], bool] = lambda: False,
        say: Callable[[str], None] = lambda _: None,
        *,
        force: bool = False,
        is_new: bool = False,
        sources: Sequence[str | Path] = (),
    ) -> None:
        """Open the (first) file. `stopped` tells when to stop waiting for the reader of a pipe.

        Without `force`, a file that holds data is refused. `say` receives problems that do not end the capture at
        once. Whoever may read the file may read its `sources`, too. May raise OutputRefused, and FileExistsError if the
        file must be new.
        """
        self._base = path
        self._is_new = is_new
        self._sources = sources
        self._limits = limits
        self._stopped = stopped
        self._say = say
        self._number = 1
        self._opened = path  # the newest, before it is there
        self._begun = time.monotonic()
        self._file = self._open()
        if not force and self._file.holds_data:
            self._file.close()
            cure = ": choose another file with -w, or overwrite it with --force"
            raise OutputRefused(f"{path} holds data already", cure)
        self._before: _OpenFile | None = None  # the last closed one of several files
        self._next: _OpenFile | None = None
        self._kept = deque([self._file.path])  # all names if the oldest files are deleted, else only the first
        self._stay: list[str] = []  # older ones that could not be deleted
        self._lasting: Lasting | None = None
        self._doubted = False  # disk trouble was reported
        self.failed = False  # the next of several files could not be opened, so this one is the last

    @property
    def full(self) -> bool:
        """Tell whether the file has reached a limit."""
        size, duration_s = self._limits.size, self._limits.duration_s
        return (size is not None and self._file.size >= size) or (
            duration_s is not None and time.monotonic() - self._begun >= duration_s
        )

    @property
    def continues(self) -> bool:
        """Tell whether another file follows when this one is full."""
        return self._limits.several

    @property
    def heading_bytes(self) -> int:
        """Return how much of a file its heading may take, so that there is room for records."""
        return self._limits.size // 4 if self._limits.size is not None else sys.maxsize

    @property
    def done(self) -> bool:
        """Tell whether the last file is full."""
        return self.full and (self.failed or not self._limits.several or self._number == self._limits.files)

    @property
    def open_names(self) -> Collection[str]:
        """Return the names, without folder, of files that are written or will be in a moment. For any thread."""
        return {Path(self._file.path).name, Path(self._opened).name}

    def begin(self) -> None:
        """Begin the file; empty it if it is a regular file."""
        self._file.empty()
        self._begun = time.monotonic()

    @contextlib.contextmanager
    def lasting(self) -> Iterator[None]:
        """Make written data reach the disk soon while the block runs: a power cut costs a second.

        Not on Windows, where a file held open for that could not be deleted.
        """
        if sys.platform == "win32" or not self._file.regular:
            yield
            return
        self._lasting = Lasting()
        self._lasting.follow(self._file.descriptor, self._file.path)
        try:
            yield
        finally:
            self._lasting.end()
            self._tell_trouble()
            self._lasting = None

    def write(self, block: bytes) -> None:
        """Write one block. OutputError if that fails: then a regular file has been cut back to the block before."""
        file = self._file
        rest = memoryview(block)
        try:
            while rest:
                written = file.write_some(rest)
                rest = rest[written:]
                if not written and self._stopped():
                    raise OutputError(f"{self} is not being read; the last records are missing in it")
        except OSError as error:
            file.cut(len(block) - len(rest))
            raise self._failure(error) from error
        file.size += len(block)
        if self._lasting:
            self._lasting.note()
            self._tell_trouble()

    def check(self) -> None:
        """Check, while there is nothing to write, that a pipe still has a reader; ReaderGone if not."""
        if self._file.deserted:
            raise self._failure(BrokenPipeError(errno.EPIPE, ""))

    def open_next(self) -> bool:
        """Open the next of several files while the present one can still be written. If that fails, the present one
        is the last.
        """
        try:
            self._next = self._open(self._number + 1)
        except OutputRefused as error:
            self.failed = True
            self._say(f"{error}; everything before it is saved")
        return not self.failed

    def go_on(self) -> None:
        """Close this file and continue with the one that `open_next` opened; delete the oldest if there are too
        many.
        """
        assert self._next
        self._file.close()
        self._before, self._file, self._next = self._file, self._next, None
        self._number += 1
        if self._lasting:
            self._lasting.follow(self._file.descriptor, self._file.path)
        if self._limits.keep:
            self._kept.append(self._file.path)
            surplus = [self._kept.popleft()] if len(self._kept) > self._limits.keep else []
            self._stay = [path for path in (*self._stay, *surplus) if not self._deleted(path)]

    def _deleted(self, path: str) -> bool:
        """Try to delete a file of a ring. Windows keeps it while somebody reads it."""
        try:
            Path(path).unlink(missing_ok=True)
        except OSError as error:
            if path not in self._stay:
                self._say(f"{path} cannot be deleted: {error.strerror}; each new file tries again")
            return False
        return True

    def close(self) -> None:
        """Close the file. Remove a new file without contents."""
        for file in (self._file, self._next):
            if file:
                file.close()

    def __str__(self) -> str:
        return self._file.name

    def _last(self) -> tuple[int, _OpenFile | None]:
        """Return the number of files, and the last one. A new one without contents does not count: it is removed."""
        empty = self._file.is_new_and_empty
        return (self._number - 1, self._before) if empty else (self._number, self._file)

    @property
    def summary(self) -> str:
        """Describe everything that was written."""
        number, last = self._last()
        if not last:
            return "no file"
        if number == 1:
            return last.name
        kept = len(self._kept) - (last != self._file) if self._limits.keep else number
        deleted = f", of which the last {kept} were kept" if kept < number else ""
        return f"{number} files{deleted}: {self._kept[0]} to {last.path}"

    @property
    def written(self) -> str:
        """Say where everything was written, and how to open it if that is one file."""
        number, last = self._last()
        if not last or number > 1 or not last.regular or last.path == STANDARD_OUTPUT:
            return f"written to {self.summary}"
        wireshark, file = shell_word(typed("wireshark")), shell_word(last.path)
        return f"written to {self.summary}; open it with: {wireshark} -C SIS {file}"

    def _tell_trouble(self) -> None:
        """Report once that the disk does not take the data."""
        if self._lasting and self._lasting.trouble and not self._doubted:
            self._doubted = True
            self._say(
                f"{self}: {self._lasting.trouble}: a power cut can cost more than the last {PROMISED_S:.0f} s; "
                "capture to another disk"
            )

    def _open(self, number: int = 1) -> _OpenFile:
        if not self._limits.several:
            return _OpenFile(self._base, self._sources, is_new=self._is_new)
        seconds = time.time()
        while True:
            path = self._opened = file_name(self._base, number, seconds)
            try:
                return _OpenFile(path, self._sources, is_new=path != self._base)
            except FileExistsError:  # of a capture that ended a moment ago: started anew, this one must not empty it
                seconds += 1

    def _failure(self, error: OSError) -> OutputError:
        if is_reader_gone(error, is_file=self._file.regular):
            return ReaderGone(f"the reader of {self} is gone; the capture has ended")
        return OutputError(f"{self}: {error.strerror}; everything before it is saved")


class _OpenFile:
    """A file, pipe or terminal open for writing; `size` is the number of bytes written to it."""

    def __init__(self, path: str, sources: Sequence[str | Path], *, is_new: bool) -> None:
        """Open without changing the contents. May raise OutputRefused, and FileExistsError if it must be new."""
        self.path = path
        self.name = "standard output" if path == STANDARD_OUTPUT else path  # for messages
        self.size = 0
        try:
            mode = mode_like(sources)
            self.descriptor, self._created = _open(path, mode, is_new=is_new)
        except OSError as error:
            if is_new and isinstance(error, FileExistsError):
                raise
            raise OutputRefused(f"{self.name} cannot be written: {why(error)}") from error
        about = os.fstat(self.descriptor)
        self.regular = stat.S_ISREG(about.st_mode)
        self._mode = stat.S_IMODE(about.st_mode) & (mode if sources else 0o7777)
        self._poll: select.poll | None = None
        if self.regular and path != STANDARD_OUTPUT and not lock(self.descriptor):
            os.close(self.descriptor)
            raise OutputRefused(f"{self.path} is being written by another capture")
        if sys.platform != "win32" and not self.regular:
            self._poll = select.poll()
            self._poll.register(self.descriptor, select.POLLOUT)

    def empty(self) -> None:
        """Remove the contents of an older capture, unless a shell appends to the file."""
        if self.regular and self.path != STANDARD_OUTPUT:
            os.ftruncate(self.descriptor, 0)
            if sys.platform != "win32":
                with contextlib.suppress(PermissionError):  # it belongs to somebody else, who decides
                    os.fchmod(self.descriptor, self._mode)

    def write_some(self, data: memoryview) -> int:
        """Write as much as possible, after a short wait if necessary; return the number of bytes. May raise OSError."""
        if not self._poll:
            return os.write(self.descriptor, data)
        if not self._poll.poll(_WAIT_MS):
            return 0
        try:
            return os.write(self.descriptor, data[:PIECE])
        except BlockingIOError:
            time.sleep(_PAUSE_S)
            return 0

    def cut(self, count: int) -> None:
        """Remove the last bytes, if possible."""
        if self.regular:
            with contextlib.suppress(OSError):
                os.ftruncate(self.descriptor, os.fstat(self.descriptor).st_size - count)

    @property
    def holds_data(self) -> bool:
        """Whether `empty` would take something away."""
        return self.regular and self.path != STANDARD_OUTPUT and os.fstat(self.descriptor).st_size > 0

    @property
    def is_new_and_empty(self) -> bool:
        """Tell whether the file is new and still empty. Windows says of `nul`, too, that it is new."""
        return self._created and self.regular and not self.size

    @property
    def deserted(self) -> bool:
        """Tell whether it is a pipe without a reader."""
        if sys.platform == "win32" or self._poll is None:
            return False
        return any(events & select.POLLERR for _, events in self._poll.poll(0))

    def close(self) -> None:
        """Close; delete the file if it is new and empty."""
        os.close(self.descriptor)
        if self.is_new_and_empty:
            Path(self.path).unlink(missing_ok=True)


def _open(path: str, mode: int, *, is_new: bool) -> tuple[int, bool]:
    """Open for writing without changing the contents; return the descriptor, and whether the file is new.

    A file that must be new has a name that can be foreseen: a pipe put there would wait for a reader for ever.
    """
    if path == STANDARD_OUTPUT:
        os.write(1, b"")  # raises OSError if it is closed, or open only for reading
        if sys.platform == "win32":
            msvcrt.setmode(1, os.O_BINARY)
        return never_waiting(1), False
    if sys.platform == "win32":
        flags = os.O_WRONLY | os.O_BINARY
    else:
        flags = os.O_WRONLY | os.O_NOCTTY
    if path.startswith(WINDOWS_PIPES):
        return os.open(path, flags), False
    if not is_new:
        flags |= no_link(path)
    try:
        return os.open(path, flags | os.O_CREAT | os.O_EXCL, mode), True
    except FileExistsError:
        if is_new:
            raise
        return os.open(path, flags | os.O_CREAT, mode), False
