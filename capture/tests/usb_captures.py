# SPDX-License-Identifier: GPL-2.0-or-later
"""USB captures byte by byte: pseudo headers of usbmon (link types 189, 220) and USBPcap (249), usbmon's text, adapters.

Layouts: Documentation/usb/usbmon.rst of Linux (binary format and text), USBPcap's capture format, USB 2.0 chapter 9,
the Linux drivers ftdi_sio, ch341, cp210x and pl2303, USB PSTN subclass chapter 6, AN571 of Silicon Labs. Times are ms
since T0.
"""

from __future__ import annotations

import itertools
import struct
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple, Protocol

T0 = 1_700_000_000  # s since 1970
USBMON_SHORT, USBMON, USBPCAP, RTAC = 189, 220, 249, 250
TEXT = -1  # instead of a link type
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

    def complete(  # noqa: PLR0913 - fields of a header
        self, time_ms: float, kind: int, endpoint: int, number: int, data: bytes, length: int, status: int = 0
    ) -> Packet:
        """It is done; `length` bytes were transferred."""


class Usbmon:
    """Linux: 64 bytes before the data."""

    link_type = USBMON

    def __init__(self, device: Device = Device()) -> None:  # noqa: B008 - immutable
        self._device = device

    def _packet(self, time_ms: float, event: bytes, kind: int, endpoint: int, number: int, **rest: object) -> Packet:
        data, setup, length, status = (rest.get(name) for name in ("data", "setup", "length", "status"))
        assert isinstance(data, bytes) and isinstance(setup, bytes)
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
            status,
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
        return self._packet(time_ms, b"S", kind, endpoint, number, data=data, setup=setup, length=length, status=-115)

    def complete(  # noqa: PLR0913
        self, time_ms: float, kind: int, endpoint: int, number: int, data: bytes, length: int, status: int = 0
    ) -> Packet:
        return self._packet(time_ms, b"C", kind, endpoint, number, data=data, setup=b"", length=length, status=status)


class ShortUsbmon(Usbmon):
    """Linux, as read(2) delivers it: the first 48 bytes before the data."""

    link_type = USBMON_SHORT

    def _packet(self, time_ms: float, event: bytes, kind: int, endpoint: int, number: int, **rest: object) -> Packet:
        _, packet = super()._packet(time_ms, event, kind, endpoint, number, **rest)
        return time_ms, packet[:48] + packet[64:]


class UsbmonText(Usbmon):
    """Linux: a line of text for each transfer, with at most 32 bytes of its data."""

    link_type = TEXT

    def _packet(self, time_ms: float, event: bytes, kind: int, endpoint: int, number: int, **rest: object) -> Packet:
        data, setup, length, status = (rest.get(name) for name in ("data", "setup", "length", "status"))
        assert isinstance(data, bytes) and isinstance(setup, bytes)
        device, inbound = self._device, endpoint & 0x80
        said = str(status)
        if kind == CONTROL and event == b"S":
            said = "s {:02x} {:02x} {:04x} {:04x} {:04x}".format(*struct.unpack("<BBHHH", setup))
        shown = data[:32]
        words = " ".join(shown[at : at + 4].hex() for at in range(0, len(shown), 4))
        way = f"{' ICB'[kind]}{'i' if inbound else 'o'}"
        line = (
            f"{number:016x} {round(T0 * 1_000_000 + time_ms * 1000) % 4096_000_000} {event.decode()} "
            f"{way}:{device.bus}:{device.address:03}:{endpoint & 0x0F} {said} {length}"
            + (f" = {words}" if words else f" {'<' if inbound else '>'}" if length else "")
        )
        return time_ms, f"{line}\n".encode()


class UsbPcap:
    """Windows: 27 bytes before the data, 28 of a control transfer."""

    link_type = USBPCAP

    def __init__(self, device: Device = Device()) -> None:  # noqa: B008 - immutable
        self._device = device

    def _packet(  # noqa: PLR0913 - fields of a header
        self, time_ms: float, info: int, kind: int, endpoint: int, number: int, data: bytes, status: int = 0
    ) -> Packet:
        stage = b"" if kind != CONTROL else b"\x03" if info else b"\x00"
        function = 0x0009 if kind != CONTROL else 0x001B
        header = struct.pack(
            "<HQIHBHHBBI",
            27 + len(stage),
            number,
            status,
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

    def complete(  # noqa: PLR0913
        self, time_ms: float, kind: int, endpoint: int, number: int, data: bytes, length: int, status: int = 0
    ) -> Packet:
        return self._packet(time_ms, 1, kind, endpoint, number, data, status)


class Host:
    """A computer that uses one adapter; the packets of their communication."""

    def __init__(self, recorder: Recorder, inbound: int = 0x81, outbound: int = 0x02) -> None:
        self._recorder = recorder
        self._inbound = inbound
        self._outbound = outbound
        self._number = itertools.count(1)
        self.packets: list[Packet] = []

    def request(  # noqa: PLR0913 - fields of a request
        self, time_ms: float, kind: int, request: int, value: int, place: int = 0, data: bytes = b"", status: int = 0
    ) -> None:
        """Set something in the adapter."""
        number = next(self._number)
        setup = struct.pack("<BBHHH", kind, request, value, place, len(data))
        self.packets.append(self._recorder.submit(time_ms, CONTROL, 0x00, number, data, setup))
        self.packets.append(self._recorder.complete(time_ms + 0.1, CONTROL, 0x00, number, b"", len(data), status))

    def descriptor(self, time_ms: float, kind: int, data: bytes) -> None:
        """Ask for a descriptor: 1 the device, 2 its configuration."""
        number = next(self._number)
        setup = struct.pack("<BBHHH", 0x80, 6, kind << 8, 0, len(data))
        self.packets.append(self._recorder.submit(time_ms, CONTROL, 0x80, number, b"", setup))
        self.packets.append(self._recorder.complete(time_ms + 0.1, CONTROL, 0x80, number, data, len(data)))

    def receive(self, asked_ms: float, time_ms: float, data: bytes, length: int | None = None, status: int = 0) -> None:
        """Ask for characters, and get these bytes; `length` if more came than the capture has."""
        number = next(self._number)
        self.packets.append(self._recorder.submit(asked_ms, BULK, self._inbound, number))
        length = len(data) if length is None else length
        self.packets.append(self._recorder.complete(time_ms, BULK, self._inbound, number, data, length, status))

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
        packets = sorted(self.packets, key=lambda packet: packet[0])
        if self._recorder.link_type == TEXT:
            path.write_bytes(b"".join(line for _, line in packets))
            return path
        return pcap(path, self._recorder.link_type, packets)


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


# -- Other adapters, just plugged in and opened at 9600 Bd 8E1 by 9 ms ------------------------------------------------


def device_descriptor(vendor: int, product: int) -> bytes:
    """A device whose class is its vendor's own."""
    return struct.pack("<BBHBBBBHHHBBBB", 18, 1, 0x0110, 0xFF, 0, 0, 8, vendor, product, 0x0262, 0, 2, 0, 1)


def ch340(host: Host) -> None:
    """Version, initialize; 48 MHz / 64 / 78, upper byte 256 - 78; receive, transmit, even parity, 8 bits."""
    host.request(1, 0x40, 0xA1, 0)
    host.request(2, 0x40, 0x9A, 0x1312, 0xB282)
    host.request(3, 0x40, 0x9A, 0x2518, 0x00DB)
    host.request(4, 0x40, 0xA4, 0xFF9F)


def ch340_by_its_maker(host: Host) -> None:
    """The driver of the maker: format and rate in one request."""
    host.request(1, 0x40, 0xA1, 0)
    host.request(2, 0x40, 0xA1, 0xDB9C, 0xB282)
    host.request(3, 0x40, 0xA4, 0x009F)


def cp210x(host: Host) -> None:
    """Enable; rate; 8 bits, even parity, 1 stop bit."""
    host.request(1, 0x41, 0x00, 1)
    host.request(2, 0x41, 0x1E, 0, 0, struct.pack("<I", 9600))
    host.request(3, 0x41, 0x03, 0x0820)


def old_cp210x(host: Host) -> None:
    """3.6864 MHz / 384."""
    host.request(1, 0x41, 0x00, 1)
    host.request(2, 0x41, 0x01, 384)
    host.request(3, 0x41, 0x03, 0x0820)


def cp210x_with_events(host: Host) -> None:
    """Line errors among the characters, behind EC."""
    cp210x(host)
    host.request(4, 0x41, 0x15, 0xEC)


def pl2303(host: Host) -> None:
    """Its own registers, then as CDC."""
    host.request(1, 0x40, 0x01, 0x0404)
    host.request(2, 0x40, 0x01, 0, 1)
    host.request(3, CLASS_REQUEST, SET_LINE_CODING, 0, 0, line_coding(9600, 0, 2, 8))
    host.request(4, CLASS_REQUEST, 0x22, 3)
