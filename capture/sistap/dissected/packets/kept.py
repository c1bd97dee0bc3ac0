# SPDX-License-Identifier: GPL-2.0-or-later
"""Keeps what tshark printed for each packet on disk, compressed: only the last packet decides which windows are needed.

Dissecting the whole capture again would take as long as the first time.
"""

from __future__ import annotations

import marshal
import zlib
from collections.abc import Collection, Iterator
from typing import Any, NamedTuple

from sistap.tap.common.temporary import Blobs

_TOGETHER = 500  # rows in a blob
_LEVEL = 1  # of compression; higher levels take several times as long and save a fifth


class Span(NamedTuple):
    """A stretch of a capture, in s since its first packet; both ends are included."""

    start_s: float
    end_s: float


class _Held(NamedTuple):
    """The packets in a blob; their times may be out of order."""

    earliest_s: float
    latest_s: float

    def may_have(self, spans: Collection[Span]) -> bool:
        return any(span.start_s <= self.latest_s and self.earliest_s <= span.end_s for span in spans)


class Kept:
    """Rows in the order of their packets. Use it in a `with`."""

    def __init__(self) -> None:
        self._blobs = Blobs("what was read of the capture")
        self._held: list[_Held] = []  # one for each blob
        self._rows: list[Any] = []  # of the next blob, with their times
        self._times_s: list[float] = []

    def __enter__(self) -> Kept:
        return self

    def __exit__(self, *error: object) -> None:
        self._blobs.__exit__(*error)

    def put(self, time_s: float, row: Any) -> None:
        """Keep the row of a packet, of strings and bytes. Refusal if there is no room."""
        self._rows.append(row)
        self._times_s.append(time_s)
        if len(self._rows) == _TOGETHER:
            self._write()

    def rows(self, spans: Collection[Span]) -> Iterator[Any]:
        """Yield the rows of the packets that begin in these spans, and of some neighbours."""
        if self._rows:
            self._write()
        for place, held in enumerate(self._held):
            if held.may_have(spans):
                yield from marshal.loads(zlib.decompress(self._blobs.get(place)))

    def _write(self) -> None:
        self._blobs.put(zlib.compress(marshal.dumps(self._rows), _LEVEL))
        self._held.append(_Held(min(self._times_s), max(self._times_s)))
        for values in (self._rows, self._times_s):
            values.clear()
