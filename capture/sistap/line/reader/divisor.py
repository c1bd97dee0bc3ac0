# SPDX-License-Identifier: GPL-2.0-or-later
"""The rate of an 8250 or 16550: its clock divided by a whole number, whatever rate was asked for.

The driver reports the wish: at 115200 Hz, 76800 Bd are 57600.
"""

from __future__ import annotations

import fcntl
import struct
import sys
import termios

if sys.platform == "win32":
    raise ImportError("Windows does not tell the clock of a port")

# Linux, <linux/serial.h>: of struct serial_struct the eighth member, baud_base; more than its size has anywhere.
_SERIAL = struct.Struct("28xi96x")


def rate(fd: int, baud: int) -> int | None:
    """Return the rate that a port really has when its driver says `baud`; None where it does not tell its clock."""
    try:
        (clock,) = _SERIAL.unpack(fcntl.ioctl(fd, termios.TIOCGSERIAL, bytes(_SERIAL.size)))
    except (OSError, AttributeError):  # not Linux
        return None
    divisor = max((2 * clock + baud) // (2 * baud), 1)  # to the nearest, as the driver does
    return round(clock / divisor) if clock > 0 else None
