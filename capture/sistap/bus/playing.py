# SPDX-License-Identifier: GPL-2.0-or-later
"""Turns telegrams into timed characters: gaps, reaction delays, pauses, and seeded faults.

Times are ns since the bus was started; a character's time is the end of its stop bit, when a receiver has it. `Faults`
are disturbances on the tap's branch of the wire: the stations understand each other all the same. What a scenario
disturbs (faults.py) is on the line itself: who does not understand a command does not answer.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Generator, Iterator, Sequence
from typing import NamedTuple

from sistap.bus.collision import collide
from sistap.bus.script import Rate
from sistap.bus.sending import Sending, Slot
from sistap.bus.station import Station
from sistap.bus.times import Times
from sistap.follow import Change, Follow
from sistap.line import Flag, LineSettings
from sistap.telegram import is_whole

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
    "break@5", "loss@5", "pause@5" (a pause before it) and "checksum@1". "ascii" marks what is no telegram. What a
    scenario disturbs is marked with the names of its faults (faults.py).
    """

    time_ns: int  # when its first character was sent
    sent: bytes
    characters: list[Character]  # without those that were lost
    marks: list[str]
    settings: LineSettings = LineSettings()  # with which it was sent
    line: int = 0  # 1 and 2: the directions of a full-duplex line
    uncertainty_ns: int = 0  # of its times, besides what reading several characters at once adds


Disturb = Callable[[Sending, int], Sending]  # with the time in ns


def _undisturbed(sending: Sending, now_ns: int) -> Sending:  # noqa: ARG001
    return sending


Exchange = Generator[Played, None, bytes | None]  # what is sent, and the reaction it came to


class Player:
    """The simulated line with its stations: sends telegrams, one after the other."""

    def __init__(  # noqa: PLR0913 - what the line is, who is on it, and what goes wrong
        self,
        settings: LineSettings,
        faults: Faults,
        seed: int,
        stations: Sequence[Station] = (),
        times: Times | None = None,
        disturb: Disturb = _undisturbed,
    ) -> None:
        """Start at time 0 with a silent line; `disturb` decides what becomes of what is sent, for everybody."""
        self.settings = settings
        self.collided = False
        self._rate_since = 0
        self._follow = Follow(settings.baud)
        times = times or Times.for_line(settings)
        self._tza_ns = times.tza * _MS
        self._trs_ns = times.trs * _MS
        self._faults = faults
        self._stations = stations
        self._disturb = disturb
        # Sources of their own, so that faults change nothing but what they disturb.
        self._timing = random.Random(f"{seed} timing")
        self._noise = random.Random(f"{seed} noise")
        self._mixing = random.Random(f"{seed} mixing")
        self._now = 0  # nothing is sent before
        self._last_end = 0  # of the last character
        self._lost = False  # characters were lost since the last that arrived

    @property
    def now_ns(self) -> int:
        """The time before which nothing more is sent."""
        return self._now

    def exchange(self, command: bytes, rival: bytes | None = None) -> Exchange:
        """Send a command, come to what is answered, and wait as a master does before it goes on."""
        self._go_to(self._follow.due(self._now))
        sending = self._disturb(Sending(command, self.settings), self._now)
        self.collided = sending.colliding and rival is not None
        if self.collided and rival:
            collide(sending, rival, self._mixing)
        yield from self._put(sending)
        commanded_ns = self._now
        reaction = None
        if not sending.damaged and is_whole(command):
            reactions = [station.react(command, self._now) for station in self._stations]  # a broadcast is for all
            reaction = next((reaction for reaction in reactions if reaction), None)
            self._go_to(self._follow.take(command, self._now))  # who accepts alone answers at the new rate
        if reaction is not None:
            reaction = yield from self._answer(reaction, commanded_ns)
        if reaction is None:
            # Nobody may be asked before they could have answered.
            self._now = max(self._now, commanded_ns + self._trs_ns)
        self._now += self._tza_ns + self._timing.randrange(5 * _MS, 25 * _MS)
        return reaction

    def send(self, characters: bytes) -> Iterator[Played]:
        """Send characters that nobody has to answer, and be silent for a while."""
        marks = [] if is_whole(characters) else ["ascii"]
        yield from self._put(self._disturb(Sending(characters, self.settings, marks=marks), self._now))
        self._now += self._trs_ns

    def wait(self, ns: int) -> None:
        """Let time pass."""
        self._now += ns

    def change(self, rate: Rate) -> None:
        """Go on at another rate: since the last character, or since the time has come."""
        if rate.after_ms:
            self._rate_since += rate.after_ms * _MS
            self._now = max(self._now, self._rate_since + self._trs_ns)  # nobody's timer is exact
        else:
            self._rate_since = self._last_end
        self.settings = self.settings._replace(baud=rate.baud)

    def _answer(self, reaction: bytes, commanded_ns: int) -> Exchange:
        """Send a reaction, come to what the master understands of it if it begins within TrS."""
        sending = self._disturb(Sending(reaction, self.settings), self._now)
        if sending.silent:
            return None
        # A start is recognised only after a silence longer than TzA (chapter 10.3).
        self._now += self._tza_ns + self._timing.randrange(1 * _MS, 6 * _MS) + sending.delay_ns
        for played in self._put(sending):
            yield played
        if sending.damaged or played.time_ns - self.settings.character_ns > commanded_ns + self._trs_ns:
            return None
        self._go_to(self._follow.take(reaction, self._now))
        return reaction

    def _go_to(self, change: Change | None) -> None:
        """Go on at the rate that the bus was told."""
        if change:
            self.settings = self.settings._replace(baud=change.baud)

    def _put(self, sending: Sending) -> Iterator[Played]:
        """Send, after what is on the line before it."""
        if sending.before:
            noise = Sending(bytes(slot.value for slot in sending.before), self.settings, marks=["ascii"])
            noise.slots = sending.before
            yield self._sent(noise)
            self._now += 2 * self._tza_ns  # or no start would be recognised
        yield self._sent(sending)

    def _sent(self, sending: Sending) -> Played:
        characters: list[Character] = []
        sent, slots, noticed = sending.sent, sending.slots, list(sending.marks)
        if not noticed and self._happens(self._faults.checksum):
            noticed.append(f"checksum@{CHECKSUM}")
            wrong = sent[CHECKSUM] ^ self._noise.randrange(1, 256)
            sent = sent[:CHECKSUM] + bytes([wrong]) + sent[CHECKSUM + 1 :]
            slots[CHECKSUM].value = wrong
        for index, slot in enumerate(slots):
            self._now += slot.pause_ns + self._interval(index, sending.settings, noticed)
            if index == 0:
                time_ns = self._now
            arrived = self._disturbed(index, slot, noticed)
            if arrived is not None:
                characters.append(arrived)
        self._last_end = self._now
        return Played(time_ns, sent, characters, noticed, sending.settings)

    def _interval(self, index: int, settings: LineSettings, marks: list[str]) -> int:
        """How long after the character before it this one comes; most follow back to back."""
        character_ns = settings.character_ns
        gap = int(character_ns * 0.2 * self._timing.random() ** 4)
        if index and self._happens(self._faults.pause):
            marks.append(f"pause@{index}")
            return int(self._tza_ns * self._noise.uniform(1.5, 3))
        return character_ns + gap

    def _disturbed(self, index: int, slot: Slot, marks: list[str]) -> Character | None:
        if self._happens(self._faults.loss):
            marks.append(f"loss@{index}")
            self._lost = True
            return None
        value, flags = slot.value, slot.flags | (int(Flag.LOST_BEFORE) if self._lost else 0)
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
