# SPDX-License-Identifier: GPL-2.0-or-later
"""The signals that end a command: SIGINT, SIGTERM, SIGQUIT, and SIGHUP (the terminal is gone) unless nohup ignores it.

Any number of signals ends a command once: Stopped is raised wherever the command is, and `with` and `finally` close
what is open. A command that must not be interrupted (a capture, while it writes) checks `asked` instead. Most others
wait where nothing can check it: for tshark, for the reader of a pipe, in a library.

An exception that comes at any instruction can be swallowed: Python drops it in `__del__`, and libraries catch anything.
So Stopped is raised again and again until the command has ended, but never where Stopped is being handled.

A flag with `signal.set_wakeup_fd`, checked where a command waits, would be shorter here and longer everywhere else: a
report reads tshark for minutes, then counts for seconds; `tables` is in a library; a log is read from a pipe. Each of
these would need a check, and one that forgets it ignores Ctrl-C. Only a capture has one place where it waits.

Two things must never be interrupted: making something that must be removed again, and removing it. Both happen while
Stopped is `held`. Everything else may be left at any instruction.

This is imported before the rest of sistap, so it imports next to nothing.
"""

from __future__ import annotations

import _thread
import os
import signal
import sys
import time
from types import FrameType

from sistap.tap.terminal.exits import DONE

AGAIN_S = 0.1  # pause before Stopped is raised again


class Stopped(BaseException):
    """A signal has requested the end. It is no Exception, so that no handler of failures catches it."""


class Stop:
    """Whether the end was requested, by a signal or by `ask`. A process has one.

    It has its own handlers because a job that a script starts with & inherits SIGINT ignored, and Python leaves it so.
    """

    _of_command: Stop | None = None  # the stop of the command in this process

    def __init__(self) -> None:
        self.asked = False
        self.at_once = True  # False: the command checks `asked`
        self._owns_process = False
        self._is_importing = False
        self._insists = False
        self._holds = 0
        self._before: dict[int, signal._HANDLER] = {}
        self._hook = sys.unraisablehook
        self._main_thread = _thread.get_ident()
        self._poking = _thread.allocate_lock()

    @classmethod
    def current(cls) -> Stop:
        """Return the stop of the running command; outside of one, a stop that is never requested."""
        return cls._of_command or cls()

    def begin(self) -> None:
        """Let a signal end the process at once during imports, when there is nothing to undo."""
        self._owns_process = self._is_importing = True
        self._install()

    def __enter__(self) -> Stop:
        if not self._before:
            self._install()
        Stop._of_command = self
        self._is_importing = False
        return self

    def __exit__(self, *error: object) -> None:
        """Call `end`. If a signal comes just before, the handler of Stopped must call it."""
        self.end()

    def end(self) -> None:
        """Ignore signals if the process ends now; else restore the former handlers."""
        with self._poking:
            Stop._of_command = None
        for number, handler in self._before.items():
            signal.signal(number, signal.SIG_IGN if self._owns_process else handler)
        self._before = {}
        sys.unraisablehook = self._hook

    def ask(self) -> None:
        """Request the end without a signal, from any thread."""
        self.asked = True
        self._begin_to_insist()

    def hold(self) -> None:
        """Hold Stopped back until `release`."""
        self._holds += 1

    def release(self) -> None:
        """Let signals raise Stopped again; raise it now if one came meanwhile."""
        self._holds -= 1
        self._raise_if_asked()

    def _install(self) -> None:
        numbers = [signal.SIGINT, signal.SIGTERM]
        if sys.platform != "win32":
            numbers.append(signal.SIGQUIT)
            if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
                numbers.append(signal.SIGHUP)
        self._before = {number: signal.signal(number, self._handle) for number in numbers}
        self._hook, sys.unraisablehook = sys.unraisablehook, self._tell

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self._is_importing:
            os._exit(DONE)  # an exception during an import could appear as a traceback, or be lost
        if Stop._of_command is self:
            self.asked = True
            try:
                self._raise_if_asked()
            except SystemError:  # C code went on although Stopped was raised in it, and met the next signal
                raise Stopped from None

    def _raise_if_asked(self) -> None:
        if not (self.asked and self.at_once) or self._holds or Stop._of_command is not self or _is_being_handled():
            return
        self._begin_to_insist()
        raise Stopped

    def _begin_to_insist(self) -> None:
        if not self._insists:
            self._insists = True
            _thread.start_new_thread(self._insist, ())

    def _insist(self) -> None:
        """Send the main thread a signal again and again, which interrupts a system call as well."""
        while True:
            time.sleep(AGAIN_S)
            with self._poking:
                if Stop._of_command is not self or not self.at_once:
                    return
                if sys.platform == "win32":
                    signal.raise_signal(signal.SIGINT)
                else:
                    signal.pthread_kill(self._main_thread, signal.SIGTERM)

    def _tell(self, args: sys.UnraisableHookArgs) -> None:
        """Report as ever what was raised where nobody can catch it, but not Stopped, which comes again."""
        if not isinstance(args.exc_value, Stopped):
            self._hook(args)


def _is_being_handled() -> bool:
    """Tell whether the interrupted code handles Stopped, as `finally` does, or was called by code that does."""
    error = sys.exc_info()[1]
    while error and not isinstance(error, Stopped):
        error = error.__context__
    return error is not None


class held:
    """Hold Stopped back in a `with`, in the main thread. Keep it short: a signal waits for its end."""

    def __enter__(self) -> None:
        self._stop = Stop.current()
        self._stop.hold()

    def __exit__(self, *error: object) -> None:
        """Release it; may raise Stopped."""
        self._stop.release()
