# SPDX-License-Identifier: GPL-2.0-or-later
"""Captures of USB adapters: the transfers of each device, and the characters of the line at its port."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from sistap.imports import cdc, ftdi
from sistap.imports.source import RECEIVED, SENT, Told, need_rate, numbered
from sistap.imports.usb_transfers import (
    BULK,
    INTERRUPT,
    Arrivals,
    Departures,
    Setup,
    Transfer,
    Transfers,
    bounded,
    latest_ns,
)
from sistap.line.settings import Flag, LineSettings, Read
from sistap.terminal.exits import UsageError
from sistap.wireshark.tshark import Tshark


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


# -- The capture -----------------------------------------------------------------------------------------------------


@dataclass(slots=True)
class _Device:
    """What a capture shows about any device."""

    is_ftdi: bool = False  # its vendor, or a request that only such an adapter gets
    is_cdc: bool = False
    inbound: int = 0  # transfers with data to the computer ...
    status_first: int = 0  # ... and how many of them begin like those of an FTDI adapter

    def look(self, transfer: Transfer) -> None:
        """Take note of a transfer."""
        setup = transfer.setup
        self.is_ftdi |= transfer.vendor == ftdi.VENDOR or (setup is not None and ftdi.is_request(setup))
        self.is_cdc |= transfer.classes >= cdc.CLASSES or (setup is not None and cdc.is_request(setup))
        if transfer.type == BULK and transfer.inbound and transfer.data:
            self.inbound += 1
            self.status_first += ftdi.looks_like(transfer.data)

    @property
    def kind(self) -> Kind | None:
        """Return its kind; None if the capture shows no adapter that can be read.

        An adapter that was opened before the capture began shows its kind only by the status before its characters.
        """
        if self.is_cdc and not self.is_ftdi:
            return CDC
        return FTDI if self.is_ftdi or 0 < self.inbound == self.status_first else None


class _Port:
    """What a capture shows about a port, read as a certain kind of adapter."""

    def __init__(self, name: str, kind: Kind, told: Told) -> None:
        self.name = name  # "1.5", "1.5B"
        self.adapter = Adapter(kind, told)
        self.settings: LineSettings | None = None  # of its first character
        self.was_set = False  # whether they were set by then
        self.counts = {False: 0, True: 0}  # characters received and sent
        self.sources: set[int] = set()  # endpoints of these characters
        # latency timers at that time, in ms, and whether they were set
        self.timers: set[tuple[int | None, bool]] = set()

    def look(self, transfer: Transfer) -> None:
        """Take note of a transfer."""
        for read in self.adapter.take(transfer):
            self._count(read)
            if read.line != SENT:
                self.sources.add(transfer.endpoint)
                self.timers.add((self.adapter.latency_ms, self.adapter.latency_was_set))

    def finish(self) -> None:
        """Take note of the end of the capture."""
        for read in self.adapter.finish():
            self._count(read)

    def _count(self, read: Read) -> None:
        if self.settings is None:
            self.settings, self.was_set = read.settings, self.adapter.was_set
        self.counts[read.line == SENT] += len(read.data)

    def __str__(self) -> str:
        settings = f"{self.settings}, " if self.settings and self.settings.baud else ""
        return f"{self.name} ({self.adapter.kind.name}, {settings}{sum(self.counts.values()):,} characters)"


class UsbCapture:
    """A Source: the characters of one adapter."""

    def __init__(self, tshark: Tshark, capture: Path, told: Told) -> None:
        """Find the chosen adapter in the capture. May raise UsageError and TsharkError."""
        self._transfers = Transfers(tshark, capture)
        self._told = told
        port = _chosen(_ports(self._transfers, told), capture, told.device)
        self._device, self._port, self._kind = port.name.rstrip(_LETTERS), port.name, port.adapter.kind
        assert port.settings
        self.settings = port.settings
        need_rate(self.settings, capture, self._kind.no_rate)
        self.settings_from = "as the adapter was set" if port.was_set else "as given"
        if port.was_set and told.baud not in (None, self.settings.baud):
            self.settings_from += f", not {told.baud} Bd"
        name = f"{self._kind.name} adapter {port.name}"
        self.lines = numbered(
            f"{name}, received", f"{name}, sent", has_received=port.counts[False] > 0, has_sent=port.counts[True] > 0
        )
        self.timing = f"times of USB transfers, {_bound(port)}"
        self.warning = ""

    def reads(self) -> Iterator[Read]:
        """Yield all characters. Sent characters leave the adapter after what has come meanwhile."""
        adapter = Adapter(self._kind, self._told)
        waiting: list[tuple[int, int, Read]] = []
        number = itertools.count()

        def wait(reads: Iterator[Read]) -> None:
            for read in reads:
                heapq.heappush(waiting, (read.time_ns, next(number), read))

        for transfer in self._transfers:
            if transfer.device == self._device and _port_name(transfer, self._kind) == self._port:
                wait(adapter.take(transfer))
                while waiting and waiting[0][0] <= latest_ns(transfer):
                    yield heapq.heappop(waiting)[2]
        wait(adapter.finish())
        while waiting:
            yield heapq.heappop(waiting)[2]
        self.warning = self._transfers.warning


_LETTERS = "BCDEFGH"


def _port_name(transfer: Transfer, kind: Kind) -> str:
    """Name the port of a transfer. The first port has the name of the device."""
    setup = transfer.setup
    port = kind.port_of_endpoint(transfer.endpoint) if setup is None else kind.port_of_request(setup)
    return transfer.device + (_LETTERS[(port - 1) % len(_LETTERS)] if port > 0 else "")


def _ports(transfers: Transfers, told: Told) -> list[_Port]:
    """Find all ports with characters. The kind of a device may show only in its last transfer, so it is read as each
    kind.
    """
    devices: dict[str, _Device] = {}
    ports: dict[tuple[str, Kind], _Port] = {}
    for transfer in transfers:
        devices.setdefault(transfer.device, _Device()).look(transfer)
        for kind in KINDS:
            name = _port_name(transfer, kind)
            if (name, kind) not in ports:
                ports[name, kind] = _Port(name, kind, told)
            ports[name, kind].look(transfer)
    for port in ports.values():
        port.finish()
    found = [port for (name, kind), port in ports.items() if devices[name.rstrip(_LETTERS)].kind is kind]
    return [port for port in found if port.settings]


def _chosen(ports: list[_Port], capture: Path, device: str | None) -> _Port:
    listed = "; ".join(str(port) for port in ports)
    if not ports:
        raise UsageError(
            f"{capture} has no characters of an FTDI or CDC adapter; begin the capture before the adapter is plugged "
            "in, so that it shows what it is"
        )
    if device is None and len(ports) > 1:
        raise UsageError(f"{capture} has several adapters: choose one with --device: {listed}")
    meant = [port for port in ports if device in (None, port.name)]
    if not meant:
        raise UsageError(f"{capture} has no adapter {device} with characters, only {listed}")
    if len(meant[0].sources) > 1:
        raise UsageError(f"{meant[0]} has several serial ports, and their characters cannot be told apart")
    return meant[0]


def _bound(port: _Port) -> str:
    """Describe the uncertainty of received characters, with the latency timer as it was when they came."""
    timers = port.timers or {(port.adapter.latency_ms, port.adapter.latency_was_set)}
    times_ms = sorted({latency_ms for latency_ms, _ in timers if latency_ms is not None})
    if not times_ms:
        return "two USB frames; what the adapter itself adds is not known"
    known = ", as by default: the capture does not show it" if not any(was_set for _, was_set in timers) else ""
    return f"latency timer {' and '.join(map(str, times_ms))} ms{known}, and a USB frame"
