# SPDX-License-Identifier: GPL-2.0-or-later
"""What is heard now, in bounded memory: the last records as a capture to show."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping

from sistap.tap.files.pcapng import Interface
from sistap.tap.files.writer import Blocks
from sistap.tap.records.before import Before, Heard, heard
from sistap.tap.records.record import Record

MOST = 2000  # records that are shown; then the older half is left out


class Window:
    """The last records. A capture of them begins with what the bus had told before: limits, names, units."""

    def __init__(self, interfaces: Mapping[int, Interface], started: Iterable[Record]) -> None:
        self._blocks = Blocks(interfaces)
        self._heading = self._blocks.section()
        self._started = [self._blocks.packet(record) for record in started]
        self._before = Before()
        self._recent: deque[tuple[bytes, Heard]] = deque()  # block, and what it says of its bus
        self._cut_ns = 0  # where the last record that was left out ends
        self.left_out = 0

    def add(self, record: Record) -> None:
        """Add a record."""
        self._heading += self._blocks.interface(record.line)
        self._recent.append((self._blocks.packet(record), heard(record)))
        if len(self._recent) > MOST:
            self._leave_out(MOST // 2)

    def capture(self) -> bytes:
        """Return a capture of them."""
        return b"".join([self._heading, *self._started, *self._told(), *(block for block, _ in self._recent)])

    @property
    def before(self) -> int:
        """Return the number of packets in the capture that come before the last records."""
        return len(self._started) + len(self._told())

    def _told(self) -> list[bytes]:
        """Return the telegrams before the last records that explain them; none while all records are there."""
        if not self.left_out:
            return []
        return [self._blocks.packet(record) for record in self._before.records(self._cut_ns)]

    def _leave_out(self, count: int) -> None:
        for _ in range(count):
            _, said = self._recent.popleft()
            self._before.take(said)
            self._cut_ns = said.end_ns
        self.left_out += count
