# SPDX-License-Identifier: GPL-2.0-or-later
"""The simulated line: turns telegrams into timed characters, with gaps, reaction delays and pauses.

Times are ns since the bus was started; a character's time is the end of its stop bit, when a receiver has it.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from sisbus.playing.characters import Branch, Faults, Played, Sending, SentCharacter, Slot
from sisbus.playing.conducting import Exchange, Rate
from sisbus.stations.station import Station
from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.sis.initialization import Follow, RateChange
from sistap.tap.sis.telegram import is_whole


class Times(NamedTuple):
    """The times that the master sets with service 0x03, in ms."""

    trs: int  # slave reaction time
    tza: int  # character interval
    tmas: int  # cycle of the master control word

    @classmethod
    def for_line(cls, settings: LineSettings) -> Times:
        """Return times that the line can keep: TzA 5 ms, or four characters of a slow line."""
        tza = max(5, -(-4 * settings.character_ns // 1_000_000))
        return cls(10 * tza, tza, 100 * tza)


# -- Two masters that send at the same time: what a receiver hears ---------------------------------------------------

# Where both transmitters of an RS485 line send the same level, the line has it. Where they differ, the stronger one
# wins, at random. This applies to a parity bit, too.


def collide(sending: Sending, other: bytes, scatter: random.Random) -> None:
    """Mix the characters of another telegram, which begins within this one, into what is sent."""
    start = scatter.randrange(len(sending.slots))
    for place, value in enumerate(other, start=start):
        if place < len(sending.slots):
            sending.slots[place] = mixed = _mixed(sending.slots[place].value, value, scatter)
            mixed.flags = 0 if sending.settings.parity == "N" else mixed.flags
        else:
            sending.slots.append(Slot(value))
    sending.damage(f"collision@{start}={other.hex().upper()}")


def _mixed(one: int, other: int, scatter: random.Random) -> Slot:
    value = _either(one, other, 8, scatter)
    parity = _either(one.bit_count() & 1, other.bit_count() & 1, 1, scatter)
    return Slot(value, 0 if parity == value.bit_count() & 1 else int(Flag.CHARACTER_ERROR))


def _either(one: int, other: int, bits: int, scatter: random.Random) -> int:
    """Return the bits on which both agree; the others are random."""
    return one ^ ((one ^ other) & scatter.getrandbits(bits))


# -- The player ------------------------------------------------------------------------------------------------------

_MS = 1_000_000

Disturb = Callable[[Sending, int], Sending]  # with the time in ns


class Player:
    """The simulated line with its stations: sends telegrams, one after the other."""

    def __init__(  # noqa: PLR0913 - the line, its stations, and the faults
        self,
        settings: LineSettings,
        faults: Faults,
        seed: int,
        stations: Sequence[Station] = (),
        times: Times | None = None,
        disturb: Disturb = lambda sending, now_ns: sending,
    ) -> None:
        """Start at time 0 with a silent line; `disturb` changes what is sent, for all receivers."""
        self.settings = settings
        self.collided = False
        self._rate_since = 0
        self._follow = Follow(settings.baud)
        times = times or Times.for_line(settings)
        self._tza_ns = times.tza * _MS
        self._trs_ns = times.trs * _MS
        self._stations = stations
        self._disturb = disturb
        self._branch = Branch(faults, seed)
        # Separate random generators, so that faults change only what they disturb.
        self._timing = random.Random(f"{seed} timing")
        self._mixing = random.Random(f"{seed} mixing")
        self._now = 0  # nothing is sent earlier
        self._last_end = 0  # end of the last character

    @property
    def now_ns(self) -> int:
        """Return the time before which nothing more is sent."""
        return self._now

    def exchange(self, command: bytes, rival: bytes | None = None) -> Exchange:
        """Send a command, return its reaction, and wait as a master does before it continues."""
        self._go_to(self._follow.due(self._now))
        sending = self._disturb(Sending(command, self.settings), self._now)
        self.collided = sending.colliding and rival is not None
        if self.collided and rival:
            collide(sending, rival, self._mixing)
        yield from self._put(sending)
        commanded_ns = self._now
        reaction = None
        if not sending.damaged and is_whole(command):
            reactions = [station.react(command, self._now) for station in self._stations]  # a broadcast reaches all
            reaction = next((reaction for reaction in reactions if reaction), None)
            self._go_to(self._follow.take(command, self._now))  # a station that accepts alone answers at the new rate
        if reaction is not None:
            reaction = yield from self._answer(reaction, commanded_ns)
        if reaction is None:
            # The next command must wait until they could have answered.
            self._now = max(self._now, commanded_ns + self._trs_ns)
        self._now += self._tza_ns + self._timing.randrange(5 * _MS, 25 * _MS)
        return reaction

    def send(self, characters: bytes) -> Iterator[Played]:
        """Send characters that need no answer, then be silent for a while."""
        marks = [] if is_whole(characters) else ["ascii"]
        yield from self._put(self._disturb(Sending(characters, self.settings, marks=marks), self._now))
        self._now += self._trs_ns

    def type(self, characters: bytes) -> Iterator[Played]:
        """Send a line of the ASCII protocol, and what the drives say to it."""
        yield from self._put(Sending(characters, self.settings, marks=["ascii"]))
        terminals = [station.terminal for station in self._stations if station.terminal]
        said = [terminal.hear(value, self._now) for value in characters for terminal in terminals]
        for answer in filter(None, said):
            self._now += self._tza_ns + self._timing.randrange(2 * _MS, 12 * _MS)
            yield from self._put(Sending(answer, self.settings, marks=["ascii"]))
        self._now += self._tza_ns + self._timing.randrange(20 * _MS, 60 * _MS) if any(said) else self._trs_ns

    def wait(self, ns: int) -> None:
        """Let time pass."""
        self._now += ns

    def change(self, rate: Rate) -> None:
        """Continue at another rate: from the last character on, or from the given time."""
        if rate.after_ms:
            self._rate_since += rate.after_ms * _MS
            self._now = max(self._now, self._rate_since + self._trs_ns)  # timers are never exact
        else:
            self._rate_since = self._last_end
        self.settings = self.settings._replace(baud=rate.baud)

    def _answer(self, reaction: bytes, commanded_ns: int) -> Exchange:
        """Send a reaction; return what the master understands of it if it begins within TrS."""
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

    def _go_to(self, change: RateChange | None) -> None:
        """Continue at the rate that the bus was told."""
        if change:
            self.settings = self.settings._replace(baud=change.baud)

    def _put(self, sending: Sending) -> Iterator[Played]:
        """Send after what is on the line already."""
        if sending.before:
            noise = Sending(bytes(slot.value for slot in sending.before), self.settings, marks=["ascii"])
            noise.slots = sending.before
            yield self._sent(noise)
            self._now += 2 * self._tza_ns  # otherwise no start is recognised
        yield self._sent(sending)

    def _sent(self, sending: Sending) -> Played:
        self._branch.falsify(sending)
        characters: list[SentCharacter] = []
        for index, slot in enumerate(sending.slots):
            self._now += slot.pause_ns + self._interval(index, sending)
            if index == 0:
                time_ns = self._now
            arrived = self._branch.arrived(index, slot, self._now, sending.marks)
            if arrived is not None:
                characters.append(arrived)
        self._last_end = self._now
        return Played(time_ns, sending.sent, characters, sending.marks, sending.settings)

    def _interval(self, index: int, sending: Sending) -> int:
        """Return the interval in ns from the character before; most follow back to back."""
        character_ns = sending.settings.character_ns
        gap = int(character_ns * 0.2 * self._timing.random() ** 4)
        pause_ns = self._branch.pause(index, self._tza_ns, sending.marks)
        return character_ns + gap if pause_ns is None else pause_ns
