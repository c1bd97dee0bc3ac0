# SPDX-License-Identifier: GPL-2.0-or-later
"""The signals that end a command: SIGINT, SIGTERM, SIGQUIT, and SIGHUP (the terminal is gone) unless nohup ignores it.

Any number of signals ends a command once. The first raises Stopped wherever the command is, so that everything open is
closed on the way out. Later ones are ignored until the process has ended. A command that must not be interrupted (a
capture, while it writes) checks `asked` instead.

Two things must never be interrupted: making something that must be removed again, and removing it. Both happen while
Stopped is `held`. Everything else may be left at any instruction.

This is imported before the rest of sistap, so it imports next to nothing.
"""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType, TracebackType

from sistap.terminal.exits import DONE

_AGAIN_S = 0.01  # pause before trying a swallowed stop again
_DEAF = "ignored due to race condition"  # Python's message about a signal just before it was ignored


class Stopped(BaseException):
    """A signal has requested the end. It is no Exception, so that no handler of failures catches it."""

    def __init__(self, stop: Stop) -> None:
        """Belong to a stop that must know when this object is gone."""
        super().__init__()
        self._stop = stop

    def __del__(self) -> None:
        self._stop.listen()


class Stop:
    """Whether the end was requested, by a signal or by `ask`. A process has one.

    It has its own handlers because a job that a script starts with & inherits SIGINT ignored, and Python leaves it so.
    """

    _of_command: Stop | None = None  # the stop of the command in this process

    def __init__(self) -> None:
        self.asked = False
        self.at_once = True  # False: the command checks `asked`
        self._handle_now = self._ignore
        self._ends_process = False
        self._holds = 0
        self._before: dict[int, signal._HANDLER] = {}
        self._hook = sys.unraisablehook

    @classmethod
    def current(cls) -> Stop:
        """Return the stop of the running command; outside of one, a stop that is never requested."""
        return cls._of_command or cls()

    def begin(self) -> None:
        """Let a signal end the process at once during imports, when there is nothing to undo."""
        self._ends_process = True
        self._handle_now = self._leave
        self._install()

    def __enter__(self) -> Stop:
        if not self._before:
            self._install()
        Stop._of_command = self
        self._handle_now = self._stop
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Call `end`. If a signal comes just before, the handler of Stopped must call it."""
        self.end()

    def end(self) -> None:
        """Ignore signals if the process ends now; else restore the former handlers."""
        self._handle_now = self._ignore
        Stop._of_command = None
        for number, handler in self._before.items():
            signal.signal(number, signal.SIG_IGN if self._ends_process else handler)
        self._before = {}
        sys.unraisablehook = self._hook

    def ask(self) -> None:
        """Request the end without a signal, from any thread."""
        self.asked = True

    def hold(self) -> None:
        """Hold Stopped back until `release`."""
        self._holds += 1

    def release(self) -> None:
        """Let signals raise Stopped again; raise it now if one came meanwhile."""
        self._holds -= 1
        if self.asked and self._handle_now == self._stop:
            self._stop()

    def listen(self) -> None:
        """Let signals raise Stopped again if the raised one was swallowed and the command still runs."""
        if Stop._of_command is not self:
            return
        self._handle_now = self._stop
        for number in self._before:
            signal.signal(number, self._handle)

    def _install(self) -> None:
        numbers = [signal.SIGINT, signal.SIGTERM]
        if sys.platform != "win32":
            numbers.append(signal.SIGQUIT)
            if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
                numbers.append(signal.SIGHUP)
        self._before = {number: signal.signal(number, self._handle) for number in numbers}
        self._hook, sys.unraisablehook = sys.unraisablehook, self._told

    def _handle(self, number: int, frame: FrameType | None) -> None:
        self._handle_now()

    def _leave(self) -> None:
        os._exit(DONE)  # an exception during an import could appear as a traceback, or be lost

    def _ignore(self) -> None:
        pass

    def _stop(self) -> None:
        self.asked = True
        if self.at_once and not self._holds:
            self._be_deaf()
            raise Stopped(self)

    def _be_deaf(self) -> None:
        """Block handlers while Stopped propagates: Python fails if a handler runs in C code that continues.

        For several simultaneous signals Python calls the handlers one after the other. So this calls the others first.
        """
        self._handle_now = self._ignore
        signal.raise_signal(next(iter(self._before)))
        for number in self._before:
            signal.signal(number, signal.SIG_IGN)

    def _told(self, args: sys.UnraisableHookArgs) -> None:
        """Try again if Stopped was raised where nobody can catch it, such as in the callback of a weak reference."""
        if isinstance(args.exc_value, Stopped):
            import threading  # imported late, as it is hardly ever needed

            again = threading.Timer(_AGAIN_S, self._signal_again)
            again.daemon = True
            again.start()
        elif not (isinstance(args.exc_value, OSError) and _DEAF in str(args.exc_value)):
            self._hook(args)

    def _signal_again(self) -> None:
        """Send the main thread a signal, which interrupts a system call as well."""
        if Stop._of_command is not self:
            return
        if sys.platform == "win32":
            signal.raise_signal(signal.SIGINT)
        else:
            import threading

            signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGTERM)


class held:
    """Hold Stopped back in a `with`, in the main thread. Keep it short: a signal waits for its end."""

    def __enter__(self) -> None:
        self._stop = Stop.current()
        self._stop.hold()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Release it; may raise Stopped."""
        self._stop.release()
