# SPDX-License-Identifier: GPL-2.0-or-later
"""What a master does: a script is a generator of actions, and is told what each of them brought."""

from __future__ import annotations

from collections.abc import Generator
from typing import NamedTuple

_GROUPS = 200  # from this receiver address on nobody answers (IF02 chapter 2.2)


class Rate(NamedTuple):
    """From here on the bus has this rate; the master is silent until `after_ms` after it had the one before."""

    baud: int
    after_ms: int = 0


class Wait(NamedTuple):
    """The master is silent for so long."""

    ns: int


class Raw(NamedTuple):
    """Characters as they are, telegram or not; never sent again."""

    characters: bytes


class Token(NamedTuple):
    """Another master has the word; the telegram says so (service 0x0F)."""

    receiver: int
    telegram: bytes


# Bytes are a command telegram; the script is told its reaction, or None.
Action = bytes | Rate | Wait | Raw | Token
Script = Generator[Action, bytes | None, None]


def is_answered(command: bytes) -> bool:
    """Tell whether a whole command is for one station: the last of its addresses decides."""
    subaddresses = command[4] & 0x07
    return command[7 + subaddresses] < _GROUPS


def repeating(script: Script, repeats: int, twm_ns: int) -> Script:
    """Send what was not answered again, after TwM, so many times (chapter 10.5: only the originator repeats)."""
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
