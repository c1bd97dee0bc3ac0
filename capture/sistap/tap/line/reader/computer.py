# SPDX-License-Identifier: GPL-2.0-or-later
"""How late this computer sees a character: measured for a moment before a capture, and then all the time.

The measurement uses a pseudo terminal of our own, or a socket where there is none.
"""

from __future__ import annotations

import functools
import random
import socket
import sys
import threading
import time
from array import array
from contextlib import suppress
from typing import NamedTuple, Protocol

from sistap.tap.line.clock import monotonic_ns
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN

MEASURE_NS = 200_000_000
_PATIENCE_S = 1.0  # longest wait for a byte


class Delay(Protocol):
    """How late characters are seen."""

    @property
    def late_ns(self) -> int:
        """Return the bound that holds now, in ns."""


class Still(NamedTuple):
    """A bound that nobody measures again."""

    late_ns: int


@functools.cache
def computer(*, at_once: bool = True) -> Delay:
    """Return this computer's delay, the same for all ports. `at_once`: first measure it for MEASURE_NS.

    There are fewer than a thousand first samples, so their p99.9 is the largest. UNCERTAINTY_UNKNOWN if nothing can be
    measured. Windows cannot wait for a port and a socket at once: there the first measurement stays.
    """
    with suppress(OSError):
        if sys.platform == "win32":
            return Still(max(through_socket(MEASURE_NS), default=UNCERTAINTY_UNKNOWN) if at_once else 0)
        from sistap.tap.line.reader import delay

        measured = delay.Computer()
        if at_once:
            measured.measure(MEASURE_NS)
        return measured
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
