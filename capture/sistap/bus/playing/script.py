# SPDX-License-Identifier: GPL-2.0-or-later
"""A script: a generator of a master's actions that receives the result of each."""

from __future__ import annotations

from collections.abc import Generator
from typing import NamedTuple

_GROUPS = 200  # nobody answers at this receiver address or above (IF02 chapter 2.2)


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


class Token(NamedTuple):
    """Another master gets the word; the telegram says so (service 0x0F)."""

    receiver: int
    telegram: bytes


# Bytes are a command telegram. The script receives its reaction, or None.
Action = bytes | Rate | Wait | Raw | Token
Script = Generator[Action, bytes | None, None]


def is_answered(command: bytes) -> bool:
    """Tell whether a whole command is for one station: its last address decides."""
    subaddresses = command[4] & 0x07
    return command[7 + subaddresses] < _GROUPS


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
