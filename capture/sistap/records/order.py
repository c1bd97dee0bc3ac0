# SPDX-License-Identifier: GPL-2.0-or-later
"""Puts the records of several lines in the order in which their first characters came.

A record waits while a telegram that began before it is still coming in on the other line, but no longer than HOLD_NS:
then it is written, and what began earlier comes after it.
"""

from __future__ import annotations

import heapq
import itertools
from collections import deque
from collections.abc import Iterable, Iterator

from sistap.records.record import Record

HOLD_NS = 500_000_000  # the longest telegram (263 characters) takes 301 ms at 9600 Bd


class Order:
    """Records that wait. The clock of `now_ns` is any that goes on; the other times are those of the records."""

    def __init__(self) -> None:
        self._waiting: list[tuple[int, int, Record]] = []  # time, number: equal times stay as they came
        self._number = itertools.count()
        self._since: deque[tuple[int, int]] = deque()  # when each began to wait, and its time
        self._overdue_ns = 0  # nothing waits that is as old as this

    def add(self, records: Iterable[Record], now_ns: int) -> None:
        """Let these wait."""
        for record in records:
            heapq.heappush(self._waiting, (record.time_ns, next(self._number), record))
            self._since.append((now_ns, record.time_ns))

    def due(self, unfinished_ns: Iterable[int | None], now_ns: int) -> Iterator[Record]:
        """Yield what need not wait any longer; `unfinished_ns`: when what is not in records yet came, of each line."""
        while self._since and now_ns - self._since[0][0] >= HOLD_NS:
            self._overdue_ns = max(self._overdue_ns, self._since.popleft()[1])
        first_ns = min((time_ns for time_ns in unfinished_ns if time_ns is not None), default=None)
        while self._waiting and (first_ns is None or self._waiting[0][0] <= max(first_ns, self._overdue_ns)):
            yield heapq.heappop(self._waiting)[2]

    @property
    def empty(self) -> bool:
        """Whether nothing waits."""
        return not self._waiting
