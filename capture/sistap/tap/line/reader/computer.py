# SPDX-License-Identifier: GPL-2.0-or-later
"""How late this computer sees a character, measured before a capture: by a pseudo terminal or a socket."""

from __future__ import annotations

import functools
import random
import socket
import sys
import threading
import time
from array import array
from contextlib import closing, suppress

from sistap.tap.line.clock import monotonic_ns
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN

MEASURE_NS = 200_000_000
_PATIENCE_S = 1.0  # longest wait for a byte


@functools.cache
def measured_ns() -> int:
    """Measure once, for MEASURE_NS, how late this computer sees a character; UNCERTAINTY_UNKNOWN if it cannot.

    There are fewer than a thousand samples, so their p99.9 is the largest. On Windows nothing is measured afterwards:
    it cannot wait for a port and a socket at once.
    """
    with suppress(OSError):
        if sys.platform == "win32":
            return max(through_socket(MEASURE_NS), default=UNCERTAINTY_UNKNOWN)
        from sistap.tap.line.reader.delay import Computer

        with closing(Computer()) as computer:
            return computer.measure(MEASURE_NS)
    return UNCERTAINTY_UNKNOWN


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
