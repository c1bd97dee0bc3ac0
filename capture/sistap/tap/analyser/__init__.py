# SPDX-License-Identifier: GPL-2.0-or-later
"""Logic analysers as ports.

Their addresses, and which are plugged in (probe), edges to characters (uart), the settings that make characters of
edges (finding), and the reader (reader). It may use line. line/reader imports `open_reader` when such a port is opened.
"""

from __future__ import annotations

from sistap.tap.line.reader.contract import Reader, needs_rate
from sistap.tap.line.settings import LineSettings


def open_reader(port: str, settings: LineSettings, line: int) -> Reader:
    """Open "sigrok:DRIVER". May raise PortError."""
    from sistap.tap.analyser.reader import SigrokReader

    if settings.baud <= 0:
        raise needs_rate(port)
    return SigrokReader(port, settings, line)
