# SPDX-License-Identifier: GPL-2.0-or-later
"""Faults on the tap's branch of the wire: the stations still understand each other.

Faults of a scenario (scenarios/faults.py) are on the line itself: a station that does not understand a command does not
answer.
"""

from __future__ import annotations

import random
from typing import NamedTuple

from sistap.bus.playing.played import Character
from sistap.bus.playing.sending import CHECKSUM, Sending, Slot
from sistap.line.settings import Flag


class Faults(NamedTuple):
    """Probabilities of faults, for each character; `checksum` for each telegram."""

    parity: float = 0.0  # a bit is wrong, and the parity bit shows it
    break_: float = 0.0  # the line is held low for a character: 00 and a break arrive
    loss: float = 0.0  # a character does not arrive, and the next one shows it
    checksum: float = 0.0  # sent with a wrong checksum
    pause: float = 0.0  # later than TzA allows

    @classmethod
    def parse(cls, text: str) -> Faults:
        """Parse "parity=0.01,loss=0.001"; ValueError says what is wrong with it."""
        names = {name.rstrip("_"): name for name in cls._fields}
        values: dict[str, float] = {}
        for item in text.split(","):
            name, _, value = item.partition("=")
            try:
                values[names[name.strip()]] = float(value)
            except (KeyError, ValueError):
                raise ValueError(f"fault '{item}' is not NAME=PROBABILITY, NAME one of {', '.join(names)}") from None
        if not all(0 <= value <= 1 for value in values.values()):
            raise ValueError(f"faults '{text}': a probability is a number from 0 to 1")
        return cls(**values)


NO_FAULTS = Faults()


class Branch:
    """Applies faults to what is sent. They have a random generator of their own, and so change nothing else."""

    def __init__(self, faults: Faults, seed: int) -> None:
        self._faults = faults
        self._noise = random.Random(f"{seed} noise")
        self._lost = False  # since the last character that arrived

    def falsify(self, sending: Sending) -> None:
        """Give an otherwise good telegram a wrong checksum, at random."""
        if not sending.marks and self._happens(self._faults.checksum):
            sending.marks.append(f"checksum@{CHECKSUM}")
            sending.set_checksum(sending.sent[CHECKSUM] ^ self._noise.randrange(1, 256))

    def pause(self, index: int, tza_ns: int, marks: list[str]) -> int | None:
        """Return the interval in ns before a character that comes later than TzA allows; None: in time."""
        if not index or not self._happens(self._faults.pause):
            return None
        marks.append(f"pause@{index}")
        return int(tza_ns * self._noise.uniform(1.5, 3))

    def arrived(self, index: int, slot: Slot, time_ns: int, marks: list[str]) -> Character | None:
        """Return a character as it arrives; None: it is lost, and the next one shows it."""
        if self._happens(self._faults.loss):
            marks.append(f"loss@{index}")
            self._lost = True
            return None
        value, flags = slot.value, slot.flags | (int(Flag.LOST_BEFORE) if self._lost else 0)
        self._lost = False
        if self._happens(self._faults.break_):
            marks.append(f"break@{index}")
            return Character(time_ns, 0x00, flags | Flag.BREAK)
        if self._happens(self._faults.parity):
            value ^= 1 << self._noise.randrange(8)
            marks.append(f"parity@{index}={value:02X}")
            flags |= Flag.CHARACTER_ERROR
        return Character(time_ns, value, flags)

    def _happens(self, probability: float) -> bool:
        return probability > 0 and self._noise.random() < probability
