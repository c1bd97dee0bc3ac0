# SPDX-License-Identifier: GPL-2.0-or-later
"""What was sent at once, as receivers get it: characters with their times, and how adapters group them into reads."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from sistap.line.settings import LineSettings

TIMING = "times and their uncertainty are those the virtual bus says"


class Character(NamedTuple):
    """One character as a receiver with the bus's settings gets it; `flags` are Flag.FROM_READER."""

    time_ns: int
    value: int
    flags: int


class Played(NamedTuple):
    """What one station sent at once.

    `marks` name the faults: "parity@5=42" means that character 5 of `sent` arrived as 42 hex. The others are "break@5",
    "loss@5", "pause@5" (a pause before it) and "checksum@1". "ascii" marks text that is not a telegram. The marks of a
    scenario are the names of its faults (scenarios/faults.py).
    """

    time_ns: int  # when its first character was sent
    sent: bytes
    characters: list[Character]  # without those that were lost
    marks: list[str]
    settings: LineSettings = LineSettings()  # settings of the sender
    line: int = 0  # 1 and 2: the directions of a full-duplex line
    uncertainty_ns: int = 0  # of its times, besides the grouping into reads


def reads(characters: Sequence[Character], most: int, character_ns: int) -> Iterator[Sequence[Character]]:
    """Group the characters of one telegram as a coarse adapter does: up to `most`, or until a silence.

    A 16550 reports an unfilled FIFO after a silence of four character times.
    """
    begin = 0
    for end in range(1, len(characters) + 1):
        full = end - begin == most
        silent = end == len(characters) or characters[end].time_ns - characters[end - 1].time_ns > 5 * character_ns
        if full or silent:
            yield characters[begin:end]
            begin = end


def uncertainty(read: Sequence[Character]) -> int:
    """Return how much earlier than its read the first of its characters came, in ns."""
    return read[-1].time_ns - read[0].time_ns
