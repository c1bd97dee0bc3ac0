# SPDX-License-Identifier: GPL-2.0-or-later
"""Stations that answer at a pseudo terminal, in real time or faster by a factor; prints the terminal's name.

python3 answering_bus.py SPEED BAUD
"""

from __future__ import annotations

import os
import sys

from sisbus.stations.making import make
from sisbus.wires.answering import serve
from sisbus.wires.pseudo_terminal import PseudoTerminalPort
from sisbus.wires.wire import Pace
from sistap.tap.line.settings import LineSettings

STATIONS: list[dict[str, object]] = [
    {"address": 3, "behind": [{"address": 2, "kind": "synax", "behind": [{"address": 8}]}]},
    {"address": 4},
]


class FastTime(Pace):
    """Time that goes faster than a clock."""

    def __init__(self, speed: int) -> None:
        super().__init__()
        self._speed = speed

    def now_ns(self) -> int:
        return super().now_ns() * self._speed

    def left_s(self, time_ns: int) -> float:
        return super().left_s(time_ns) / self._speed


class FastPort(PseudoTerminalPort):
    """A terminal without a rate."""

    def write(self, data: bytes) -> None:
        os.write(self._ours, data)


def main() -> None:
    """Serve until somebody ends the process."""
    speed, settings = int(sys.argv[1]), LineSettings(baud=int(sys.argv[2]))
    port = PseudoTerminalPort(settings, 1) if speed == 1 else FastPort(settings, 1)
    print(port.name, flush=True)
    serve(port, make(STATIONS, 1), FastTime(speed))


if __name__ == "__main__":
    main()
