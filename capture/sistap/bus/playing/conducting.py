# SPDX-License-Identifier: GPL-2.0-or-later
"""Passes the word from one master to the next, and performs the actions of their scripts on the line."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from sistap.bus.playing.line import Line
from sistap.bus.playing.played import Played
from sistap.bus.playing.script import Action, Rate, Raw, Script, Token, Wait
from sistap.sis.telegram import is_whole


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


def conduct(line: Line, scripts: Mapping[int, Script], end_ns: float = math.inf) -> Iterator[Played]:
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


def _exchange(line: Line, holder: _Master, command: bytes, others: list[_Master]) -> Iterator[Played]:
    rival = next((master for master in others if isinstance(master.pending, bytes)), None)
    rivals_command = rival.pending if rival and isinstance(rival.pending, bytes) else None
    reaction = yield from line.exchange(command, rivals_command)
    if rival and line.collided:
        rival.tell(None)
    holder.tell(reaction)


def _silent_or_raw(line: Line, action: Rate | Wait | Raw) -> Iterator[Played]:
    if isinstance(action, Rate):
        line.change(action)
    elif isinstance(action, Wait):
        line.wait(action.ns)
    elif is_whole(action.characters):
        yield from line.exchange(action.characters, None)
    else:
        yield from line.send(action.characters)
