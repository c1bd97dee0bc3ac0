# SPDX-License-Identifier: GPL-2.0-or-later
"""USB serial chips, as far as the drivers of Linux see them: descriptors, requests, and packets with line errors.

A chip gets each character with its line status, as in a 16550. It says what it knows in its own way: FT232R and PL2303
for a whole packet, CP2102 for each character, CDC beside the packets, CH340 not at all.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

LOST, PARITY, FRAMING, BREAK = 0x02, 0x04, 0x08, 0x10  # line status; LOST: characters were lost before this one
FORMAT_PARITIES = "NOEMS"  # as FTDI, CDC and PL2303 number them
STOPS = ("1", "1.5", "2")

Character = tuple[int, int]  # value, line status
Tell = Callable[..., None]  # what the computer has set, by name

# Directions and kinds of control requests: USB 2.0, table 9-2.
STANDARD_IN, CLASS_IN, VENDOR_IN = 0x80, 0xA1, 0xC0
CLASS_OUT, VENDOR_OUT, INTERFACE_OUT, INTERFACE_IN = 0x21, 0x40, 0x41, 0xC1


class Chip:
    """A chip; subclasses override what differs."""

    product = ""
    ids = (0, 0, 0)  # vendor, product, release
    usb = 0x0200  # its version
    device_class = 0
    full, head = 64, 0  # bytes in a packet, and those of them that are no characters
    latency_s = 0.0  # an incomplete packet goes that long after the one before
    sticky = False  # of an FT232R: the packet after a break reports the break, too
    notifies = False  # it has an interrupt endpoint for line errors
    interfaces = 1
    interface = "09 04 00 00 02 ff 00 00 00"  # its descriptors, before the two bulk endpoints

    def __init__(self, tell: Tell) -> None:
        """`tell` takes what the computer sets."""
        self.tell = tell

    def control(self, kind: int, request: int, value: int, index: int, data: bytes) -> bytes | None:  # noqa: ARG002
        """Return the answer to a request of this chip; None: it does not know it."""
        return b""

    def room(self, status: int) -> int:  # noqa: ARG002
        """Return how many bytes of a packet a character takes at most."""
        return 1

    def closes(self, status: int) -> bool:  # noqa: ARG002
        """Tell whether a packet ends with a character of this status."""
        return False

    def stands_alone(self, status: int) -> bool:  # noqa: ARG002
        """Tell whether a character of this status has a packet of its own."""
        return False

    def packet(self, part: Sequence[Character]) -> bytes:
        """Return what goes through the bulk endpoint."""
        return bytes(value for value, _ in part)

    def notice(self, status: int) -> bytes:  # noqa: ARG002
        """Return what goes through the interrupt endpoint before a packet with these line errors."""
        return b""

    @property
    def descriptors(self) -> tuple[bytes, bytes]:
        """Return those of the device and of its configuration."""
        device = struct.pack("<BBHBBBBHHHBBBB", 18, 1, self.usb, self.device_class, 0, 0, 64, *self.ids, 1, 2, 3, 1)
        ends = struct.pack("<BBBBHB", 7, 5, 0x81, 2, self.full, 0) + struct.pack("<BBBBHB", 7, 5, 0x02, 2, self.full, 0)
        body = bytes.fromhex(self.interface) + ends
        return device, struct.pack("<BBHBBBBB", 9, 2, 9 + len(body), self.interfaces, 1, 0, 0x80, 50) + body


def together(part: Sequence[Character]) -> int:
    """Return the line errors of a packet."""
    status = 0
    for _, one in part:
        status |= one
    return status


class Ft232r(Chip):
    """Two bytes of status before each packet. A break ends a packet. If `sticky`, the next one still reports it."""

    product, ids = "FT232R USB UART", (0x0403, 0x6001, 0x0600)
    head, latency_s = 2, 0.016
    _after_break = False
    # FTDI's AN232B-05: eighths of a divisor, keyed by their code; divisors with another meaning.
    _EIGHTHS = (0, 4, 2, 1, 3, 5, 6, 7)
    _SPECIAL: ClassVar[dict[float, float]] = {0: 1, 1: 1.5}

    def control(self, kind: int, request: int, value: int, index: int, data: bytes) -> bytes | None:  # noqa: ARG002
        """Rate, format, lines, latency timer."""
        if (kind, request) == (VENDOR_OUT, 9):
            self.latency_s = (value & 0xFF) / 1000
        elif (kind, request) == (VENDOR_OUT, 1):  # the high byte selects the lines
            self.tell(**{name: bool(value & bit) for name, bit in (("dtr", 1), ("rts", 2)) if value >> 8 & bit})
        elif (kind, request) == (VENDOR_OUT, 3):
            divisor = (value & 0x3FFF) + self._EIGHTHS[value >> 14 | (index & 1) << 2] / 8
            self.tell(baud=3_000_000 / self._SPECIAL.get(divisor, divisor))
        elif (kind, request) == (VENDOR_OUT, 4):
            self.tell(format=f"{value & 0xF}{FORMAT_PARITIES[value >> 8 & 7]}{STOPS[value >> 11 & 3]}")
        answers = {5: b"\x31\x60", 0x90: b"\xff\xff", 10: bytes([round(self.latency_s * 1000)])}
        return answers.get(request, b"") if kind == VENDOR_IN else b""

    def closes(self, status: int) -> bool:
        """A break is the last character of its packet."""
        return bool(status & BREAK)

    def packet(self, part: Sequence[Character]) -> bytes:
        """Put the status of all characters before them."""
        status = together(part)
        reported = status | (BREAK if self.sticky and self._after_break else 0)
        self._after_break = bool(status & BREAK)
        return bytes([0x01, 0x60 | reported]) + super().packet(part)


class Cp2102(Chip):
    """Escapes in the stream: EC 00 is the character EC; EC 01 comes before a status and its character (AN571)."""

    product, ids = "CP2102 USB to UART", (0x10C4, 0xEA60, 0x0100)
    _baud = 9600
    _escapes = False

    def control(self, kind: int, request: int, value: int, index: int, data: bytes) -> bytes | None:  # noqa: ARG002
        """Rate, format, lines, events; only the part number of the vendor requests."""
        if request == 0xFF:
            return b"\x02\0" if value == 0x370B else None
        if (kind, request) == (INTERFACE_OUT, 0x1E):
            (self._baud,) = struct.unpack("<I", data)
            self.tell(baud=float(self._baud))
        elif (kind, request) == (INTERFACE_OUT, 0x03):
            self.tell(format=f"{value >> 8}{FORMAT_PARITIES[value >> 4 & 15]}{STOPS[value & 15]}")
        elif (kind, request) == (INTERFACE_OUT, 0x07):  # the high byte selects the lines
            self.tell(**{name: bool(value & bit) for name, bit in (("dtr", 1), ("rts", 2)) if value >> 8 & bit})
        elif (kind, request) == (INTERFACE_OUT, 0x13):  # flow control holds both lines, too
            dtr, rts = struct.unpack("<II", data[:8])
            self.tell(dtr=bool(dtr & 1), rts=bool(rts >> 6 & 1))
        elif (kind, request) == (INTERFACE_OUT, 0x15):
            self._escapes = bool(value)
        return {0x1D: struct.pack("<I", self._baud), 0x04: b"\x00\x08"}.get(request, bytes(64))

    def room(self, status: int) -> int:
        """Four bytes with a status, two as EC."""
        return 4 if status else 2

    def packet(self, part: Sequence[Character]) -> bytes:
        """Escape what needs it."""
        if not self._escapes:
            return super().packet(part)
        packet = b""
        for value, status in part:
            packet += bytes([0xEC, 1, status, value] if status else [0xEC, 0] if value == 0xEC else [value])
        return packet


class Ch340(Chip):
    """It knows of line errors, but its driver never asks. Version 0x31 gets the format."""

    product, ids, device_class, full = "USB Serial", (0x1A86, 0x7523, 0x0254), 0xFF, 32
    interface = "09 04 00 00 03 ff 00 00 00 07 05 82 03 08 00 01"

    def control(self, kind: int, request: int, value: int, index: int, data: bytes) -> bytes | None:  # noqa: ARG002
        """Rate, format, lines; registers 0x12 and 0x13 have the divisor, 0x18 the format."""
        if (kind, request) == (VENDOR_OUT, 0xA4):
            self.tell(dtr=not value & 0x20, rts=not value & 0x40)
        elif (kind, request, value) == (VENDOR_OUT, 0x9A, 0x1312):
            divisor, shift = 0x100 - (index >> 8), 12 - 3 * (index & 3) - (index >> 2 & 1)
            self.tell(baud=48_000_000 / (1 << shift) / divisor)
        elif (kind, request, value) == (VENDOR_OUT, 0x9A, 0x2518):
            parity = "OEMS"[index >> 4 & 3] if index & 8 else "N"
            self.tell(format=f"{5 + (index & 3)}{parity}{2 if index & 4 else 1}")
        return {0x5F: b"\x31\x00", 0x95: b"\xff\xee"}.get(request, b"") if kind == VENDOR_IN else b""


class Acm(Chip):
    """Requests of CDC, which PL2303 has, too."""

    notifies = True
    _coding = struct.pack("<IBBB", 9600, 0, 0, 8)

    def control(self, kind: int, request: int, value: int, index: int, data: bytes) -> bytes | None:  # noqa: ARG002
        """Rate, format, lines."""
        if (kind, request) == (CLASS_OUT, 0x20):
            self._coding = data
            baud, stop, parity, bits = struct.unpack("<IBBB", data)
            self.tell(baud=float(baud), format=f"{bits}{FORMAT_PARITIES[parity]}{STOPS[stop]}")
        elif (kind, request) == (CLASS_OUT, 0x22):
            self.tell(dtr=bool(value & 1), rts=bool(value & 2))
        return self._coding if (kind, request) == (CLASS_IN, 0x21) else b""

    def notice(self, status: int) -> bytes:
        """SERIAL_STATE (CDC PSTN 1.2, chapter 6.5.4): break, framing, parity, overrun."""
        bits = ((BREAK, 2), (FRAMING, 4), (PARITY, 5), (LOST, 6))
        state = sum(1 << place for bit, place in bits if status & bit)
        return struct.pack("<BBHHHH", 0xA1, 0x20, 0, 0, 2, state)


class Pl2303(Acm):
    """One status for the packet that comes next; a break is a character of it. Most rates are sent as a divisor."""

    product, ids, usb = "USB-Serial Controller", (0x067B, 0x2303, 0x0300), 0x0110  # a PL2303HX
    interface = "09 04 00 00 03 ff 00 00 00 07 05 82 03 0a 00 01"

    def control(self, kind: int, request: int, value: int, index: int, data: bytes) -> bytes | None:
        """Also registers, which are all 0."""
        if kind == VENDOR_IN:
            return b"\0"
        answer = super().control(kind, request, value, index, data)
        if request == 0x20 and (coded := struct.unpack("<I", data[:4])[0]) & 1 << 31:
            self.tell(baud=12_000_000 * 32 / ((coded & 0x1FF) << 2 * (coded >> 9 & 7)))
        return answer


class Cdc(Acm):
    """A break is told and is no character."""

    product, ids, device_class = "CDC adapter", (0x1209, 0x0001, 0x0100), 2
    interfaces = 2
    interface = (
        "09 04 00 00 01 02 02 01 00 05 24 00 10 01 05 24 01 00 01 04 24 02 06 05 24 06 00 01 07 05 82 03 0a 00 01 "
        "09 04 01 00 02 0a 00 00 00"
    )

    def stands_alone(self, status: int) -> bool:
        """Only a break does."""
        return bool(status & BREAK)

    def packet(self, part: Sequence[Character]) -> bytes:
        """Leave the break out."""
        return super().packet([one for one in part if not one[1] & BREAK])

    def notice(self, status: int) -> bytes:
        """Tell a break as nothing else."""
        return super().notice(BREAK if status & BREAK else status)


CHIPS: dict[str, Any] = {"ft232r": Ft232r, "cp2102": Cp2102, "ch340": Ch340, "pl2303": Pl2303, "cdc": Cdc}
