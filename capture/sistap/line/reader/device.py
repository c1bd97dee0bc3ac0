# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads a serial device of this machine."""

from __future__ import annotations

import fcntl
import os
import select
import struct
import sys

from sistap.line import ports, priority
from sistap.line.clock import CLOCK
from sistap.line.clocks import monotonic_ns
from sistap.line.reader import latency
from sistap.line.reader.contract import READ_SIZE, STEP_MS, PortLost
from sistap.line.reader.opening import change_device, open_device, true_rate
from sistap.line.reader.trouble import lost_text
from sistap.line.reader.tuning import Tuning
from sistap.line.settings import Flag, LineSettings, Read

if sys.platform == "win32":
    raise ImportError("Windows has no terminals: sistap.line.reader.url reads its ports")

# Linux, <asm-generic/ioctls.h>: struct serial_icounter_struct, of it the counters frame, overrun, parity, brk and
# buf_overrun.
_TIOCGICOUNT = 0x545D
_COUNTERS = struct.Struct("24x5i36x")


class PosixReader:
    """Reads a descriptor itself, by poll and read: a time stamp is microseconds late, through pyserial tens of them."""

    def __init__(self, port: str, settings: LineSettings, line: int = 0) -> None:
        """Open and configure the port. May raise PortError."""
        self.name = port
        self.settings = settings
        self.line = line
        pseudo_terminal = ports.adapter(port).pseudo_terminal
        self._known = latency.known()  # before opening: the port would fill while this is measured
        self._emptied_ns = monotonic_ns()  # everything unread came later than this
        self._serial = open_device(port, settings, pseudo_terminal)
        self._lost = lost_text(port, pseudo_terminal)
        self._fd: int = self._serial.fileno()
        self._tuning = Tuning(port, self._fd, settings)
        self._behind = ports.adapter(port)  # as it is now that it is tuned
        self.adapter = str(self._behind)
        bound = latency.bound(self._known, port, self._behind, settings)
        self._latency_ns = bound.ns
        rate = true_rate(self._fd, port, settings)
        rates = [f"the port really runs at {rate} Bd"] if rate != settings.baud else []
        self.timing = "; ".join([bound.how, *rates, *self._tuning.done, priority.words()])
        self.notes: tuple[str, ...] = (*self._tuning.missed, *bound.notes)
        poll = select.poll()
        poll.register(self._fd, select.POLLIN)
        self._poll = poll.poll
        self._decoder = MarkDecoder()
        self._counters = _error_counters(self._fd)

    def read(self, timeout_s: float) -> Read | None:
        """Return what arrived, None if nothing did in that time. May raise PortLost."""
        in_time = self._wait(timeout_s)
        return None if in_time is None else self.take(in_time=in_time)

    def fileno(self) -> int:
        """Return the descriptor, for who waits for several ports at once and then calls take() and nothing_until()."""
        return self._fd

    def nothing_until(self, time_ns: int) -> None:
        """Note that nothing was unread at this instant of the monotonic clock."""
        if not self._decoder.pending:
            self._emptied_ns = time_ns

    def take(self, *, in_time: bool) -> Read | None:
        """Return what is there; `in_time`: it came while it was waited for. May raise PortLost."""
        asked_ns = monotonic_ns()
        try:
            data = os.read(self._fd, READ_SIZE)
        except BlockingIOError:
            return None
        except OSError:
            data = b""
        now = monotonic_ns()
        if not data:
            raise PortLost(self._lost)
        decoder = self._decoder
        in_time = in_time and not decoder.pending
        characters, flags = decoder.feed(data)
        uncertainty_ns = latency.uncertainty_ns(
            self._latency_ns, self.settings, len(characters), now - self._emptied_ns, in_time=in_time
        )
        if not decoder.pending and len(data) < READ_SIZE:
            self._emptied_ns = asked_ns
        if not characters:
            return None
        if self._counters is not None:
            flags = self._with_counted(flags)
        return Read(self.line, CLOCK.wall_ns(now), characters, flags, uncertainty_ns, self.settings)

    def change(self, settings: LineSettings) -> None:
        """Read with other settings from now on. PortError if the port cannot do them: then the old ones stay."""
        change_device(self._serial, settings, self._behind.pseudo_terminal)
        self.settings = settings
        self._latency_ns = latency.bound(self._known, self.name, self._behind, settings).ns

    def _wait(self, timeout_s: float) -> bool | None:
        """Wait for characters: None if none came, else whether they came while it waited for them."""
        left_ms, step_ms = timeout_s * 1000, 0.0
        asked_ns = monotonic_ns()
        while not self._poll(step_ms):
            self.nothing_until(asked_ns + int(step_ms * 1e6))  # poll looked once more when its time was up
            if left_ms <= 0:
                return None
            step_ms = min(STEP_MS, left_ms)
            left_ms -= step_ms
            asked_ns = monotonic_ns()
        return step_ms > 0

    def close(self) -> None:
        """Set the port back to what it was, and let it go."""
        self._tuning.undo()
        self._serial.close()

    def _with_counted(self, flags: bytes) -> bytes:
        """Add to the flags of a read what only the driver's error counters tell."""
        before, now = self._counters, _error_counters(self._fd)
        if now is None or before is None or now == before:
            return flags
        self._counters = now
        framing, overrun, parity, breaks, buffer_overrun = map(int.__ne__, now, before)
        unmarked = (framing or parity or breaks) and not any(flags)
        marked = bytearray(flags)
        # A loss is before one of the characters, an error that left no mark at one of them.
        if unmarked or ((overrun or buffer_overrun) and len(flags) > 1):
            marked = bytearray(flag | Flag.UNLOCATED_ERROR for flag in flags)
        if overrun or buffer_overrun:
            marked[0] |= Flag.LOST_BEFORE
        return bytes(marked)


def _error_counters(fd: int) -> tuple[int, ...] | None:
    """Read the driver's counters of frame, overrun, parity, break and buffer overrun; None where it has none."""
    try:
        return _COUNTERS.unpack(fcntl.ioctl(fd, _TIOCGICOUNT, bytes(_COUNTERS.size)))
    except OSError:
        return None


class MarkDecoder:
    """Takes the error marks of PARMRK out of what a terminal delivers (termios(3)), wherever reads cut it.

    FF FF is the character FF, FF 00 xx a character xx with an error, FF 00 00 a break. Any other FF is kept as it is.
    """

    def __init__(self) -> None:
        """Start with nothing received."""
        self.pending = b""  # the beginning of a mark that the last read cut

    def feed(self, data: bytes) -> tuple[bytes, bytes]:
        """Return the characters and, for each, its Flag."""
        if self.pending:
            data, self.pending = self.pending + data, b""
        at = data.find(0xFF)
        if at < 0:
            return data, bytes(len(data))
        characters, flags, start = bytearray(), bytearray(), 0
        while at >= 0:
            characters += data[start:at]
            flags += bytes(at - start)
            mark = data[at : at + 3]
            start = at + len(mark)
            if mark in (b"\xff", b"\xff\x00"):
                self.pending = mark
            elif mark[1]:
                characters.append(0xFF)
                flags.append(0)
                start = at + (2 if mark[1] == 0xFF else 1)
            else:
                characters.append(mark[2])
                flags.append(Flag.CHARACTER_ERROR if mark[2] else Flag.BREAK)
            at = data.find(0xFF, start)
        characters += data[start:]
        flags += bytes(len(data) - start)
        return bytes(characters), bytes(flags)
