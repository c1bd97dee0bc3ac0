# SPDX-License-Identifier: GPL-2.0-or-later
"""Live values on standard output, as lines of InfluxDB's line protocol. A slow reader, or none, disturbs nothing.

Text of a drive is escaped: no name of a parameter adds a line or a tag.
"""

from __future__ import annotations

import math
import os
import socket
import threading
from collections import deque
from collections.abc import Callable, Iterable
from typing import NamedTuple

from sistap.dissected.accesses.access import Access
from sistap.tap.line import priority
from sistap.tap.terminal.console import visible

MOST = 50_000  # values that wait; then the oldest go
PATIENCE_S = 5.0  # at the end
_TOGETHER = 1000
_TURN_S = 1.0  # in which values gather

_HOST = socket.gethostname()
_TAG = str.maketrans(
    {",": "\\,", "=": "\\=", " ": "\\ ", "\\": "/"}
)  # a \ at the end of a tag would escape what follows
_TEXT = str.maketrans({'"': '\\"', "\\": "\\\\"})


class Value(NamedTuple):
    """A value of a parameter."""

    time_ns: int
    access: Access

    @property
    def plain(self) -> float | str:
        """Return it as a number, if it is one."""
        plain = self.access.plain
        return plain if isinstance(plain, int | float) and math.isfinite(plain) else self.access.value


def line(value: Value) -> str:
    """Return a line of InfluxDB's line protocol."""
    plain, access = value.plain, value.access
    fields = {"text": plain} if isinstance(plain, str) else {}
    fields |= {"name": access.name, "unit": access.unit}
    said = [f'{name}="{visible(text).translate(_TEXT)}"' for name, text in fields.items() if text]
    if not isinstance(plain, str):
        said.insert(0, f"value={plain!r}")
    port, station, device, ident = access.parameter
    tags = {"device": str(device), "host": _HOST, "parameter": ident, "port": port, "station": station}
    told = [f"{name}={visible(text).translate(_TAG)}" for name, text in tags.items() if text]
    return f"{','.join(['sis', *told])} {','.join(said)} {value.time_ns}"


class ValueLines:
    """Values on their way out, from `start` to `close`, in a thread of their own."""

    def __init__(self, write: Callable[[bytes], int] = lambda data: os.write(1, data)) -> None:
        """Begin with none; `write` takes bytes, and returns how many it took."""
        self._take = write
        self._say: Callable[[str], object] = str
        self._waiting: deque[Value] = deque(maxlen=MOST)
        self._dropped = self._unwritten = 0  # of too many; of those taken to be written
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None

    # -- In the threads of the recorder

    def start(self, say: Callable[[str], None]) -> None:
        """Begin to write; `say` gets what goes wrong."""
        self._say = say
        self._thread = threading.Thread(target=self._run, args=(priority.is_real_time(),), daemon=True)
        self._thread.start()

    def put(self, time_ns: int, accesses: Iterable[Access]) -> None:
        """Take what was read or written at a time. It never waits."""
        for access in accesses:
            if access.plain is not None:
                self._dropped += len(self._waiting) == MOST
                self._waiting.append(Value(time_ns, access))

    def close(self) -> None:
        """Write what waits, if that is quick."""
        if not self._thread:
            return
        self._ended.set()
        self._thread.join(PATIENCE_S)
        if left := len(self._waiting) + self._unwritten + self._dropped:
            self._say(f"{left} value{'' if left == 1 else 's'} could not be written to standard output")

    # -- In its own thread

    def _run(self, is_urgent: bool) -> None:
        if is_urgent:  # as the thread of the recorder
            priority.take_real_time()
        try:
            while not self._ended.wait(_TURN_S):
                self._write()
            self._write()
        except OSError as error:  # whoever reads it is gone: the recording goes on
            self._say(f"no more values are written to standard output: {error.strerror}")

    def _write(self) -> None:
        while count := min(len(self._waiting), _TOGETHER):
            self._unwritten = count
            data = "".join(f"{line(self._waiting.popleft())}\n" for _ in range(count)).encode()
            while data:
                data = data[self._take(data) :]
            self._unwritten = 0
