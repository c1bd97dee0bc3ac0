# SPDX-License-Identifier: GPL-2.0-or-later
"""Two masters that send at the same time: what a receiver hears.

Where both transmitters of an RS485 line send the same level, the line has it. Where they differ, the stronger one wins,
at random. This applies to a parity bit, too.
"""

from __future__ import annotations

import random

from sistap.bus.playing.sending import Sending, Slot
from sistap.line.settings import Flag


def collide(sending: Sending, other: bytes, scatter: random.Random) -> None:
    """Mix the characters of another telegram, which begins within this one, into what is sent."""
    start = scatter.randrange(len(sending.slots))
    for place, value in enumerate(other, start=start):
        if place < len(sending.slots):
            sending.slots[place] = mixed = _mixed(sending.slots[place].value, value, scatter)
            mixed.flags = 0 if sending.settings.parity == "N" else mixed.flags
        else:
            sending.slots.append(Slot(value))
    sending.marks.append(f"collision@{start}={other.hex().upper()}")
    sending.damaged = True


def _mixed(one: int, other: int, scatter: random.Random) -> Slot:
    value = _either(one, other, 8, scatter)
    parity = _either(one.bit_count() & 1, other.bit_count() & 1, 1, scatter)
    return Slot(value, 0 if parity == value.bit_count() & 1 else int(Flag.CHARACTER_ERROR))


def _either(one: int, other: int, bits: int, scatter: random.Random) -> int:
    """Return the bits on which both agree; the others are random."""
    return one ^ ((one ^ other) & scatter.getrandbits(bits))
