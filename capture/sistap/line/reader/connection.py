# SPDX-License-Identifier: GPL-2.0-or-later
"""The connection to a virtual bus or a distant tap, up to its introduction."""

from __future__ import annotations

import socket
import sys
from typing import NamedTuple
from urllib.parse import urlsplit

from sistap.line import bus_socket
from sistap.line.clock import CLOCK
from sistap.line.reader.contract import PortError
from sistap.line.reader.trouble import connection_trouble

TIMEOUT_S = 5


class Connection(NamedTuple):
    """A connection, and what came over it."""

    socket: socket.socket
    decoder: bus_socket.Decoder
    hello: bus_socket.Hello
    after_hello: list[bus_socket.Message]
    ahead_ns: int  # how far our clock is ahead of the other end's
    ahead_by_ns: int  # largest error of ahead_ns


def connect(port: str) -> Connection:
    """Connect to bus://HOST:PORT or bus:///SOCKET. May raise PortError."""
    asked_ns = CLOCK.now_ns()
    try:
        connection = _connected(port)
        try:
            return _greeted(connection, asked_ns)
        except BaseException:
            connection.close()
            raise
    except ValueError as error:
        raise PortError(f"{port}: {error}: give the address that `sistap bus` or `sistap serve` prints") from error
    except OSError as error:
        raise PortError(connection_trouble(port, error)) from error


def _greeted(connection: socket.socket, asked_ns: int) -> Connection:
    """Wait for the first message. OSError, or ValueError if it is another one."""
    connection.settimeout(TIMEOUT_S)
    decoder = bus_socket.Decoder()
    hello, *others = _received(connection, decoder)
    heard_ns = CLOCK.now_ns()
    if not isinstance(hello, bus_socket.Hello):
        raise ValueError("it does not say what it is")  # noqa: TRY004 - a wrong value on the wire
    while hello.kind == bus_socket.Kind.TAP and not others:  # its settings
        others = _received(connection, decoder)
    ahead_ns = hello.time_ns - (asked_ns + heard_ns) // 2
    return Connection(connection, decoder, hello, others, ahead_ns, (heard_ns - asked_ns) // 2)


def _received(connection: socket.socket, decoder: bus_socket.Decoder) -> list[bus_socket.Message]:
    """Wait for messages. May raise OSError or ValueError."""
    messages: list[bus_socket.Message] = []
    while not messages:
        data = connection.recv(4096)
        if not data:
            raise OSError(
                0, "the other end closes the connection at once: its --allow must name you, and it may be full"
            )
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
