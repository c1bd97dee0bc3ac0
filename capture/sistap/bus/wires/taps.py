# SPDX-License-Identifier: GPL-2.0-or-later
"""The bus at a socket: taps connect, say their line settings and get reads with times and errors
(sistap.line.bus_socket).

A tap that stops reading holds up the bus once the buffers are full, and so loses nothing.
"""

from __future__ import annotations

import contextlib
import random
import select
import socket
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from sistap.bus.playing.hearing import received
from sistap.bus.playing.played import Character, Played, reads, uncertainty
from sistap.bus.wires.pace import Pace
from sistap.line import bus_socket
from sistap.line.settings import LineSettings, Read

_LEAVE_S = 2.0  # how long a tap may take to notice that the bus has ended
_TICK_NS = 1_000_000_000  # so often, at least, does a tap hear of simulated time


class Tap:
    """One connected tap."""

    def __init__(self, connection: socket.socket, seed: int) -> None:
        """Wait for its settings."""
        self.connection = connection
        self.settings: LineSettings | None = None
        self._noise = random.Random(f"{seed} tap")
        self._decoder = bus_socket.Decoder()
        self._dealt_with_ns: int | None = None  # all before this; None: this tap does not tell

    def receive(self) -> bool:
        """Take what it says; False if it has left or speaks something else."""
        try:
            data = self.connection.recv(4096)
            for message in self._decoder.feed(data):
                if isinstance(message, LineSettings):
                    self.settings = message
                    self.connection.sendall(bus_socket.pack_settings(message))
                elif isinstance(message, bus_socket.Time):
                    self._dealt_with_ns = message.time_ns
        except OSError:
            return False
        except ValueError as error:
            print(f"sistap bus: closed a connection: {error}", file=sys.stderr)
            return False
        return bool(data)

    def wait(self, wall_ns: int) -> bool:
        """Say that nothing arrives before this time, wait until what did is dealt with; False if it has left."""
        if self._dealt_with_ns is None:
            return True
        try:
            self.connection.sendall(bus_socket.pack_time(wall_ns))
        except OSError:
            return False
        while self._dealt_with_ns < wall_ns:
            if not self.receive():
                return False
        return True

    def send(self, read: Sequence[Character], played: Played, wall_ns: int) -> bool:
        """Send one read of what was played, heard with the tap's own settings; False if it has left."""
        if self.settings is None:
            return True
        heard = [received(character, played.settings, self.settings, self._noise) for character in read]
        values, flags = bytes(value for value, _ in heard), bytes(flag for _, flag in heard)
        uncertainty_ns = max(uncertainty(read), played.uncertainty_ns)
        try:
            self.connection.sendall(bus_socket.pack_read(Read(played.line, wall_ns, values, flags, uncertainty_ns)))
        except OSError:
            return False
        return True

    def leave(self) -> None:
        """End the connection so that the tap gets everything: closing with something unread would throw it away."""
        with contextlib.suppress(OSError):
            self.connection.shutdown(socket.SHUT_WR)
            self.connection.settimeout(_LEAVE_S)
            until = time.monotonic() + _LEAVE_S
            while self.connection.recv(4096) and time.monotonic() < until:
                pass
        self.connection.close()


class Taps:
    """A listening socket and the taps that came."""

    def __init__(  # noqa: PLR0913 - what the bus is, and how it is to be heard
        self, pace: Pace, address: str, seed: int, most: int
    ) -> None:
        """Listen at HOST:PORT or at a PATH; reads have `most` characters. May raise OSError; ValueError: no address."""
        self._pace = pace
        self._seed = seed
        self._now = 0  # so far taps know the time
        self._most = most
        self._taps: list[Tap] = []
        self._path: Path | None = None
        if "/" in address:
            self._path = Path(address).absolute()
            self._listener = _listen_path(self._path)
            self.name = f"bus://{self._path}"
        else:
            host, port = _host_port(address)
            family = socket.AF_INET6 if ":" in host else socket.AF_INET
            self._listener = socket.create_server((host, port), family=family)
            shown = f"[{host}]" if ":" in host else host
            self.name = f"bus://{shown}:{self._listener.getsockname()[1]}"

    @property
    def deserted(self) -> bool:
        """Whether the last tap has left; simulated time then stops, real time goes on."""
        return self._pace.simulated and not self._heard

    def wait_for_listener(self) -> None:
        """Wait until a tap has said its settings."""
        while not self._heard:
            self._attend(None)
        self._pace.start()

    def deliver(self, played: Played) -> list[str]:
        """Send all reads at their times."""
        line = played.settings
        self._attend(0)
        if self._pace.simulated:
            self._pass_time(played.time_ns - line.character_ns)
        for read in reads(played.characters, self._most, line.character_ns):
            time_ns = read[-1].time_ns
            self._pace.wait_until(time_ns)
            if not self._pace.simulated:
                self._attend(0)
            wall_ns = self._pace.wall_ns(time_ns)
            self._keep([tap for tap in self._taps if tap.send(read, played, wall_ns)])
            self._now = time_ns
        return []

    def _pass_time(self, until_ns: int) -> None:
        """Let simulated time go on, with the taps that want to know it."""
        while self._now < until_ns:
            self._now = min(self._now + _TICK_NS, until_ns)
            wall_ns = self._pace.wall_ns(self._now)
            self._keep([tap for tap in self._taps if tap.wait(wall_ns)])

    def close(self) -> None:
        """End all connections."""
        self._listener.close()
        if self._path:
            self._path.unlink(missing_ok=True)
        for tap in self._taps:
            tap.leave()

    @property
    def _heard(self) -> bool:
        """Whether anybody who connected has turned out to be a tap."""
        return any(tap.settings for tap in self._taps)

    def _attend(self, timeout_s: float | None) -> None:
        """Let new taps in and hear what taps say."""
        sockets = [self._listener, *(tap.connection for tap in self._taps)]
        ready, _, _ = select.select(sockets, [], [], timeout_s)
        if self._listener in ready:
            connection, _ = self._listener.accept()
            if self._path is None:
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._taps.append(Tap(connection, self._seed))
        self._keep([tap for tap in self._taps if tap.connection not in ready or tap.receive()])

    def _keep(self, staying: list[Tap]) -> None:
        for tap in self._taps:
            if tap not in staying:
                tap.connection.close()
        self._taps = staying


def _host_port(address: str) -> tuple[str, int]:
    host, colon, port = address.rpartition(":")
    if not colon or not port.isdecimal() or int(port) > 0xFFFF:
        raise ValueError(f"'{address}' is neither HOST:PORT nor a PATH with a / (for example 127.0.0.1:0 or ./bus)")
    return host.strip("[]") or "127.0.0.1", int(port)


def _listen_path(path: Path) -> socket.socket:
    """Listen at a path; a socket that a bus left behind is replaced, anything else is not."""
    if sys.platform == "win32":
        raise ValueError(f"'{path}': Windows has no sockets that are files: say HOST:PORT (for example 127.0.0.1:0)")
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
