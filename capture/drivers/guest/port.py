# SPDX-License-Identifier: GPL-2.0-or-later
"""Prints the settings of a port and its driver as a JSON object, for a comparison.

All of it comes from sysfs. Opening an open port, without waiting for a carrier, would raise DTR and RTS again.
"""

from __future__ import annotations

import json
from pathlib import Path

SYSFS = Path("/sys")
LOW_LATENCY = 1 << 13  # ASYNC_LOW_LATENCY of <linux/tty_flags.h>


def main(port: str) -> int:
    """Print it; 1 if there is no such port."""
    name = Path(port).resolve().name
    uart = SYSFS / "class/tty" / name
    flags = _line(uart / "flags")
    state = {
        "low latency": bool(int(flags, 16) & LOW_LATENCY) if flags else None,
        "FIFO trigger": _line(uart / "rx_trig_bytes"),
        "latency timer": _line(SYSFS / "bus/usb-serial/devices" / name / "latency_timer"),
    }
    print(json.dumps(state))
    return 0 if uart.exists() and _line(uart / "type") != "0" else 1


def _line(file: Path) -> str | None:
    return file.read_text().strip() if file.exists() else None
