# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads a distant tap: `sistap serve` on another computer."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue

from sistap.tap.line.clock import CLOCK, monotonic_ns
from sistap.tap.line.reader.contract import PortError
from sistap.tap.line.settings import Flag, Happening, LineSettings, Notice, Read
from sistap.tap.wire import protocol
from sistap.tap.wire.connection import Connection, connect

PATIENCE_NS = 10_000_000_000  # longest silence of the tap, which sends something every half second
AGAIN_S = 1.0  # pause before the next try
MOST_AGAIN_S = 60.0  # and when connections end soon, again and again
_STEADY_NS = 60_000_000_000  # a connection that lasts longer does not end soon
_AT_ONCE = 10  # messages of the tap that are passed on at once, then one a second

_OF_A_READER = bytes(flag & Flag.FROM_READER for flag in range(256))


class DistantReader:
    """Reads the socket of a distant tap; reconnects after the connection is lost.

    The tap defines its settings; nobody else sets them. It receives nothing but a sign of life.
    """

    settings_are_told = True

    def __init__(self, port: str, line: int, connection: Connection) -> None:
        """Continue with a connection on which only the first message was read."""
        self.name = port
        self.line = line
        self.adapter = f"{connection.hello.name}: {connection.hello.adapter}"
        self.timing = f"{_clock(connection, port)}; {connection.hello.timing}"
        self.notes = connection.hello.notes
        self.settings = next(
            (message for message in connection.after_hello if isinstance(message, LineSettings)), LineSettings(0)
        )
        self._reads: deque[Read] = deque()
        self._time_ns = connection.hello.time_ns  # everything up to here is known
        self._lost = False  # whether something is missing before the next character
        self._search: _Search | None = None
        self._pause_s = 0.0  # before the next search
        self._unsent = b""  # of the last answer
        self._all_again_ns = 0  # when _AT_ONCE messages may pass again
        self._left_out = 0  # messages since the last that passed
        self._begin(connection)

    def read(self, timeout_s: float) -> Read | None:
        """Return what arrived; None if nothing arrived in that time. A lost connection is no end."""
        if not self._reads:
            if self._connection:
                self._receive(self._connection, timeout_s)
            else:
                self._look(timeout_s)
            if self._left_out and self._passes():
                self._tell_left_out()
        return self._reads.popleft() if self._reads else None

    def now_ns(self) -> int:
        """Return the time there."""
        return CLOCK.now_ns() + self._ahead_ns

    def change(self, settings: LineSettings) -> None:  # noqa: ARG002 - whatever they are
        """Refuse: the settings are set at the tap."""
        raise PortError(f"{self.name}: set rate and format there, with the options of `sistap serve`")

    def close(self) -> None:
        """Leave the tap."""
        if self._connection:
            self._connection.socket.close()
        if self._search:
            self._search.give_up()

    def _begin(self, connection: Connection) -> None:
        self._connection: Connection | None = connection
        self._began_ns = connection.hello.began_ns
        self._place = connection.hello.place
        self._ahead_ns = connection.ahead_ns
        self._heard_ns = self._connected_ns = monotonic_ns()
        for message in connection.after_hello:
            self._take(message)

    def _receive(self, connection: Connection, timeout_s: float) -> None:
        try:
            connection.socket.settimeout(timeout_s)
            data = connection.socket.recv(65536)
            self._heard_ns = monotonic_ns()
            messages = connection.decoder.feed(data)
            for message in messages:
                self._take(message)
            if any(isinstance(message, protocol.Time) for message in messages):
                self._answer(connection)
            if not data:
                self._lose("its other end has closed it")
        except (TimeoutError, BlockingIOError):
            if monotonic_ns() - self._heard_ns > PATIENCE_NS:
                self._lose(f"nothing was heard for {PATIENCE_NS // 1_000_000_000} s")
        except OSError as error:
            self._lose(error.strerror or str(error))
        except ValueError as error:
            self._lose(str(error))

    def _take(self, message: protocol.Message) -> None:
        if isinstance(message, LineSettings):
            self.settings = message
        elif isinstance(message, protocol.Time):
            self._time_ns = message.time_ns
            self._reads.append(Read(self.line, message.time_ns, b"", b"", 0))
        elif isinstance(message, Read):
            self._time_ns = message.time_ns
            self._place += len(message.data)
            self._reads.append(self._own(message))
        elif isinstance(message, Notice):
            self._pass_on(message.happening, message.text)
        elif isinstance(message, protocol.Lost):
            self._place += message.characters
            self._miss(message.characters, "they were not taken in time here, or by the network", self._pass_on)

    def _own(self, read: Read) -> Read:
        """Convert a read of the tap into one of ours."""
        flags = read.flags.translate(_OF_A_READER)
        if self._lost and flags:
            flags = bytes([flags[0] | Flag.LOST_BEFORE]) + flags[1:]
            self._lost = False
        return read._replace(line=self.line, flags=flags, settings=self.settings)

    def _answer(self, connection: Connection) -> None:
        """Send the tap a sign of life, never waiting: without room, the tap does not read and does not miss it."""
        self._unsent = self._unsent or protocol.pack_time(self._time_ns)
        connection.socket.settimeout(0)
        with suppress(OSError):
            self._unsent = self._unsent[connection.socket.send(self._unsent) :]

    def _tell(self, happening: Happening, text: str) -> None:
        self._reads.append(Read(self.line, self._time_ns, b"", b"", 0, notices=(Notice(happening, text),)))

    def _miss(self, count: int, why: str, tell: Callable[[Happening, str], None]) -> None:
        self._lost = True
        tell(Happening.LOST, f"{count} character{'' if count == 1 else 's'} missing: {why}")

    def _pass_on(self, happening: Happening, text: str) -> None:
        """Tell what the tap says; of a flood only a little."""
        if self._passes():
            self._tell_left_out()
            self._tell(happening, text)
        else:
            self._left_out += 1

    def _passes(self) -> bool:
        now = monotonic_ns()
        if self._all_again_ns - now > (_AT_ONCE - 1) * 1_000_000_000:
            return False
        self._all_again_ns = max(self._all_again_ns, now) + 1_000_000_000
        return True

    def _tell_left_out(self) -> None:
        if self._left_out:
            self._tell(Happening.MARKER, f"the tap says too much: {self._left_out} of its messages are left out here")
        self._left_out = 0

    def _lose(self, why: str) -> None:
        """Begin to look for a new connection."""
        if self._connection:
            self._connection.socket.close()
        self._connection = None
        self._unsent = b""
        self._look_again(is_steady=monotonic_ns() - self._connected_ns > _STEADY_NS)
        self._tell(Happening.GONE, f"the connection to {self.name} is lost ({why}): trying until it is back")

    def _look_again(self, *, is_steady: bool = False) -> None:
        """Look for a new connection: at once after a long one, else after pauses that grow."""
        self._search = _Search(self.name, 0.0 if is_steady else self._pause_s)
        self._pause_s = AGAIN_S if is_steady else min(max(AGAIN_S, 2 * self._pause_s), MOST_AGAIN_S)

    def _look(self, timeout_s: float) -> None:
        """Continue with a new connection, if one appears in that time."""
        connection = self._search.found(timeout_s) if self._search else None
        if not connection:
            return
        self._search = None
        hello = connection.hello
        if hello.kind != protocol.Kind.TAP:
            connection.socket.close()
            self._look_again()
            return
        away = f"connected again after {(monotonic_ns() - self._heard_ns) / 1e9:.1f} s"
        missing = hello.place - self._place
        same = hello.began_ns == self._began_ns and missing >= 0
        self._time_ns = hello.time_ns
        if not same:
            what = f"{hello.name}: {hello.adapter}; {_clock(connection, self.name)}"
            text = f"{away}, to a tap that was started meanwhile ({what})"
            self._tell(Happening.ANEW, f"{text}: how many characters are missing is not known")
            self._lost = True
        elif missing:
            self._miss(missing, away, self._tell)
        else:
            self._tell(Happening.MARKER, f"{away}: no character is missing")
        self._begin(connection)


class _Search:
    """Tries to connect after a pause, in a thread of its own: resolving a host may take long."""

    def __init__(self, port: str, pause_s: float) -> None:
        self._port = port
        self._pause_s = pause_s
        self._found: SimpleQueue[Connection] = SimpleQueue()
        self._ended = threading.Event()
        threading.Thread(target=self._try, daemon=True).start()

    def found(self, timeout_s: float) -> Connection | None:
        """Return the connection once, if it is there in that time."""
        try:
            return self._found.get(timeout=timeout_s) if timeout_s else self._found.get_nowait()
        except Empty:
            return None

    def give_up(self) -> None:
        """Stop trying."""
        self._ended.set()

    def _try(self) -> None:
        self._ended.wait(self._pause_s)
        while not self._ended.is_set():
            with suppress(PortError):
                self._found.put(connect(self._port))
                return
            self._ended.wait(AGAIN_S)


def _clock(connection: Connection, port: str) -> str:
    """Describe the clock of the times."""
    ahead_ns, by_ms = connection.ahead_ns, connection.ahead_by_ns / 1e6
    which = "ahead of" if ahead_ns >= 0 else "behind"
    return f"times are of the clock at {port}, {abs(ahead_ns) / 1e9:.4f} s {which} this one, within {by_ms:.1f} ms"
