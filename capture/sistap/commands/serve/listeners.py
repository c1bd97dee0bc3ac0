# SPDX-License-Identifier: GPL-2.0-or-later
"""The listeners of a served line. sistap discards what they send, so none can change or delay anything here."""

from __future__ import annotations

import socket
from collections.abc import Callable, Sequence

from sistap.tap.line.clock import CLOCK, monotonic_ns
from sistap.tap.line.reader import Reader
from sistap.tap.line.settings import Happening, LineSettings, Notice, Read
from sistap.tap.records.record import Event, Record
from sistap.tap.wire import protocol
from sistap.tap.wire.protocol import Hello
from sistap.tap.wire.server import Network, Peer, Peers

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
            self.put(protocol.pack_settings(read.settings))
        self.put(packed)

    def tell(self, message: bytes) -> None:
        """Send a message that the listener can do without."""
        if self._has_room:
            self.put(message)

    def catch_up(self) -> None:
        """Resume once the listener has read half of what waited."""
        if self._missing and self.waiting < ROOM // 2:
            self.put(protocol.pack_lost(self._missing))
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
        packed = protocol.pack_read(read)
        for listener in self._peers:
            listener.hear(read, packed)

    def notice(self, notice: Notice) -> None:
        """Tell all listeners that something has happened."""
        self._tell(protocol.pack_notice(notice))

    def attend(self, before_ns: int) -> None:
        """Serve the listeners without blocking. Everything that arrived before `now` was published."""
        if before_ns - self._told_ns >= TELL_NS:
            self._told_ns = before_ns
            self._tell(protocol.pack_time(CLOCK.wall_ns(before_ns)))
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
            listener.put(protocol.pack_hello(hello) + protocol.pack_settings(self._settings))
        return listener


# -- What they hear --------------------------------------------------------------------------------------------------

_MOST_NS = 50_000_000  # longest time that listeners wait while characters come without a pause

# Events at the tap that listeners cannot detect themselves.
_HAPPENINGS = {Event.MARKER: Happening.MARKER, Event.ADAPTER_LOST: Happening.GONE}


class PublishedReader:
    """A reader that reads as the reader behind it does. Listeners get their turn when nothing waits to be read."""

    def __init__(self, reader: Reader, listeners: Listeners) -> None:
        self._reader = reader
        self._listeners = listeners
        self._attended_ns = 0
        self.name = reader.name
        self.adapter = reader.adapter
        self.timing = reader.timing
        self.notes = reader.notes
        self.settings = reader.settings
        self.line = reader.line

    def read(self, timeout_s: float) -> Read | None:
        """Return what arrived; None if nothing arrived in that time. May raise PortLost."""
        asked_ns = monotonic_ns()
        read = self._published(0)
        if read is None or asked_ns - self._attended_ns >= _MOST_NS:
            self._attended_ns = asked_ns
            self._listeners.attend(asked_ns)
        return read or self._published(timeout_s)

    def change(self, settings: LineSettings) -> None:
        """Read with other settings from now on. May raise PortError."""
        self._reader.change(settings)
        self.settings = self._reader.settings

    def close(self) -> None:
        """Release the port."""
        self._reader.close()

    def _published(self, timeout_s: float) -> Read | None:
        read = self._reader.read(timeout_s)
        if read:
            self._listeners.publish(read)
        return read


class EventSink:
    """A sink that sends the events among the records to the listeners. They make all other records themselves."""

    def __init__(self, listeners: Listeners) -> None:
        self._listeners = listeners

    def begin(self, *started: Record) -> None:
        """Do nothing: the first message has said it."""

    def write(self, record: Record) -> bool:
        """Send an event; ignore other records."""
        if (happening := _HAPPENINGS.get(record.event)) is not None:
            self._listeners.notice(Notice(happening, record.data.decode()))
        return False

    def look(self, time_ns: int) -> None:
        """Do nothing: there is no file."""

    def end(self, time_ns: int) -> None:
        """Do nothing: no file to close."""
