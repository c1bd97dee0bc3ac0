# SPDX-License-Identifier: GPL-2.0-or-later
"""The address of the wire: HOST:PORT, or a PATH for a Unix socket; and who may connect."""

from __future__ import annotations

import ipaddress
import socket
import sys
from collections.abc import Sequence
from pathlib import Path

IP = ipaddress.IPv4Address | ipaddress.IPv6Address
Network = ipaddress.IPv4Network | ipaddress.IPv6Network


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
            host, port = host_port(address)
            family = socket.AF_INET6 if ":" in host else socket.AF_INET
            self.socket = socket.create_server((host, port), family=family)
            shown = f"[{host}]" if ":" in host else host
            self.name = f"bus://{shown}:{self.socket.getsockname()[1]}"
        self.socket.setblocking(False)

    def accept(self) -> tuple[socket.socket, IP | None] | None:
        """Accept a connection; return it and its address (a path has none), or None if nobody waits any more."""
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
        """Stop listening."""
        self.socket.close()
        if self._path:
            self._path.unlink(missing_ok=True)


def host_port(address: str) -> tuple[str, int]:
    """Parse HOST:PORT. ValueError says what is wrong."""
    host, colon, port = address.rpartition(":")
    if not colon or not port.isdecimal() or int(port) > 0xFFFF:
        raise ValueError(f"'{address}' is neither HOST:PORT nor a PATH with a / (for example 127.0.0.1:0 or ./bus)")
    return host.strip("[]") or "127.0.0.1", int(port)


def plain_ip(text: str) -> IP:
    """Parse an address without its scope; convert an IPv4-mapped IPv6 address to IPv4."""
    ip = ipaddress.ip_address(text.partition("%")[0])
    return getattr(ip, "ipv4_mapped", None) or ip


def may_come(ip: IP | None, allowed: Sequence[Network]) -> bool:
    """Tell whether an address belongs to this computer or to one of the networks."""
    return ip is None or ip.is_loopback or any(ip in network for network in allowed)


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
