# SPDX-License-Identifier: GPL-2.0-or-later
"""USB captures: which adapters there are, and the characters of the chosen one."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from sistap.imports import cdc, ftdi
from sistap.imports.source import SENT, Told, need_rate, numbered
from sistap.imports.usb_adapter import CDC, FTDI, KINDS, Adapter, Kind
from sistap.imports.usb_times import latest_ns
from sistap.imports.usb_transfers import BULK, Transfer, Transfers
from sistap.line.settings import LineSettings, Read
from sistap.terminal.exits import UsageError
from sistap.wireshark.tshark import Tshark


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
