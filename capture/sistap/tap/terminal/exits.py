# SPDX-License-Identifier: GPL-2.0-or-later
"""How a command ends: the exit codes, which `sistap --help` explains, and what refuses to begin or to go on."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

DONE, FAILED, USAGE, PORT = 0, 1, 2, 3
_Value = TypeVar("_Value")


class Refusal(Exception):
    """What ends a command: its text is the line to show, which says what is wrong and what to do; and the exit code.

    Those derived from it are the library's, or somebody goes on after them; each has its code.
    """

    code = USAGE

    def __init__(self, text: str, code: int | None = None) -> None:
        super().__init__(text)
        if code is not None:
            self.code = code


class NotCaptured(Refusal, ValueError):
    """The file cannot be read as a capture; the text is one line with the cure."""


def why(error: OSError) -> str:
    """Return why a file cannot be opened. Of a folder, Windows says that permission is denied."""
    if os.name == "nt" and isinstance(error, PermissionError) and Path(str(error.filename)).is_dir():
        return os.strerror(errno.EISDIR)
    return error.strerror or str(error)


def argument(parse: Callable[[str], _Value]) -> Callable[[str], _Value]:
    """Return the type of an argument: what a ValueError of `parse` says is shown."""

    def parsed(text: str) -> _Value:
        try:
            return parse(text)
        except ValueError as error:
            import argparse  # not needed by a command that starts

            raise argparse.ArgumentTypeError(str(error)) from None

    return parsed
