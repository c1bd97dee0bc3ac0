# SPDX-License-Identifier: GPL-2.0-or-later
"""One running tshark: takes blocks of a capture, and returns a line for each packet that it prints. Nobody waits for
it.

Two threads decouple it: tshark must never wait for its lines to be read while blocks are written to it, and neither
must the writer wait for tshark. The threads have the priority of their starter. At a lower one they could delay a
reader, because only one thread of Python runs at a time. tshark itself always has ordinary priority.
"""

from __future__ import annotations

import queue
import tempfile
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress

from sistap.line import priority
from sistap.wireshark.tshark import Tshark, TsharkError


class Running:
    """A tshark that reads what is put into it until `end`."""

    def __init__(self, tshark: Tshark, arguments: Sequence[str]) -> None:
        """Start it. May raise OSError."""
        self.lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()  # None: it has ended
        self._blocks: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed when it has ended
        is_urgent = priority.is_real_time()
        with priority.ordinary_children():
            self._process = tshark.start(["-r", "-", "-l", *arguments], self._errors)
        for work in (self._write, self._listen):
            threading.Thread(target=_at_priority, args=(work, is_urgent), daemon=True).start()

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
        self._errors.seek(0)
        said = self._errors.read().decode(errors="replace").strip().splitlines()
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


def _at_priority(work: Callable[[], None], is_urgent: bool) -> None:
    if is_urgent:
        priority.take_real_time()
    work()
