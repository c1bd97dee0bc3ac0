# SPDX-License-Identifier: GPL-2.0-or-later
"""The other end of a CDC-ACM adapter that the guest is itself (g_serial at dummy_hcd): a terminal that sends and hears.

Input and output are those of adapter.py. It knows no line errors; {"break": true} sends a break.
"""

from __future__ import annotations

import json
import os
import select
import sys
import termios
import tty


def main(port: str) -> int:
    """Run the other end until this ends."""
    terminal = os.open(port, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(terminal)
    loop, played, rest = False, 0, b""
    print("{}", flush=True)
    while True:
        ready, _, _ = select.select([0, terminal], [], [])
        if terminal in ready:
            data = os.read(terminal, 4096)
            if not data:
                return 0
            print(json.dumps({"sent": data.hex()}), flush=True)
            if loop:
                os.write(terminal, data)
        if 0 in ready:
            data = os.read(0, 1 << 16)
            if not data:
                return 0
            *lines, rest = (rest + data).split(b"\n")
            for line in lines:
                message = json.loads(line)
                loop = message.get("loop", loop)
                if message.get("break"):
                    termios.tcdrain(terminal)
                    termios.tcsendbreak(terminal, 0)
                characters = bytes(value for value, _ in message.get("play", ()))
                if characters:
                    os.write(terminal, characters)
                    played += len(characters)
                    print(json.dumps({"played": played}), flush=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
