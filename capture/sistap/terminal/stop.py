# SPDX-License-Identifier: GPL-2.0-or-later
"""The signals that end a command: SIGINT, SIGTERM, and SIGHUP (the terminal is gone) unless nohup had it ignored.

However many come, they end a command once. The first one raises Stopped wherever the command is, so that everything
that is open is closed on the way out. Others are ignored until the process has ended: they would only disturb that. A
command that must not be torn (a capture, while it writes) looks at `asked` instead.

Two things must not be torn anywhere: what makes something that somebody has to take away again, and what takes it away.
Both happen while Stopped is `held`. Everything else may be left at any instruction.

Nothing else of sistap is imported before this, so this imports next to nothing.
"""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType, TracebackType

from sistap.terminal.exits import DONE

_AGAIN_S = 0.01  # until a stop that was swallowed is tried again
_DEAF = "ignored due to race condition"  # what Python says of a signal that came just before it was ignored


class Stopped(BaseException):
    """A signal has asked for the end. It is no Exception: nobody who handles failures may take it for one."""

    def __init__(self, stop: Stop) -> None:
        """Belong to a stop, that has to know when this is gone."""
        super().__init__()
        self._stop = stop

    def __del__(self) -> None:
        self._stop.listen()


class Stop:
    """Whether the end was asked for, by a signal or by `ask`. A process has one.

    The handlers are our own because a job that a script starts with & inherits SIGINT ignored, and Python leaves it so.
    """

    _of_command: Stop | None = None  # of the one that runs in this process

    def __init__(self) -> None:
        self.asked = False
        self.at_once = True  # False: the command looks at `asked`
        self._handle_now = self._ignore
        self._ends_process = False
        self._holds = 0
        self._before: dict[int, signal._HANDLER] = {}
        self._hook = sys.unraisablehook

    @classmethod
    def current(cls) -> Stop:
        """Return the stop of the command that runs; outside of one, a stop that nobody asks for."""
        return cls._of_command or cls()

    def begin(self) -> None:
        """Let a signal end the process on the spot, as long as nothing has happened that has to be undone: imports."""
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
        """Call `end`. A signal can come just before: then whoever catches Stopped has to call it."""
        self.end()

    def end(self) -> None:
        """Ignore signals if the process ends now; else put back the handlers that were there before."""
        self._handle_now = self._ignore
        Stop._of_command = None
        for number, handler in self._before.items():
            signal.signal(number, signal.SIG_IGN if self._ends_process else handler)
        self._before = {}
        sys.unraisablehook = self._hook

    def ask(self) -> None:
        """Ask for the end without a signal, from whatever thread."""
        self.asked = True

    def hold(self) -> None:
        """Let nothing raise Stopped until `release`."""
        self._holds += 1

    def release(self) -> None:
        """Let signals raise Stopped again; raise it now if one came meanwhile."""
        self._holds -= 1
        if self.asked and self._handle_now == self._stop:
            self._stop()

    def listen(self) -> None:
        """Let signals raise Stopped again, if somebody has swallowed the one that was raised, and the command runs."""
        if Stop._of_command is not self:
            return
        self._handle_now = self._stop
        for number in self._before:
            signal.signal(number, self._handle)

    def _install(self) -> None:
        numbers = [signal.SIGINT, signal.SIGTERM]
        if sys.platform != "win32" and signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
            numbers.append(signal.SIGHUP)
        self._before = {number: signal.signal(number, self._handle) for number in numbers}
        self._hook, sys.unraisablehook = sys.unraisablehook, self._told

    def _handle(self, number: int, frame: FrameType | None) -> None:
        self._handle_now()

    def _leave(self) -> None:
        os._exit(DONE)  # an exception could come out as a traceback, or be lost, in the middle of an import

    def _ignore(self) -> None:
        pass

    def _stop(self) -> None:
        self.asked = True
        if self.at_once and not self._holds:
            self._be_deaf()
            raise Stopped(self)

    def _be_deaf(self) -> None:
        """Let no handler run while Stopped is on its way: in C code that goes on, Python itself stumbles over that.

        Of several signals that came at once, it calls the handlers one after the other. So this calls the others first.
        """
        self._handle_now = self._ignore
        signal.raise_signal(next(iter(self._before)))
        for number in self._before:
            signal.signal(number, signal.SIG_IGN)

    def _told(self, args: sys.UnraisableHookArgs) -> None:
        """Try again if Stopped was raised where nobody can catch it, such as in the callback of a weak reference."""
        if isinstance(args.exc_value, Stopped):
            import threading  # late, as it is hardly ever needed

            again = threading.Timer(_AGAIN_S, self._signal_again)
            again.daemon = True
            again.start()
        elif not (isinstance(args.exc_value, OSError) and _DEAF in str(args.exc_value)):
            self._hook(args)

    def _signal_again(self) -> None:
        """Send the main thread a signal, because that ends a system call, too."""
        if Stop._of_command is not self:
            return
        if sys.platform == "win32":
            signal.raise_signal(signal.SIGINT)
        else:
            import threading

            signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGTERM)


class held:
    """Hold Stopped back in a `with`, in the main thread. Nothing in it may take long: a signal waits for its end."""

    def __enter__(self) -> None:
        self._stop = Stop.current()
        self._stop.hold()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Let it go; may raise Stopped."""
        self._stop.release()
