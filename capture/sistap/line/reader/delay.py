# SPDX-License-Identifier: GPL-2.0-or-later
"""Measures how late this program sees characters that it sends itself, through a pseudo terminal or a port."""

from __future__ import annotations

import os
import pty
import random
import select
import sys
import threading
import time
import tty
from array import array
from contextlib import suppress

from sistap.line.clock import monotonic_ns
from sistap.line.reader.contract import READ_SIZE

if sys.platform == "win32":
    raise ImportError("Windows has no pseudo terminals")

PATIENCE_NS = 1_000_000_000  # longest time for a character to come back

# the characters sent: never FF, which a port would escape, and never a start character of SIS
_FIRST, _VALUES = ord("@"), 63


class LoopBroken(OSError):
    """What was sent did not come back; the text is one clause."""


def through_pty(duration_ns: int) -> array[int]:
    """Measure on a pseudo terminal of our own, in ns; OSError without one."""
    master, slave = pty.openpty()
    try:
        tty.setraw(slave)
        return through(slave, master, duration_ns)
    finally:
        os.close(master)
        os.close(slave)


def through(reading: int, writing: int, duration_ns: int, character_ns: int = 0) -> array[int]:
    """Send characters one by one; return for each the time from its end on the line until it was seen, in ns.

    OSError if they do not come back.
    """
    written = array("q")
    # A descriptor of its own: so the reader does not wait for this thread after a signal.
    arguments = (os.dup(writing), written, monotonic_ns() + duration_ns, character_ns)
    writer = threading.Thread(target=_write, args=arguments, daemon=True)
    writer.start()
    delays = _read(reading, written, writer)
    writer.join()
    if not written:
        raise LoopBroken("the port takes no character")
    return array("q", (max(0, delay - character_ns) for delay in delays))


def _write(writing: int, written: array[int], end_ns: int, character_ns: int) -> None:
    """Write a character now and then, at random times that no rhythm of the hardware can match; try at least one."""
    with suppress(OSError), os.fdopen(writing, "wb", buffering=0) as stream:
        is_first = True
        while (now := monotonic_ns()) < end_ns or is_first:
            is_first = False
            written.append(now)
            if not stream.write(_characters(len(written) - 1, 1)):
                written.pop()  # a port such as that of cdc_acm takes no more while 16 characters are on their way
            time.sleep(character_ns / 1e9 + random.uniform(0.0002, 0.0008))


def _read(reading: int, written: array[int], writer: threading.Thread) -> array[int]:
    """Read what the writer writes, until it ends; return the times from write to read, in ns."""
    poll = select.poll()
    poll.register(reading, select.POLLIN)
    delays = array("q")
    while writer.is_alive() or len(delays) < len(written):
        seen = len(delays)
        if poll.poll(10):
            data = os.read(reading, READ_SIZE)
            now = monotonic_ns()
            if not data:
                raise LoopBroken("the port is gone")
            if len(written) < seen + len(data) or data != _characters(seen, len(data)):
                raise LoopBroken(f"what came back is not what was sent ({data[:8].hex(' ')})")
            delays.extend(now - sent for sent in written[seen : seen + len(data)])
        elif seen < len(written) and monotonic_ns() - written[seen] > PATIENCE_NS:
            raise LoopBroken("a character that was sent did not come back within a second")
    return delays


def _characters(start: int, count: int) -> bytes:
    """Return the characters sent from number `start` on."""
    return bytes(_FIRST + number % _VALUES for number in range(start, start + count))
