# SPDX-License-Identifier: GPL-2.0-or-later
"""Turns telegrams into timed characters: gaps, reaction delays, pauses, and seeded faults.

Times are ns since the bus was started; a character's time is the end of its stop bit, when a receiver has it. Faults
are disturbances on the tap's branch of the wire: the stations understand each other all the same.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from sistap.bus.drive import Station
from sistap.bus.master import Rate, Times
from sistap.line import Flag, LineSettings

# A drive talks ASCII until it is spoken to in SIS; this one says what it is.
POWER_ON_TEXT = b"DKC02.3-040-7-FW FWA-ECODR3-SMT-02VRS-MS\r\n"

CHECKSUM = 1  # its place in a telegram
_MS = 1_000_000


class Faults(NamedTuple):
    """Probabilities of faults: of a character, but `checksum` of a telegram."""

    parity: float = 0.0  # a bit is wrong, and the parity bit tells
    break_: float = 0.0  # the line is held down over a character: 00 and a break arrive
    loss: float = 0.0  # a character does not arrive, and the next one tells
    checksum: float = 0.0  # sent with a wrong checksum
    pause: float = 0.0  # later than TzA allows

    @classmethod
    def parse(cls, text: str) -> Faults:
        """Read "parity=0.01,loss=0.001"; ValueError says what is wrong with it."""
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


class Character(NamedTuple):
    """One character as a receiver with the bus's own settings gets it; `flags` are Flag.FROM_READER."""

    time_ns: int
    value: int
    flags: int


class Played(NamedTuple):
    """What one station sent in one go.

    `marks` name the faults: "parity@5=42" says that character 5 of `sent` arrived as 42 hex; the others are
    "break@5", "loss@5", "pause@5" (a pause before it) and "checksum@1". "ascii" marks what is no telegram.
    """

    time_ns: int  # when its first character was sent
    sent: bytes
    characters: list[Character]  # without those that were lost
    marks: list[str]
    settings: LineSettings = LineSettings()  # with which it was sent


class Player:
    """Sends telegrams, one after the other."""

    def __init__(self, settings: LineSettings, faults: Faults, seed: int) -> None:
        """Start at time 0 with a silent line."""
        self._settings = settings
        self._rate_since = 0
        self._tza_ns = Times.for_line(settings).tza * _MS
        self._trs_ns = Times.for_line(settings).trs * _MS
        self._faults = faults
        # Two sources, so that faults change nothing but what they disturb.
        self._timing = random.Random(f"{seed} timing")
        self._noise = random.Random(f"{seed} noise")
        self._now = 0  # nothing is sent before
        self._last_end = 0  # of the last character
        self._lost = False  # characters were lost since the last that arrived

    def exchange(self, command: bytes, reaction: bytes | None) -> Iterator[Played]:
        """Send a command and what is answered, and wait as the master does before it goes on."""
        yield self._send(command)
        if reaction is None:
            self._now += self._trs_ns  # nobody may be asked before they could have answered
        else:
            # A start is recognised only after a silence longer than TzA (chapter 10.3).
            self._now += self._tza_ns + self._timing.randrange(1 * _MS, 6 * _MS)
            yield self._send(reaction)
        self._now += self._tza_ns + self._timing.randrange(5 * _MS, 25 * _MS)

    def change(self, rate: Rate) -> None:
        """Go on at another rate: since the last character, or since the time has come."""
        if rate.after_ms:
            self._rate_since += rate.after_ms * _MS
            self._now = max(self._now, self._rate_since + self._trs_ns)  # nobody's timer is exact
        else:
            self._rate_since = self._last_end
        self._settings = self._settings._replace(baud=rate.baud)

    def text(self, characters: bytes) -> Played:
        """Send what is no telegram, and be silent for a while."""
        played = self._send(characters, "ascii")
        self._now += self._trs_ns
        return played

    def _send(self, sent: bytes, *marks: str) -> Played:
        characters: list[Character] = []
        noticed = list(marks)
        if not marks and self._happens(self._faults.checksum):
            noticed.append(f"checksum@{CHECKSUM}")
            wrong = sent[CHECKSUM] ^ self._noise.randrange(1, 256)
            sent = sent[:CHECKSUM] + bytes([wrong]) + sent[CHECKSUM + 1 :]
        for index, value in enumerate(sent):
            self._now += self._interval(index, noticed)
            if index == 0:
                time_ns = self._now
            arrived = self._disturbed(index, value, noticed)
            if arrived is not None:
                characters.append(arrived)
        self._last_end = self._now
        return Played(time_ns, sent, characters, noticed, self._settings)

    def _interval(self, index: int, marks: list[str]) -> int:
        """How long after the character before it this one comes; most follow back to back."""
        character_ns = self._settings.character_ns
        gap = int(character_ns * 0.2 * self._timing.random() ** 4)
        if index and self._happens(self._faults.pause):
            marks.append(f"pause@{index}")
            return int(self._tza_ns * self._noise.uniform(1.5, 3))
        return character_ns + gap

    def _disturbed(self, index: int, value: int, marks: list[str]) -> Character | None:
        if self._happens(self._faults.loss):
            marks.append(f"loss@{index}")
            self._lost = True
            return None
        flags = int(Flag.LOST_BEFORE) if self._lost else 0
        self._lost = False
        if self._happens(self._faults.break_):
            marks.append(f"break@{index}")
            return Character(self._now, 0x00, flags | Flag.BREAK)
        if self._happens(self._faults.parity):
            value ^= 1 << self._noise.randrange(8)
            marks.append(f"parity@{index}={value:02X}")
            flags |= Flag.CHARACTER_ERROR
        return Character(self._now, value, flags)

    def _happens(self, probability: float) -> bool:
        return probability > 0 and self._noise.random() < probability


def play(player: Player, commands: Iterable[bytes | Rate], stations: Sequence[Station]) -> Iterator[Played]:
    """Play a power-on text, then every command and the reaction of the station that it is for."""
    yield player.text(POWER_ON_TEXT)
    for command in commands:
        if isinstance(command, Rate):
            player.change(command)
            continue
        reactions = [station.react(command) for station in stations]  # a broadcast is for all of them
        yield from player.exchange(command, next((reaction for reaction in reactions if reaction), None))


def reads(characters: Sequence[Character], most: int, character_ns: int) -> Iterator[Sequence[Character]]:
    """Group the characters of one telegram as a coarse adapter delivers them: `most`, or until a silence.

    The silence is that after which a 16550 reports an unfilled FIFO: four character times.
    """
    begin = 0
    for end in range(1, len(characters) + 1):
        full = end - begin == most
        silent = end == len(characters) or characters[end].time_ns - characters[end - 1].time_ns > 5 * character_ns
        if full or silent:
            yield characters[begin:end]
            begin = end


def uncertainty(read: Sequence[Character]) -> int:
    """How much earlier than its read the first of its characters came, in ns."""
    return read[-1].time_ns - read[0].time_ns
