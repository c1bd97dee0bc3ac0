# SPDX-License-Identifier: GPL-2.0-or-later
"""Opens a port as any terminal program does, and sends each line of its input, which is hexadecimal.

Prints {} when the port is open, and {"received": hex} for what comes.
"""

from __future__ import annotations

import json
import os
import select
import sys

import serial


def main(port: str, baud: str, text: str) -> int:
    """Send until the input ends."""
    device = serial.Serial(port, int(baud), int(text[0]), text[1], float(text[2:]))
    print("{}", flush=True)
    while True:
        ready, _, _ = select.select([0, device.fileno()], [], [])
        if 0 in ready:
            line = sys.stdin.readline()
            if not line:
                return 0
            device.write(bytes.fromhex(line))
        if device.fileno() in ready:
            received = os.read(device.fileno(), 4096)
            print(json.dumps({"received": received.hex()}), flush=True)
