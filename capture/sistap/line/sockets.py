# SPDX-License-Identifier: GPL-2.0-or-later
"""Where the wire is: HOST:PORT, or a PATH, which is a socket among files; and who may come there."""

from __future__ import annotations

import ipaddress
import socket
import sys
from collections.abc import Sequence
from pathlib import Path

IP = ipaddress.IPv4Address | ipaddress.IPv6Address
Network = ipaddress.IPv4Network | ipaddress.IPv6Network


class Listening:
    """A socket that listens, and never waits."""

    def __init__(self, address: str) -> None:
        """Listen at HOST:PORT or at a PATH. May raise OSError; ValueError: it is no address."""
        self._path: Path | None = None
        if "/" in address:
            self._path = Path(address).absolute()
            self.socket = _listen_path(self._path)
            self.name = f"bus://{self._path}"
        else:
            host, port = host_port(address)
            family = socket.AF_INET6 if ":" in host else socket.AF_INET
            self.socket = socket.create_server((host, port), family=family)
            shown = f"[{host}]" if ":" in host else host
            self.name = f"bus://{shown}:{self.socket.getsockname()[1]}"
        self.socket.setblocking(False)

    def accept(self) -> tuple[socket.socket, IP | None] | None:
        """Let somebody in: the connection and the address, which a path has not; None if nobody is there any more."""
        try:
            connection, address = self.socket.accept()
            connection.setblocking(False)
            if self._path:
                return connection, None
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except OSError:
            return None
        return connection, plain_ip(address[0])

    def close(self) -> None:
        """Listen no more."""
        self.socket.close()
        if self._path:
            self._path.unlink(missing_ok=True)


def host_port(address: str) -> tuple[str, int]:
    """Read HOST:PORT. ValueError says what is wrong."""
    host, colon, port = address.rpartition(":")
    if not colon or not port.isdecimal() or int(port) > 0xFFFF:
        raise ValueError(f"'{address}' is neither HOST:PORT nor a PATH with a / (for example 127.0.0.1:0 or ./bus)")
    return host.strip("[]") or "127.0.0.1", int(port)


def plain_ip(text: str) -> IP:
    """Read an address, without the scope behind it; an IPv4 address in IPv6 clothes is that IPv4 address."""
    ip = ipaddress.ip_address(text.partition("%")[0])
    return getattr(ip, "ipv4_mapped", None) or ip


def may_come(ip: IP | None, allowed: Sequence[Network]) -> bool:
    """Tell whether this computer or one of the networks has an address."""
    return ip is None or ip.is_loopback or any(ip in network for network in allowed)


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
