# SPDX-License-Identifier: GPL-2.0-or-later
"""The line of the UART that uart.c makes. Input and output are those of adapter.py, without "loop", "idle" and pace."""

from __future__ import annotations

import json
import os
import select
import struct
import sys

DEVICE = "/dev/uart"
WRITTEN = struct.Struct("=QBB6x")  # when, register, value
LOOK_S = 0.05
CLOCK = 1_843_200 // 16  # Hz, of divisor 1

# Registers; 0 and 1 are the divisor while bit 7 of LCR is set.
DATA, LCR, MCR = 0, 3, 4


class Registers:
    """What the driver has written so far."""

    def __init__(self, device: int) -> None:
        """Read them from the device."""
        self._device = device
        self._format, self._lines, self._divisor = 0, 0, [0, 0]

    def look(self) -> None:
        """Say what is new."""
        for ns, register, value in WRITTEN.iter_unpack(os.read(self._device, WRITTEN.size * 1024)):
            message = self._message(register, value)
            if message:
                print(json.dumps(message | {"ns": ns}), flush=True)

    def _message(self, register: int, value: int) -> dict[str, object]:
        if register < len(self._divisor) and self._format & 0x80:
            self._divisor[register] = value
            divisor = self._divisor[0] | self._divisor[1] << 8
            return {"told": {"baud": CLOCK / divisor}} if register and divisor else {}
        if register == DATA:
            return {"sent": f"{value:02x}"}
        if register == MCR:
            return {"told": {"dtr": bool(value & 1), "rts": bool(value & 2)}}
        if register == LCR:
            self._format = value
            parity = "OEMS"[value >> 4 & 3] if value & 8 else "N"
            return {"told": {"format": f"{5 + (value & 3)}{parity}{2 if value & 4 else 1}"}}
        return {}


def main() -> int:
    """Play what the input says until it ends."""
    device = os.open(DEVICE, os.O_RDWR)
    registers = Registers(device)
    played = 0
    print("{}", flush=True)
    while True:
        ready, _, _ = select.select([sys.stdin], [], [], LOOK_S)
        if ready:
            line = sys.stdin.readline()
            if not line:
                return 0
            characters = json.loads(line).get("play", ())
            os.write(device, bytes(byte for character in characters for byte in character))
            played += len(characters)
            print(json.dumps({"played": played}), flush=True)
        registers.look()
