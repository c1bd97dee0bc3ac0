# SPDX-License-Identifier: GPL-2.0-or-later
"""Two masters that send at the same time: what a receiver makes of it.

Where two transmitters of an RS485 line want the same, the line is that; where they do not, it is whatever the stronger
one makes of it. A parity bit is such a bit, too.
"""

from __future__ import annotations

import random

from sistap.bus.playing.sending import Sending, Slot
from sistap.line.settings import Flag


def collide(sending: Sending, other: bytes, scatter: random.Random) -> None:
    """Mix the characters of another telegram, which begins somewhere in this one, into what is sent."""
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
    """Return bits on which the two agree; where they do not, any."""
    return one ^ ((one ^ other) & scatter.getrandbits(bits))
