# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads several ports as one, with all characters in order.

If the system can wait for all of them at once, one thread reads them. Then a time stamp is as good as that of a single
port, and a late reader knows it. Separate threads would delay each other without noticing.
"""

from __future__ import annotations

import select
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import ceil
from queue import Empty, SimpleQueue
from typing import Protocol, runtime_checkable

from sistap.tap.line.clock import monotonic_ns
from sistap.tap.line.reader.contract import STEP_MS, PortLost, Reader
from sistap.tap.line.settings import Read

_MOST_BYTES = 16 << 20  # that threads have read and nobody has taken: half a minute with a read in each ms
if sys.platform == "win32":  # it has no poll, and does not need it
    _TO_READ = 0
else:
    _TO_READ = select.POLLIN


Ready = list[tuple[int, int]]  # descriptors, as poll returns them


class Source(Protocol):
    """Where characters come from: a reader, or several as one."""

    def read(self, timeout_s: float) -> Read | None:
        """Return what arrived; None if nothing arrived in that time. May raise PortLost, once for each port."""


class Polled(Protocol):
    """What a caller can poll."""

    def fileno(self) -> int:
        """Return the descriptor to poll."""

    def read_now(self, slept_ns: int) -> list[Read]:
        """Return what is there. The process slept until it came; 0: it was there before. May raise PortLost."""


class Beside(Polled, Protocol):
    """What is polled together with a port, and knows when the caller is about to sleep."""

    def before_sleep(self, now_ns: int) -> int:
        """Do what has to be done before a sleep. Return how long it may last, at most, in ms."""

    def note(self, delay_ns: int) -> None:
        """Note that a sleep until nothing came lasted so much too long."""


@runtime_checkable
class Pollable(Polled, Reader, Protocol):
    """A reader that a caller can poll."""

    def nothing_until(self, time_ns: int, slept_ns: int) -> list[Read]:
        """Note that nothing was unread at this instant of the monotonic clock, just after a sleep of that length.

        Return what was held back until then.
        """

    def held(self) -> list[Read]:
        """Stop holding characters back: return them."""

    @property
    def beside(self) -> Beside | None:
        """Return what is polled together with this reader, and before it."""


@runtime_checkable
class Several(Source, Protocol):
    """Readers that are read as one; more can be added."""

    def add(self, reader: Reader) -> None:
        """Add a reader."""


@contextmanager
def together(readers: Sequence[Reader], *, may_change: bool = False) -> Iterator[Source]:
    """Read several readers as one, each with its own line, until the block ends. They stay open.

    `may_change`: the result is a Several, to which a reader can be added in place of a lost one.
    """
    pollable = [reader for reader in readers if isinstance(reader, Pollable)]
    if sys.platform != "win32" and len(pollable) == len(readers):
        yield PolledReaders(pollable)
    elif len(readers) == 1 and not may_change:
        yield readers[0]
    else:
        threaded = ThreadedReaders(readers)
        try:
            yield threaded
        finally:
            threaded.end()


class PolledReaders:
    """Readers polled by one thread."""

    def __init__(self, readers: Sequence[Pollable]) -> None:
        self._polled: dict[int, Polled] = {}  # the readers, and what is beside them
        self._readers: dict[int, Pollable] = {}
        self._beside: set[Beside] = set()
        self._poll = select.poll()
        for reader in readers:
            self.add(reader)
        self._reads: deque[Read] = deque()
        self._lost: deque[PortLost] = deque()

    def add(self, reader: Reader) -> None:
        """Add a reader, which must be Pollable."""
        assert isinstance(reader, Pollable)
        if reader.beside:
            self._beside.add(reader.beside)
        for polled in _both(reader):
            self._polled[polled.fileno()] = polled
            self._poll.register(polled.fileno(), _TO_READ)
        self._readers[reader.fileno()] = reader

    def read(self, timeout_s: float) -> Read | None:
        """Return what arrived; None if nothing arrived, at most that long. May raise PortLost, once for each port."""
        if not self._reads and not self._lost:
            self._wait(timeout_s)
        if not self._reads and not timeout_s:
            self._reads.extend(read for reader in self._readers.values() for read in reader.held())
        if self._reads:
            return self._reads.popleft()
        if self._lost:
            raise self._lost.popleft()
        return None

    def _wait(self, timeout_s: float) -> None:
        """Take what is there, else what comes in that time."""
        if (ready := self._poll.poll(0)) and self._take(ready, 0):
            return
        end_ns, left_ms = monotonic_ns() + int(timeout_s * 1e9), ceil(timeout_s * 1000)
        while left_ms > 0 and not self._sleep(STEP_MS if left_ms > STEP_MS else left_ms):
            left_ms = -((monotonic_ns() - end_ns) // 1_000_000)  # rounded up

    def _sleep(self, step_ms: int) -> bool:
        """Take what comes within the step, now that nothing is there; tell whether anything came."""
        asked_ns = monotonic_ns()
        for beside in self._beside:
            most_ms = beside.before_sleep(asked_ns)
            step_ms = most_ms if most_ms < step_ms else step_ms
        ready = self._poll.poll(step_ms)
        slept_ns = monotonic_ns() - asked_ns or 1
        came = self._take(ready, slept_ns)  # before anything else: it gets its time here
        if ready and self._readers.keys() <= dict(ready).keys():
            return came
        if ready:
            self._note_silence(ready, asked_ns, slept_ns)
            asked_ns, slept_ns = monotonic_ns(), 1
            ready = self._poll.poll(0)  # until when were the others silent?
            self._take(ready, 0)
        else:
            for beside in self._beside:
                beside.note(slept_ns - step_ms * 1_000_000)
            asked_ns += step_ms * 1_000_000  # poll looks once more when time is up
        self._note_silence(ready, asked_ns, slept_ns)
        return bool(self._reads or self._lost)

    def _note_silence(self, ready: Ready, time_ns: int, slept_ns: int) -> None:
        """Tell the readers that are not ready that nothing was unread at that time, just after a sleep."""
        for descriptor in self._readers.keys() - dict(ready).keys():
            self._reads.extend(self._readers[descriptor].nothing_until(time_ns, slept_ns))

    def _take(self, ready: Ready, slept_ns: int) -> bool:
        """Take what is there; tell whether anything is to be told."""
        for descriptor, _ in ready:
            reader = self._polled[descriptor]
            try:
                self._reads.extend(reader.read_now(slept_ns))
            except PortLost as lost:
                assert isinstance(reader, Pollable)
                if reader.beside:
                    self._beside.discard(reader.beside)
                for polled in _both(reader):
                    self._poll.unregister(polled.fileno())
                    del self._polled[polled.fileno()]
                del self._readers[descriptor]
                self._lost.append(lost)
        return bool(self._reads or self._lost)


def _both(reader: Pollable) -> tuple[Polled, ...]:
    """Return what is polled for a reader, in the order in which poll returns it."""
    return (reader.beside, reader) if reader.beside else (reader,)


class ThreadedReaders:
    """Readers with a thread each: for ports whose times have no bound, or are those of a virtual bus."""

    def __init__(self, readers: Sequence[Reader]) -> None:
        self._queue: SimpleQueue[Read | PortLost] = SimpleQueue()
        self._bytes = 0  # in the queue
        self._lock = threading.Lock()
        self._ended = False
        self._threads: list[threading.Thread] = []
        for reader in readers:
            self.add(reader)

    def add(self, reader: Reader) -> None:
        """Add a reader."""
        self._threads = [thread for thread in self._threads if thread.is_alive()]
        self._threads.append(threading.Thread(target=self._listen, args=(reader,), daemon=True))
        self._threads[-1].start()

    def end(self) -> None:
        """Stop reading: then the ports can be closed."""
        self._ended = True
        for thread in self._threads:
            thread.join()

    def read(self, timeout_s: float) -> Read | None:
        """Return what arrived; None if nothing arrived in that time. May raise PortLost, once for each port."""
        try:
            item = self._queue.get(timeout=timeout_s) if timeout_s else self._queue.get_nowait()
        except Empty:
            return None
        if isinstance(item, PortLost):
            raise item
        self._count(item, -1)
        return item

    def _count(self, read: Read, sign: int) -> None:
        with self._lock:
            self._bytes += sign * (500 + 2 * len(read.data))  # roughly its memory

    def _listen(self, reader: Reader) -> None:
        while not self._ended:
            while self._bytes > _MOST_BYTES and not self._ended:  # a port that floods must not fill the memory
                time.sleep(STEP_MS / 1000)
            try:
                read = reader.read(STEP_MS / 1000)
            except PortLost as lost:
                self._queue.put(PortLost(str(lost), reader.line))
                return
            if read:
                self._count(read, 1)
                self._queue.put(read)
