# SPDX-License-Identifier: GPL-2.0-or-later
"""The wire over a socket: the characters of a virtual bus.

The messages (protocol), the end that listens for connections (server), and the reader (connection). It may use line.
line/reader imports `open_reader` when such a port is opened.
"""

from __future__ import annotations

from sistap.tap.line.reader.contract import Reader
from sistap.tap.line.settings import LineSettings


def open_reader(port: str, settings: LineSettings, line: int) -> Reader:
    """Open "bus://HOST:PORT" or "bus:///SOCKET", to read with these settings. PortError."""
    from sistap.tap.wire.connection import WireReader

    return WireReader(port, settings, line)
