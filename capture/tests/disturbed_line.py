# SPDX-License-Identifier: GPL-2.0-or-later
"""A line between two partners of procedure 3964R that disturbs some of what they send; its time is simulated.

Taps hear what arrives. What the line does deceives nobody. A block that loses 00 or a pair 10 10, for example, keeps
its BCC, and an STX that becomes DLE is an answer: no partner and no tap can see that.
"""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Callable
from typing import NamedTuple, Protocol

from foreign_partner import DLE, STX, ZVZ_MS, Receiver

CHARACTER_NS = 1_145_833  # 9600 Bd, 11 bits
CHARACTER_MS = CHARACTER_NS / 1e6
LONGEST_ANSWER = 6  # characters


class Partner(Protocol):
    """One end of the line."""

    def say(self) -> bytes: ...
    def hear(self, character: int) -> None: ...
    def wait(self, ms: float) -> None: ...


class Said(NamedTuple):
    """What a side meant to send at once."""

    side: int
    data: bytes
    whole: bool  # it arrives that way, without a pause above ZVZ


class Slot(NamedTuple):
    """A character on the line."""

    pause: int  # before it, in characters
    value: int | None  # None: it does not arrive


Slots = list[Slot]


def _noise(slots: Slots) -> tuple[int, ...]:
    return (0x03, 0xFF) if len(slots) == 1 else (0x03, 0xFF, 0x02, 0x10, 0x15)


def _change(slots: Slots, chance: random.Random) -> None:
    place = chance.randrange(len(slots))
    value = slots[place].value
    slots[place] = Slot(0, chance.choice([other for other in _noise(slots) if other != value]))


def _lose(slots: Slots, chance: random.Random) -> None:
    place = chance.randrange(len(slots))
    for at in range(place, min(place + chance.choice((1, 1, 5)), len(slots))):
        slots[at] = Slot(0, None)


def _insert(slots: Slots, chance: random.Random) -> None:
    slots.insert(chance.randint(0, len(slots)), Slot(0, chance.choice(_noise(slots))))


def _stop(slots: Slots, chance: random.Random) -> None:
    del slots[chance.randrange(len(slots)) :]


def _wait(slots: Slots, chance: random.Random) -> None:
    """Pause: in a block shorter or longer than ZVZ, before it or a handshake longer than QVZ.

    A block that begins with STX and a pause looks like two requests: nobody would wait there.
    """
    place = chance.randrange(len(slots))
    place += place == 1 and slots[0].value == STX
    pause_ms = chance.choice((30, 150, 300) if place else (150, 2100))
    slots[place] = slots[place]._replace(pause=int(pause_ms / CHARACTER_MS))


FAULTS: tuple[Callable[[Slots, random.Random], None], ...] = (_change, _lose, _insert, _stop, _wait)


def _deceives(said: bytes, slots: Slots) -> bool:
    """Tell whether a receiver takes anything else than the block for good, even after it has refused the block."""
    receiver: Receiver | None = Receiver()
    for place, (pause, value) in enumerate(slots):
        if pause * CHARACTER_MS > ZVZ_MS:
            receiver = None
        if receiver is None:
            receiver = Receiver() if value == STX else None
        elif value is not None and (good := receiver.take(value)) is not None:
            if good:
                return bytes(slot.value for slot in slots[: place + 1] if slot.value is not None) != said
            receiver = None
    return False


class DisturbedLine:
    """The line. `tap` is told the side, the time in ns and the value of each character that arrives."""

    def __init__(
        self, sides: tuple[Partner, Partner], chance: random.Random, tap: Callable[[int, int, int], None], errors: float
    ) -> None:
        self.now_ns = 0
        self.said: list[Said] = []
        self._sides = sides
        self._chance = chance
        self._tap = tap
        self._errors = errors
        self._saying: list[int | None] = [None, None]  # a handshake
        self._coming: tuple[deque[Slot], deque[Slot]] = (deque(), deque())
        self._unheard: tuple[deque[int], deque[int]] = (deque(), deque())  # another request while a side asks

    def step(self) -> None:
        """Let the time of one character pass."""
        self.now_ns += CHARACTER_NS
        arrived = [(side, value) for side in (0, 1) if (value := self._next(side)) is not None]
        for side, value in arrived:
            self._tap(side, self.now_ns, value)
            if not self._coming[1 - side] or value == self._saying[1 - side] == STX:
                self._unheard[1 - side].append(value)
        for side, partner in enumerate(self._sides):
            while self._unheard[side] and not self._coming[side]:
                partner.hear(self._unheard[side].popleft())
                self._say(side)
            if not self._coming[side]:
                partner.wait(CHARACTER_MS)
                self._say(side)

    def _next(self, side: int) -> int | None:
        coming = self._coming[side]
        if coming and coming[0].pause:
            coming[0] = coming[0]._replace(pause=coming[0].pause - 1)
            return None
        return coming.popleft().value if coming else None

    def _say(self, side: int) -> None:
        said = self._sides[side].say()
        if not said:
            return
        slots = self._on_the_way(said)
        whole = [slot.value for slot in slots] == list(said) and all(
            slot.pause < ZVZ_MS / CHARACTER_MS for slot in slots
        )
        self.said.append(Said(side, said, whole))
        self._saying[side] = said[0] if len(said) == 1 else None
        if slots:
            answer = self._chance.randrange(LONGEST_ANSWER)
            slots[0] = slots[0]._replace(pause=slots[0].pause + answer)
        self._coming[side].extend(slots)

    def _on_the_way(self, said: bytes) -> Slots:
        meant = [Slot(0, value) for value in said]
        if self._chance.random() >= self._errors:
            return meant
        while True:
            slots = meant.copy()
            self._chance.choice(FAULTS)(slots, self._chance)
            if len(said) == 1 or not _deceives(said, slots):
                return slots

    def whole_blocks(self, side: int) -> list[bytes]:
        """Return the blocks of a side that were asked for, granted, sent and acknowledged without a disturbance."""
        ask, grant, other = Said(side, bytes([STX]), True), Said(1 - side, bytes([DLE]), True), 1 - side
        return [
            said.data
            for (asked, granted, said, then) in zip(
                self.said, self.said[1:], self.said[2:], self.said[3:], strict=False
            )
            if (asked, granted) == (ask, grant)
            and said.side == side
            and said.whole
            and then[:2] == (other, bytes([DLE]))
        ]
