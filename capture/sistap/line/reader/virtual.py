# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads a virtual bus."""

from __future__ import annotations

from collections import deque
from contextlib import suppress

from sistap.line import bus_socket
from sistap.line.reader.connection import Connection, connect
from sistap.line.reader.contract import PortError, PortLost
from sistap.line.reader.trouble import connection_trouble
from sistap.line.settings import LineSettings, Read


class WireReader:
    """Reads the socket of a virtual bus (sistap.line.bus_socket). Its reads have their own times, errors and line."""

    def __init__(self, port: str, settings: LineSettings, line: int = 0, connection: Connection | None = None) -> None:
        """Connect, if necessary, and send the line settings. May raise PortError."""
        connection = connection or connect(port)
        self.name = port
        self.adapter = connection.hello.adapter
        self.timing = connection.hello.timing
        self.notes = connection.hello.notes
        self.settings = settings
        self.line = line
        self._socket = connection.socket
        try:
            # First the time: simulated time must wait for this reader. The bus begins with the settings.
            self._socket.sendall(bus_socket.pack_time(0) + bus_socket.pack_settings(settings))
        except OSError as error:
            raise PortError(connection_trouble(port, error)) from error
        self._decoder = connection.decoder
        self._heard_with = settings
        self._reads: deque[Read] = deque()
        self._joined_ns = connection.hello.time_ns
        self._answer = b""  # for the bus, when everything before was processed
        for message in connection.after_hello:
            self._take(message)

    def read(self, timeout_s: float) -> Read | None:
        """Return what arrived; None if nothing arrived in that time. May raise PortLost.

        A read without characters gives the time of a bus with simulated time. The next call that may wait lets the bus
        continue.
        """
        if not self._reads:
            self._receive(timeout_s)
        return self._reads.popleft() if self._reads else None

    def now_ns(self) -> int:
        """Return the time on the bus when this reader joined: no character is older."""
        return self._joined_ns

    def change(self, settings: LineSettings) -> None:
        """Read with other settings from the bus's next character on."""
        self.settings = settings
        with suppress(OSError):  # the next read reports that the bus has ended
            self._socket.sendall(bus_socket.pack_settings(settings))

    def _receive(self, timeout_s: float) -> None:
        try:
            if self._answer and timeout_s:
                self._socket.sendall(self._answer)
                self._answer = b""
            self._socket.settimeout(timeout_s)
            data = self._socket.recv(65536)
            for message in self._decoder.feed(data):
                self._take(message)
        except (TimeoutError, BlockingIOError):
            return
        except OSError:
            data = b""
        except ValueError as error:
            raise PortLost(f"{self.name}: {error}: give the address that `sistap bus` prints") from error
        if not data:
            raise PortLost(f"the bus has ended ({self.name}): start it and a new capture")

    def _take(self, message: bus_socket.Message) -> None:
        if isinstance(message, LineSettings):
            self._heard_with = message
            return
        if isinstance(message, bus_socket.Time):
            self._answer = bus_socket.pack_time(message.time_ns)
            message = Read(0, message.time_ns, b"", b"", 0)
        if isinstance(message, Read):  # a bus sends nothing else
            self._reads.append(message._replace(line=self.line or message.line, settings=self._heard_with))

    def close(self) -> None:
        """Leave the bus."""
        self._socket.close()
