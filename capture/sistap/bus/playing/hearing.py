# SPDX-License-Identifier: GPL-2.0-or-later
"""What a receiver with other line settings than the sender makes of a character, bit by bit.

A UART samples the line in the middle of each bit, counted at its own rate from the edge of the start bit.
"""

from __future__ import annotations

import random

from sistap.bus.playing.played import Character
from sistap.line.settings import Flag, LineSettings


def received(character: Character, line: LineSettings, tap: LineSettings, noise: random.Random) -> tuple[int, int]:
    """Return value and flags of a character of the bus at a tap; everybody hears a fault of the line."""
    if tap[:3] == line[:3]:  # a receiver samples one stop bit at most
        return character.value, character.flags
    value, flags = hear(character.value, line, tap, noise)
    return value, character.flags | flags


def hear(value: int, line: LineSettings, tap: LineSettings, noise: random.Random) -> tuple[int, Flag]:
    """Return value and flags of a character sent with `line` and received with `tap`; exact at equal rates.

    At another rate, one character is heard as one. If the receiver still listens when it is over, `noise` follows it.
    """
    if tap.baud == 0:
        tap = tap._replace(baud=line.baud)
    sent = _bits(value, line)
    looks = 1 + tap.data_bits + (tap.parity != "N") + 1
    places = [(2 * look + 1) * line.baud // (2 * tap.baud) for look in range(looks)]
    seen = [sent[place] if place < len(sent) else _after(line, tap, noise) for place in places]
    data, stop = seen[1 : 1 + tap.data_bits], seen[-1]
    heard = sum(bit << place for place, bit in enumerate(data))
    if not any(seen):
        return 0, Flag.BREAK
    wrong_parity = tap.parity != "N" and seen[-2] != _parity(heard, tap.parity)
    return heard, Flag.CHARACTER_ERROR if wrong_parity or not stop else Flag(0)


def _bits(value: int, line: LineSettings) -> list[int]:
    """Return start bit, data from the lowest bit on, parity, stop bit."""
    data = [value >> place & 1 for place in range(line.data_bits)]
    parity = [] if line.parity == "N" else [_parity(value, line.parity)]
    return [0, *data, *parity, 1]


def _parity(value: int, parity: str) -> int:
    odd = value.bit_count() % 2
    return {"E": odd, "O": 1 - odd, "M": 1, "S": 0}[parity]


def _after(line: LineSettings, tap: LineSettings, noise: random.Random) -> int:
    """Return the level after the character: idle, unless the receiver is far behind."""
    return 1 if line.baud == tap.baud else noise.getrandbits(1)
