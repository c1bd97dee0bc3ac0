# SPDX-License-Identifier: GPL-2.0-or-later
"""Opens and configures serial devices of this computer so that they only listen, and finds their true rate.

Many drivers report the requested rate. The true one is the clock of the port, divided by a whole number: a 16550 with a
clock of 115200 Hz runs 76800 Bd at 57600.
"""

from __future__ import annotations

import errno
import fcntl
import functools
import os
import struct
import sys
import termios
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from sistap.tap.line import ports
from sistap.tap.line.reader.contract import PortError
from sistap.tap.line.reader.pyserial import closed_serial
from sistap.tap.line.reader.trouble import Otherwise, device_trouble
from sistap.tap.line.settings import LineSettings

if sys.platform == "win32":
    raise ImportError("Windows has no terminals: sistap.tap.windows reads its ports")

if TYPE_CHECKING:  # imported late: the rest works without pyserial
    import serial

# Linux, <linux/serial.h>: baud_base is the eighth member of struct serial_struct; the buffer is larger than any
# system's.
_SERIAL = struct.Struct("28xi96x")


def divided_rate(fd: int, baud: int) -> int | None:
    """Return the true rate of a port whose driver says `baud`; None if it does not state its clock."""
    try:
        (clock,) = _SERIAL.unpack(fcntl.ioctl(fd, termios.TIOCGSERIAL, bytes(_SERIAL.size)))
    except (OSError, AttributeError):  # not Linux
        return None
    divisor = max((2 * clock + baud) // (2 * baud), 1)  # rounded to the nearest, as the driver does
    return round(clock / divisor) if clock > 0 else None


# Linux, drivers/usb/serial/ch341.c: ch341_get_divisor.
_CH341_SLOWEST, _CH341_FASTEST = 46, 3_000_000
_CH341_CLOCK = 12_000_000
_CH341_FINE = 23_437  # up to here a slower clock is used, whose steps are below 1 %


def ch341_rate(baud: int) -> int:
    """Return the true rate of a CH340 or CH341."""
    baud = min(max(baud, _CH341_SLOWEST), _CH341_FASTEST)
    if baud <= _CH341_FINE:
        return baud
    clock, divisor = _CH341_CLOCK, _CH341_CLOCK // baud
    if not 9 <= divisor <= 255:
        clock, divisor = clock // 2, divisor // 2
    above, below = clock / divisor, clock / (divisor + 1)
    return round(below if above - baud >= baud - below else above)


_STICK_PARITY = 0o10000000000 if sys.platform == "linux" else 0  # CMSPAR, which the module termios lacks
_PARITIES = {
    "N": 0,
    "E": termios.PARENB,
    "O": termios.PARENB | termios.PARODD,
    "M": termios.PARENB | termios.PARODD | _STICK_PARITY,
    "S": termios.PARENB | _STICK_PARITY,
}

_FORMAT = termios.CSIZE | termios.PARENB | termios.PARODD | termios.CSTOPB | _STICK_PARITY  # all bits of a format

# Linux, <asm-generic/ioctls.h>: c_ospeed of struct termios2.
_TCGETS2 = 0x802C542A
_TERMIOS2 = struct.Struct("40xI")

_TOLERANCE = 0.03  # of the rate: the largest error that a character tolerates
_MODEM_LINES = struct.pack("I", termios.TIOCM_DTR | termios.TIOCM_RTS)
_TIOCGEXCL = 0x80045440  # Linux, <asm-generic/ioctls.h>


def open_device(port: str, settings: LineSettings, pseudo_terminal: bool) -> serial.Serial:
    """Open a device exclusively: RTS and DTR low, no flow control, errors marked. May raise PortError."""
    try:
        device = closed_serial(port, settings, _lowering())
        if pseudo_terminal:
            # Linux strips these from a pty. If nothing else was to change, libc reports an error.
            device.bytesize, device.parity = 8, "N"
        device.open()
        try:
            if not pseudo_terminal:  # there the claim would stay until its other end is closed
                with suppress(OSError):
                    fcntl.ioctl(device.fileno(), termios.TIOCEXCL)  # from now on, only root can open it
            _mark_errors(device.fileno())
            _check(device, settings, pseudo_terminal)
        except BaseException:
            device.close()
            raise
    except (OSError, ValueError, OverflowError, termios.error) as error:
        raise PortError(device_trouble(port, settings, error)) from error
    return device


def change_device(device: serial.Serial, settings: LineSettings, pseudo_terminal: bool) -> None:
    """Change rate and format of an open device without loss. PortError if it cannot: then the old settings stay.

    Not through pyserial, which would switch the marking of errors off for a moment.
    """
    before, speed = termios.tcgetattr(device.fileno()), _speed(device.fileno())
    after = before.copy()
    after[2] &= ~_FORMAT
    after[2] |= _control(settings, pseudo_terminal)
    try:
        _set(device, after, settings.baud)
        _check(device, settings, pseudo_terminal)
    except (OSError, ValueError, OverflowError, NotImplementedError, termios.error) as error:
        with suppress(OSError, ValueError, termios.error):
            _set(device, before, speed)
        cause = ValueError() if isinstance(error, NotImplementedError) else error
        raise PortError(device_trouble(str(device.port), settings, cause)) from error


@functools.cache  # a class is never freed while no garbage is collected, and a missing port is tried every second
def _lowering() -> type[serial.Serial]:
    """Return pyserial's class with RTS and DTR low before it is configured: on adapters that takes up to 40 ms."""
    import serial

    class Lowering(serial.Serial):
        def _reconfigure_port(self, force_update: bool = False) -> None:
            if self.fd is not None and not self.is_open:
                _check_claim(self.fd)
                # Lock it first: the lines of a port that another program uses must not change. pyserial then reports
                # the error.
                with suppress(OSError):
                    fcntl.flock(self.fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    fcntl.ioctl(self.fd, termios.TIOCMBIC, _MODEM_LINES)
            pyserial: Any = super()  # its types have no private names
            pyserial._reconfigure_port(force_update)

    return Lowering


def _check_claim(fd: int) -> None:
    """Raise OSError if another program has claimed a port, which stops all but root."""
    claimed = False
    with suppress(OSError):  # not Linux
        claimed = any(fcntl.ioctl(fd, _TIOCGEXCL, bytes(4)))
    if claimed:
        raise OSError(errno.EBUSY, os.strerror(errno.EBUSY))


def _set(device: serial.Serial, attributes: list[Any], baud: int | None) -> None:
    """Set the attributes of a device, and any rate; None: the rate of the attributes."""
    constant = getattr(termios, f"B{baud}", None)
    if constant is not None:
        attributes[4] = attributes[5] = constant
    termios.tcsetattr(device.fileno(), termios.TCSANOW, attributes)
    if baud is not None and constant is None:
        pyserial: Any = device
        pyserial._set_special_baudrate(baud)  # as pyserial does when it opens a port


def _control(settings: LineSettings, pseudo_terminal: bool) -> int:
    """Return the control flags of a format; a pseudo terminal has only one format."""
    if pseudo_terminal:
        return termios.CS8
    size: int = getattr(termios, f"CS{settings.data_bits}")
    return size | _PARITIES[settings.parity] | (termios.CSTOPB if settings.stop_half_bits > 2 else 0)


def _mark_errors(fd: int) -> None:
    """Let the line discipline mark errors, which pyserial has switched off, and drop earlier input."""
    attributes = termios.tcgetattr(fd)
    attributes[0] |= termios.PARMRK | termios.INPCK  # without INPCK, framing errors are not marked either
    attributes[0] &= ~(termios.IGNPAR | termios.IGNBRK | termios.BRKINT | termios.ISTRIP)
    attributes[6][termios.VMIN] = 1  # so that an empty read means that the port is gone
    attributes[6][termios.VTIME] = 0
    termios.tcsetattr(fd, termios.TCSANOW, attributes)
    termios.tcflush(fd, termios.TCIFLUSH)


def _check(device: serial.Serial, settings: LineSettings, pseudo_terminal: bool) -> None:
    """Raise Otherwise if the driver has silently set another rate or format."""
    fd = device.fileno()
    baud = true_rate(fd, str(device.port), settings)
    # Linux ignores the format of a pseudo terminal.
    found = settings.format if pseudo_terminal else _format(termios.tcgetattr(fd)[2])
    wanted = settings.format if pseudo_terminal else _format(_control(settings, pseudo_terminal))
    if abs(baud - settings.baud) > settings.baud * _TOLERANCE or found != wanted:
        raise Otherwise(f"its driver sets {baud} Bd {found}")


def _format(control: int) -> str:
    """Return the format of control flags; 1.5 stop bits have the flag of two."""
    bits = next(bits for bits in (5, 6, 7, 8) if control & termios.CSIZE == getattr(termios, f"CS{bits}"))
    flags = control & (termios.PARENB | termios.PARODD | _STICK_PARITY) if control & termios.PARENB else 0
    parity = next(parity for parity, meant in _PARITIES.items() if flags == meant)
    return f"{bits}{parity}{2 if control & termios.CSTOPB else 1}"


def true_rate(fd: int, port: str, settings: LineSettings) -> int:
    """Return the true rate of an open port in Bd, as far as it is known."""
    set_by_driver = _speed(fd) or settings.baud
    if ports.adapter(port).driver == "ch341-uart":
        return ch341_rate(set_by_driver)
    return (divided_rate(fd, set_by_driver) if ports.is_8250(port) else None) or set_by_driver


def _speed(fd: int) -> int | None:
    """Return the rate that the driver reports; None if it reports none."""
    try:
        (speed,) = _TERMIOS2.unpack(fcntl.ioctl(fd, _TCGETS2, bytes(_TERMIOS2.size)))
    except OSError:
        return None  # not Linux
    return int(speed)
