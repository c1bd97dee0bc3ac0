# SPDX-License-Identifier: GPL-2.0-or-later
"""The PPC: a slave that executes RK512 commands and answers each telegram."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from sistap.bus.devices.parameters import LENGTH_WORDS
from sistap.bus.procedure3964 import rk512
from sistap.bus.procedure3964.heads import SIZE, Head
from sistap.bus.procedure3964.partner import Partner
from sistap.bus.procedure3964.rk512 import Command, Error, Reaction

_INPUTS = 99  # a data block of its own
_LISTS = range(1, 6)  # data blocks in which long lists come
Place = tuple[int, bytes]  # axis, and type and number of a parameter


@dataclass
class Memory:
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
            return Reaction(False, Error.NO_SUCH_COMMAND, b"")
        if command.letter not in (rk512.SEND, rk512.FETCH):
            return Reaction(command.follow_up, Error.NO_SUCH_COMMAND, b"")
        if command.letter == rk512.FETCH:
            error, data = self._fetch_on() if command.follow_up else self._fetch(command)
        else:
            error, data = self._send_on(command) if command.follow_up else self._send(command), b""
        return Reaction(command.follow_up, error, data)

    def _fetch(self, command: Command) -> tuple[Error, bytes]:
        self._reading = b""
        if not command.data:
            if command.block not in self.blocks:
                return Error.NO_SUCH_BLOCK, b""
            self._reading = self.blocks[command.block]
            return self._fetch_on()
        try:
            place = _place(Head.read(command.data))
        except ValueError:
            return Error.WRONG_LENGTH, b""
        if place not in self.parameters:
            return Error.NO_SUCH_BLOCK, b""
        self._reading = self.parameters[place]
        return self._fetch_on(LENGTH_WORDS if place in self.lists else rk512.LARGEST)

    def _fetch_on(self, most: int = rk512.LARGEST) -> tuple[Error, bytes]:
        data, self._reading = self._reading[:most], self._reading[most:]
        return (Error.NONE, data) if data else (Error.OUT_OF_SEQUENCE, b"")

    def _send(self, command: Command) -> Error:
        self._writing = command
        return self._written(command)

    def _send_on(self, command: Command) -> Error:
        if self._writing is None:
            return Error.OUT_OF_SEQUENCE
        self._writing = self._writing._replace(data=self._writing.data + command.data)
        return self._written(self._writing)

    def _written(self, command: Command) -> Error:
        """Store what a command has brought, if it is complete."""
        missing = 2 * command.words - len(command.data)
        if missing > 0:
            return Error.NONE
        self._writing = None
        if missing < 0:
            return Error.WRONG_LENGTH
        if command.block == _INPUTS:
            self.blocks[command.block] = command.data
            return Error.NONE
        self._list += command.data
        if command.block in _LISTS and command.block > 1:
            return Error.NONE
        data, self._list = self._list, b""
        return self._write(data)

    def _write(self, data: bytes) -> Error:
        try:
            place = _place(Head.read(data))
        except ValueError:
            return Error.WRONG_LENGTH
        if place not in self.parameters:
            return Error.NO_SUCH_BLOCK
        self.parameters[place] = data[SIZE:]
        return Error.NONE


def _place(head: Head) -> Place:
    return head.axis, head.parameter


class Ppc:
    """A PPC at the procedure."""

    def __init__(self, partner: Partner, memory: Memory, reaction_ns: int, slow: Mapping[int, int]) -> None:
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
