# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenarios of procedure 3964R: the tables [s5], [ppc] and [[fault]]."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from sisbus.devices.parameters import ident
from sisbus.playing.characters import Faults, Played
from sisbus.playing.conducting import Wait
from sisbus.procedure3964 import controls, rk512
from sisbus.procedure3964.controls import S5, ControlMemory, Ppc, Script, Step
from sisbus.procedure3964.link import BOTH, Link
from sisbus.procedure3964.partner import Disturb, Occasion, Partner, Trouble
from sisbus.procedure3964.rk512 import Head
from sisbus.table import (
    BYTE,
    WORD,
    Misread,
    Table,
    choice,
    each,
    milliseconds,
    octets,
    several,
    text,
    whole,
)
from sistap.tap.line.settings import LineSettings

_AXIS = whole(0, 40)
_NTH = whole(1, 1 << 31)
_LARGE = 1024  # bytes; a longer list is a "current transmission"
_PAUSE_MS = 20
_PRIORITY = choice({"high": True, "low": False})


@dataclass
class LinkFault:
    """One [[fault]] table: what happens the n-th time that one of the two sends something."""

    side: str
    occasion: Occasion
    trouble: Trouble
    which: Sequence[int]


@dataclass(frozen=True)
class Procedure:
    """The contents of a file. It can be played again and again."""

    duplex: bool
    has_ppc: bool
    s5_high: bool  # if both request, the S5 goes first
    steps: Sequence[Step]  # empty without an S5
    parameters: Mapping[tuple[int, bytes], bytes]
    lists: frozenset[tuple[int, bytes]]
    blocks: Mapping[int, bytes]
    reaction_ns: int
    slow_ns: Mapping[int, int]
    faults: Sequence[LinkFault]

    def play(  # noqa: PLR0913 - the options of playing a scenario
        self, settings: LineSettings, seed: int, cycles: int, tap_faults: Faults, end_ns: float
    ) -> Iterator[Played]:
        """Play the script that often; 0 means endlessly."""
        return Link(settings, self.duplex, self.s5(seed, cycles), self.ppc(), tap_faults, seed).play(end_ns)

    def s5(self, seed: int, cycles: int) -> S5:
        """Return the S5, which plays the script that often."""
        partner = Partner(high=self.s5_high, disturb=self._disturb("s5"))
        return S5(partner, self._script(cycles), random.Random(f"{seed} master"))

    def ppc(self) -> Ppc:
        """Return the PPC, as it is after power-on."""
        memory = ControlMemory(dict(self.parameters), self.lists, dict(self.blocks))
        partner = Partner(high=not self.s5_high, disturb=self._disturb("ppc"))
        return Ppc(partner, memory, self.reaction_ns, self.slow_ns)

    def _script(self, cycles: int) -> Script:
        passed = 0
        while not cycles or passed < cycles:
            passed += 1
            for step in self.steps:
                yield from step()

    def _disturb(self, side: str) -> Disturb:
        said: Counter[Occasion] = Counter()

        def disturb(occasion: Occasion) -> Trouble | None:
            said[occasion] += 1
            meant = [fault for fault in self.faults if (fault.side, fault.occasion) == (side, occasion)]
            return next((fault.trouble for fault in meant if said[occasion] in fault.which), None)

        return disturb


# -- Reading --------------------------------------------------------------------------------------------------------


def read(table: Table, duplex: bool, faults: Sequence[LinkFault]) -> Procedure:
    """Read [s5] and [ppc] of a scenario: both, or one whose partner is real. ValueError names the key and the cure."""
    has_s5, has_ppc = "s5" in table, "ppc" in table
    master = table.take("s5", lambda value: Table(value, "[s5]"), Table({}, "[s5]"))
    slave = table.take("ppc", lambda value: Table(value, "[ppc]"), Table({}, "[ppc]"))
    parameters = slave.each("parameter", "[[ppc.parameter]]", _parameter)
    procedure = Procedure(
        duplex,
        has_ppc,
        master.take("priority", _PRIORITY, True) if has_s5 else not slave.take("priority", _PRIORITY, False),
        master.need("script", each("[s5], step", _step)) if has_s5 else [],
        {place: data for place, data, _ in parameters},
        frozenset(place for place, _, is_list in parameters if is_list),
        dict(slave.each("block", "[[ppc.block]]", lambda block: (block.need("number", BYTE), _data(block)))),
        slave.take("reaction_ms", milliseconds, _PAUSE_MS * 1_000_000),
        dict(slave.each("slow", "[[ppc.slow]]", _slow)),
        faults,
    )
    if has_s5 and not procedure.steps:
        raise ValueError("[s5]: script is empty: add a step")
    if faults and not (has_s5 and has_ppc):
        raise ValueError("sistap does not disturb a real line: [[fault]] needs [s5] and [ppc]")
    master.end()
    slave.end()
    return procedure


def _parameter(table: Table) -> tuple[tuple[int, bytes], bytes, bool]:
    head = _head(table, "ident", write=False)
    is_list = "list" in table
    data = _elements(table.need("list", octets)) if is_list else _data(table)
    return (head.axis, head.parameter), data, is_list


def _slow(table: Table) -> tuple[int, int]:
    return table.need("command", _NTH), table.need("ms", milliseconds)


def _head(table: Table, key: str, *, write: bool, last: bool = True) -> Head:
    axis = table.take("axis", _AXIS, 0)
    return table.need(key, lambda value: Head.of(_ident(value), axis, write=write, last=last))


def _ident(value: object) -> str:
    ident(text(value))
    return text(value)


def _data(table: Table) -> bytes:
    """Read whole words, high byte first."""
    key = table.one_of(["word", "value", "data"])
    if key == "data":
        data = table.need(key, octets)
        if not data or len(data) % 2:
            raise Misread(f"{table.where}: data has {len(data)} bytes: use whole words")
        return data
    size = 2 if key == "word" else 4
    return table.need(key, whole(0, (1 << 8 * size) - 1)).to_bytes(size, "big")


def _elements(elements: bytes) -> bytes:
    """Put the length words before the elements of a list."""
    return 2 * len(elements).to_bytes(2, "big") + elements


# -- Steps ----------------------------------------------------------------------------------------------------------


def _step(table: Table) -> Step:
    return _STEPS[table.one_of(list(_STEPS))](table)


def _read(table: Table) -> Step:
    head, words = _head(table, "read", write=False), table.take("words", WORD, 1)
    return lambda: controls.fetch(0, words, head)


def _read_list(table: Table) -> Step:
    head = _head(table, "read_list", write=False)
    return lambda: controls.fetch_list(head)


def _write(table: Table) -> Step:
    head, data = _head(table, "write", write=True), _data(table)
    return lambda: controls.send([(0, bytes(head) + data)])


def _write_points(table: Table) -> Step:
    """Read a cam: points of four bytes with its own number as value, in as many data blocks as an S5 needs."""
    points = table.need("points", whole(1, 4000))
    data = _elements(b"".join(point.to_bytes(4, "big") for point in range(1, points + 1)))
    head = _head(table, "write_points", write=True, last=len(data) <= _LARGE)
    return lambda: controls.send(rk512.blocks(bytes(head) + data))


def _read_block(table: Table) -> Step:
    number, words = table.need("read_block", BYTE), table.take("words", WORD, 1)
    return lambda: controls.fetch(number, words)


def _write_block(table: Table) -> Step:
    number, data = table.need("write_block", BYTE), _data(table)
    return lambda: controls.send([(number, data)])


def _wait(table: Table) -> Step:
    wait = Wait(table.need("wait_ms", milliseconds))

    def step() -> Script:
        yield wait

    return step


_STEPS: Mapping[str, Callable[[Table], Step]] = {
    "read": _read,
    "read_list": _read_list,
    "write": _write,
    "write_points": _write_points,
    "read_block": _read_block,
    "write_block": _write_block,
    "wait_ms": _wait,
}


# -- Faults ---------------------------------------------------------------------------------------------------------

# Maps a kind to the occasions it can affect.
_KINDS: Mapping[str, Sequence[Occasion]] = {
    "refused": (Occasion.GRANT,),
    "unheard": (Occasion.GRANT,),
    "lost": (Occasion.ACKNOWLEDGE, Occasion.GRANT),
    "late": (Occasion.GRANT, Occasion.ACKNOWLEDGE),
    "bcc": (Occasion.BLOCK,),
    "broken": (Occasion.BLOCK,),
    BOTH: (Occasion.ASK,),
}
_NUMBERS = {"late": ("ms", milliseconds), "broken": ("character", whole(1, 4096))}


def fault(table: Table) -> LinkFault:
    """Read a table [[fault]]. ValueError names the key and the cure."""
    kind = table.need("kind", choice({name: name for name in _KINDS}))
    occasions = _KINDS[kind]
    side = "ppc" if kind == BOTH else table.need("of", choice({"s5": "s5", "ppc": "ppc"}))
    occasion = occasions[0]
    if len(occasions) > 1:
        occasion = table.take("answer", choice({one.value: one for one in occasions}), occasion)
    amount = table.need(*_NUMBERS[kind]) if kind in _NUMBERS else 0
    return LinkFault(side, occasion, Trouble(kind, amount), table.need("which", several(_NTH)))
