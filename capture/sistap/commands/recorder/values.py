# SPDX-License-Identifier: GPL-2.0-or-later
"""Live values beside a recording: a thread with a bounded queue. A server that is away, or slow, disturbs nothing."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable

from sistap.commands.recorder.outlets import Outlet, Refused, Undelivered, Value
from sistap.dissected.accesses.access import Access
from sistap.tap.line import priority

MOST = 50_000  # values that wait; then the oldest go
PATIENCE_S = 5.0  # at the end
_TOGETHER = 1000
_SHOWN = 300  # characters of what a server says
_TURN_S = 1.0  # in which values gather
_PAUSES_S = (1.0, 5.0, 15.0, 60.0)  # before the next try, after so many failures


class Values:
    """Values on their way to an outlet, from `start` to `close`."""

    def __init__(self, outlet: Outlet) -> None:
        """Begin with none."""
        self._outlet = outlet
        self._say: Callable[[str], object] = str
        self._waiting: deque[Value] = deque(maxlen=MOST)
        self._batch: list[Value] = []  # on its way
        self._dropped = 0  # since the last that was delivered
        self._refused = 0
        self._failures = 0
        self._told = ""
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None

    # -- In the threads of the recorder

    def start(self, say: Callable[[str], None]) -> None:
        """Begin to deliver; `say` gets what goes wrong, once."""
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
        """Deliver what waits, if that is quick."""
        if not self._thread:
            return
        self._ended.set()
        self._thread.join(PATIENCE_S)
        if left := len(self._waiting) + len(self._batch) + self._dropped + self._refused:
            self._say(f"{left} value{'' if left == 1 else 's'} could not be delivered to {self._outlet.name}")

    # -- In its own thread

    def _run(self, is_urgent: bool) -> None:
        if is_urgent:  # as the thread of the recorder
            priority.take_real_time()
        pause_s = _TURN_S
        while not self._ended.wait(pause_s):
            pause_s = _TURN_S if self._deliver() else _PAUSES_S[min(self._failures, len(_PAUSES_S)) - 1]
        self._deliver()
        self._outlet.close()

    def _deliver(self) -> bool:
        """Deliver all that waits; return whether that succeeded."""
        while self._batch or self._waiting:
            if not self._batch:
                self._batch = [self._waiting.popleft() for _ in range(min(len(self._waiting), _TOGETHER))]
            try:
                self._outlet.deliver(self._batch)
            except Refused as refused:
                if not self._refused:
                    self._say(f"{self._outlet.name} refuses values: {str(refused)[:_SHOWN]}. They are left out")
                self._refused += len(self._batch)
            except Exception as error:  # noqa: BLE001 - whatever it is, the recording goes on
                self._failures += 1
                why = (str(error) if isinstance(error, Undelivered) else repr(error))[:_SHOWN]
                self._tell(f"values cannot be delivered to {self._outlet.name}: {why}. Trying again; {MOST} can wait")
                return False
            else:
                self._recover()
            self._batch = []
        return True

    def _recover(self) -> None:
        if self._failures:
            dropped = f"; {self._dropped} were too many to wait" if self._dropped else ""
            self._say(f"values are delivered to {self._outlet.name} again{dropped}")
        self._failures, self._dropped, self._told = 0, 0, ""

    def _tell(self, text: str) -> None:
        if text != self._told:
            self._say(text)
        self._told = text
