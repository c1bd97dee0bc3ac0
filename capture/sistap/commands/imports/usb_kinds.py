# SPDX-License-Identifier: GPL-2.0-or-later
"""The kinds of USB adapters: a row for each says how it is known, and how it is read."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from sistap.commands.imports import cdc, ch340, cp210x, ftdi
from sistap.commands.imports.usb_line import Plain
from sistap.commands.imports.usb_transfers import Setup
from sistap.tap.line.drivers import NOT_REPORTED
from sistap.tap.line.settings import Flag, LineSettings


class Kind(NamedTuple):
    """A kind of adapter, defined by its differences from one that only transports characters."""

    name: str
    vendors: frozenset[int] = frozenset()
    requests: frozenset[tuple[int, int]] = frozenset()  # bmRequestType and bRequest of those that it gets
    # Line settings after a request.
    settings_after: Callable[[Setup, bytes, LineSettings], LineSettings] = lambda _, __, settings: settings
    transfers: Callable[[], Plain] = Plain  # takes the characters out of them
    notified: Callable[[bytes], Flag] = lambda _: Flag(0)  # errors in an interrupt transfer
    port_of_endpoint: Callable[[int], int] = lambda _: 0
    port_of_request: Callable[[Setup], int] = lambda _: 0
    latency_ms: int | None = None  # of its timer; None: it has none
    no_rate: str = "its port was opened before the capture began"  # why a capture may not state the rate
    errors: str = ""  # what is special about its line errors


UNKNOWN = Kind("unknown", errors=NOT_REPORTED)
FTDI = Kind(
    "FTDI",
    ftdi.VENDORS,
    ftdi.REQUESTS,
    ftdi.settings_after,
    ftdi.Packets,
    port_of_endpoint=ftdi.port_of_endpoint,
    port_of_request=ftdi.port_of_request,
    latency_ms=ftdi.LATENCY_MS,
)
CH340 = Kind("CH340", ch340.VENDORS, ch340.REQUESTS, ch340.settings_after, errors=NOT_REPORTED)
CP210X = Kind("CP210x", cp210x.VENDORS, cp210x.REQUESTS, cp210x.settings_after, cp210x.Events)
# Its events were switched on before the capture began.
CP210X_WITH_EVENTS = CP210X._replace(name="CP210x with events", transfers=lambda: cp210x.Events(cp210x.ESCAPE))
CDC = Kind("CDC", frozenset(), cdc.REQUESTS, cdc.settings_after, notified=cdc.errors, no_rate=cdc.NO_RATE)
PL2303 = Kind("PL2303", cdc.PL2303_VENDORS, cdc.PL2303_REQUESTS, cdc.pl2303_settings_after, notified=cdc.errors)

# Of kinds that the same evidence fits, the first goes before the others.
KINDS = (UNKNOWN, FTDI, CH340, CP210X, CP210X_WITH_EVENTS, CDC, PL2303)
FORMS = (UNKNOWN, FTDI, CP210X_WITH_EVENTS)  # those whose transfers differ
