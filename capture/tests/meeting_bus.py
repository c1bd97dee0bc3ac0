# SPDX-License-Identifier: GPL-2.0-or-later
"""Half a line of procedure 3964R at a pseudo terminal, faster than real time: an S5 that asks, or a PPC that reacts.

Prints the terminal's name; an S5 prints at its end, in hexadecimal, the reaction to each command. FILE has the blocks
that came.

python3 meeting_bus.py SPEED s5|ppc high|low COMMANDS SEED FILE
"""

from __future__ import annotations

import math
import random
import sys
from collections import deque
from typing import IO

from answering_bus import FastPort, FastTime

from sisbus.procedure3964 import rk512
from sisbus.procedure3964.controls import S5, ControlMemory, Ppc, Script
from sisbus.procedure3964.partner import Partner
from sisbus.procedure3964.rk512 import Head
from sisbus.wires.answering import meet
from sistap.tap.line.settings import LineSettings

# S-0-0237 of each axis; with the characters that have a meaning in the procedure.
VALUES = {axis: bytes(random.Random(axis).choices(b"\x02\x03\x10\x15\x41\xff", k=4)) for axis in range(1, 33)}


def command_of(axis: int) -> bytes:
    """Return the command that reads the value of an axis."""
    return rk512.command(rk512.FETCH, 0, 2, bytes(Head.of("S-0-0237", axis, write=False)))


def axes(seed: int, count: int) -> list[int]:
    """Return that many axes, each with another value than the one before."""
    chance, chosen = random.Random(seed), [0]
    while len(chosen) <= count:
        axis = chance.randint(1, 32)
        chosen += [axis] * (VALUES[axis] != VALUES.get(chosen[-1]))
    return chosen[1:]


def s5(seed: int, count: int, outcomes: list[bytes | None], *, high: bool) -> S5:
    """Return an S5 that reads axes, and notes the reactions; None: given up."""

    def script() -> Script:
        for axis in axes(seed, count):
            reaction = yield command_of(axis)
            outcomes.append(bytes(reaction) if reaction else None)

    return S5(Partner(high=high), script(), random.Random(seed))


def ppc(*, high: bool) -> Ppc:
    """Return a PPC with these values."""
    memory = ControlMemory({(axis, b"\0\0\xed"): value for axis, value in VALUES.items()}, frozenset())
    return Ppc(Partner(high=high), memory, 5_000_000, {})


class Told(deque[bytes]):
    """The blocks that came; each is written to a file, too."""

    def __init__(self, file: IO[str]) -> None:
        super().__init__()
        self._file = file

    def append(self, data: bytes) -> None:
        super().append(data)
        print(data.hex(), file=self._file)


def main() -> None:
    """Play it; a PPC until somebody ends the process."""
    speed, role, priority, count, seed, name = sys.argv[1:]
    outcomes: list[bytes | None] = []
    high = priority == "high"
    station = s5(int(seed), int(count), outcomes, high=high) if role == "s5" else ppc(high=high)
    port = FastPort(LineSettings(9600), 1)
    with open(name, "w", buffering=1) as file:
        station.partner.received = Told(file)
        print(port.name, flush=True)
        port.wait_for_partner()
        meet(port, station, math.inf, FastTime(int(speed)))
    print(*(outcome.hex() if outcome else "-" for outcome in outcomes))


if __name__ == "__main__":
    main()
