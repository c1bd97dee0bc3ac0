# SPDX-License-Identifier: GPL-2.0-or-later
"""Readers: each returns what one read of a device, a pyserial URL, a virtual bus or an analyser delivered.

A reader only listens. It never writes to a port, sends no break and flushes no output. It lowers RTS and DTR: on many
adapters RTS switches the RS485 transmitter on.
"""

from __future__ import annotations

import sys

from sistap.line.analyser import is_analyser
from sistap.line.bus_socket import Kind
from sistap.line.reader.contract import Distant, Measuring, OwnTime, PortError, PortLost, Reader
from sistap.line.reader.several import Several, Source, together
from sistap.line.settings import LineSettings

__all__ = [
    "Distant",
    "Measuring",
    "OwnTime",
    "PortError",
    "PortLost",
    "Reader",
    "Several",
    "Source",
    "open_reader",
    "together",
]


def open_reader(port: str, settings: LineSettings, line: int = 0) -> Reader:
    """Open a device, a virtual bus or distant tap ("bus://..."), an analyser ("sigrok:...") or a pyserial URL.

    May raise PortError.
    """
    # Each reader is imported where it is needed, so that listing ports starts quickly.
    if port.startswith("bus://"):
        from sistap.line.reader.connection import connect

        connection = connect(port)
        if connection.hello.kind == Kind.TAP:
            from sistap.line.reader.distant import DistantReader

            return DistantReader(port, line, connection)
        from sistap.line.reader.virtual import WireReader

        return WireReader(port, settings, line, connection)
    if settings.baud <= 0:
        raise PortError(f"{port} needs a rate: give it with --baud")
    if is_analyser(port):
        from sistap.line.reader.sigrok import SigrokReader

        return SigrokReader(port, settings, line)
    if "://" in port:
        from sistap.line.reader.url import UrlReader

        return UrlReader(port, settings, line)
    if sys.platform == "win32":
        from sistap.line.reader.windows import WindowsReader

        return WindowsReader(port, settings, line)
    from sistap.line.reader.device import PosixReader

    return PosixReader(port, settings, line)
