# SPDX-License-Identifier: GPL-2.0-or-later
"""One running tshark: takes blocks of a capture, and returns a line for each packet that it prints. Nobody waits for
it.

Two threads decouple it: tshark must never wait for its lines to be read while blocks are written to it, and neither
must the writer wait for tshark. The threads have the priority of their starter. At a lower one they could delay a
reader, because only one thread of Python runs at a time. tshark itself always has ordinary priority.
"""

from __future__ import annotations

import os
import queue
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress

from sistap.dissected.wireshark.tshark import Tshark, TsharkError
from sistap.tap.common.complaints import Complaints
from sistap.tap.line import priority


@contextmanager
def ordinary_children() -> Iterator[None]:
    """Start programs with ordinary priority, whatever this thread has.

    A program inherits the real-time priority of the thread that starts it. A busy one would then starve all others.
    """
    if sys.platform != "linux" or not priority.is_real_time():
        yield
        return
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    try:
        yield
    finally:
        os.sched_setscheduler(0, *before)


class Running:
    """A tshark that reads what is put into it until `end`."""

    def __init__(self, tshark: Tshark, arguments: Sequence[str]) -> None:
        """Start it. May raise OSError."""
        self.lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()  # None: it has ended
        self._blocks: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        begin: Callable[[], object] = priority.take_real_time if priority.is_real_time() else bool
        with Complaints(begin) as self._complaints, ordinary_children():
            self._process = tshark.start(["-r", "-", "-l", *arguments], self._complaints.stream)
        for work in (self._write, self._listen):
            threading.Thread(target=_after, args=(begin, work), daemon=True).start()

    def put(self, data: bytes) -> None:
        """Send whole blocks."""
        self._blocks.put(data)

    def end(self) -> None:
        """Send no more: tshark prints its remaining lines, then None follows."""
        self._blocks.put(None)

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()
        self.end()

    def wait(self) -> None:
        """Wait for its end."""
        self._process.wait()

    @property
    def pid(self) -> int:
        """Return its process number."""
        return self._process.pid

    @property
    def ended_well(self) -> bool:
        """Tell whether it has ended after reading everything."""
        return self._process.returncode == 0

    def failure(self) -> TsharkError:
        """Return why it has ended."""
        self._process.wait()
        said = self._complaints.text().splitlines()
        return TsharkError(said[-1] if said else f"tshark ended with exit code {self._process.returncode}")

    def _write(self) -> None:
        assert self._process.stdin
        with suppress(OSError):  # it has ended, and its lines show it
            while (data := self._blocks.get()) is not None:
                self._process.stdin.write(data)
                self._process.stdin.flush()
        with suppress(OSError):
            self._process.stdin.close()

    def _listen(self) -> None:
        assert self._process.stdout
        with self._process.stdout as stdout:
            for line in stdout:
                self.lines.put(line.decode(errors="replace").rstrip("\n"))
        self._process.wait()
        self._blocks.put(None)  # ends the writer
        self.lines.put(None)


def _after(begin: Callable[[], object], work: Callable[[], None]) -> None:
    begin()
    work()
