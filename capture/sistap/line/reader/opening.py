# SPDX-License-Identifier: GPL-2.0-or-later
"""Opens and configures serial devices of this machine, so that they only listen."""

from __future__ import annotations

import fcntl
import struct
import sys
import termios
from contextlib import suppress
from typing import TYPE_CHECKING

from sistap.line.reader.contract import PortError
from sistap.line.reader.listening import closed_serial
from sistap.line.reader.trouble import device_trouble
from sistap.line.settings import LineSettings

if sys.platform == "win32":
    raise ImportError("Windows has no terminals: sistap.line.reader.url opens its ports")

if TYPE_CHECKING:  # imported where it is needed: without pyserial the rest still works
    import serial

_STICK_PARITY = 0o10000000000 if sys.platform == "linux" else 0  # CMSPAR, which termios does not know
_PARITIES = {
    "N": 0,
    "E": termios.PARENB,
    "O": termios.PARENB | termios.PARODD,
    "M": termios.PARENB | termios.PARODD | _STICK_PARITY,
    "S": termios.PARENB | _STICK_PARITY,
}

# Linux, <asm-generic/ioctls.h>: struct termios2, of it c_ospeed.
_TCGETS2 = 0x802C542A
_TERMIOS2 = struct.Struct("40xI")


def open_device(port: str, settings: LineSettings, pseudo_terminal: bool) -> serial.Serial:
    """Open a device exclusively, RTS and DTR down, no flow control, errors marked. May raise PortError."""
    try:
        device = closed_serial(port, settings)
        if pseudo_terminal:
            # Linux strips these from a pty, and libc takes it for an error when nothing else was to change.
            device.bytesize, device.parity = 8, "N"
        device.open()
        try:
            _mark_errors(device.fileno())
            _check_speed(device.fileno(), settings.baud)
        except BaseException:
            device.close()
            raise
    except (OSError, ValueError, OverflowError, termios.error) as error:
        raise PortError(device_trouble(port, settings, error)) from error
    return device


def change_device(device: serial.Serial, settings: LineSettings, pseudo_terminal: bool) -> None:
    """Change rate and format of an open device, dropping nothing. PortError if it cannot: then the old ones stay.

    Not through pyserial, which would switch the marking of errors off for a moment.
    """
    fd = device.fileno()
    before = termios.tcgetattr(fd)
    after = before.copy()
    after[2] &= ~(termios.CSIZE | termios.PARENB | termios.PARODD | termios.CSTOPB | _STICK_PARITY)
    after[2] |= _control(LineSettings() if pseudo_terminal else settings, parity=not pseudo_terminal)
    try:
        after[4] = after[5] = getattr(termios, f"B{settings.baud}")
        termios.tcsetattr(fd, termios.TCSANOW, after)
        _check_speed(fd, settings.baud)
    except (OSError, ValueError, AttributeError, termios.error) as error:
        with suppress(termios.error):
            termios.tcsetattr(fd, termios.TCSANOW, before)
        cause = ValueError() if isinstance(error, AttributeError) else error
        raise PortError(device_trouble(str(device.port), settings, cause)) from error


def _control(settings: LineSettings, *, parity: bool) -> int:
    """Return the control flags of a format."""
    flags = _PARITIES[settings.parity] if parity else 0
    flags |= termios.CSTOPB if settings.stop_half_bits > 2 else 0
    size: int = getattr(termios, f"CS{settings.data_bits}")
    return flags | size


def _mark_errors(fd: int) -> None:
    """Let the line discipline mark errors, which pyserial has switched off, and drop what came before."""
    attributes = termios.tcgetattr(fd)
    attributes[0] |= termios.PARMRK | termios.INPCK  # INPCK: without it no framing errors either
    attributes[0] &= ~(termios.IGNPAR | termios.IGNBRK | termios.BRKINT | termios.ISTRIP)
    attributes[6][termios.VMIN] = 1  # so that a read of nothing means that the port has gone
    attributes[6][termios.VTIME] = 0
    termios.tcsetattr(fd, termios.TCSANOW, attributes)
    termios.tcflush(fd, termios.TCIFLUSH)


def _check_speed(fd: int, baud: int) -> None:
    """Raise ValueError if the driver quietly set another rate; 3 % is what a character can bear."""
    try:
        (speed,) = _TERMIOS2.unpack(fcntl.ioctl(fd, _TCGETS2, bytes(_TERMIOS2.size)))
    except OSError:
        return  # not Linux
    if abs(speed - baud) > baud * 0.03:
        raise ValueError(f"the driver set {speed} Bd")
