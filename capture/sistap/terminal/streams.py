# SPDX-License-Identifier: GPL-2.0-or-later
"""The standard streams: a reader that does not read must never delay a command or its end."""

from __future__ import annotations

import contextlib
import errno
import os
import select
import sys

STANDARD_OUTPUT = "-"
PIECE = getattr(select, "PIPE_BUF", 512)  # bytes that a pipe takes without blocking once poll reports room
_WAIT_MS = 100  # upper bound on the time to stop


def is_reader_gone(error: OSError, *, is_file: bool = False, system: str = sys.platform) -> bool:
    """Tell whether a write failed because the reader is gone.

    Windows reports EPIPE for a pipe whose other end was just closed, and EINVAL after that.
    """
    return error.errno == errno.EPIPE or (system == "win32" and error.errno == errno.EINVAL and not is_file)


def leave_standard_output() -> None:
    """Discard the rest of the buffer: it must not fail again when it is flushed or when Python ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)


def end_standard_output() -> None:
    """Flush standard output if that does not block, else drop it: the command was stopped."""
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
    """Duplicate a standard stream; a write to a stopped terminal then does not block.

    The stream itself must keep its mode: it is shared with the shell.
    """
    if sys.platform != "win32" and os.isatty(descriptor):
        with contextlib.suppress(OSError):  # a terminal of another user
            return os.open(os.ttyname(descriptor), os.O_WRONLY | os.O_NOCTTY | os.O_NONBLOCK)
    return os.dup(descriptor)
