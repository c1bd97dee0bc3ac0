# SPDX-License-Identifier: GPL-2.0-or-later
"""Readers: each returns what one read of a device, a pyserial URL, a virtual bus or an analyser delivered.

A reader only listens. It never writes to a port, sends no break and flushes no output. It lowers RTS and DTR: on many
adapters RTS switches the RS485 transmitter on.
"""

from __future__ import annotations

import importlib
import sys

from sistap.tap.line.reader.contract import Exact, Measuring, OwnTime, PortError, PortLost, Reader, needs_rate
from sistap.tap.line.reader.several import Several, Source, together
from sistap.tap.line.settings import LineSettings

__all__ = [
    "Exact",
    "Measuring",
    "OwnTime",
    "PortError",
    "PortLost",
    "Reader",
    "Several",
    "Source",
    "together",
]


# Rooms that bring readers of other ports, each with an `open_reader`.
ELSEWHERE = {"bus://": "sistap.tap.wire", "sigrok:": "sistap.tap.analyser"}
WINDOWS = "sistap.tap.windows"


def open_reader(port: str, settings: LineSettings, line: int = 0) -> Reader:
    """Open a device, a virtual bus ("bus://..."), an analyser ("sigrok:...") or a pyserial URL.

    May raise PortError.
    """
    # Each reader is imported where it is needed, so that listing ports starts quickly.
    for kind, module in ELSEWHERE.items():
        if port.startswith(kind):
            reader: Reader = importlib.import_module(module).open_reader(port, settings, line)
            return reader
    if settings.baud <= 0:
        raise needs_rate(port)
    if "://" in port:
        from sistap.tap.line.reader.pyserial import UrlReader

        return UrlReader(port, settings, line)
    if sys.platform == "win32":
        of_windows: Reader = importlib.import_module(WINDOWS).WindowsReader(port, settings, line)
        return of_windows
    from sistap.tap.line.reader.device import PosixReader

    return PosixReader(port, settings, line)
