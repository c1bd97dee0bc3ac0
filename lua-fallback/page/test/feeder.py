# SPDX-License-Identifier: GPL-2.0-or-later
"""Plays the demo at a pseudo terminal: feeder.py BAUD SECONDS LOG.

LOG gets for each character its value, and the times before and after it was written, in ns since 1970. Prints the name
of the terminal, and at the end how many characters it has written. Then it waits for the end of its input: what is not
read before would be lost.
"""

from __future__ import annotations

import struct
import sys
import time
from pathlib import Path

from sisbus.scenarios.scenario import Playing, load
from sisbus.wires.pseudo_terminal import PseudoTerminal
from sisbus.wires.wire import Pace
from sistap.tap.line.settings import LineSettings

CHARACTER = struct.Struct("<BQQ")


class Noting(PseudoTerminal):
    """A pseudo terminal that notes when it has written what."""

    def __init__(self, pace: Pace, baud: int, log: Path) -> None:
        super().__init__(pace, baud)
        self._log = log.open("wb")

    def _write(self, value: int) -> bool:
        before_ns = time.time_ns()
        written = super()._write(value)
        self._log.write(CHARACTER.pack(value, before_ns, time.time_ns()))
        return written

    def flush(self) -> None:
        """Write the log, and say how many characters there are."""
        count = self._log.tell() // CHARACTER.size
        self._log.close()
        print(count, flush=True)


def main() -> None:
    """Play."""
    settings, pace = LineSettings(int(sys.argv[1])), Pace()
    terminal = Noting(pace, settings.baud, Path(sys.argv[3]))
    print(terminal.name, flush=True)
    terminal.wait_for_listener()
    for played in load("demo").play(settings, Playing(end_ns=float(sys.argv[2]) * 1e9)):
        terminal.deliver(played)
    terminal.flush()
    sys.stdin.read()
    terminal.close()


if __name__ == "__main__":
    main()
