# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads a serial device of this computer."""

from __future__ import annotations

import fcntl
import os
import struct
import sys
import termios
from functools import partial

from sistap.tap.line import others, ports, priority
from sistap.tap.line.clock import CLOCK, monotonic_ns
from sistap.tap.line.reader import latency
from sistap.tap.line.reader.contract import READ_SIZE, PortLost
from sistap.tap.line.reader.delay import Computer
from sistap.tap.line.reader.errors import Counts, Errors
from sistap.tap.line.reader.opening import change_device, open_device, true_rate
from sistap.tap.line.reader.several import PolledReaders
from sistap.tap.line.reader.trouble import lost_text
from sistap.tap.line.reader.tuning import Tuning
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag, LineSettings, Read

if sys.platform == "win32":
    raise ImportError("Windows has no terminals: sistap.tap.windows reads its ports")

# Linux, <asm-generic/ioctls.h>: struct serial_icounter_struct; of it the counters frame, overrun, parity, brk and
# buf_overrun.
_TIOCGICOUNT = 0x545D
_COUNTERS = struct.Struct("24x5i36x")


class PosixReader:
    """Reads a descriptor directly with poll and read. A time stamp is microseconds late; through pyserial, tens of
    them.
    """

    def __init__(self, port: str, settings: LineSettings, line: int = 0) -> None:
        """Open and configure the port. May raise PortError."""
        self.name = port
        self.settings = settings
        self.line = line
        pseudo_terminal = ports.adapter(port).pseudo_terminal
        known = self._known = latency.known()  # before opening: the port would fill during this measurement
        shared = others.look(port)
        self._serial = open_device(port, settings, pseudo_terminal)
        self._lost = lost_text(port, pseudo_terminal=pseudo_terminal)
        self._fd: int = self._serial.fileno()
        self._tuning = Tuning(port, self._fd, settings)
        self._emptied_ns = self._asked_ns = monotonic_ns()  # everything unread came after this; the last read
        termios.tcflush(self._fd, termios.TCIFLUSH)  # tuning may clear a FIFO: a gap without a flag
        self._behind = ports.adapter(port)  # after tuning
        self.adapter = str(self._behind)
        bound = self._bound = latency.bound(known, port, self._behind, settings)
        rate = true_rate(self._fd, port, settings)
        rates = [f"the port really runs at {rate} Bd"] if rate != settings.baud else []
        tells = self._behind.tells
        self.timing = "; ".join(filter(None, [bound.how, *rates, *self._tuning.done, priority.words(), tells.clause]))
        notes = (shared.known and shared.warning(port), *self._tuning.missed, *bound.notes, tells.warning(port))
        self.notes: tuple[str, ...] = tuple(filter(None, notes))
        self._decoder = MarkDecoder()
        counters = partial(_error_counters, self._fd)  # without self: that would be a cycle, which nobody frees
        self._errors = Errors(counters, tells)
        self._alone: PolledReaders | None = None  # it polls this reader, if nobody else does
        self.beside = None if known.machine_ns >= UNCERTAINTY_UNKNOWN else Computer(known.machine_ns)

    def read(self, timeout_s: float) -> Read | None:
        """Return what arrived; None if nothing arrived in that time. May raise PortLost."""
        self._alone = self._alone or PolledReaders([self])
        return self._alone.read(timeout_s)

    @property
    def uncertainty_ns(self) -> int:
        """Return how late a character can be seen, as far as is known now."""
        return self._bound.ns(self._machine_ns)

    @property
    def _machine_ns(self) -> int:
        return self.beside.late_ns if self.beside else self._known.machine_ns

    def fileno(self) -> int:
        """Return the descriptor, for a caller that polls several ports and then calls take() and nothing_until()."""
        return self._fd

    def nothing_until(self, time_ns: int, slept_ns: int) -> list[Read]:
        """Note that nothing was unread at this instant of the monotonic clock. Return what was held back until then.

        The process had just slept so long. If it had not, the kernel may have had no time to pass on what had come.
        """
        if not self._decoder.pending:
            self._emptied_ns = time_ns
        return self._errors.silent(slept_ns)

    def held(self) -> list[Read]:
        """Stop holding characters back: return them."""
        return self._errors.all()

    def read_now(self, slept_ns: int) -> list[Read]:
        """Return what is there. The process slept until it came; 0: it was there before. May raise PortLost.

        What was held back comes first. If the driver has counted an error whose place is not known yet, the read is
        held.
        """
        asked_ns = monotonic_ns()
        try:
            data = os.read(self._fd, READ_SIZE)
        except BlockingIOError:
            return self._errors.silent(0)
        except OSError:
            data = b""
        now = monotonic_ns()
        if not data:
            if held := self.held():
                return held  # the next read finds the port lost again
            raise PortLost(self._lost, self.line)
        decoder = self._decoder
        # A worker of the kernel passes characters on. A busy process can keep the processor from it. So what comes at
        # once when this process sleeps may have come before. And if characters come without a sleep, the worker has had
        # the processor since the last read, but perhaps not until this one.
        machine_ns = self._machine_ns
        in_time = slept_ns >= machine_ns and not decoder.pending
        if in_time:
            self._emptied_ns = asked_ns - slept_ns
        characters, flags = decoder.feed(data)
        uncertainty_ns = latency.uncertainty_ns(
            self._bound.ns(machine_ns), self.settings, len(characters), now - self._emptied_ns, in_time=in_time
        )
        if not decoder.pending and len(data) < READ_SIZE:
            self._emptied_ns = asked_ns if slept_ns else self._asked_ns
        self._asked_ns = asked_ns
        if not characters:
            return []
        read = Read(self.line, CLOCK.wall_ns(now), characters, flags, uncertainty_ns, self.settings)
        return self._errors.take(read, slept=slept_ns > 0)

    def change(self, settings: LineSettings) -> None:
        """Read with other settings from now on. PortError if the port does not support them."""
        change_device(self._serial, settings, self._behind.pseudo_terminal)
        self.settings = settings
        self._bound = latency.bound(self._known, self.name, self._behind, settings)

    def close(self) -> None:
        """Restore the settings of the port and release it."""
        self._alone = None  # otherwise a cycle
        self._tuning.undo()
        self._serial.close()
        if self.beside:
            self.beside.close()
            self.beside = None


def _error_counters(fd: int) -> Counts | None:
    """Return the driver's counters; None if it has none."""
    try:
        frame, overrun, parity, breaks, buffer_overrun = _COUNTERS.unpack(
            fcntl.ioctl(fd, _TIOCGICOUNT, bytes(_COUNTERS.size))
        )
    except OSError:
        return None
    return Counts(frame, overrun, parity, breaks, buffer_overrun)


_UNMARKED = bytes(256)  # the flags of any character without a mark


class MarkDecoder:
    """Removes the error marks of PARMRK from what a terminal delivers (termios(3)), wherever a read cuts them.

    FF FF is the character FF, FF 00 xx a character xx with an error, FF 00 00 a break. Any other FF is kept as it is.
    """

    def __init__(self) -> None:
        self.pending = b""  # the beginning of a mark that the last read cut off

    def feed(self, data: bytes) -> tuple[bytes, bytes]:
        """Return the characters and, for each, its Flag."""
        if self.pending:
            data, self.pending = self.pending + data, b""
        if 0xFF not in data:
            return data, data.translate(_UNMARKED)
        characters, flags, start, at = bytearray(), bytearray(), 0, data.find(0xFF)
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
