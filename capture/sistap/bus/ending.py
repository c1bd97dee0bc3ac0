# SPDX-License-Identifier: GPL-2.0-or-later
"""How a command that plays ends: the one line for what cannot be, and the signals that stop it."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class Refusal(Exception):
    """It does not begin or go on; the text is one line that names the cure."""

    def __init__(self, code: int, text: str) -> None:
        """Say so, with an exit code."""
        super().__init__(text.replace("\n", "\\n"))  # names of files can have several
        self.code = code


class _Stopped(Exception):
    """SIGINT or SIGTERM came."""


class Stop:
    """Whether a signal has asked for the end."""

    def __init__(self) -> None:
        """Nothing has."""
        self.asked = False
        self.at_once = True  # False: whoever plays looks at `asked`, so that nothing is torn that is half written


@contextmanager
def stoppable() -> Iterator[Stop]:
    """Let SIGINT and SIGTERM end what is done here, even where a script started it with SIGINT ignored.

    After the first one others are ignored, until the process ends: they would only disturb the closing of what is open.
    """
    stop = Stop()

    def handle(signum: int, frame: FrameType | None) -> None:
        if stop.asked:
            return
        stop.asked = True
        if stop.at_once:
            raise _Stopped

    before = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    except _Stopped:
        pass
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_IGN if stop.asked else handler)
