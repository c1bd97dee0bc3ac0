# SPDX-License-Identifier: GPL-2.0-or-later
"""One running tshark: blocks of a capture go in, a line for each packet that it prints comes out. Nobody waits for it.

Two threads are between: tshark must never have to wait with its lines while it is written to, nor may whoever has
blocks for it. They have the priority of who starts them: at a lower one they could keep a reader from its turn, for
only one thread of Python runs at a time. tshark itself always has the ordinary one.
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
        """Send no more: it says what it still has to say, then None."""
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
        """The number of its process."""
        return self._process.pid

    @property
    def ended_well(self) -> bool:
        """Whether it has ended, and has read all that there was."""
        return self._process.returncode == 0

    def failure(self) -> TsharkError:
        """Say why it has ended."""
        self._process.wait()
        self._errors.seek(0)
        said = self._errors.read().decode(errors="replace").strip().splitlines()
        return TsharkError(said[-1] if said else f"tshark ended with exit code {self._process.returncode}")

    def _write(self) -> None:
        assert self._process.stdin
        with suppress(OSError):  # it has ended, and its lines say so
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
        self._blocks.put(None)  # nobody has to write any more
        self.lines.put(None)


def _at_priority(work: Callable[[], None], is_urgent: bool) -> None:
    if is_urgent:
        priority.take_real_time()
    work()
