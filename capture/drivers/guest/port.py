# SPDX-License-Identifier: GPL-2.0-or-later
"""What is set at a port and its driver, so that it can be compared: prints a JSON object."""

from __future__ import annotations

import fcntl
import json
import os
import struct
import termios
from pathlib import Path

LOW_LATENCY = 1 << 13  # ASYNC_LOW_LATENCY of <linux/tty_flags.h>
FILES = {
    "latency timer": "/sys/bus/usb-serial/devices/{}/latency_timer",
    "FIFO trigger": "/sys/class/tty/{}/rx_trig_bytes",
}


def main(port: str) -> int:
    """Print it."""
    state: dict[str, object] = {}
    descriptor = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        serial = fcntl.ioctl(descriptor, termios.TIOCGSERIAL, bytes(128))
        state["low latency"] = bool(struct.unpack_from("i", serial, 16)[0] & LOW_LATENCY)
    except OSError:
        state["low latency"] = None
    finally:
        os.close(descriptor)
    for name, file in FILES.items():
        path = Path(file.format(Path(port).resolve().name))
        state[name] = path.read_text().strip() if path.exists() else None
    print(json.dumps(state))
    return 0
