# SPDX-License-Identifier: GPL-2.0-or-later
"""The wire over a socket: the characters of a virtual bus, or of a tap on another computer.

The messages (protocol), the end that listens for connections (server), and the two readers: of a bus (connection) and
of a tap (distant). It may use line. line/reader imports `open_reader` when such a port is opened.
"""

from __future__ import annotations

from sistap.tap.line.reader.contract import Reader
from sistap.tap.line.settings import LineSettings


def open_reader(port: str, settings: LineSettings, line: int) -> Reader:
    """Open "bus://HOST:PORT" or "bus:///SOCKET": a bus reads with these settings, a tap has its own. PortError."""
    from sistap.tap.wire.connection import WireReader, connect
    from sistap.tap.wire.distant import DistantReader
    from sistap.tap.wire.protocol import Kind

    connection = connect(port)
    if connection.hello.kind == Kind.TAP:
        return DistantReader(port, line, connection)
    return WireReader(port, settings, line, connection)
