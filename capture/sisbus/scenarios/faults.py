# SPDX-License-Identifier: GPL-2.0-or-later
"""The faults on the line of a scenario: which telegram is disturbed, and how."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from sisbus.playing.characters import CHECKSUM, Sending, Slot
from sisbus.table import (
    BYTE,
    RATE,
    STATION,
    Table,
    characters,
    choice,
    milliseconds,
    number,
    octets,
    seconds,
    several,
    whole,
)
from sistap.tap.line.settings import Flag
from sistap.tap.sis.telegram import is_whole, parse

_EVER_NS = 1 << 62

Effect = Callable[[Sending, random.Random], None]
Place = Callable[[Sending, random.Random], int]


# -- How ------------------------------------------------------------------------------------------------------------


def _place(table: Table) -> Place:
    """Read which character to disturb; without the key any."""
    fixed = table.take("character", whole(0, 262), -1)

    def place(sending: Sending, scatter: random.Random) -> int:
        last = len(sending.slots) - 1
        return min(fixed, last) if fixed >= 0 else scatter.randint(0, last)

    return place


def _checksum(table: Table) -> Effect:
    def effect(sending: Sending, scatter: random.Random) -> None:
        sending.set_checksum(sending.sent[CHECKSUM] ^ scatter.randrange(1, 256))
        sending.marks.append(f"checksum@{CHECKSUM}")
        sending.damaged = True

    return effect


def _lost(table: Table) -> Effect:
    place = _place(table)

    def effect(sending: Sending, scatter: random.Random) -> None:
        at = place(sending, scatter)
        if len(sending.slots) <= 2:  # something must remain to be sent
            return
        del sending.slots[at]
        if at < len(sending.slots):  # the line is idle where the character would have been
            sending.slots[at].pause_ns += sending.settings.character_ns
        sending.marks.append(f"lost@{at}")
        sending.damaged = True

    return effect


def _extra(table: Table) -> Effect:
    place, added = _place(table), table.take("characters", octets, b"")

    def effect(sending: Sending, scatter: random.Random) -> None:
        at, values = place(sending, scatter), added or scatter.randbytes(1)
        sending.slots[at:at] = [Slot(value) for value in values]
        sending.marks.append(f"extra@{at}={values.hex().upper()}")
        sending.damaged = True

    return effect


def _pause(table: Table) -> Effect:
    """Read a pause. The receiver reads on (chapter 2.4), so it still understands."""
    place, ns = _place(table), table.need("ms", milliseconds)

    def effect(sending: Sending, scatter: random.Random) -> None:
        at = max(1, place(sending, scatter))
        sending.slots[at].pause_ns += ns
        sending.marks.append(f"pause@{at}")

    return effect


def _late(table: Table) -> Effect:
    ns = table.need("ms", milliseconds)

    def effect(sending: Sending, scatter: random.Random) -> None:
        sending.delay_ns += ns
        sending.marks.append("late")

    return effect


def _silent(table: Table) -> Effect:
    def effect(sending: Sending, scatter: random.Random) -> None:
        sending.silent = True

    return effect


def _parity(table: Table) -> Effect:
    place = _place(table)

    def effect(sending: Sending, scatter: random.Random) -> None:
        at = place(sending, scatter)
        slot = sending.slots[at]
        slot.value ^= 1 << scatter.randrange(8)
        if sending.settings.parity != "N":
            slot.flags |= Flag.CHARACTER_ERROR
        sending.marks.append(f"parity@{at}={slot.value:02X}")
        sending.damaged = True

    return effect


def _break(table: Table) -> Effect:
    place = _place(table)

    def effect(sending: Sending, scatter: random.Random) -> None:
        at = place(sending, scatter)
        sending.slots[at].value, sending.slots[at].flags = 0x00, int(Flag.BREAK)
        sending.marks.append(f"break@{at}")
        sending.damaged = True

    return effect


def _noise(table: Table) -> Effect:
    """Read noise on an idle line: any values, half of them with a wrong stop bit or parity."""
    count = table.take("count", whole(1, 4096), 4)

    def effect(sending: Sending, scatter: random.Random) -> None:
        errors = (0, int(Flag.CHARACTER_ERROR))
        sending.before += [Slot(scatter.randrange(256), scatter.choice(errors)) for _ in range(count)]

    return effect


def _ascii(table: Table) -> Effect:
    said = table.need("text", characters)

    def effect(sending: Sending, scatter: random.Random) -> None:
        sending.before += [Slot(value) for value in said]

    return effect


def _baud(table: Table) -> Effect:
    """Read a rate that no other station uses."""
    baud = table.need("baud", RATE)

    def effect(sending: Sending, scatter: random.Random) -> None:
        sending.settings = sending.settings._replace(baud=baud)
        sending.marks.append(f"baud={baud}")
        sending.damaged = True

    return effect


def _collision(table: Table) -> Effect:
    def effect(sending: Sending, scatter: random.Random) -> None:
        sending.colliding = True

    return effect


COMMAND, REACTION, TELEGRAM = "command", "reaction", "telegram"

# Maps a kind to its reader and to the telegrams it can affect, most usual first.
_KINDS: dict[str, tuple[Callable[[Table], Effect], Sequence[str]]] = {
    "checksum": (_checksum, (TELEGRAM, COMMAND, REACTION)),
    "lost": (_lost, (TELEGRAM, COMMAND, REACTION)),
    "extra": (_extra, (TELEGRAM, COMMAND, REACTION)),
    "pause": (_pause, (TELEGRAM, COMMAND, REACTION)),
    "late": (_late, (REACTION,)),
    "silent": (_silent, (REACTION,)),
    "parity": (_parity, (TELEGRAM, COMMAND, REACTION)),
    "break": (_break, (TELEGRAM, COMMAND, REACTION)),
    "noise": (_noise, (TELEGRAM, COMMAND, REACTION)),
    "ascii": (_ascii, (TELEGRAM, COMMAND, REACTION)),
    "baud": (_baud, (TELEGRAM, COMMAND, REACTION)),
    "collision": (_collision, (COMMAND,)),
}


# -- When -----------------------------------------------------------------------------------------------------------


@dataclass
class Fault:
    """One [[fault]] table."""

    kind: str
    effect: Effect
    of: str
    station: int | None  # the receiver of the command, which sends the reaction
    master: int | None
    service: int | None
    places: Sequence[int]  # which of the matching telegrams, counted from 1; none: all
    probability: float
    from_ns: int
    to_ns: int
    count: int = 0  # matching telegrams so far

    @classmethod
    def of_table(cls, table: Table) -> Fault:
        """Parse a table. ValueError names key and cure."""
        kind = table.need("kind", choice({name: name for name in _KINDS}))
        reading, telegrams = _KINDS[kind]
        fault = cls(
            kind,
            reading(table),
            table.take("of", choice({name: name for name in telegrams}), telegrams[0]),
            table.take("station", STATION, None),
            table.take("master", STATION, None),
            table.take("service", BYTE, None),
            table.take("which", several(whole(1, 1 << 31)), []),
            table.take("probability", number(0, 1), 1.0),
            table.take("from_s", seconds, 0),
            table.take("to_s", seconds, _EVER_NS),
        )
        table.end()
        return fault

    def meant(self, telegram: bytes, now_ns: int, scatter: random.Random) -> bool:
        """Tell whether it affects this telegram; call it once for each."""
        if not is_whole(telegram):
            return False
        header = parse(telegram)
        kind = REACTION if header.reaction else COMMAND
        wanted = (self.station, self.master, self.service)
        given = (header.receiver, header.sender, header.service)
        if (
            self.of not in (kind, TELEGRAM)
            or any(want not in (None, is_) for want, is_ in zip(wanted, given, strict=True))
            or not self.from_ns <= now_ns < self.to_ns
        ):
            return False
        self.count += 1
        return (not self.places or self.count in self.places) and scatter.random() < self.probability


@dataclass
class Switch(Fault):
    """A fault that acts while it is switched on. Switched off, it changes nothing that is random."""

    switched_on: set[str] = field(default_factory=set)  # kinds

    def meant(self, telegram: bytes, now_ns: int, scatter: random.Random) -> bool:
        """Tell whether it affects this telegram."""
        return self.kind in self.switched_on and super().meant(telegram, now_ns, scatter)


class Disturbances:
    """All faults of a line."""

    def __init__(self, faults: Sequence[Fault], seed: int) -> None:
        """Begin to count; the seed decides random values."""
        self._faults = [replace(fault) for fault in faults]
        self._scatter = random.Random(f"{seed} faults")

    def __call__(self, sending: Sending, now_ns: int) -> Sending:
        """Disturb what is sent, if a fault applies to it."""
        telegram = sending.sent
        for fault in self._faults:
            if fault.meant(telegram, now_ns, self._scatter):
                fault.effect(sending, self._scatter)
        return sending
