# SPDX-License-Identifier: GPL-2.0-or-later
"""Characters: as they are sent, on their way to the line, on the tap's branch of it, and as a receiver gets them."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from sistap.tap.line.settings import Flag, LineSettings

TIMING = "times and their uncertainty are those the virtual bus says"


class SentCharacter(NamedTuple):
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
    characters: list[SentCharacter]  # without those that were lost
    marks: list[str]
    settings: LineSettings = LineSettings()  # settings of the sender
    line: int = 0  # 1 and 2: the directions of a full-duplex line
    uncertainty_ns: int = 0  # of its times, besides the grouping into reads


def reads(characters: Sequence[SentCharacter], most: int, character_ns: int) -> Iterator[Sequence[SentCharacter]]:
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


def uncertainty(read: Sequence[SentCharacter]) -> int:
    """Return how much earlier than its read the first of its characters came, in ns."""
    return read[-1].time_ns - read[0].time_ns


# -- On their way to the line, where faults can still change them ----------------------------------------------------

CHECKSUM = 1  # its place in a telegram


@dataclass
class Slot:
    """One character, and its deviations."""

    value: int
    flags: int = 0  # of Flag.FROM_READER
    pause_ns: int = 0  # pause before it, beyond the usual one


@dataclass
class Sending:
    """What a station sends at once, and what happens to it on the line."""

    sent: bytes
    settings: LineSettings  # settings of the sender
    slots: list[Slot] = field(default_factory=list)
    before: list[Slot] = field(default_factory=list)  # what is on the line before it, from no sender
    marks: list[str] = field(default_factory=list)
    delay_ns: int = 0  # extra delay of a reaction
    silent: bool = False  # it is not sent at all
    colliding: bool = False  # another master sends at the same time
    damaged: bool = False  # no station understands it

    def __post_init__(self) -> None:
        self.slots = [Slot(value) for value in self.sent]

    def set_checksum(self, value: int) -> None:
        """Send another checksum."""
        self.sent = self.sent[:CHECKSUM] + bytes([value]) + self.sent[CHECKSUM + 1 :]
        self.slots[CHECKSUM].value = value

    def damage(self, mark: str) -> None:
        """Note a fault that no station understands."""
        self.marks.append(mark)
        self.damaged = True


# -- Faults on the tap's branch of the wire: the stations still understand each other --------------------------------

# Faults of a scenario (scenarios/faults.py) are on the line itself: a station that does not understand a command does
# not answer.


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

    def arrived(self, index: int, slot: Slot, time_ns: int, marks: list[str]) -> SentCharacter | None:
        """Return a character as it arrives; None: it is lost, and the next one shows it."""
        if self._happens(self._faults.loss):
            marks.append(f"loss@{index}")
            self._lost = True
            return None
        value, flags = slot.value, slot.flags | (int(Flag.LOST_BEFORE) if self._lost else 0)
        self._lost = False
        if self._happens(self._faults.break_):
            marks.append(f"break@{index}")
            return SentCharacter(time_ns, 0x00, flags | Flag.BREAK)
        if self._happens(self._faults.parity):
            value ^= 1 << self._noise.randrange(8)
            marks.append(f"parity@{index}={value:02X}")
            flags |= Flag.CHARACTER_ERROR
        return SentCharacter(time_ns, value, flags)

    def _happens(self, probability: float) -> bool:
        return probability > 0 and self._noise.random() < probability


# -- What a receiver with other line settings than the sender makes of a character, bit by bit -----------------------

# A UART samples the line in the middle of each bit, counted at its own rate from the edge of the start bit.


def received(character: SentCharacter, line: LineSettings, tap: LineSettings, noise: random.Random) -> tuple[int, int]:
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
