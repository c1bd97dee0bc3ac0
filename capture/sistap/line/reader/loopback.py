# SPDX-License-Identifier: GPL-2.0-or-later
"""Measures how late this program sees data from a socket, where there are no pseudo terminals."""

from __future__ import annotations

import random
import socket
import threading
import time
from array import array
from contextlib import suppress

from sistap.line.clocks import monotonic_ns

_PATIENCE_S = 1.0  # longest wait for a byte


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
