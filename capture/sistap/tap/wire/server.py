# SPDX-License-Identifier: GPL-2.0-or-later
"""The end of the wire that listens: its address, and all connections served at once.

An address is HOST:PORT, or a PATH for a Unix socket. No connection can block another.
"""

from __future__ import annotations

import contextlib
import selectors
import socket
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Generic, TypeVar

from sistap.tap.line.clock import monotonic_ns


class Listening:
    """A listening socket that never blocks."""

    def __init__(self, address: str) -> None:
        """Listen at HOST:PORT or at a PATH. Raise OSError; or ValueError for an invalid address."""
        self._path: Path | None = None
        if "/" in address:
            self._path = Path(address).absolute()
            self.socket = _listen_path(self._path)
            self.name = f"bus://{self._path}"
        else:
            host, port = _host_port(address)
            family = socket.AF_INET6 if ":" in host else socket.AF_INET
            self.socket = socket.create_server((host, port), family=family)
            shown = f"[{host}]" if ":" in host else host
            self.name = f"bus://{shown}:{self.socket.getsockname()[1]}"
        self.socket.setblocking(False)

    def accept(self) -> socket.socket | None:
        """Accept a connection; return None if nobody waits any more."""
        try:
            connection, _ = self.socket.accept()
            connection.setblocking(False)
            if not self._path:
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except OSError:
            return None
        return connection

    def close(self) -> None:
        """Stop listening."""
        self.socket.close()
        if self._path:
            self._path.unlink(missing_ok=True)


def _host_port(address: str) -> tuple[str, int]:
    host, colon, port = address.rpartition(":")
    if not colon or not port.isdecimal() or int(port) > 0xFFFF:
        raise ValueError(f"'{address}' is neither HOST:PORT nor a PATH with a / (for example 127.0.0.1:0 or ./bus)")
    return host.strip("[]") or "127.0.0.1", int(port)


def _listen_path(path: Path) -> socket.socket:
    """Listen at a path. Replace a socket that a bus left behind, but nothing else."""
    if sys.platform == "win32":
        raise ValueError(f"'{path}': Windows has no sockets that are files: use HOST:PORT (for example 127.0.0.1:0)")
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        if path.is_socket() and not _alive(path):
            path.unlink()
        listener.bind(str(path))
        listener.listen()
    except OSError:
        listener.close()
        raise
    return listener


def _alive(path: Path) -> bool:
    if sys.platform == "win32":
        return False
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
        return probe.connect_ex(str(path)) == 0


MOST = 32  # at once; others are turned away
_AT_ONCE = 4  # accepted or turned away before the present peers get their turn
_PIECE = 4096  # bytes read from one peer before the others get their turn
_LEAVE_S = 2.0  # time for a peer to notice the end
_QUIET_NS = 10_000_000_000  # pause after a message about a rejected connection: repeated attempts are no news


class Peer:
    """One connection. Data wait here until the system accepts them."""

    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection
        self.came_ns = monotonic_ns()
        self._waiting = bytearray()

    @property
    def waiting(self) -> int:
        """Return how many bytes wait."""
        return len(self._waiting)

    def put(self, data: bytes) -> None:
        """Queue data for sending."""
        self._waiting += data

    def take(self, data: bytes) -> None:  # noqa: B027
        """Take what the peer says; the default ignores it. ValueError says why the connection must end."""

    def send(self) -> bool:
        """Send what the system accepts; return whether the peer is still connected."""
        try:
            while self._waiting and (sent := self.connection.send(self._waiting)):
                del self._waiting[:sent]
        except BlockingIOError:
            return True
        except OSError:
            return False
        return True


P = TypeVar("P", bound=Peer)


class Peers(Generic[P]):
    """All connections."""

    def __init__(self, address: str, welcome: Callable[[socket.socket], P], say: Callable[[str], None]) -> None:
        """Listen at an address; `welcome` makes a peer of a connection. May raise OSError; ValueError for an invalid
        address.
        """
        self._listening = Listening(address)
        self.name = self._listening.name
        self._welcome = welcome
        self._say = say
        self._turned_away_ns: int | None = None  # time of the last message about it
        self._leaving = False
        self._peers: dict[socket.socket, P] = {}
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listening.socket, selectors.EVENT_READ)

    def __iter__(self) -> Iterator[P]:
        """Yield the connected peers; some may be dropped meanwhile."""
        return iter(list(self._peers.values()))

    def attend(self, timeout_s: float | None) -> None:
        """Accept a connection, read from the peers and send to them; wait no longer than the given time."""
        self.send()
        for key, events in self._selector.select(timeout_s):
            peer = self._peers.get(key.fileobj)  # type: ignore[call-overload] # only sockets are registered
            if key.fileobj is self._listening.socket:
                self._let_in()
            elif peer and events & selectors.EVENT_READ:
                self._hear(peer)
        self.send()

    def send(self) -> None:
        """Send what waits, as far as the system accepts it."""
        for peer in self:
            waited = peer.waiting
            if waited and not peer.send():
                self.drop(peer)
            elif waited:
                events = selectors.EVENT_READ | (selectors.EVENT_WRITE if peer.waiting else 0)
                self._selector.modify(peer.connection, events)

    def drop(self, peer: P, why: str = "") -> None:
        """End a connection, and report why."""
        if self._peers.pop(peer.connection, None):
            self._selector.unregister(peer.connection)
            peer.connection.close()
            if why:
                self._say(f"closed a connection: {why}")

    def close(self) -> None:
        """End all connections after everything was delivered: closing with unread data would discard it."""
        self._leaving = True
        self._selector.unregister(self._listening.socket)
        self._listening.close()
        end_ns = monotonic_ns() + int(_LEAVE_S * 1e9)
        self._attend_until(lambda: not any(peer.waiting for peer in self), end_ns)
        for peer in self:
            with contextlib.suppress(OSError):
                peer.connection.shutdown(socket.SHUT_WR)
        self._attend_until(lambda: not self._peers, end_ns)
        for peer in self:
            self.drop(peer)
        self._selector.close()

    def _attend_until(self, done: Callable[[], bool], end_ns: int) -> None:
        while not done() and (left_ns := end_ns - monotonic_ns()) > 0:
            self.attend(left_ns / 1e9)

    def _let_in(self) -> None:
        for _ in range(_AT_ONCE):
            connection = self._listening.accept()
            if connection is None:
                return
            if len(self._peers) >= MOST:
                self._turn_away(connection, f"{MOST} are connected already")
            else:
                self._peers[connection] = self._welcome(connection)
                self._selector.register(connection, selectors.EVENT_READ)

    def _turn_away(self, connection: socket.socket, why: str) -> None:
        connection.close()
        now = monotonic_ns()
        if self._turned_away_ns is None or now - self._turned_away_ns >= _QUIET_NS:
            self._turned_away_ns = now
            self._say(f"refused a connection: {why}")

    def _hear(self, peer: P) -> None:
        try:
            data = peer.connection.recv(_PIECE)
            if data and not self._leaving:
                peer.take(data)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        except ValueError as error:
            self.drop(peer, str(error))
            return
        if not data:
            self.drop(peer)
