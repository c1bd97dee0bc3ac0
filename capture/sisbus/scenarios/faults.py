# SPDX-License-Identifier: GPL-2.0-or-later
"""The faults on the line of a scenario: which telegram is disturbed, and how."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from sisbus.playing.characters import CHECKSUM, Sending, Slot
from sisbus.table import (
    BYTE,
    RATE,
    STATION,
    Reading,
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

COMMAND, REACTION, TELEGRAM = "command", "reaction", "telegram"


# -- How: each changes what is sent, by random numbers, at a character and by an amount, where a kind has them ---------


def _checksum(sending: Sending, scatter: random.Random) -> None:
    sending.set_checksum(sending.sent[CHECKSUM] ^ scatter.randrange(1, 256))
    sending.damage(f"checksum@{CHECKSUM}")


def _lost(sending: Sending, scatter: random.Random, at: int) -> None:
    if len(sending.slots) <= 2:  # something must remain to be sent
        return
    del sending.slots[at]
    if at < len(sending.slots):  # the line is idle where the character would have been
        sending.slots[at].pause_ns += sending.settings.character_ns
    sending.damage(f"lost@{at}")


def _extra(sending: Sending, scatter: random.Random, at: int, added: bytes) -> None:
    values = added or scatter.randbytes(1)
    sending.slots[at:at] = [Slot(value) for value in values]
    sending.damage(f"extra@{at}={values.hex().upper()}")


def _pause(sending: Sending, scatter: random.Random, at: int, ns: int) -> None:
    at = max(1, at)  # a receiver reads on (chapter 2.4): it still understands
    sending.slots[at].pause_ns += ns
    sending.marks.append(f"pause@{at}")


def _late(sending: Sending, scatter: random.Random, ns: int) -> None:
    sending.delay_ns += ns
    sending.marks.append("late")


def _silent(sending: Sending, scatter: random.Random) -> None:
    sending.silent = True


def _parity(sending: Sending, scatter: random.Random, at: int) -> None:
    slot = sending.slots[at]
    slot.value ^= 1 << scatter.randrange(8)
    if sending.settings.parity != "N":
        slot.flags |= Flag.CHARACTER_ERROR
    sending.damage(f"parity@{at}={slot.value:02X}")


def _break(sending: Sending, scatter: random.Random, at: int) -> None:
    sending.slots[at].value, sending.slots[at].flags = 0x00, int(Flag.BREAK)
    sending.damage(f"break@{at}")


def _noise(sending: Sending, scatter: random.Random, count: int) -> None:
    """Add any values on an idle line, half of them with a wrong stop bit or parity."""
    errors = (0, int(Flag.CHARACTER_ERROR))
    sending.before += [Slot(scatter.randrange(256), scatter.choice(errors)) for _ in range(count)]


def _ascii(sending: Sending, scatter: random.Random, said: bytes) -> None:
    sending.before += [Slot(value) for value in said]


def _baud(sending: Sending, scatter: random.Random, baud: int) -> None:
    """Send at a rate that no other station uses."""
    sending.settings = sending.settings._replace(baud=baud)
    sending.damage(f"baud={baud}")


def _collision(sending: Sending, scatter: random.Random) -> None:
    sending.colliding = True


class _Kind(NamedTuple):
    """A kind of fault."""

    effect: Callable[..., None]
    of: Sequence[str] = (TELEGRAM, COMMAND, REACTION)  # what it can affect, most usual first
    at_character: bool = False  # any, without the key `character`
    amount: tuple[str, Reading[Any]] | None = None  # its key, and how to read that
    usual: Any = None  # the amount without the key; None: the key is needed


_KINDS = {
    "checksum": _Kind(_checksum),
    "lost": _Kind(_lost, at_character=True),
    "extra": _Kind(_extra, at_character=True, amount=("characters", octets), usual=b""),
    "pause": _Kind(_pause, at_character=True, amount=("ms", milliseconds)),
    "late": _Kind(_late, (REACTION,), amount=("ms", milliseconds)),
    "silent": _Kind(_silent, (REACTION,)),
    "parity": _Kind(_parity, at_character=True),
    "break": _Kind(_break, at_character=True),
    "noise": _Kind(_noise, amount=("count", whole(1, 4096)), usual=4),
    "ascii": _Kind(_ascii, amount=("text", characters)),
    "baud": _Kind(_baud, amount=("baud", RATE)),
    "collision": _Kind(_collision, (COMMAND,)),
}


# -- When -----------------------------------------------------------------------------------------------------------


@dataclass
class Fault:
    """One [[fault]] table."""

    kind: str
    character: int  # -1: any
    amount: Any
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
        name = table.need("kind", choice({name: name for name in _KINDS}))
        kind = _KINDS[name]
        return cls(
            name,
            table.take("character", whole(0, 262), -1) if kind.at_character else -1,
            _amount(table, kind),
            table.take("of", choice({name: name for name in kind.of}), kind.of[0]),
            table.take("station", STATION, None),
            table.take("master", STATION, None),
            table.take("service", BYTE, None),
            table.take("which", several(whole(1, 1 << 31)), []),
            table.take("probability", number(0, 1), 1.0),
            table.take("from_s", seconds, 0),
            table.take("to_s", seconds, _EVER_NS),
        )

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

    def disturb(self, sending: Sending, scatter: random.Random) -> None:
        """Change what is sent."""
        kind, last = _KINDS[self.kind], len(sending.slots) - 1
        given: list[Any] = []
        if kind.at_character:
            given.append(min(self.character, last) if self.character >= 0 else scatter.randint(0, last))
        if kind.amount:
            given.append(self.amount)
        kind.effect(sending, scatter, *given)


def _amount(table: Table, kind: _Kind) -> Any:  # noqa: ANN401
    if kind.amount is None:
        return None
    return table.need(*kind.amount) if kind.usual is None else table.take(*kind.amount, kind.usual)


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
                fault.disturb(sending, self._scatter)
        return sending
