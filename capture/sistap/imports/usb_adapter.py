# SPDX-License-Identifier: GPL-2.0-or-later
"""One port of a USB adapter: takes the transfers of its device, yields the characters of its line."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from sistap.imports import cdc, ftdi
from sistap.imports.source import RECEIVED, Told
from sistap.imports.usb_times import Arrivals, Departures, bounded, latest_ns
from sistap.imports.usb_transfers import BULK, INTERRUPT, Setup, Transfer
from sistap.line.settings import Flag, LineSettings, Read


class Kind(NamedTuple):
    """A kind of adapter, defined by its differences."""

    name: str
    settings_after: Callable[[Setup, bytes, LineSettings], LineSettings]  # line settings after a request
    packets: Callable[[bytes], Iterator[tuple[bytes, bytes]]]  # characters and flags in a transfer
    is_full: Callable[[bytes], bool]  # whether more may have waited than the transfer has room for
    notified: Callable[[bytes], Flag]  # errors in an interrupt transfer
    port_of_endpoint: Callable[[int], int]
    port_of_request: Callable[[Setup], int]
    latency_ms: int | None  # of its timer; None: it has none
    no_rate: str  # why a capture may not state the rate


def _only_port(_: object) -> int:
    return 0


FTDI = Kind(
    "FTDI",
    ftdi.settings_after,
    ftdi.packets,
    ftdi.is_full,
    lambda _: Flag(0),
    ftdi.port_of_endpoint,
    ftdi.port_of_request,
    ftdi.LATENCY_MS,
    "",
)
CDC = Kind(
    "CDC",
    cdc.settings_after,
    lambda data: iter([(data, bytes(len(data)))]),
    lambda _: False,
    cdc.errors,
    _only_port,
    _only_port,
    None,
    cdc.NO_RATE,
)
KINDS = (FTDI, CDC)


class Adapter:
    """A port, and what came and went through it."""

    def __init__(self, kind: Kind, told: Told) -> None:
        self.kind = kind
        self.settings = told.settings
        self.was_set = False  # by the capture, not only by the user
        self.latency_ms = kind.latency_ms
        self.latency_was_set = False
        self._arrivals = Arrivals()
        self._departures = Departures()
        self._submitted: dict[str, Transfer] = {}  # what is on its way out
        self._next_received = Flag(0)  # errors that apply to the next character
        self._next_sent = Flag(0)

    def take(self, transfer: Transfer) -> Iterator[Read]:
        """Yield the characters that a transfer brings, or that left with it."""
        if transfer.setup is not None:
            self._take_request(transfer.setup, transfer.data)
        elif transfer.type == INTERRUPT:
            self._next_received |= self.kind.notified(transfer.data)
        elif transfer.type == BULK and transfer.inbound:
            yield from self._take_inbound(transfer)
        elif transfer.type == BULK:
            yield from self._take_outbound(transfer)

    def finish(self) -> Iterator[Read]:
        """Yield what was still on its way out when the capture ended."""
        for submitted in self._submitted.values():
            yield from self._departures.sent(submitted, None, bytes(len(submitted.data)), self.settings)

    def _take_request(self, setup: Setup, data: bytes) -> None:
        settings = self.kind.settings_after(setup, data, self.settings._replace(baud=0))
        self.was_set |= settings.baud != 0
        self.settings = settings._replace(baud=settings.baud or self.settings.baud)
        latency_ms = ftdi.latency_ms(setup)
        if self.latency_ms is not None and latency_ms is not None:
            self.latency_ms = latency_ms
            self.latency_was_set = True

    def _take_inbound(self, transfer: Transfer) -> Iterator[Read]:
        if not transfer.completed:
            self._arrivals.ask(transfer)
            return
        if transfer.data:
            is_full = self.kind.is_full(transfer.data)
            waited_ns = self._arrivals.waited_ns(transfer, self.latency_ms, is_full=is_full)
            packets = list(self.kind.packets(transfer.data))
            characters = b"".join(characters for characters, _ in packets)
            if characters:
                flags = bytearray(b"".join(flags for _, flags in packets))
                flags[0] |= self._next_received
                self._next_received = Flag(0)
                yield Read(RECEIVED, latest_ns(transfer), characters, bytes(flags), bounded(waited_ns), self.settings)
        if transfer.is_cut:
            self._next_received |= Flag.LOST_BEFORE

    def _take_outbound(self, transfer: Transfer) -> Iterator[Read]:
        if not transfer.completed:
            if transfer.data or transfer.is_cut:
                self._submitted[transfer.id] = transfer
            return
        submitted = self._submitted.pop(transfer.id, None)
        if submitted is None:
            return
        flags = bytearray(len(submitted.data[: transfer.actual]))
        if flags:
            flags[0] |= self._next_sent
            self._next_sent = Flag(0)
        yield from self._departures.sent(submitted, transfer, bytes(flags), self.settings)
        if submitted.is_cut:
            self._next_sent |= Flag.LOST_BEFORE
