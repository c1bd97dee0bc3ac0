# SPDX-License-Identifier: GPL-2.0-or-later
"""Sorts the records of several lines by the times of their first characters.

A record waits while a telegram that began earlier is still coming in on the other line, but no longer than HOLD_NS.
Then it is written, and what began earlier follows it.
"""

from __future__ import annotations

import heapq
import itertools
from collections import deque
from collections.abc import Iterable, Iterator

from sistap.records.record import Record

HOLD_NS = 500_000_000  # the longest telegram (263 characters) takes 301 ms at 9600 Bd


class Order:
    """Waiting records. `now_ns` may be any monotonic clock; the other times are those of the records."""

    def __init__(self) -> None:
        self._waiting: list[tuple[int, int, Record]] = []  # time, number: records of equal time keep their order
        self._number = itertools.count()
        self._since: deque[tuple[int, int]] = deque()  # when each began to wait, and its time
        self._overdue_ns = 0  # nothing that is at least this old waits

    def add(self, records: Iterable[Record], now_ns: int) -> None:
        """Add records."""
        for record in records:
            heapq.heappush(self._waiting, (record.time_ns, next(self._number), record))
            self._since.append((now_ns, record.time_ns))

    def due(self, unfinished_ns: Iterable[int | None], now_ns: int) -> Iterator[Record]:
        """Yield records that need not wait any longer; `unfinished_ns`: for each line, the oldest time not in a
        record.
        """
        while self._since and now_ns - self._since[0][0] >= HOLD_NS:
            self._overdue_ns = max(self._overdue_ns, self._since.popleft()[1])
        first_ns = min((time_ns for time_ns in unfinished_ns if time_ns is not None), default=None)
        while self._waiting and (first_ns is None or self._waiting[0][0] <= max(first_ns, self._overdue_ns)):
            yield heapq.heappop(self._waiting)[2]

    @property
    def empty(self) -> bool:
        """Tell whether nothing waits."""
        return not self._waiting
