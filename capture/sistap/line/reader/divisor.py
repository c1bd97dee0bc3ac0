# SPDX-License-Identifier: GPL-2.0-or-later
"""The true rate of an 8250 or 16550: its clock divided by a whole number, whatever rate was requested.

The driver reports the requested rate: with a clock of 115200 Hz, 76800 Bd are really 57600.
"""

from __future__ import annotations

import fcntl
import struct
import sys
import termios

if sys.platform == "win32":
    raise ImportError("Windows does not tell the clock of a port")

# Linux, <linux/serial.h>: baud_base is the eighth member of struct serial_struct; the buffer is larger than any
# system's.
_SERIAL = struct.Struct("28xi96x")


def rate(fd: int, baud: int) -> int | None:
    """Return the true rate of a port whose driver says `baud`; None if it does not state its clock."""
    try:
        (clock,) = _SERIAL.unpack(fcntl.ioctl(fd, termios.TIOCGSERIAL, bytes(_SERIAL.size)))
    except (OSError, AttributeError):  # not Linux
        return None
    divisor = max((2 * clock + baud) // (2 * baud), 1)  # rounded to the nearest, as the driver does
    return round(clock / divisor) if clock > 0 else None
