# SPDX-License-Identifier: GPL-2.0-or-later
"""A text file, or standard output, opened for writing; failures have one line."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import BinaryIO

from sistap.terminal.streams import STANDARD_OUTPUT, is_reader_gone, leave_standard_output


class NotOpened(Exception):
    """FILE cannot be written; the text is the line to show."""


class Incomplete(Exception):
    """The disk is full; the text is the line to show."""


@contextmanager
def opened(path: str | None, cure: str = "name another file with -o") -> Iterator[BinaryIO]:
    """Open the output, standard output without a path. May raise NotOpened, and Incomplete at the end."""
    if path in (None, STANDARD_OUTPUT):
        try:
            yield sys.stdout.buffer
            sys.stdout.buffer.flush()
        except OSError as error:
            if is_reader_gone(error):
                raise  # needs no message
            leave_standard_output()
            raise Incomplete(f"standard output is incomplete: {error.strerror}; make room, or {cure}") from None
        return
    try:
        file = open(str(path), "wb")  # noqa: SIM115 - closed below
    except OSError as error:
        raise NotOpened(f"cannot write {path}: {error.strerror}; {cure}") from None
    try:
        with file:
            yield file
    except OSError as error:
        raise Incomplete(f"{path} is incomplete: {error.strerror}; make room, or {cure}") from None
