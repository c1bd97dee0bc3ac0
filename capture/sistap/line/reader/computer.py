# SPDX-License-Identifier: GPL-2.0-or-later
"""How late this computer sees a character: measured for a moment before a capture, and then all the time.

The measurement uses a pseudo terminal of our own, or a socket where there is none.
"""

from __future__ import annotations

import functools
import os
import random
import socket
import sys
import threading
import time
from array import array
from bisect import bisect_left, insort
from collections import deque
from collections.abc import Iterable
from contextlib import suppress
from typing import NamedTuple, Protocol

from sistap.common.quantiles import quantile
from sistap.line.clock import monotonic_ns
from sistap.line.reader.contract import READ_SIZE
from sistap.line.settings import UNCERTAINTY_UNKNOWN, Read

MEASURE_NS = 200_000_000
KEPT = 1000  # delays, of about ten seconds
_SHARE = 0.999
_PAUSES_S = (0.005, 0.015)  # at random, so that no rhythm of the computer can match
_PATIENCE_S = 1.0  # longest wait for a byte


class Delay(Protocol):
    """How late characters are seen."""

    @property
    def late_ns(self) -> int:
        """Return the bound that holds now, in ns."""


class Still(NamedTuple):
    """A bound that nobody measures again."""

    late_ns: int


class Computer:
    """Sends characters to itself and sees them as late as those of a port: whoever polls ports polls this, too.

    Its bound is p99.9 of the last KEPT characters, or the delay of the very last one, if that is longer.
    """

    def __init__(self, delays: Iterable[int]) -> None:
        """Begin with delays in ns that were measured before. OSError without a pseudo terminal."""
        import pty  # Windows has none
        import tty

        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._slave, False)
        self._delays = deque(delays, KEPT)
        self._ordered = sorted(self._delays)
        self._last_ns = 0
        self._sent_ns = 0  # when the character was sent that nobody has seen; 0: there is none
        threading.Thread(target=self._send, daemon=True).start()

    @property
    def late_ns(self) -> int:
        """Return the bound that holds now, in ns."""
        return max(int(quantile(self._ordered, _SHARE)) if self._ordered else 0, self._last_ns)

    def fileno(self) -> int:
        """Return the descriptor to poll."""
        return self._slave

    def read_now(self, slept_ns: int) -> list[Read]:
        """Note how late a character is seen, if the process slept until it came."""
        with suppress(BlockingIOError):  # several threads may poll
            os.read(self._slave, READ_SIZE)
            if slept_ns:
                self._note(monotonic_ns() - self._sent_ns)
            self._sent_ns = 0
        return []

    def nothing_until(self, _time_ns: int, _slept_ns: int) -> list[Read]:
        """Do nothing: no character came."""
        return []

    def held(self) -> list[Read]:
        """Return nothing: no character is for others."""
        return []

    def _note(self, delay_ns: int) -> None:
        if len(self._delays) == KEPT:
            del self._ordered[bisect_left(self._ordered, self._delays[0])]
        self._delays.append(delay_ns)
        insort(self._ordered, delay_ns)
        self._last_ns = delay_ns

    def _send(self) -> None:
        """Send a character now and then, one at a time: if nobody polls, nothing piles up."""
        source = random.Random()  # of its own: a program may seed the common one
        while True:
            time.sleep(source.uniform(*_PAUSES_S))
            if not self._sent_ns:
                self._sent_ns = monotonic_ns()
                os.write(self._master, b"@")


@functools.cache
def computer(*, at_once: bool = True) -> Delay:
    """Return this computer's delay, the same for all ports. `at_once`: first measure it for MEASURE_NS.

    There are fewer than a thousand first samples, so their p99.9 is the largest. UNCERTAINTY_UNKNOWN if nothing can be
    measured. Windows cannot wait for a port and a socket at once: there the first measurement stays.
    """
    with suppress(OSError):
        if sys.platform == "win32":
            return Still(max(through_socket(MEASURE_NS), default=UNCERTAINTY_UNKNOWN) if at_once else 0)
        from sistap.line.reader import delay

        return Computer(delay.through_pty(MEASURE_NS) if at_once else ())
    return Still(UNCERTAINTY_UNKNOWN)


def through_socket(duration_ns: int) -> array[int]:
    """Send bytes one by one through a socket of our own; return the time of each in ns. May raise OSError."""
    reading, writing = socket.socketpair()
    with reading, writing:
        reading.settimeout(_PATIENCE_S)
        for end in (reading, writing):
            with suppress(OSError):  # not TCP
                end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        written = array("q")
        writer = threading.Thread(target=_write, args=(writing, written, monotonic_ns() + duration_ns), daemon=True)
        writer.start()
        delays = array("q")
        while data := reading.recv(4096):
            now_ns = monotonic_ns()
            delays.extend(now_ns - sent for sent in written[len(delays) : len(delays) + len(data)])
        writer.join()
    return delays


def _write(writing: socket.socket, written: array[int], end_ns: int) -> None:
    """Write a byte now and then at random times; then end the connection."""
    with suppress(OSError):
        while (now_ns := monotonic_ns()) < end_ns:
            written.append(now_ns)
            writing.send(b"@")
            time.sleep(random.uniform(0.0002, 0.0008))
        writing.shutdown(socket.SHUT_WR)
