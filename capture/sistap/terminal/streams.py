# SPDX-License-Identifier: GPL-2.0-or-later
"""The standard streams: nobody who does not read them may hold a command or its end up."""

from __future__ import annotations

import contextlib
import errno
import os
import select
import sys

STANDARD_OUTPUT = "-"
PIECE = getattr(select, "PIPE_BUF", 512)  # bytes that a pipe takes without waiting once poll says that it takes any
_WAIT_MS = 100  # so long, at most, does a stop take


def is_reader_gone(error: OSError, *, is_file: bool = False, system: str = sys.platform) -> bool:
    """Tell whether a write failed because nobody reads any more.

    Windows says EPIPE for a pipe whose other end was closed just now, and EINVAL from then on.
    """
    return error.errno == errno.EPIPE or (system == "win32" and error.errno == errno.EINVAL and not is_file)


def leave_standard_output() -> None:
    """Send what is left in its buffer nowhere: it must not fail again when it is flushed or when Python ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)


def end_standard_output() -> None:
    """Write what is left in its buffer if that need not wait for the reader, else drop it: the command was stopped."""
    try:
        if _takes_some(1):
            sys.stdout.flush()
            return
    except OSError:
        pass
    leave_standard_output()


def _takes_some(descriptor: int) -> bool:
    if sys.platform == "win32":  # it has no poll
        return True
    poll = select.poll()
    poll.register(descriptor, select.POLLOUT)
    return bool(poll.poll(_WAIT_MS))


def never_waiting(descriptor: int) -> int:
    """Duplicate a standard stream; if it is a terminal, so that a write does not wait where the terminal is stopped.

    The stream itself must keep its mode: it is shared with the shell.
    """
    if sys.platform != "win32" and os.isatty(descriptor):
        with contextlib.suppress(OSError):  # a terminal of another user
            return os.open(os.ttyname(descriptor), os.O_WRONLY | os.O_NOCTTY | os.O_NONBLOCK)
    return os.dup(descriptor)
