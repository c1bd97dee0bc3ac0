# SPDX-License-Identifier: GPL-2.0-or-later
"""How a command ends: the exit codes, which `sistap --help` explains, and wrong usage."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

DONE, FAILED, USAGE, PORT = 0, 1, 2, 3
_Value = TypeVar("_Value")


class Error(Exception):
    """What the library raises: each is derived from it; str() is one line that says what is wrong, and what to do."""


class UsageError(Error):
    """Invalid options or files; str() is the line to show, and the command ends with USAGE."""


def argument(parse: Callable[[str], _Value]) -> Callable[[str], _Value]:
    """Return the type of an argument: what a ValueError of `parse` says is shown."""

    def parsed(text: str) -> _Value:
        try:
            return parse(text)
        except ValueError as error:
            import argparse  # not needed by a command that starts

            raise argparse.ArgumentTypeError(str(error)) from None

    return parsed
