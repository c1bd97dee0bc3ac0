# SPDX-License-Identifier: GPL-2.0-or-later
"""The listeners of a served line. sistap discards what they send, so none can change or delay anything here."""

from __future__ import annotations

import socket
from collections.abc import Callable, Sequence

from sistap.line import bus_socket
from sistap.line.bus_socket import Hello
from sistap.line.clock import CLOCK
from sistap.line.clocks import monotonic_ns
from sistap.line.peers import Peer, Peers
from sistap.line.settings import LineSettings, Notice, Read
from sistap.line.sockets import Network

ROOM = 1 << 20  # bytes that may wait for a listener: about a minute of a busy line
TELL_NS = 500_000_000  # interval between two messages with the time
PATIENCE_NS = 60_000_000_000  # longest wait for an answer to such a message


class Listener(Peer):
    """A connection to one listener."""

    def __init__(self, connection: socket.socket, settings: LineSettings) -> None:
        """Begin with nothing missing; `settings` are those that the listener was told."""
        super().__init__(connection)
        self.heard_ns = self.came_ns
        self._settings = settings
        self._missing = 0  # characters lost behind the data that waits

    def take(self, data: bytes) -> None:  # noqa: ARG002 - whatever it is
        """Note that the listener is alive; discard what it sent."""
        self.heard_ns = monotonic_ns()

    def hear(self, read: Read, packed: bytes) -> None:
        """Send what was read, or count it as missing."""
        if not self._has_room:
            self._missing += len(read.data)
            return
        if read.settings and read.settings != self._settings:
            self._settings = read.settings
            self.put(bus_socket.pack_settings(read.settings))
        self.put(packed)

    def tell(self, message: bytes) -> None:
        """Send a message that the listener can do without."""
        if self._has_room:
            self.put(message)

    def catch_up(self) -> None:
        """Resume once the listener has read half of what waited."""
        if self._missing and self.waiting < ROOM // 2:
            self.put(bus_socket.pack_lost(self._missing))
            self._missing = 0

    @property
    def _has_room(self) -> bool:
        return not self._missing and self.waiting < ROOM


class Listeners:
    """All listeners of a served line."""

    def __init__(self, address: str, allowed: Sequence[Network], say: Callable[[str], None]) -> None:
        """Listen at an address. Raise OSError; or ValueError if it is not an address."""
        self._peers = Peers(address, self._welcome, say, allowed)
        self.name = self._peers.name
        self._hello: Hello | None = None
        self._settings = LineSettings()
        self._place = 0
        self._told_ns = 0

    def begin(self, hello: Hello, settings: LineSettings) -> None:
        """Set the greeting of new listeners. It carries the time and the position at which each of them joins."""
        self._hello = hello
        self._settings = settings

    def publish(self, read: Read) -> None:
        """Send what was read to all listeners."""
        self._place += len(read.data)
        self._settings = read.settings or self._settings
        packed = bus_socket.pack_read(read)
        for listener in self._peers:
            listener.hear(read, packed)

    def notice(self, notice: Notice) -> None:
        """Tell all listeners that something has happened."""
        self._tell(bus_socket.pack_notice(notice))

    def attend(self, before_ns: int) -> None:
        """Serve the listeners without blocking. Everything that arrived before `now` was published."""
        if before_ns - self._told_ns >= TELL_NS:
            self._told_ns = before_ns
            self._tell(bus_socket.pack_time(CLOCK.wall_ns(before_ns)))
            for listener in self._peers:
                if before_ns - listener.heard_ns > PATIENCE_NS:
                    self._peers.drop(listener, f"no answer for {PATIENCE_NS // 1_000_000_000} s")
        self._peers.attend(0)
        for listener in self._peers:
            listener.catch_up()

    def close(self) -> None:
        """Send what remains, then close all connections."""
        self._peers.close()

    def _tell(self, message: bytes) -> None:
        for listener in self._peers:
            listener.tell(message)

    def _welcome(self, connection: socket.socket) -> Listener:
        listener = Listener(connection, self._settings)
        if self._hello:
            hello = self._hello._replace(time_ns=CLOCK.now_ns(), place=self._place)
            listener.put(bus_socket.pack_hello(hello) + bus_socket.pack_settings(self._settings))
        return listener
