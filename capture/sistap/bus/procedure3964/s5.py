# SPDX-License-Identifier: GPL-2.0-or-later
"""The S5: a master that sends one command after the other and waits for the reaction to each telegram."""

from __future__ import annotations

import random
from collections.abc import Callable, Generator, Iterable
from typing import NamedTuple

from sistap.bus.devices.parameters import LENGTH_WORDS
from sistap.bus.procedure3964 import rk512
from sistap.bus.procedure3964.heads import Head
from sistap.bus.procedure3964.partner import MS, Partner
from sistap.bus.procedure3964.rk512 import Error, Reaction

REACTION_NS = 5000 * MS  # longest wait for a reaction at 1200 to 19200 Bd


class Wait(NamedTuple):
    """A silence of that length."""

    ns: int


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
            if reaction is None or reaction.error != Error.NONE:
                return


class S5:
    """An S5 at the procedure."""

    def __init__(self, partner: Partner, script: Script, timing: random.Random) -> None:
        self.partner = partner
        self._script = script
        self._timing = timing
        self._command: bytes | None = None  # waits for its reaction
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
        return self._due_ns is None

    def look(self, now_ns: int) -> None:
        """Take what the procedure has received, and continue."""
        while self.partner.outcomes:
            if not self.partner.outcomes.popleft():
                self._go_on(None, now_ns)
            elif self._command is not None:
                self._due_ns = now_ns + REACTION_NS
        while self.partner.received:
            block = self.partner.received.popleft()
            if self._command is not None:
                self.partner.drop()
                self._go_on(_reaction(block), now_ns)
        if self._due_ns is not None and now_ns >= self._due_ns:
            self._go_on(None, now_ns)

    def repeat(self, now_ns: int) -> None:
        """Send the command again, as if its reaction were missing."""
        if self._command is not None:
            self.partner.send(self._command, now_ns)

    def _go_on(self, reaction: Reaction | None, now_ns: int) -> None:
        self._command = None
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
        ready_ns = now_ns + self._timing.randrange(10 * MS, 40 * MS)
        self._due_ns = ready_ns + 10 * REACTION_NS  # the attempts of the procedure come first
        self.partner.send(action, ready_ns)


def _reaction(block: bytes) -> Reaction | None:
    try:
        return rk512.read_reaction(block)
    except ValueError:
        return None
