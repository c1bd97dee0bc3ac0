# SPDX-License-Identifier: GPL-2.0-or-later
"""The steps of a master's script in a scenario: each is a table with one key that names the action."""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from sisbus.devices.parameters import LAST
from sisbus.playing.conducting import Action, MasterLine, Raw, Script, Token, Typed, Wait
from sisbus.scenarios.bodies import BODIES, Body, access, operating_data, rate_mask
from sisbus.scenarios.demo import commands
from sisbus.stations.flash import CHECKSUMS, module
from sisbus.table import (
    BYTE,
    LONG,
    STATION,
    Misread,
    Table,
    ascii_text,
    choice,
    each,
    milliseconds,
    octets,
    several,
    whole,
)
from sistap.tap.sis.telegram import build, parse, status

_POLL_NS = 100_000_000  # interval between questions whether the phase is reached
_FALL_BACK_MS = 50  # silence until all have the old rate again: timers are not exact
_POLLS = 100  # after that many the master gives up
_PIECES = 1000  # more than a list of 64 KB has
_BLOCK = 240  # largest number of bytes of a flash program command (chapter 5.6)


@dataclass
class Master:
    """The master that plays a script, and the options of playing."""

    address: int
    line: MasterLine
    seed: int
    cycles: int  # passes of a loop, 0: endless
    rates: Sequence[int]  # rates to change to after each loop of the demo
    number: Iterator[int] = field(default_factory=lambda: itertools.cycle(range(1, 256)))


Step = Callable[[Master], Script]


@dataclass(frozen=True)
class Address:
    """The receiver of a command, and its telegram number."""

    receiver: int
    route: bytes
    number: int | None  # NEXT: a new one each time

    @classmethod
    def of(cls, table: Table) -> Address:
        """Read station, route and number."""
        receiver = table.need("station", whole(0, 255))
        route = table.take("route", lambda value: bytes(several(STATION)(value)), b"")
        return cls(receiver, route, table.take("number", _number, None))

    @property
    def last(self) -> int:
        """Return the address at the end of the route: the device, unless a step names another."""
        return self.route[-1] if self.route else self.receiver

    def command(self, master: Master, body: Body) -> bytes:
        """Return the telegram."""
        number = next(master.number) if self.number == NEXT else self.number
        return build(body.service, master.address, self.receiver, body.data, subaddresses=self.route, number=number)


NEXT = -1


def _number(value: object) -> int | None:
    return NEXT if value == "next" else BYTE(value)


def script(steps: Sequence[Step], master: Master) -> Script:
    """Play steps one after the other."""
    for play in steps:
        yield from play(master)


def step(table: Table) -> Step:
    """Read a step. ValueError names it, the key and the cure."""
    return _STEPS[table.one_of(list(_STEPS))](table)


# -- Steps of one telegram and its reaction -------------------------------------------------------------------------


def _command(table: Table) -> Step:
    """Read a command of one telegram."""
    address = Address.of(table)
    return _to(address, _body(table, address.last))


def _body(table: Table, device: int) -> Body:
    return BODIES[table.one_of(list(BODIES))](table, device)


def _list(table: Table) -> Step:
    """Read a list of services (chapter 7): each item is a step, without a receiver."""
    address = Address.of(table)
    bodies = table.need("list", each(f"{table.where}, list item", lambda item: _body(item, address.last)))
    return _to(address, Body(0x04, b"".join(bytes([1 + len(data), service]) + data for service, data in bodies)))


def _to(address: Address, body: Body) -> Step:
    return _says(lambda master: [address.command(master, body)])


def _says(actions: Callable[[Master], Iterable[Action]]) -> Step:
    """Return a step of actions that do not depend on what is answered."""

    def play(master: Master) -> Script:
        for action in actions(master):  # noqa: UP028 - an answer is sent to it
            yield action

    return play


def _raw(table: Table) -> Step:
    sent = Raw(table.need("raw", octets))
    return _says(lambda _: [sent])


def _type(table: Table) -> Step:
    """Type lines of the ASCII protocol, each with CR LF, as known clients do."""
    lines = [Typed(f"{line}\r\n".encode("ascii")) for line in table.need("type", several(ascii_text()))]
    return _says(lambda _: lines)


# -- Steps of several telegrams -------------------------------------------------------------------------------------


def _read(table: Table) -> Step:
    """Read an element; the same command asks for the next piece while more follows (chapter 8.4)."""
    address = Address.of(table)
    body = Body(0x10, access(table, "read", address.last))

    def play(master: Master) -> Script:
        for _ in range(_PIECES):
            reaction = yield address.command(master, body)
            if not _good(reaction) or _body_of(reaction)[1] & LAST:
                return

    return play


def _write(table: Table) -> Step:
    """Write an element, in pieces if required: all but the last say that more follows."""
    address = Address.of(table)
    where, data = access(table, "write", address.last), operating_data(table)
    size = table.take("piece", whole(1, 240), max(1, len(data)))
    pieces = [data[start : start + size] for start in range(0, len(data), size)] or [b""]

    def play(master: Master) -> Script:
        for place, piece in enumerate(pieces, start=1):
            control = where[0] if place == len(pieces) else where[0] & ~LAST
            reaction = yield address.command(master, Body(0x1F, bytes([control]) + where[1:] + piece))
            if not _good(reaction):
                return

    return play


def _switch(table: Table) -> Step:
    """Switch the phase and ask until it is reached: the reaction acknowledges only the command (chapter 8.7)."""
    address = Address.of(table)
    phase = table.need("switch", BYTE)

    def play(master: Master) -> Script:
        reaction = yield address.command(master, Body(0x1D, bytes([phase])))
        for _ in range(_POLLS):
            if not _good(reaction) or _body_of(reaction)[1:] == bytes([phase]):
                return
            yield Wait(_POLL_NS)
            reaction = yield address.command(master, Body(0x12, b""))

    return play


def _download(table: Table) -> Step:
    """Program a module of that many bytes, block by block, until one is refused (chapter 5.6); the seed decides its
    contents.
    """
    address = Address.of(table)
    start, length = table.need("download", LONG), table.need("length", whole(CHECKSUMS + 2, 1 << 24))
    device_type = table.take("device_type", BYTE, 4)
    device = table.take("device", BYTE, address.last)

    def play(master: Master) -> Script:
        data = module(random.Random(f"{master.seed} download").randbytes((length - CHECKSUMS) & ~1))
        for offset in range(0, len(data), _BLOCK):
            where = (start + offset).to_bytes(4, "little") + bytes([device_type])
            body = bytes([device, 0x96]) + where + data[offset : offset + _BLOCK]
            reaction = yield address.command(master, Body(0x02, body))
            if not _good(reaction):
                return

    return play


def _good(reaction: bytes | None) -> bool:
    return reaction is not None and status(parse(reaction)) == 0


def _body_of(reaction: bytes | None) -> bytes:
    return parse(reaction).body if reaction else b""


# -- Steps that only say when, or who ---------------------------------------------------------------------------------


def _wait(table: Table) -> Step:
    wait = Wait(table.need("wait_ms", milliseconds))
    return _says(lambda _: [wait])


def _until(table: Table) -> Step:
    time_ns = table.need("at_ms", milliseconds)
    return _says(lambda master: [Wait(max(0, time_ns - master.line.now_ns))])


def _repeat(table: Table) -> Step:
    times = table.need("times", whole(1, 1_000_000))
    return _passes(table, "repeat", lambda _: times)


def _passes(table: Table, key: str, count: Callable[[Master], int]) -> Step:
    """Read steps that are repeated; each pass begins `every_ms` after the one before."""
    steps = table.need(key, each(f"{table.where}, {key} step", step))
    every_ns = table.take("every_ms", milliseconds, 0)
    if not _sends(table.need(key, lambda value: value)):
        raise Misread(f"{table.where}: {key} sends nothing; give it a step that does")

    def play(master: Master) -> Script:
        passes = count(master)
        for _ in range(passes) if passes else itertools.count():
            begun = master.line.now_ns
            yield from script(steps, master)
            yield Wait(max(0, begun + every_ns - master.line.now_ns))

    return play


def _sends(content: object) -> bool:
    """Tell whether a step takes time in any case: otherwise a loop would never end."""
    if isinstance(content, Mapping):
        silent = {"wait_ms", "at_ms", "repeat", "loop"}
        return any(key in _STEPS.keys() - silent for key in content) or _sends(list(content.values()))
    return isinstance(content, list) and any(map(_sends, content))


def _test_rate(table: Table) -> Step:
    """Test a rate for a time (chapter 6.6): play the steps at that rate, then return to the old one."""
    address = Address.of(table)
    mask = table.need("test_rate", rate_mask)
    ms = table.need("ms", whole(1, 0xFFFF))
    steps = table.need("steps", each(f"{table.where}, step", step))
    device = table.take("device", BYTE, address.last)
    body = Body(0x03, bytes([device, 0x08]) + ms.to_bytes(2, "little") + mask)

    def play(master: Master) -> Script:
        reaction = yield address.command(master, body)
        over_ns = master.line.now_ns + (ms + _FALL_BACK_MS) * 1_000_000
        if not _good(reaction):
            return
        yield from script(steps, master)
        yield Wait(max(0, over_ns - master.line.now_ns))

    return play


def _token(table: Table) -> Step:
    receiver = table.need("token", STATION)
    # The specification reserves the service without contents, so it has none.
    return _says(lambda master: [Token(receiver, build(0x0F, master.address, receiver))])


def _demo(table: Table) -> Step:
    """Play the script of the demo's master, which is Python (demo.py), with varying values."""
    table.need("play", choice({"demo": 0}))
    return lambda master: commands(master.line.settings, master.seed, master.cycles, master.rates)


_STEPS: dict[str, Callable[[Table], Step]] = {
    **dict.fromkeys(BODIES, _command),
    "read": _read,
    "write": _write,
    "switch": _switch,
    "list": _list,
    "download": _download,
    "raw": _raw,
    "type": _type,
    "wait_ms": _wait,
    "at_ms": _until,
    "repeat": _repeat,
    "loop": lambda table: _passes(table, "loop", lambda master: master.cycles),
    "test_rate": _test_rate,
    "token": _token,
    "play": _demo,
}
