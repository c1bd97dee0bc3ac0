# SPDX-License-Identifier: GPL-2.0-or-later
"""USB captures byte by byte: pseudo headers of usbmon (link type 220) and USBPcap (249), and what adapters say.

Layouts: Documentation/usb/usbmon.rst of Linux (binary format), USBPcap's capture format, USB 2.0 chapter 9, the Linux
driver ftdi_sio, USB PSTN subclass chapter 6. Times are ms since T0.
"""

from __future__ import annotations

import itertools
import struct
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple, Protocol

T0 = 1_700_000_000  # s since 1970
USBMON, USBPCAP, RTAC = 220, 249, 250
CONTROL, BULK, INTERRUPT = 2, 3, 1

Packet = tuple[float, bytes]


def pcap(path: Path, link_type: int, packets: Iterable[Packet]) -> Path:
    """Write a classic capture file with microseconds."""
    parts = [struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 262144, link_type)]
    for time_ms, data in packets:
        seconds, microseconds = divmod(round(time_ms * 1000), 1_000_000)
        parts.append(struct.pack("<IIII", T0 + seconds, microseconds, len(data), len(data)) + data)
    path.write_bytes(b"".join(parts))
    return path


class Device(NamedTuple):
    """An address on a bus."""

    bus: int = 1
    address: int = 5


class Recorder(Protocol):
    """Writes transfers in its own format."""

    link_type: int

    def submit(
        self, time_ms: float, kind: int, endpoint: int, number: int, data: bytes = b"", setup: bytes = b""
    ) -> Packet:
        """A transfer is handed to the host controller."""

    def complete(self, time_ms: float, kind: int, endpoint: int, number: int, data: bytes, length: int) -> Packet:
        """It is done; `length` bytes were transferred."""


class Usbmon:
    """Linux: 64 bytes before the data."""

    link_type = USBMON

    def __init__(self, device: Device = Device()) -> None:  # noqa: B008 - immutable
        self._device = device

    def _packet(self, time_ms: float, event: bytes, kind: int, endpoint: int, number: int, **rest: object) -> Packet:
        data, setup, length = (rest.get(name) for name in ("data", "setup", "length"))
        assert isinstance(data, bytes) and isinstance(setup, bytes) and isinstance(length, int)
        has_data = 0 if data else ord("<" if endpoint & 0x80 else ">")
        seconds, microseconds = divmod(round(time_ms * 1000), 1_000_000)
        header = struct.pack(
            "<QcBBBHBBqiiII8siiII",
            number,
            event,
            kind,
            endpoint,
            self._device.address,
            self._device.bus,
            0 if setup else ord("-"),
            has_data,
            T0 + seconds,
            microseconds,
            0,
            length,
            len(data),
            setup,
            0,
            0,
            0,
            0,
        )
        return time_ms, header + data

    def submit(  # noqa: PLR0913 - fields of a header
        self,
        time_ms: float,
        kind: int,
        endpoint: int,
        number: int,
        data: bytes = b"",
        setup: bytes = b"",
        length: int | None = None,
    ) -> Packet:
        length = len(data) or 512 if length is None else length
        return self._packet(time_ms, b"S", kind, endpoint, number, data=data, setup=setup, length=length)

    def complete(self, time_ms: float, kind: int, endpoint: int, number: int, data: bytes, length: int) -> Packet:
        return self._packet(time_ms, b"C", kind, endpoint, number, data=data, setup=b"", length=length)


class UsbPcap:
    """Windows: 27 bytes before the data, 28 of a control transfer."""

    link_type = USBPCAP

    def __init__(self, device: Device = Device()) -> None:  # noqa: B008 - immutable
        self._device = device

    def _packet(self, time_ms: float, info: int, kind: int, endpoint: int, number: int, data: bytes) -> Packet:
        stage = b"" if kind != CONTROL else b"\x03" if info else b"\x00"
        function = 0x0009 if kind != CONTROL else 0x001B
        header = struct.pack(
            "<HQIHBHHBBI",
            27 + len(stage),
            number,
            0,
            function,
            info,
            self._device.bus,
            self._device.address,
            endpoint,
            kind,
            len(data),
        )
        return time_ms, header + stage + data

    def submit(
        self, time_ms: float, kind: int, endpoint: int, number: int, data: bytes = b"", setup: bytes = b""
    ) -> Packet:
        return self._packet(time_ms, 0, kind, endpoint, number, setup + data)

    def complete(self, time_ms: float, kind: int, endpoint: int, number: int, data: bytes, length: int) -> Packet:
        return self._packet(time_ms, 1, kind, endpoint, number, data)


class Host:
    """A computer that uses one adapter; the packets of their communication."""

    def __init__(self, recorder: Recorder, inbound: int = 0x81, outbound: int = 0x02) -> None:
        self._recorder = recorder
        self._inbound = inbound
        self._outbound = outbound
        self._number = itertools.count(1)
        self.packets: list[Packet] = []

    def request(self, time_ms: float, kind: int, request: int, value: int, place: int = 0, data: bytes = b"") -> None:
        """Set something in the adapter."""
        number = next(self._number)
        setup = struct.pack("<BBHHH", kind, request, value, place, len(data))
        self.packets.append(self._recorder.submit(time_ms, CONTROL, 0x00, number, data, setup))
        self.packets.append(self._recorder.complete(time_ms + 0.1, CONTROL, 0x00, number, b"", len(data)))

    def descriptor(self, time_ms: float, kind: int, data: bytes) -> None:
        """Ask for a descriptor: 1 the device, 2 its configuration."""
        number = next(self._number)
        setup = struct.pack("<BBHHH", 0x80, 6, kind << 8, 0, len(data))
        self.packets.append(self._recorder.submit(time_ms, CONTROL, 0x80, number, b"", setup))
        self.packets.append(self._recorder.complete(time_ms + 0.1, CONTROL, 0x80, number, data, len(data)))

    def receive(self, asked_ms: float, time_ms: float, data: bytes, length: int | None = None) -> None:
        """Ask for characters, and get these bytes; `length` if more came than the capture has."""
        number = next(self._number)
        self.packets.append(self._recorder.submit(asked_ms, BULK, self._inbound, number))
        length = len(data) if length is None else length
        self.packets.append(self._recorder.complete(time_ms, BULK, self._inbound, number, data, length))

    def send(self, time_ms: float, taken_ms: float, data: bytes, length: int | None = None) -> None:
        """Send characters to the adapter, which has taken them at `taken_ms`."""
        number = next(self._number)
        self.packets.append(self._recorder.submit(time_ms, BULK, self._outbound, number, data))
        length = len(data) if length is None else length
        self.packets.append(self._recorder.complete(taken_ms, BULK, self._outbound, number, b"", length))

    def notify(self, time_ms: float, endpoint: int, data: bytes) -> None:
        """The adapter tells something by an interrupt transfer."""
        self.packets.append(self._recorder.complete(time_ms, INTERRUPT, endpoint, next(self._number), data, len(data)))

    def save(self, path: Path) -> Path:
        """Write all packets in the order of their times."""
        return pcap(path, self._recorder.link_type, sorted(self.packets, key=lambda packet: packet[0]))


# An FT232R at 9600 Bd 8E1. 3 MHz / 312.5: the half is a 1 in bit 14.
STATUS = b"\x01\x60"  # full speed; transmitter empty, no error
FT232R = struct.pack("<BBHBBBBHHHBBBB", 18, 1, 0x0200, 0, 0, 0, 8, 0x0403, 0x6001, 0x0600, 1, 2, 3, 1)
VENDOR_REQUEST, SET_BAUD_RATE, SET_DATA, SET_LATENCY_TIMER = 0x40, 3, 4, 9
DIVISOR_9600, DATA_8E1 = 0x4138, 0x0208


def ftdi(recorder: Recorder | None = None, latency_ms: int | None = 16) -> Host:
    """A host that has just plugged in and opened an FTDI adapter, by 4 ms."""
    host = Host(recorder or Usbmon())
    host.descriptor(0, 1, FT232R)
    host.request(1, VENDOR_REQUEST, SET_BAUD_RATE, DIVISOR_9600)
    host.request(2, VENDOR_REQUEST, SET_DATA, DATA_8E1)
    if latency_ms is not None:
        host.request(3, VENDOR_REQUEST, SET_LATENCY_TIMER, latency_ms)
    return host


# A CDC ACM adapter: interface 0 (control, interrupt endpoint 0x82), interface 1 (data, 0x83 and 0x04).
CDC_DEVICE = struct.pack("<BBHBBBBHHHBBBB", 18, 1, 0x0200, 2, 0, 0, 64, 0x2341, 0x0043, 0x0001, 1, 2, 3, 1)
_INTERFACES = bytes.fromhex(
    "0904000001020201000524001001042402060524060001052401000107058203080010"
    "09040100020a0000000705040240000007058302400000"
)
CDC_CONFIGURATION = struct.pack("<BBHBBBBB", 9, 2, 9 + len(_INTERFACES), 2, 1, 0, 0xC0, 50) + _INTERFACES
CLASS_REQUEST, SET_LINE_CODING = 0x21, 0x20


def line_coding(baud: int, stop: int, parity: int, bits: int) -> bytes:
    """The data of SET_LINE_CODING."""
    return struct.pack("<IBBB", baud, stop, parity, bits)


def cdc(recorder: Recorder | None = None) -> Host:
    """A host that has just plugged in and opened a CDC adapter, by 3 ms."""
    host = Host(recorder or Usbmon(), 0x83, 0x04)
    host.descriptor(0, 1, CDC_DEVICE)
    host.descriptor(1, 2, CDC_CONFIGURATION)
    host.request(2, CLASS_REQUEST, SET_LINE_CODING, 0, 0, line_coding(9600, 0, 2, 8))
    return host
