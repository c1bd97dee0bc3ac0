# SPDX-License-Identifier: GPL-2.0-or-later
"""A COM port that pyserial has opened, read so that no error report of its driver is lost.

ClearCommError returns the errors since its last call and the number of waiting characters. pyserial calls it before
each read and drops the errors. So only this module calls it.
"""

from __future__ import annotations

import ctypes
import sys
from typing import TYPE_CHECKING, Any

from sistap.line.reader.contract import READ_SIZE, STEP_MS
from sistap.line.settings import Flag

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
