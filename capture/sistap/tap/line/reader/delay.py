# SPDX-License-Identifier: GPL-2.0-or-later
"""How late this program sees characters that it sends itself, through a pseudo terminal or a port.

`through` measures for a while; a Computer measures as long as it is polled.
"""

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
from collections import deque
from contextlib import suppress

from sistap.tap.line.clock import monotonic_ns
from sistap.tap.line.reader.contract import READ_SIZE, STEP_MS
from sistap.tap.line.settings import Read

if sys.platform == "win32":
    raise ImportError("Windows has no pseudo terminals")

PATIENCE_NS = 1_000_000_000  # longest time for a character to come back

KEPT = 1000  # delays of a Computer: those of five to ten seconds
_PAUSES_S = (0.005, 0.015)  # between its characters; at random, so that no rhythm of the computer can match

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


class Computer:
    """Sends characters to itself and sees them as late as those of a port: whoever polls a port polls this, too.

    The sender is the thread that polls: another one would hold Python's lock while it waits for a processor, and that
    would count. For most of the time no character is under way, so a sleep that lasts too long counts as well. The
    bound is the longest of the last KEPT delays: with a chance of 1 in KEPT + 1, the next one is longer.
    """

    def __init__(self, *delays_ns: int) -> None:
        """Begin with delays, if some are known. OSError without a pseudo terminal."""
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._slave, False)
        self._count = 0  # of all delays
        self._longest: deque[tuple[int, int]] = deque()  # those with no longer one after them: number, ns
        self._random = random.Random()  # of its own: a program may seed the common one
        self._due_ns = 0  # when the next character is sent, at the earliest
        self._sent_ns = 0  # when the one was sent that nobody has seen; 0: there is none
        for delay_ns in delays_ns:
            self.note(delay_ns)

    def close(self) -> None:
        """Close the pseudo terminal."""
        os.close(self._master)
        os.close(self._slave)

    def measure(self, duration_ns: int) -> int:
        """Measure often for a while, before anybody polls; return the bound in ns."""
        poll = select.poll()
        poll.register(self._slave, select.POLLIN)
        end_ns = monotonic_ns() + duration_ns
        while not self._longest or monotonic_ns() < end_ns:
            self.before_sleep(self._due_ns)
            if poll.poll(PATIENCE_NS // 1_000_000):
                self.read_now(1)
            else:
                self.note(PATIENCE_NS)
            time.sleep(self._random.uniform(0.0002, 0.0008))
        return self.late_ns

    @property
    def late_ns(self) -> int:
        """Return the bound that holds now, in ns."""
        longest_ns = self._longest[0][1] if self._longest else 0
        return max(longest_ns, monotonic_ns() - self._sent_ns) if self._sent_ns else longest_ns

    def fileno(self) -> int:
        """Return the descriptor to poll."""
        return self._slave

    def before_sleep(self, now_ns: int) -> int:
        """Send a character now and then, one at a time. Return how long to sleep until the next one, at most, in ms.

        Whoever calls this polls at once, and sleeps until the character comes.
        """
        if self._sent_ns:
            return STEP_MS
        if now_ns < self._due_ns:
            return -((now_ns - self._due_ns) // 1_000_000)  # rounded up
        self._due_ns = now_ns + int(self._random.uniform(*_PAUSES_S) * 1e9)
        with suppress(OSError):  # no measurement ends a capture
            self._sent_ns = monotonic_ns()
            os.write(self._master, b"@")
        return STEP_MS

    def read_now(self, slept_ns: int) -> list[Read]:
        """Note how late a character is seen, if the process slept until it came."""
        with suppress(OSError):
            os.read(self._slave, READ_SIZE)
            if slept_ns:
                self.note(monotonic_ns() - self._sent_ns)
            self._sent_ns = 0
        return []

    def note(self, delay_ns: int) -> None:
        """Count a delay: of a character, or of a sleep that should have ended earlier."""
        self._count += 1
        while self._longest and self._longest[-1][1] <= delay_ns:
            self._longest.pop()
        self._longest.append((self._count, delay_ns))
        if self._longest[0][0] <= self._count - KEPT:
            self._longest.popleft()
