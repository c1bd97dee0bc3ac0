# SPDX-License-Identifier: GPL-2.0-or-later
"""Scripts of masters, the line they act on, and the word that passes from one master to the next."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Mapping
from typing import NamedTuple, Protocol

from sisbus.playing.characters import Played
from sistap.tap.line.settings import LineSettings
from sistap.tap.sis.telegram import FIRST_GROUP, is_whole


class Rate(NamedTuple):
    """The bus has this rate from here on; the master stays silent until `after_ms` after the former rate began."""

    baud: int
    after_ms: int = 0


class Wait(NamedTuple):
    """The master is silent for that long."""

    ns: int


class Raw(NamedTuple):
    """Characters as they are, telegram or not; never sent again."""

    characters: bytes


class Typed(NamedTuple):
    """A line of the ASCII protocol, with its end; never sent again."""

    characters: bytes


class Token(NamedTuple):
    """Another master gets the word; the telegram says so (service 0x0F)."""

    receiver: int
    telegram: bytes


# Bytes are a command telegram. The script receives its reaction, or None.
Action = bytes | Rate | Wait | Raw | Typed | Token
Script = Generator[Action, bytes | None, None]


def is_answered(command: bytes) -> bool:
    """Tell whether a whole command is for one station: its last address decides."""
    subaddresses = command[4] & 0x07
    return command[7 + subaddresses] < FIRST_GROUP


def repeating(script: Script, repeats: int, twm_ns: int) -> Script:
    """Repeat an unanswered command after TwM, up to that many times (chapter 10.5: only the originator repeats)."""
    reaction = None
    while True:
        try:
            action = script.send(reaction)
        except StopIteration:
            return
        reaction = yield action
        if isinstance(action, bytes) and is_answered(action):
            for _ in range(repeats):
                if reaction is not None:
                    break
                yield Wait(twm_ns)
                reaction = yield action


# -- A line: the simulated one (player.py) or a real one (wires/talking.py) ------------------------------------------

Exchange = Generator[Played, None, bytes | None]  # yields what is sent, returns the reaction


class MasterLine(Protocol):
    """Carries what a master says to the stations."""

    collided: bool  # in the last exchange, with the rival's command

    @property
    def settings(self) -> LineSettings:
        """Return the present settings."""

    @property
    def now_ns(self) -> int:
        """Return the time in ns since the bus was started; nothing more is sent before it."""

    def exchange(self, command: bytes, rival: bytes | None) -> Exchange:
        """Send a command; return its reaction, or None after TrS. `rival` is a command that another master may send."""

    def send(self, characters: bytes) -> Iterator[Played]:
        """Send characters that need no answer."""

    def type(self, characters: bytes) -> Iterator[Played]:
        """Send a line of the ASCII protocol; yield what comes back, too."""

    def wait(self, ns: int) -> None:
        """Be silent for that long."""

    def change(self, rate: Rate) -> None:
        """Continue at another rate."""


# -- Conducting ------------------------------------------------------------------------------------------------------


class _Master:
    """A script and the action that waits; None at its end."""

    def __init__(self, address: int, script: Script) -> None:
        self.address = address
        self._script = script
        self.pending: Action | None = next(script, None)

    def tell(self, reaction: bytes | None = None) -> None:
        """Send the result of the pending action to the script; then the next action is pending."""
        try:
            self.pending = self._script.send(reaction)
        except StopIteration:
            self.pending = None


def conduct(line: MasterLine, scripts: Mapping[int, Script], end_ns: float = math.inf) -> Iterator[Played]:
    """Play the scripts of masters by address. The first has the word until it passes the token or ends.

    An action that began before `end_ns`, a time of the line, is completed.
    """
    masters = [_Master(address, script) for address, script in scripts.items()]
    while masters and line.now_ns < end_ns:
        holder = masters[0]
        action = holder.pending
        if action is None:
            del masters[0]
        elif isinstance(action, Token):
            yield from line.send(action.telegram)
            holder.tell()
            # A master whose script has ended ignores the token; the next one has it.
            place = next((n for n, master in enumerate(masters) if master.address == action.receiver), 1)
            masters = masters[place:] + masters[:place]
        elif isinstance(action, bytes):
            yield from _exchange(line, holder, action, masters[1:])
        else:
            yield from _silent_or_raw(line, action)
            holder.tell()


def _exchange(line: MasterLine, holder: _Master, command: bytes, others: list[_Master]) -> Iterator[Played]:
    rival = next((master for master in others if isinstance(master.pending, bytes)), None)
    rivals_command = rival.pending if rival and isinstance(rival.pending, bytes) else None
    reaction = yield from line.exchange(command, rivals_command)
    if rival and line.collided:
        rival.tell(None)
    holder.tell(reaction)


def _silent_or_raw(line: MasterLine, action: Rate | Wait | Raw | Typed) -> Iterator[Played]:
    if isinstance(action, Rate):
        line.change(action)
    elif isinstance(action, Wait):
        line.wait(action.ns)
    elif isinstance(action, Typed):
        yield from line.type(action.characters)
    elif is_whole(action.characters):
        yield from line.exchange(action.characters, None)
    else:
        yield from line.send(action.characters)
