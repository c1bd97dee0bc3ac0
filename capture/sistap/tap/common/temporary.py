# SPDX-License-Identifier: GPL-2.0-or-later
"""Temporary data: a folder that no signal leaves behind for good, and blobs in a file without a name."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from sistap.tap.terminal.exits import FAILED, Refusal
from sistap.tap.terminal.stop import held

if sys.platform != "win32":
    import fcntl

PREFIX = "sistap-temporary-"  # no person would choose this name
_NEW_S = 60.0  # a younger folder may not be claimed yet


class Folder:
    """A temporary folder. If this process is killed, the next Folder of this user removes it."""

    def __init__(self, *others: int) -> None:
        """Make it. Remove the folders that killed processes of this user, or of these others, have left."""
        sweep(*others)
        # If a signal comes just before its end, Python removes it with the object.
        self._made = tempfile.TemporaryDirectory(prefix=PREFIX, ignore_cleanup_errors=True)
        self.path = Path(self._made.name).absolute()  # TMPDIR may be . and tshark starts elsewhere
        self.descriptor = -1
        if sys.platform != "win32":
            self.descriptor = os.open(self.path, os.O_RDONLY)
            _claim(self.descriptor)

    def close(self) -> None:
        """Remove it."""
        if sys.platform != "win32":
            os.close(self.descriptor)
        self._made.cleanup()


def sweep(*others: int) -> None:
    """Remove folders of this user, or these others, that nobody claims: their processes are no more."""
    if sys.platform == "win32":
        return
    for path in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError):
            descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
            try:
                about = os.fstat(descriptor)
                is_old = abs(time.time() - about.st_mtime) > _NEW_S
                if is_old and about.st_uid in (os.geteuid(), *others) and _claim(descriptor):
                    shutil.rmtree(path, ignore_errors=True)  # which follows no link
            finally:
                os.close(descriptor)


def _claim(descriptor: int) -> bool:
    """Claim a folder as long as the descriptor is open; tell whether nobody else does."""
    if sys.platform != "win32":
        with suppress(OSError):
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
    return False


@contextmanager
def folder() -> Iterator[Path]:
    """Make a folder; remove it at the end."""
    with held():
        made = Folder()
    try:
        yield made.path
    finally:
        with held():
            made.close()


@contextmanager
def keeping(what: str) -> Iterator[None]:
    """Write into TMPDIR; `what` describes it. Raise Refusal if there is no room."""
    try:
        yield
    except OSError as error:
        raise Refusal(
            f"{tempfile.gettempdir()} cannot keep {what}: {error.strerror}; make room, or name a larger folder with "
            "TMPDIR",
            FAILED,
        ) from None


class Blobs:
    """Blobs in a file, read by their number. Use it in a `with`; nothing is left behind."""

    def __init__(self, what: str) -> None:
        """Make the file in TMPDIR; `what` describes its contents in the message about a lack of room."""
        self._what = what
        self._file = tempfile.TemporaryFile(prefix="sistap-")  # noqa: SIM115 - closed by __exit__
        self._ends = [0]

    def __enter__(self) -> Blobs:
        return self

    def __exit__(self, *error: object) -> None:
        with suppress(OSError):  # what found no room is still in the buffer
            self._file.close()

    def put(self, blob: bytes) -> None:
        """Append a blob. Refusal if there is no room."""
        with keeping(self._what):
            self._file.seek(self._ends[-1])
            self._file.write(blob)
            self._file.flush()
        self._ends.append(self._ends[-1] + len(blob))

    def get(self, number: int) -> bytes:
        """Return a blob; the first has number 0."""
        start, end = self._ends[number : number + 2]
        self._file.seek(start)
        return self._file.read(end - start)

    def all(self) -> Iterator[tuple[bytes, float]]:
        """Yield all blobs, each with the share of all bytes up to its end, 0 to 1."""
        for number, end in enumerate(self._ends[1:]):
            yield self.get(number), end / (self._ends[-1] or 1)
