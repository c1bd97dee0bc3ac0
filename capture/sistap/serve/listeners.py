# SPDX-License-Identifier: GPL-2.0-or-later
"""Who listens to a served line. None of them can change anything here, or delay it: what they say is thrown away."""

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
TELL_NS = 500_000_000  # so often they are told the time
PATIENCE_NS = 60_000_000_000  # for an answer to that


class Listener(Peer):
    """One of them."""

    def __init__(self, connection: socket.socket, settings: LineSettings) -> None:
        """Begin with nothing missing; these are the settings that it was told."""
        super().__init__(connection)
        self.heard_ns = self.came_ns
        self._settings = settings
        self._missing = 0  # characters, behind what waits

    def take(self, data: bytes) -> None:  # noqa: ARG002 - whatever it is
        """Note that it is there."""
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
        """Send what it can do without."""
        if self._has_room:
            self.put(message)

    def catch_up(self) -> None:
        """Go on once it has read half of what waited."""
        if self._missing and self.waiting < ROOM // 2:
            self.put(bus_socket.pack_lost(self._missing))
            self._missing = 0

    @property
    def _has_room(self) -> bool:
        return not self._missing and self.waiting < ROOM


class Listeners:
    """All of them."""

    def __init__(self, address: str, allowed: Sequence[Network], say: Callable[[str], None]) -> None:
        """Listen at an address. May raise OSError; ValueError: it is no address."""
        self._peers = Peers(address, self._welcome, say, allowed)
        self.name = self._peers.name
        self._hello: Hello | None = None
        self._settings = LineSettings()
        self._place = 0
        self._told_ns = 0

    def begin(self, hello: Hello, settings: LineSettings) -> None:
        """Say this to whoever comes, with the time and the place of then."""
        self._hello = hello
        self._settings = settings

    def publish(self, read: Read) -> None:
        """Let them hear what was read."""
        self._place += len(read.data)
        self._settings = read.settings or self._settings
        packed = bus_socket.pack_read(read)
        for listener in self._peers:
            listener.hear(read, packed)

    def notice(self, notice: Notice) -> None:
        """Tell them that something has happened."""
        self._tell(bus_socket.pack_notice(notice))

    def attend(self, before_ns: int) -> None:
        """Do what is to be done for them, without waiting. All that arrived before an instant was published."""
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
        """Let them have what waits, and end."""
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
