# SPDX-License-Identifier: GPL-2.0-or-later
"""Conversations of procedure 3964R on a disturbed line: what a tap shows of them, and how ours gets through them.

The truth is known: a block is shown as good only if it was sent that way (or its receiver took it for one), and each
block that was asked for, granted, sent and acknowledged without a disturbance is shown.
"""

from __future__ import annotations

import os
import random
import select
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from disturbed_line import DisturbedLine
from foreign_partner import Commander, ForeignPartner, Receiver, Servant, block_of
from hypothesis import given
from hypothesis import strategies as st
from meeting_bus import VALUES, axes, command_of, ppc, s5
from portable import terminals

from sisbus.procedure3964.controls import S5, Ppc
from sisbus.procedure3964.partner import Saying
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.cut import PROCEDURE_3964R
from sistap.tap.records.record import Record

ERRORS = 0.12  # of all that is said
SPEED = 20  # times real time, at a terminal
LONGEST_STEP_NS = 20_000_000
BUS = Path(__file__).with_name("meeting_bus.py")
START_NS = 1_700_000_000_000_000_000
SETTINGS = LineSettings(9600)
TRICKY = b"\x00\x02\x02\x02\x03\x10\x15\xff"


class Tap:
    """A full-duplex tap."""

    def __init__(self, uncertainty_ns: int = 0) -> None:
        self._framers = {line: PROCEDURE_3964R.framer(line, SETTINGS) for line in (1, 2)}
        self._uncertainty_ns = uncertainty_ns
        self.heard: dict[int, bytearray] = {1: bytearray(), 2: bytearray()}
        self.records: list[Record] = []

    def __call__(self, side: int, time_ns: int, value: int) -> None:
        line = side + 1
        self.heard[line].append(value)
        read = Read(line, START_NS + time_ns, bytes([value]), b"\0", self._uncertainty_ns)
        self.records += self._framers[line].feed(read) + self._framers[3 - line].beside(read)

    def end(self) -> None:
        for line, framer in self._framers.items():
            self.records += framer.flush()
            assert self.heard[line] == b"".join(record.data for record in self.records if record.line == line)

    def good_blocks(self, side: int) -> list[bytes]:
        mine = (record for record in self.records if record.line == side + 1)
        return [record.data for record in mine if record.is_good_frame and len(record.data) > 1]


def judge(tap: Tap, line: DisturbedLine, came: tuple[list[bytes], list[bytes]]) -> int:
    """Compare what a tap shows with the truth; `came` is what each side took for good.

    Return how often a side erred.
    """
    tap.end()
    deceived = 0
    for side in (0, 1):
        shown, taken = tap.good_blocks(side), [block_of(data) for data in came[1 - side]]
        sent = {said.data for said in line.said if said.side == side}
        assert set(shown) <= sent.union(taken)
        assert not Counter(line.whole_blocks(side)) - Counter(shown)
        deceived += sum(block not in sent for block in taken)
    return deceived


def blocks(chance: random.Random, count: int) -> Iterator[bytes]:
    """Yield data of blocks. Many have a part with a right BCC."""
    for _ in range(count):
        tricky = bytes(chance.choices(TRICKY, k=chance.randint(1, 30)))
        yield b"\x02\x02" * chance.randint(0, 2) + tricky + chance.randbytes(chance.randint(0, 5))


def converse(seed: int, commands: int, uncertainty_ns: int = 0) -> None:
    """Let two foreign partners exchange random blocks."""
    chance = random.Random(seed)
    high = chance.random() < 0.5
    master = Commander(blocks(chance, commands), high=high)
    servant = Servant(lambda _: next(blocks(chance, 1)), high=not high)
    tap = Tap(uncertainty_ns)
    line = DisturbedLine((master, servant), chance, tap, ERRORS)
    while not master.over:
        line.step()
    judge(tap, line, (master.came, servant.came))


@pytest.mark.parametrize("seed", range(5))
def test_only_what_was_sent_is_shown(seed: int) -> None:
    converse(seed, 20)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(40))
@pytest.mark.parametrize("uncertainty_ns", [0, 500_000])
def test_only_what_was_sent_is_shown_for_long(seed: int, uncertainty_ns: int) -> None:
    converse(1000 + seed, 50, uncertainty_ns)


# -- The virtual bus and a partner of other make ---------------------------------------------------------------------


class Ours:
    """A side of the virtual bus."""

    def __init__(self, station: S5 | Ppc) -> None:
        self.came: list[bytes] = []
        self._station = station
        self._now_ns = 0
        self._out = bytearray()

    def say(self) -> bytes:
        said, self._out = bytes(self._out), bytearray()
        return said

    def hear(self, character: int) -> None:
        self._take(self._station.partner.hear(character, self._now_ns))
        self.came += self._station.partner.received
        self._station.look(self._now_ns)

    def wait(self, ms: float) -> None:
        self._now_ns += int(ms * 1e6)
        self._station.look(self._now_ns)
        self._take(self._station.partner.look(self._now_ns))

    def _take(self, saying: Saying | None) -> None:
        if saying:
            self._out += saying.said
            self._station.partner.said(self._now_ns)


def reaction_to(command: bytes) -> bytes:
    """React as a PPC; an axis that it does not have is error 14 hex."""
    value = VALUES.get(command[12]) if len(command) == 16 else None
    return bytes(4) + value if value else b"\0\0\0\x14"


def settle(asked: list[int], outcomes: list[bytes | None], deceived: int) -> int:
    """Check each answer but those of deceived receivers; return how many commands were given up."""
    assert len(outcomes) == len(asked)
    answers = [(axis, outcome) for axis, outcome in zip(asked, outcomes, strict=True) if outcome]
    assert sum(outcome != bytes(4) + VALUES[axis] for axis, outcome in answers) <= deceived
    return len(asked) - len(answers)


def meet(role: str, seed: int, count: int, *, high: bool, errors: float = ERRORS) -> int:
    """Let a foreign S5 ask our PPC, or our S5 a foreign PPC. Return how many commands were given up."""
    asked, tap = axes(seed, count), Tap()
    outcomes: list[bytes | None] = []
    station = s5(seed, count, outcomes, high=high) if role == "ppc" else ppc(high=not high)
    commander = Commander(map(command_of, asked), high=high)
    foreign = commander if role == "s5" else Servant(reaction_to, high=not high)
    ours = Ours(station)
    line = DisturbedLine((ours, foreign), random.Random(seed), tap, errors)
    while not (commander.over if role == "s5" else station.over):
        line.step()
    deceived = judge(tap, line, (ours.came, foreign.came))
    assert errors or not foreign.errors
    return settle(asked, commander.outcomes if role == "s5" else outcomes, deceived)


ROLES = pytest.mark.parametrize("role", ["s5", "ppc"])
PRIORITY = pytest.mark.parametrize("high", [True, False], ids=["high", "low"])


@ROLES
@PRIORITY
def test_a_foreign_partner_and_ours(role: str, high: bool) -> None:
    """At least 50 blocks. Hardly ever is a command disturbed so often that it is given up."""
    assert meet(role, 3964, 25, high=high, errors=0) == 0
    assert meet(role, 3964, 25, high=high) < 2


@pytest.mark.thorough
@ROLES
@PRIORITY
@pytest.mark.parametrize("seed", range(2))
def test_a_foreign_partner_and_ours_for_long(role: str, high: bool, seed: int) -> None:
    assert meet(role, seed, 500, high=high) < 20


@given(st.binary(min_size=10, max_size=200))
def test_any_block_comes_over(data: bytes) -> None:
    """What is not a command of RK512 is answered, too."""
    foreign = Commander([data])
    line = DisturbedLine((Ours(ppc(high=False)), foreign), random.Random(1), Tap(), 0)
    while not foreign.over:
        line.step()
    assert foreign.outcomes[0]
    assert foreign.outcomes[0][0] in (0x00, 0xFF)
    assert foreign.errors == []


# -- The same at a pseudo terminal -----------------------------------------------------------------------------------


class AtTerminal:
    """A side of the virtual bus in another process. Once that has ended, it hears and says nothing."""

    def __init__(self, terminal: int) -> None:
        self._terminal = terminal
        self._said = b""

    def say(self) -> bytes:
        """Return one handshake or one block, even if several came together. A block of RK512 begins with 00 or FF."""
        if not self._said and select.select([self._terminal], [], [], 0)[0]:
            with suppress(OSError):
                self._said = os.read(self._terminal, 4096)
        if self._said[:1] in (b"\x02", b"\x10", b"\x15"):
            size = 1
        else:
            receiver = Receiver()
            ends = (place for place, value in enumerate(self._said, 1) if receiver.take(value) is not None)
            size = next(ends, len(self._said))
        said, self._said = self._said[:size], self._said[size:]
        return said

    def hear(self, character: int) -> None:
        with suppress(OSError):
            os.write(self._terminal, bytes([character]))

    def wait(self, ms: float) -> None:
        """Time passes there by itself."""


@contextmanager
def running(role: str, high: bool, count: int, seed: int, file: Path) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """Run our side in a process; yield it and its terminal."""
    options = [str(SPEED), role, "high" if high else "low", str(count), str(seed), str(file)]
    process = subprocess.Popen([sys.executable, str(BUS), *options], stdout=subprocess.PIPE, text=True)
    assert process.stdout
    terminal = os.open(process.stdout.readline().strip(), os.O_RDWR | os.O_NOCTTY)
    try:
        yield process, terminal
    finally:
        process.kill()
        process.communicate()
        os.close(terminal)


def run(line: DisturbedLine, over: Callable[[], bool], terminal: int) -> None:
    """Let the line's time pass SPEED times as fast as the clock. It never jumps: ours needs time for its answers."""
    before = time.monotonic()
    while not over():
        now = time.monotonic()
        until_ns = line.now_ns + min((now - before) * SPEED * 1e9, LONGEST_STEP_NS)
        before = now
        while line.now_ns < until_ns:
            line.step()
        select.select([terminal], [], [], 0.0005)


@terminals
@pytest.mark.thorough
@pytest.mark.parametrize(("role", "high"), [("s5", True), ("ppc", False)])
def test_a_foreign_partner_at_a_terminal(role: str, high: bool, tmp_path: Path) -> None:
    seed, count, tap, file = 1, 100, Tap(500_000), tmp_path / "came"
    asked = axes(seed, count)
    ours = "s5" if role == "ppc" else "ppc"
    commander = Commander(map(command_of, asked), high=high)
    foreign = commander if role == "s5" else Servant(reaction_to, high=not high)
    with running(ours, high == (ours == "s5"), count, seed, file) as (process, terminal):
        line = DisturbedLine((AtTerminal(terminal), foreign), random.Random(seed), tap, ERRORS)
        run(line, lambda: commander.over if role == "s5" else process.poll() is not None, terminal)
        words = process.stdout.read().split() if role == "ppc" and process.stdout else []
    outcomes = [bytes.fromhex(word) if word != "-" else None for word in words]
    came = [bytes.fromhex(text) for text in file.read_text().split()]
    deceived = judge(tap, line, (came, foreign.came))
    late = count // 50  # an answer that comes after QVZ is taken for one to what was said next
    assert settle(asked, commander.outcomes if role == "s5" else outcomes, deceived + late) < count // 5


# -- The command -----------------------------------------------------------------------------------------------------

S5_ALONE = """
title = "an S5 for a real PPC"
[s5]
script = [{ read = "S-0-0237", axis = 7, words = 2 }]
"""
PPC_ALONE = f"""
title = "a PPC for a real S5"
[ppc]
parameter = [{{ ident = "S-0-0237", axis = 7, data = "{VALUES[7].hex()}" }}]
"""


@contextmanager
def playing(folder: Path, scenario: str, place: str) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """Run `sistap bus` at a pseudo terminal of its own, or at a port; yield it and the other end of the line."""
    (folder / "mine.toml").write_text(scenario)
    options = [str(folder / "mine.toml"), "--cycles", "2", "--log", str(folder / "log")]
    ours, theirs = os.openpty()
    if place == "port":
        options += ["--port", os.ttyname(theirs), "--transmit"]
    command = [sys.executable, "-m", "sistap", "bus", *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        name = process.stdout.readline().strip()
        terminal = ours if place == "port" else os.open(name, os.O_RDWR | os.O_NOCTTY)
        try:
            yield process, terminal
        finally:
            process.terminate()
    for descriptor in {ours, theirs, terminal}:
        os.close(descriptor)


def talk(foreign: ForeignPartner, terminal: int, over: Callable[[], bool]) -> None:
    """Let a foreign partner talk at a terminal, until that or until ours hangs up."""
    before = time.monotonic()
    with suppress(OSError):
        while not over():
            heard = os.read(terminal, 4096) if select.select([terminal], [], [], 0.005)[0] else b""
            for character in heard:
                foreign.hear(character)
            now = time.monotonic()
            foreign.wait((now - before) * 1000)
            before = now
            os.write(terminal, foreign.say())


PLACES = pytest.mark.parametrize("place", ["pseudo terminal", "port"])


def logged(folder: Path) -> list[str]:
    return [line.split(" ", 1)[1] for line in (folder / "log").read_text().splitlines() if line[0] != "#"]


# S-0-0237 (ED) of axis 7, 2 words: 45 ^ 44 ^ 02 ^ 02 ^ 07 ^ ED ^ 10 ^ 03 = F8.
COMMAND = "00 00 45 44 00 00 00 02 00 00 00 02 07 00 00 ED 10 03 F8".replace(" ", "")
REACTION = block_of(bytes(4) + VALUES[7]).hex().upper()
READ = ["02", "10", COMMAND, "10", "02", "10", REACTION, "10"]


@terminals
@PLACES
def test_an_s5_alone_asks_a_foreign_ppc(place: str, tmp_path: Path) -> None:
    foreign = Servant(reaction_to)
    with playing(tmp_path, S5_ALONE, place) as (process, terminal):
        talk(foreign, terminal, lambda: process.poll() is not None)
        assert process.stdout
        assert process.stdout.read() == "2 commands, 2 reactions, 0 commands not answered\n"
    assert process.returncode == 0
    assert logged(tmp_path) == READ * 2


@terminals
@PLACES
def test_a_ppc_alone_answers_a_foreign_s5(place: str, tmp_path: Path) -> None:
    foreign = Commander([command_of(7)] * 2)
    with playing(tmp_path, PPC_ALONE, place) as (process, terminal):
        talk(foreign, terminal, lambda: logged(tmp_path) == READ * 2)
    assert process.returncode == 0
    assert foreign.outcomes == [bytes(4) + VALUES[7]] * 2
