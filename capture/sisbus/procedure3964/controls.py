# SPDX-License-Identifier: GPL-2.0-or-later
"""Both ends of the line: the S5, a master, and the PPC, a slave."""

from __future__ import annotations

import random
from collections.abc import Callable, Generator, Iterable, Mapping
from dataclasses import dataclass, field

from sisbus.playing.conducting import Wait
from sisbus.procedure3964 import rk512
from sisbus.procedure3964.partner import MS, Partner
from sisbus.procedure3964.rk512 import HEAD_SIZE, Command, Head, Reaction, RkError
from sistap.dissected.telegrams.attribute import LENGTH_WORDS

REACTION_NS = 5000 * MS  # longest wait for a reaction at 1200 to 19200 Bd


# Bytes are a telegram. The script receives its reaction, None if none came.
Script = Generator[bytes | Wait, Reaction | None, None]
Step = Callable[[], Script]


def fetch(block: int, words: int, head: Head | None = None) -> Script:
    """Fetch a data block, or what a head names; follow-ups fetch what exceeds one telegram."""
    yield from _fetch_on((yield rk512.command(rk512.FETCH, block, words, bytes(head) if head else b"")), 2 * words)


def fetch_list(head: Head) -> Script:
    """Fetch the length words of a list, then its elements."""
    reaction = yield rk512.command(rk512.FETCH, 0, LENGTH_WORDS // 2, bytes(head))
    if reaction is not None and len(reaction.data) == LENGTH_WORDS:
        yield from _fetch_on(reaction, LENGTH_WORDS + int.from_bytes(reaction.data[:2], "big"))


def _fetch_on(reaction: Reaction | None, size: int) -> Script:
    """Fetch the rest of that many bytes with follow-ups."""
    while reaction is not None and reaction.data and (size := size - len(reaction.data)) > 0:
        reaction = yield rk512.follow_up(rk512.FETCH)


def send(pieces: Iterable[tuple[int, bytes]]) -> Script:
    """Send data blocks, each with as many telegrams as needed, until one is refused."""
    for block, data in pieces:
        for telegram in rk512.sending(block, data):
            reaction = yield telegram
            if reaction is None or reaction.error != RkError.NONE:
                return


class S5:
    """An S5 at the procedure."""

    def __init__(self, partner: Partner, script: Script, timing: random.Random) -> None:
        self.partner = partner
        self._script = script
        self._timing = timing
        self.commands = self.reactions = 0
        self._command: bytes | None = None  # waits for its reaction
        self._acknowledged = False  # that command
        self._due_ns: int | None = 0  # when it continues without one
        self._begun = False

    @property
    def due_ns(self) -> int | None:
        """Return when to call look again."""
        dues = [due_ns for due_ns in (self._due_ns, self.partner.due_ns) if due_ns is not None]
        return min(dues, default=None)

    @property
    def over(self) -> bool:
        """Tell whether it has nothing more to send."""
        return self.due_ns is None

    @property
    def counts(self) -> str:
        """Return the counts of what was sent and heard, in words."""
        waiting = self._command is not None
        unanswered = self.commands - self.reactions - waiting
        return f"{self.commands} commands, {self.reactions} reactions, {unanswered} commands not answered"

    def look(self, now_ns: int) -> None:
        """Take what the procedure has received, and continue."""
        while self.partner.outcomes:
            if not self.partner.outcomes.popleft():
                self._go_on(None, now_ns)
            elif self._command is not None:
                self._acknowledged = True
                self._due_ns = now_ns + REACTION_NS
        while self.partner.received:
            block = self.partner.received.popleft()
            if self._acknowledged:  # else it is an old one, which comes again because its acknowledgment was lost
                self.reactions += 1
                self.partner.drop()
                self._go_on(_reaction(block), now_ns)
        if self._due_ns is not None and now_ns >= self._due_ns:
            self._go_on(None, now_ns)

    def repeat(self, now_ns: int) -> None:
        """Send the command again, as if its reaction were missing."""
        if self._command is not None:
            self.partner.send(self._command, now_ns)

    def _go_on(self, reaction: Reaction | None, now_ns: int) -> None:
        self._command, self._acknowledged = None, False
        try:
            action = self._script.send(reaction) if self._begun else next(self._script)
        except StopIteration:
            self._due_ns = None
            return
        self._begun = True
        if isinstance(action, Wait):
            self._due_ns = now_ns + action.ns
            return
        self._command = action
        self.commands += 1
        ready_ns = now_ns + self._timing.randrange(10 * MS, 40 * MS)
        self._due_ns = ready_ns + 10 * REACTION_NS  # the attempts of the procedure come first
        self.partner.send(action, ready_ns)


def _reaction(block: bytes) -> Reaction | None:
    try:
        return rk512.read_reaction(block)
    except ValueError:
        return None


# -- The PPC: it executes RK512 commands and answers each telegram ---------------------------------------------------

_INPUTS = 99  # a data block of its own
_LISTS = range(1, 6)  # data blocks in which long lists come
Place = tuple[int, bytes]  # axis, and type and number of a parameter


@dataclass
class ControlMemory:
    """The contents of a PPC, and the state of a command that is not complete."""

    parameters: dict[Place, bytes]
    lists: frozenset[Place]  # places whose length words are sent first
    blocks: dict[int, bytes] = field(default_factory=dict)
    _writing: Command | None = None  # data of follow-ups are added to its data
    _list: bytes = b""  # from data blocks with higher numbers
    _reading: bytes = b""  # what is still to be fetched

    def react(self, telegram: bytes) -> Reaction:
        """Execute a telegram; return the answer."""
        try:
            command = rk512.read_command(telegram)
        except ValueError:
            return Reaction(False, RkError.NO_SUCH_COMMAND, b"")
        if command.letter not in (rk512.SEND, rk512.FETCH):
            return Reaction(command.follow_up, RkError.NO_SUCH_COMMAND, b"")
        if command.letter == rk512.FETCH:
            error, data = self._fetch_on() if command.follow_up else self._fetch(command)
        else:
            error, data = self._send_on(command) if command.follow_up else self._send(command), b""
        return Reaction(command.follow_up, error, data)

    def _fetch(self, command: Command) -> tuple[RkError, bytes]:
        self._reading = b""
        if not command.data:
            if command.block not in self.blocks:
                return RkError.NO_SUCH_BLOCK, b""
            self._reading = self.blocks[command.block]
            return self._fetch_on()
        try:
            place = _place(Head.read(command.data))
        except ValueError:
            return RkError.WRONG_LENGTH, b""
        if place not in self.parameters:
            return RkError.NO_SUCH_BLOCK, b""
        self._reading = self.parameters[place]
        return self._fetch_on(LENGTH_WORDS if place in self.lists else rk512.LARGEST)

    def _fetch_on(self, most: int = rk512.LARGEST) -> tuple[RkError, bytes]:
        data, self._reading = self._reading[:most], self._reading[most:]
        return (RkError.NONE, data) if data else (RkError.OUT_OF_SEQUENCE, b"")

    def _send(self, command: Command) -> RkError:
        self._writing = command
        return self._written(command)

    def _send_on(self, command: Command) -> RkError:
        if self._writing is None:
            return RkError.OUT_OF_SEQUENCE
        self._writing = self._writing._replace(data=self._writing.data + command.data)
        return self._written(self._writing)

    def _written(self, command: Command) -> RkError:
        """Store what a command has brought, if it is complete."""
        missing = 2 * command.words - len(command.data)
        if missing > 0:
            return RkError.NONE
        self._writing = None
        if missing < 0:
            return RkError.WRONG_LENGTH
        if command.block == _INPUTS:
            self.blocks[command.block] = command.data
            return RkError.NONE
        self._list += command.data
        if command.block in _LISTS and command.block > 1:
            return RkError.NONE
        data, self._list = self._list, b""
        return self._write(data)

    def _write(self, data: bytes) -> RkError:
        try:
            place = _place(Head.read(data))
        except ValueError:
            return RkError.WRONG_LENGTH
        if place not in self.parameters:
            return RkError.NO_SUCH_BLOCK
        self.parameters[place] = data[HEAD_SIZE:]
        return RkError.NONE


def _place(head: Head) -> Place:
    return head.axis, head.parameter


class Ppc:
    """A PPC at the procedure."""

    over = False  # it waits for commands as long as it is on

    def __init__(self, partner: Partner, memory: ControlMemory, reaction_ns: int, slow: Mapping[int, int]) -> None:
        """React that long after a command; `slow` gives the delay of the n-th one."""
        self.partner = partner
        self.memory = memory
        self._reaction_ns = reaction_ns
        self._slow = slow
        self._commands = 0

    @property
    def due_ns(self) -> int | None:
        """Return when to call look again."""
        return self.partner.due_ns

    def look(self, now_ns: int) -> None:
        """Take what the procedure has received."""
        while self.partner.received:
            self._commands += 1
            reaction = bytes(self.memory.react(self.partner.received.popleft()))
            self.partner.send(reaction, now_ns + self._slow.get(self._commands, self._reaction_ns))
        self.partner.outcomes.clear()
