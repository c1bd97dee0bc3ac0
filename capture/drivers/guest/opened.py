# SPDX-License-Identifier: GPL-2.0-or-later
"""Opens a port as a capture does, with one rate and format after the other; then changes them while it is open.

Each line of the input is "RATE FORMAT", "change RATE FORMAT", or "close". Each answer is a JSON object: the settings
that records would carry, or why the port was refused.
"""

from __future__ import annotations

import json
import sys

from sistap.tap.line.reader import PortError, Reader, open_reader
from sistap.tap.line.settings import LineSettings


def main(port: str) -> int:
    """Execute the input."""
    reader: Reader | None = None
    print("{}", flush=True)
    for line in sys.stdin:
        *change, baud, text = line.split()
        settings = LineSettings.parse(int(baud), text)
        try:
            if change:
                assert reader
                reader.change(settings)
            else:
                if reader:
                    reader.close()
                reader = None
                reader = open_reader(port, settings, 0)
            answer = {"settings": str(reader.settings)}
        except PortError as error:
            answer = {"refused": str(error)}
        print(json.dumps(answer), flush=True)
    if reader:
        reader.close()
    return 0
