# SPDX-License-Identifier: GPL-2.0-or-later
"""Keeps a log and what was found in it on disk until all of it has been dissected.

A log is read only once, because it may grow meanwhile, and because finding the bytes is most of the work. The spool
holds enough to write the log again with its explanations.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator
from typing import NamedTuple

from sistap.commands.annotate.cutting import PiecePart
from sistap.commands.annotate.textlog import LogLine
from sistap.tap.common.temporary import Blobs


class LogEntry(NamedTuple):
    """A line with its number of bytes, and the places of the telegrams and other characters that it completes."""

    line: LogLine | None  # None: after the last line
    size: int
    complete: list[list[PiecePart]]


class Spool:
    """Keeps a log. Use it in a `with`."""

    def __init__(self) -> None:
        self._blobs = Blobs("the log")

    def __enter__(self) -> Spool:
        return self

    def __exit__(self, *error: object) -> None:
        self._blobs.__exit__(*error)

    def put(self, entries: list[LogEntry]) -> None:
        """Keep a batch. Refusal if there is no room."""
        self._blobs.put(pickle.dumps(entries, pickle.HIGHEST_PROTOCOL))

    def batches(self, progress: Callable[[float], None]) -> Iterator[list[LogEntry]]:
        """Return the batches in order; call `progress` with the part that has been read, 0 to 1."""
        for blob, part in self._blobs.all():
            yield pickle.loads(blob)
            progress(part)
