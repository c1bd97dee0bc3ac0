# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads a COM port of Windows, opened by pyserial, so that no error report of its driver is lost.

ClearCommError returns the errors since its last call and the number of waiting characters. pyserial calls it before
each read and drops the errors. So only this module calls it.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from sistap.tap.line import ports
from sistap.tap.line.clock import CLOCK, STEADY, monotonic_ns
from sistap.tap.line.ports import Adapter
from sistap.tap.line.reader import latency
from sistap.tap.line.reader.contract import READ_SIZE, STEP_MS, PortError, PortLost
from sistap.tap.line.reader.pyserial import closed_serial, reconfigure
from sistap.tap.line.reader.trouble import lost_text, url_trouble
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag, LineSettings, Read
from sistap.tap.terminal.advice import advice

if TYPE_CHECKING:  # imported late: the rest works without pyserial
    import serial

# winbase.h: CE_RXOVER and CE_OVERRUN, then CE_RXPARITY, CE_FRAME and CE_BREAK.
LOST, DAMAGED = 0x01 | 0x02, 0x04 | 0x08 | 0x10

_ERROR_IO_PENDING = 997
_ENDED_EARLY = (995, 1460)  # ERROR_OPERATION_ABORTED, ERROR_TIMEOUT: what came before is valid


class CommPort:
    """Reads what waits, or waits for the first character for STEP_MS."""

    def __init__(self, device: serial.Serial, api: Any = None) -> None:
        """Take pyserial's open port; `api` is serial.win32."""
        self._api = api or _win32()
        self._device = device
        self._handle: Any = getattr(device, "_port_handle")  # noqa: B009 - private, and on Windows only
        self._overlapped = self._api.OVERLAPPED()
        self._overlapped.hEvent = self._api.CreateEvent(None, 1, 0, None)
        self._buffer = ctypes.create_string_buffer(READ_SIZE)
        self._errors = 0  # since errors() was last called
        self.prepare()

    def prepare(self) -> None:
        """Limit the wait of a read to STEP_MS; call it again after pyserial has changed settings."""
        time_outs = self._api.COMMTIMEOUTS()
        time_outs.ReadTotalTimeoutConstant = STEP_MS
        self._api.SetCommTimeouts(self._handle, ctypes.byref(time_outs))

    def waiting(self) -> int:
        """Return how many characters can be read at once. OSError if the port is gone."""
        errors, status = self._api.DWORD(), self._api.COMSTAT()
        if not self._api.ClearCommError(self._handle, ctypes.byref(errors), ctypes.byref(status)):
            raise self._error()
        self._errors |= errors.value
        count: int = status.cbInQue
        return count

    def take(self, waiting: int) -> bytes:
        """Read what waits; if nothing does, the first character that comes within STEP_MS. OSError if the port is gone.

        It reads one character only: Windows would wait for as many as are asked for.
        """
        size = min(waiting, READ_SIZE) or 1
        api, count = self._api, self._api.DWORD()
        overlapped = ctypes.byref(self._overlapped)
        api.ResetEvent(self._overlapped.hEvent)
        is_done = api.ReadFile(self._handle, self._buffer, size, ctypes.byref(count), overlapped)
        if not is_done and api.GetLastError() not in (0, _ERROR_IO_PENDING):
            raise self._error()
        is_done = api.GetOverlappedResult(self._handle, overlapped, ctypes.byref(count), True)
        if not is_done and api.GetLastError() not in _ENDED_EARLY:
            raise self._error()
        return self._buffer.raw[: count.value]

    def errors(self) -> int:
        """Return the errors since the last call."""
        errors, self._errors = self._errors, 0
        return errors

    def close(self) -> None:
        """Release the port."""
        self._device.close()
        self._api.CloseHandle(self._overlapped.hEvent)

    def _error(self) -> OSError:
        return OSError(self._api.GetLastError(), "the port does not answer")


def flags(errors: int, count: int) -> bytes:
    """Return the flags of the characters of a read during which these errors came."""
    lost = errors & LOST
    # A loss is before one of the characters; any other error is at one of them.
    unlocated = errors & DAMAGED or (lost and count > 1)
    marked = bytearray([Flag.UNLOCATED_ERROR if unlocated else 0]) * count
    if lost:
        marked[0] |= Flag.LOST_BEFORE
    return bytes(marked)


def _win32() -> Any:
    if sys.platform != "win32":
        raise OSError("only Windows has COM ports")
    from serial import win32

    return win32


# The longest sleep without suspension: Windows may add a tick of its clock (15.6 ms) to each.
_SLEEP_NS = (STEP_MS + 16) * 1_000_000


class WindowsReader:
    """Reads through Windows itself, which reports line errors for a whole read, not for a character."""

    def __init__(
        self,
        port: str,
        settings: LineSettings,
        line: int = 0,
        behind: Adapter | None = None,
        comm: Callable[..., CommPort] = CommPort,
    ) -> None:
        """Open the port. May raise PortError. `behind` comes from the registry."""
        self.name = port
        self.settings = settings
        self.line = line
        self._behind = behind or ports.adapter(port)
        self.adapter = str(self._behind) if self._behind.name else port
        self._known = None if self._behind.latency_ms is None else latency.known()  # before the port is open
        self._latency_ns, how, self.notes = self._bound()
        self.timing = f"{how}; {STEADY}"
        self._emptied_ns = monotonic_ns()  # everything unread came after this
        try:
            self._device = closed_serial(port, settings)
            self._device.open()
            self._port = comm(self._device)
        except (OSError, ValueError) as error:
            raise PortError(url_trouble(port, settings, error)) from error
        self._is_lost = False
        self._error: int | None = None  # of Windows, when the port was lost

    def read(self, timeout_s: float) -> Read | None:
        """Return what arrived; None if nothing arrived in that time. May raise PortLost."""
        end_ns = monotonic_ns() + int(timeout_s * 1e9)
        try:
            while not self._is_lost:
                asked_ns = monotonic_ns()
                waiting = self._port.waiting()
                in_time = not waiting
                if in_time:
                    self._emptied_ns = asked_ns
                if in_time and not timeout_s:
                    return None
                if data := self._port.take(waiting):
                    return self._received(data, in_time=in_time)
                if monotonic_ns() >= end_ns:
                    return None
        except OSError as error:
            self._is_lost, self._error = True, error.errno
        raise PortLost(lost_text(self.name, windows_error=self._error))

    def _received(self, data: bytes, *, in_time: bool) -> Read:
        """Add what came meanwhile: an error that Windows reports after a read may belong to these characters."""
        now_ns = monotonic_ns()
        since_ns = self._emptied_ns
        with suppress(OSError):  # what came before the port was lost is kept
            while len(data) < READ_SIZE:
                self._emptied_ns = monotonic_ns()
                if not (waiting := self._port.waiting()):
                    break
                data += self._port.take(waiting)
                now_ns = monotonic_ns()
        uncertainty_ns = latency.uncertainty_ns(
            self._latency_ns, self.settings, len(data), now_ns - since_ns, in_time=in_time, sleep_ns=_SLEEP_NS
        )
        marked = flags(self._port.errors(), len(data))
        return Read(self.line, CLOCK.wall_ns(now_ns), data, marked, uncertainty_ns, self.settings)

    def change(self, settings: LineSettings) -> None:
        """Read with other settings from now on. PortError if the port does not support them."""
        try:
            reconfigure(self._device, self.settings, settings)
        finally:
            self._port.prepare()
        self.settings = settings
        self._latency_ns = self._bound()[0]

    def close(self) -> None:
        """Release the port."""
        self._port.close()

    def _bound(self) -> tuple[int, str, tuple[str, ...]]:
        """Return how late a character can be seen in ns, a phrase for its source, and messages for the user."""
        behind = self._behind
        if self._known is None or behind.latency_ms is None:
            note = f"{self.name}: without a known uncertainty no verdict on its times is possible: use an FTDI adapter"
            return UNCERTAINTY_UNKNOWN, "Windows does not report how exact its times are", (note,)
        bound = latency.bound(self._known, self.name, behind, self.settings)
        if behind.latency_ms <= 1:
            return bound.ns(self._known.machine_ns), bound.how, bound.notes
        cure = advice("win32").latency_timer.format(name=behind.name or self.name)
        note = f"{self.name}: its latency timer is {behind.latency_ms} ms, so times are up to that late: {cure}"
        return bound.ns(self._known.machine_ns), bound.how, (note, *bound.notes)
