# SPDX-License-Identifier: GPL-2.0-or-later
"""Captures of USB adapters: the transfers of each device, and the characters of the line at its port."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Protocol

from sistap.commands.imports import cdc, ftdi
from sistap.commands.imports.source import RECEIVED, SENT, Stated, need_rate, numbered
from sistap.commands.imports.usb_kinds import CDC, FORMS, FTDI, KINDS, UNKNOWN, Kind
from sistap.commands.imports.usb_transfers import (
    BULK,
    CONTROL,
    INTERRUPT,
    Arrivals,
    Departures,
    Setup,
    Transfer,
    bounded,
    latest_ns,
    with_requests,
)
from sistap.tap.line.settings import Flag, LineSettings, Read
from sistap.tap.records.framer import Framer
from sistap.tap.records.record import Record
from sistap.tap.terminal.exits import Refusal

_NOT_SAID = LineSettings(0, 0, "", 0)
_ENOUGH = 2  # different requests that an adapter of a kind gets


class UsbAdapter:
    """A port, and what came and went through it."""

    def __init__(self, kind: Kind, stated: Stated) -> None:
        self.kind = kind
        self.settings = stated.settings
        self.said = _NOT_SAID  # what the capture says of them; what the user says goes before it
        self.latency_ms = kind.latency_ms
        self.latency_was_set = False
        self._stated = stated
        self._transfers = kind.transfers()
        self._arrivals = Arrivals()
        self._departures = Departures()
        self._submitted: dict[str, Transfer] = {}  # what is on its way out
        self._next_received = Flag(0)  # errors that apply to the next character
        self._next_sent = Flag(0)

    def take(self, transfer: Transfer) -> Iterator[Read]:
        """Yield the characters that a transfer brings, or that left with it."""
        if transfer.type == CONTROL:
            if transfer.setup is not None and transfer.completed and not transfer.failed:
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
        self._transfers.asked(setup)
        self.said = self.kind.settings_after(setup, data, self.said)
        self.settings = line_settings(self._stated, self.said)
        latency_ms = ftdi.latency_ms(setup)
        if self.latency_ms is not None and latency_ms is not None:
            self.latency_ms = latency_ms
            self.latency_was_set = True

    def _take_inbound(self, transfer: Transfer) -> Iterator[Read]:
        if not transfer.completed:
            self._arrivals.ask(transfer)
            return
        if transfer.data:
            is_full = self._transfers.is_full(transfer.data)
            waited_ns = self._arrivals.waited_ns(transfer, self.latency_ms, is_full=is_full)
            packets = list(self._transfers.packets(transfer.data))
            characters = b"".join(characters for characters, _ in packets)
            if characters:
                flags = bytearray(b"".join(flags for _, flags in packets))
                if transfer.failed:
                    flags = bytearray(flag | Flag.UNLOCATED_ERROR for flag in flags)
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


def line_settings(stated: Stated, said: LineSettings) -> LineSettings:
    """Return the settings of a line: those that the user states, else what the capture says, else 8E1."""
    format_of = stated.settings if stated.format or not said.data_bits else said
    return format_of._replace(baud=stated.baud or said.baud)


# -- The capture -----------------------------------------------------------------------------------------------------


class _Port:
    """What a capture shows about a port, read as a certain kind of adapter."""

    def __init__(self, name: str, kind: Kind, stated: Stated) -> None:
        self.name = name  # "1.5", "1.5B"
        self.why = ""  # it is read as this kind
        self.adapter = UsbAdapter(kind, stated)
        self.settings: LineSettings | None = None  # of its first character
        self.said = _NOT_SAID  # by then
        self.counts = {False: 0, True: 0}  # characters received and sent
        self.good = 0  # telegrams
        self.sources: set[int] = set()  # endpoints of these characters
        # latency timers at that time, in ms, and whether they were set
        self.timers: set[tuple[int | None, bool]] = set()
        self._stated = stated
        self._framers: dict[int, Framer] = {}

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
        for framer in self._framers.values():
            self._judge(framer.flush())

    def _count(self, read: Read) -> None:
        assert read.settings
        if self.settings is None:
            self.settings, self.said = read.settings, self.adapter.said
        self.counts[read.line == SENT] += len(read.data)
        if read.line not in self._framers:
            self._framers[read.line] = self._stated.cut.framer(read.line, read.settings)
        self._judge(self._framers[read.line].feed(read))

    def _judge(self, records: Iterable[Record]) -> None:
        self.good += sum(record.is_good_frame and not record.is_handshake for record in records)

    @property
    def settings_from(self) -> str:
        """Return where the settings come from."""
        assert self.settings
        rate = f"{self.said.baud} Bd" if self.said.baud else ""
        format_ = self.said.format if self.said.data_bits else ""
        if rate and self.said.baud != self.settings.baud or format_ not in ("", self.settings.format):
            return f"as given; the adapter was set to {' '.join(filter(None, (rate, format_)))}"
        what = "" if rate and format_ else "the rate " if rate else "the format "
        return f"{what}as the adapter was set" if rate or format_ else "as given"

    def __str__(self) -> str:
        settings = f"{self.settings}, " if self.settings and self.settings.baud else ""
        return f"{self.name} ({self.adapter.kind.name}, {settings}{sum(self.counts.values()):,} characters)"


class _Device:
    """What a capture shows about any device. Its kind may show only in the last transfer: it is read as each kind."""

    def __init__(self, stated: Stated) -> None:
        self._stated = stated
        self._vendor: int | None = None
        self._classes: frozenset[int] = frozenset()
        self._requests: set[tuple[int, int]] = set()
        self._inbound = 0  # transfers with data to the computer ...
        self._status_first = 0  # ... and how many of them begin like those of an FTDI adapter
        self._ports: dict[str, dict[str, _Port]] = {kind.name: {} for kind in KINDS}  # by kind and name

    def look(self, transfer: Transfer) -> None:
        """Take note of a transfer."""
        self._vendor = transfer.vendor or self._vendor
        self._classes |= transfer.classes
        if transfer.setup:
            self._requests.add((transfer.setup.type, transfer.setup.request))
        if transfer.type == BULK and transfer.inbound and transfer.data and not transfer.is_cut and not transfer.failed:
            self._inbound += 1
            self._status_first += ftdi.looks_like(transfer.data)
        named = [kind for kind in KINDS if self._vendor in kind.vendors]
        for kind in [*named, CDC] if named else KINDS:
            ports, name = self._ports[kind.name], _port_name(transfer, kind)
            if name not in ports:
                ports[name] = _Port(name, kind, self._stated)
            ports[name].look(transfer)

    def ports(self) -> Iterator[_Port]:
        """Yield its ports with characters, as the kind of adapter that it is; none if it cannot be read as any."""
        for ports in self._ports.values():
            for port in ports.values():
                port.finish()
        kind, why = self._kind()
        for port in self._ports[kind.name].values() if why else ():
            port.why = why
            if port.settings:
                yield port

    def _kind(self) -> tuple[Kind, str]:
        """Return its kind, and how that is known; empty if it is not known."""
        kinds, why = self._known()
        good = {kind: sum(port.good for port in self._ports[kind.name].values()) for kind in kinds}
        best = max(kinds, key=lambda kind: (good[kind], (kind is FTDI) == self._has_status))
        if why and best is kinds[0]:
            return best, why
        telegrams = _telegrams(best, good) if good[best] else ""
        status = "a status in front of its characters" if best is FTDI and self._has_status else ""
        return best, "; ".join(filter(None, (why, telegrams, status)))

    def _known(self) -> tuple[Sequence[Kind], str]:
        """Return the kinds that it can be, and what says so, except for its characters."""
        if self._classes >= cdc.CLASSES:
            return [CDC], "its interfaces"
        if named := [kind for kind in KINDS if self._vendor in kind.vendors]:
            return named, f"vendor {self._vendor:04x}"
        possible = [kind for kind in KINDS if kind is not FTDI or self._has_status or not self._inbound]
        most = max(len(self._requests & kind.requests) for kind in possible)
        kinds = [kind for kind in possible if len(self._requests & kind.requests) == most]
        if not most:
            kinds = [kind for kind in kinds if kind in FORMS]
        # Devices of other kinds have vendor requests, too: one alone says little.
        return kinds, "its requests" if most >= _ENOUGH else ""

    @property
    def _has_status(self) -> bool:
        """Tell whether a status like that of an FTDI adapter is in front of all characters."""
        return 0 < self._inbound == self._status_first


def _telegrams(best: Kind, good: Mapping[Kind, int]) -> str:
    """Say how many good telegrams there are, and how many if it is read as another kind."""
    fewer = [
        f"as {'plain characters' if kind is UNKNOWN else kind.name}: {count or 'none'}"
        for kind, count in good.items()
        if count < good[best]
    ]
    said = f"{good[best]} good telegram{'s' if good[best] > 1 else ''}"
    return f"{said}; read {', '.join(fewer)}" if fewer else said


class AnyTransfers(Protocol):
    """The transfers in a file."""

    warning: str  # after the last one: what could not be read

    def __iter__(self) -> Iterator[Transfer]:
        """Yield the transfers in the order of the file. May raise TsharkError."""


class UsbCapture:
    """A Source: the characters of one adapter."""

    def __init__(self, transfers: AnyTransfers, capture: Path, stated: Stated) -> None:
        """Find the chosen adapter in the capture. May raise Refusal and TsharkError."""
        self._transfers = transfers
        self._stated = stated
        ports = _ports(self._transfers, stated)
        port = _chosen(ports, capture, stated.device, self._transfers.warning)
        self._device, self._port, self._kind = port.name.rstrip(_LETTERS), port.name, port.adapter.kind
        assert port.settings
        self.settings = port.settings
        need_rate(self.settings, capture, self._kind.no_rate)
        self.settings_from = port.settings_from
        name = f"{self._kind.name} adapter {port.name}"
        self.lines = numbered(
            f"{name}, received", f"{name}, sent", has_received=port.counts[False] > 0, has_sent=port.counts[True] > 0
        )
        self.timing = f"times of USB transfers ({self._kind.name}: {port.why}), {_bound(port)}"
        self.warning = ""

    def reads(self) -> Iterator[Read]:
        """Yield all characters. Sent characters leave the adapter after what has come meanwhile."""
        adapter = UsbAdapter(self._kind, self._stated)
        waiting: list[tuple[int, int, Read]] = []
        number = itertools.count()

        def wait(reads: Iterator[Read]) -> None:
            for read in reads:
                heapq.heappush(waiting, (read.time_ns, next(number), read))

        for transfer in with_requests(self._transfers):
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


def _ports(transfers: AnyTransfers, stated: Stated) -> list[_Port]:
    """Find all ports with characters."""
    devices: dict[str, _Device] = {}
    for transfer in with_requests(transfers):
        devices.setdefault(transfer.device, _Device(stated)).look(transfer)
    return [port for device in devices.values() for port in device.ports()]


def _chosen(ports: list[_Port], capture: Path, device: str | None, warning: str) -> _Port:
    listed = "; ".join(str(port) for port in ports)
    if not ports:
        raise Refusal(
            f"{capture} has no characters of a serial adapter that is known, and no good telegrams; "
            + (warning and f"{warning}; ")
            + "begin the capture before the adapter is plugged in, so that it shows what it is"
        )
    if device is None and len(ports) > 1:
        raise Refusal(f"{capture} has several adapters: choose one with --device: {listed}")
    meant = [port for port in ports if device in (None, port.name)]
    if not meant:
        raise Refusal(f"{capture} has no adapter {device} with characters, only {listed}")
    if len(meant[0].sources) > 1:
        raise Refusal(f"{meant[0]} has several serial ports, and their characters cannot be told apart")
    return meant[0]


def _bound(port: _Port) -> str:
    """Describe the uncertainty of received characters, with the latency timer as it was when they came."""
    timers = port.timers or {(port.adapter.latency_ms, port.adapter.latency_was_set)}
    times_ms = sorted({latency_ms for latency_ms, _ in timers if latency_ms is not None})
    if not times_ms:
        errors = f"; {port.adapter.kind.errors}" if port.adapter.kind.errors else ""
        return f"two USB frames; what the adapter itself adds is not known{errors}"
    known = ", as by default: the capture does not show it" if not any(was_set for _, was_set in timers) else ""
    return f"latency timer {' and '.join(map(str, times_ms))} ms{known}, and a USB frame"
