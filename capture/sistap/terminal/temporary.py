# SPDX-License-Identifier: GPL-2.0-or-later
"""What is kept on disk for a while: a folder that stays behind after no signal, and blobs in a file without a name."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from sistap.terminal.stop import held
from sistap.terminal.writing import Incomplete


@contextmanager
def folder() -> Iterator[Path]:
    """Make a folder; remove it at the end. If a signal comes just before that, Python does it with the object."""
    with held():
        made = tempfile.TemporaryDirectory(prefix="sistap-")
    try:
        yield Path(made.name)
    finally:
        with held():
            made.cleanup()


class Blobs:
    """Blobs that are read again later, by their number. Use it in a `with`; nothing is left behind."""

    def __init__(self, what: str) -> None:
        """Make the file, where TMPDIR says; `what` is what it keeps, for the line that says that there is no room."""
        self._what = what
        self._file = tempfile.TemporaryFile(prefix="sistap-")  # noqa: SIM115 - closed by __exit__
        self._ends = [0]

    def __enter__(self) -> Blobs:
        return self

    def __exit__(self, *error: object) -> None:
        with suppress(OSError):  # what found no room is still in the buffer
            self._file.close()

    def put(self, blob: bytes) -> None:
        """Keep a blob behind the others. Incomplete if there is no room."""
        try:
            self._file.seek(self._ends[-1])
            self._file.write(blob)
            self._file.flush()
        except OSError as error:
            raise Incomplete(
                f"{tempfile.gettempdir()} cannot keep {self._what}: {error.strerror}; make room, or name a larger "
                "folder with TMPDIR"
            ) from None
        self._ends.append(self._ends[-1] + len(blob))

    def get(self, number: int) -> bytes:
        """Return a blob; the first has number 0."""
        start, end = self._ends[number : number + 2]
        self._file.seek(start)
        return self._file.read(end - start)

    def all(self) -> Iterator[tuple[bytes, float]]:
        """Yield all blobs, each with the part of all bytes that ends with it, 0 to 1."""
        for number, end in enumerate(self._ends[1:]):
            yield self.get(number), end / (self._ends[-1] or 1)
