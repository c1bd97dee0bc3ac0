# SPDX-License-Identifier: GPL-2.0-or-later
"""The connection to a virtual bus, up to its introduction; and its reader."""

from __future__ import annotations

import socket
import sys
from collections import deque
from contextlib import suppress
from typing import NamedTuple
from urllib.parse import urlsplit

from sistap.tap.line.clock import monotonic_ns
from sistap.tap.line.reader.contract import PortError, PortLost
from sistap.tap.line.reader.trouble import connection_trouble
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.wire import protocol

TIMEOUT_S = 5  # for the connection, and for all of its introduction


class Connection(NamedTuple):
    """A connection, and what came over it."""

    socket: socket.socket
    decoder: protocol.Decoder
    hello: protocol.Hello
    after_hello: list[protocol.Message]


def connect(port: str) -> Connection:
    """Connect to bus://HOST:PORT or bus:///SOCKET. May raise PortError."""
    try:
        connection = _connected(port)
        try:
            return _greeted(connection)
        except BaseException:
            connection.close()
            raise
    except ValueError as error:
        raise PortError(f"{port}: {error}") from error
    except OSError as error:
        raise PortError(connection_trouble(port, error)) from error


def _greeted(connection: socket.socket) -> Connection:
    """Wait for the first message. OSError, or ValueError if it is another one."""
    end_ns = monotonic_ns() + TIMEOUT_S * 1_000_000_000
    decoder = protocol.Decoder()
    hello, *others = _received(connection, decoder, end_ns)
    if not isinstance(hello, protocol.Hello):
        raise ValueError(f"it does not say what it is{protocol.CURE}")  # noqa: TRY004 - a wrong value on the wire
    return Connection(connection, decoder, hello, others)


def _received(connection: socket.socket, decoder: protocol.Decoder, end_ns: int) -> list[protocol.Message]:
    """Wait for messages until then. May raise OSError, TimeoutError or ValueError."""
    messages: list[protocol.Message] = []
    while not messages:
        left_ns = end_ns - monotonic_ns()
        if left_ns <= 0:
            raise TimeoutError
        connection.settimeout(left_ns / 1e9)
        data = connection.recv(4096)
        if not data:
            raise OSError(0, "the other end closes the connection at once: it may be full")
        messages = decoder.feed(data)
    return messages


def _connected(port: str) -> socket.socket:
    """Connect. OSError, or PortError for an invalid address."""
    try:
        url = urlsplit(port)
        host, number, path = url.hostname, url.port, url.path
        if host and number:
            return socket.create_connection((host, number), TIMEOUT_S)
    except ValueError:  # also for an impossible host such as "a..b"
        host, path = None, ""
    if host or not path:
        raise PortError(f"{port} is not the address of a bus: write bus://HOST:PORT or bus:///SOCKET")
    if sys.platform == "win32":
        raise PortError(f"{port}: Windows has no sockets that are files: start the bus with --listen HOST:PORT")
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    connection.settimeout(TIMEOUT_S)
    connection.connect(path)
    return connection


class WireReader:
    """Reads the socket of a virtual bus (sistap.tap.wire.protocol). Its reads have their own times, errors and line."""

    notes: tuple[str, ...] = ()

    def __init__(self, port: str, settings: LineSettings, line: int = 0) -> None:
        """Connect, and send the line settings. May raise PortError."""
        connection = connect(port)
        self.name = port
        self.adapter = connection.hello.adapter
        self.timing = connection.hello.timing
        self.settings = settings
        self.line = line
        self._socket = connection.socket
        try:
            # First the time: simulated time must wait for this reader. The bus begins with the settings.
            self._socket.sendall(protocol.pack_time(0) + protocol.pack_settings(settings))
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
            self._socket.sendall(protocol.pack_settings(settings))

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
            raise PortLost(f"{self.name}: {error}") from error
        if not data:
            raise PortLost(f"the bus has ended ({self.name}): start it and a new capture")

    def _take(self, message: protocol.Message) -> None:
        if isinstance(message, LineSettings):
            self._heard_with = message
            return
        if isinstance(message, protocol.Time):
            self._answer = protocol.pack_time(message.time_ns)
            message = Read(0, message.time_ns, b"", b"", 0)
        if isinstance(message, Read):  # a bus sends nothing else
            self._reads.append(message._replace(line=self.line or message.line, settings=self._heard_with))

    def close(self) -> None:
        """Leave the bus."""
        self._socket.close()
