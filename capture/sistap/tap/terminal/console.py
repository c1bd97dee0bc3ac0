# SPDX-License-Identifier: GPL-2.0-or-later
"""Standard output and standard error: text that is safe to print, messages, and readers that do not read.

Text from elsewhere (a drive, an adapter, a file and its name) is made visible. A terminal obeys control characters, and
some Unicode marks reverse the text after them. Then a text seems to say something else. So invisible characters are
shown as Python escapes them in a string: \\x1b, \\u202e.

Messages are lines on standard error, and on a terminal a progress line that the lines do not tear. A reader that does
not read must never delay a command or its end.
"""

from __future__ import annotations

import contextlib
import errno
import os
import select
import sys
import weakref
from typing import Protocol

from sistap.tap.terminal.rights import as_typed

_FIRST_BYTE, _LAST_BYTE = 0xDC80, 0xDCFF  # how Python decodes a byte of a name that is not UTF-8


def visible(text: str, keep: str = "") -> str:
    """Escape invisible characters, and those that look like a space; leave the characters in `keep`."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep else _escape(c) for c in text)


def _escape(character: str) -> str:
    code = ord(character)
    if _FIRST_BYTE <= code <= _LAST_BYTE:
        return f"\\x{code & 0xFF:02x}"
    return character.encode("unicode_escape").decode()


STANDARD_OUTPUT = "-"
PIECE = getattr(select, "PIPE_BUF", 512)  # bytes that a pipe takes without blocking once poll reports room
_WAIT_MS = 100  # upper bound on the time to stop, and for a terminal to take a line: then the line is dropped


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


_ERASE = "\r\x1b[K"


class Audience(Protocol):
    """The receiver of a capture's messages: a user at a terminal, or a program with windows of its own."""

    def say(self, text: str) -> None:
        """Show one line."""

    def alarm(self, text: str) -> None:
        """Show why the capture or a part of it has ended, in one line."""

    def progress(self, text: str) -> None:
        """Show a progress line instead of the one before."""


class Console:
    """Standard error. Failing or blocked output (Ctrl-S, a hung ssh) must never end or delay a capture."""

    def __init__(self, stream: int = 2) -> None:
        """Start without a progress line; `stream` is the descriptor of standard error."""
        self._progress = False
        # Not through sys.stderr: Python would try again at its end to write what is left in the buffer.
        self._stream = stream
        self._descriptor = never_waiting(stream)
        weakref.finalize(self, os.close, self._descriptor)
        self._poll: select.poll | None = None
        if sys.platform != "win32":
            self._poll = select.poll()
            self._poll.register(self._descriptor, select.POLLOUT)

    @property
    def shows_progress(self) -> bool:
        """Tell whether it is a terminal that can overwrite a line."""
        return os.isatty(self._descriptor) and os.environ.get("TERM") != "dumb"

    def say(self, text: str) -> None:
        """Print one line."""
        self._print((_ERASE if self._progress else "") + f"sistap: {visible(as_typed(text))}\n", _WAIT_MS)
        self._progress = False

    def alarm(self, text: str) -> None:
        """Print it like any line."""
        self.say(text)

    def progress(self, text: str) -> None:
        """Show a line instead of the one before, cut to the width of the terminal, if it is one that can."""
        if not self.shows_progress:
            return
        text = visible(text)
        with contextlib.suppress(OSError):
            columns = os.get_terminal_size(self._stream).columns  # Windows knows it for the standard streams only
            text = text[: columns - 1] if columns else text
        self._print(_ERASE + text, 0)
        self._progress = True

    def _print(self, text: str, wait_ms: int) -> None:
        data = text.encode(sys.stderr.encoding, "backslashreplace")
        with contextlib.suppress(OSError):
            while data and (not self._poll or self._poll.poll(wait_ms)):
                data = data[os.write(self._descriptor, data[:PIECE]) :]
