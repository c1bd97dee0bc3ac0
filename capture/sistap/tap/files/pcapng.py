# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes pcapng blocks (RFC draft-ietf-opsawg-pcapng), each as one bytes object, so that a cut file stays readable.

Times are ns since 1970. Only the blocks that sistap needs: section, interfaces, enhanced packets, interface statistics.
"""

from __future__ import annotations

import enum
import os
import struct
from collections.abc import Iterable
from functools import cache, lru_cache
from typing import NamedTuple

LINKTYPE_WIRESHARK_UPPER_PDU = 252
LINKTYPE_RTAC_SERIAL = 250
LINKTYPE_USER0 = 147

# As the option --link-type names them.
UPPER_PDU, RTAC = "upper-pdu", "rtac"
LINK_TYPES = {
    UPPER_PDU: LINKTYPE_WIRESHARK_UPPER_PDU,
    RTAC: LINKTYPE_RTAC_SERIAL,
    **{f"user{i}": LINKTYPE_USER0 + i for i in range(16)},
}

SECTION_HEADER = 0x0A0D0D0A
# The first bytes of captures: pcapng, and pcap in both byte orders with us and with ns.
FIRST_BYTES = tuple(map(bytes.fromhex, ("0a0d0d0a", "d4c3b2a1", "a1b2c3d4", "4d3cb2a1", "a1b23c4d")))
INTERFACE_DESCRIPTION = 1
INTERFACE_STATISTICS = 5
ENHANCED_PACKET = 6

_PACKET = struct.Struct("<IIIII")  # interface, time in two halves, length in the file and on the line

Option = tuple[int, bytes]

# Upper PDU tags (epan/exported_pdu.h): the payload's dissector by name; a tag 0 ends the list.
_TAG_DISSECTOR_NAME = 12


class PacketFlags(enum.IntFlag):
    """The option epb_flags."""

    INBOUND = 1
    OUTBOUND = 2
    CRC_ERROR = 1 << 24
    SYMBOL_ERROR = 1 << 31


class Interface(NamedTuple):
    """The contents of an interface description block; empty strings are left out."""

    link_type: int
    name: str
    description: str = ""
    speed: int = 0  # bit/s; 0 unknown
    hardware: str = ""
    filter: str = ""


class Statistics(NamedTuple):
    """Counters of the interface statistics block, in packets."""

    start_ns: int
    end_ns: int
    received: int
    accepted: int
    dropped: int


def _padded(data: bytes) -> bytes:
    return data + bytes(-len(data) % 4)


def _options(options: Iterable[Option]) -> bytes:
    packed = b"".join(struct.pack("<HH", code, len(value)) + _padded(value) for code, value in options)
    return packed + bytes(4) if packed else b""


def block(kind: int, body: bytes) -> bytes:
    """Return a block."""
    length = 12 + len(body)
    return struct.pack("<II", kind, length) + body + struct.pack("<I", length)


def _time(time_ns: int) -> bytes:
    return struct.pack("<II", time_ns >> 32, time_ns & 0xFFFFFFFF)


def _text(code: int, text: str) -> list[Option]:
    return [(code, text.encode(errors="backslashreplace"))] if text else []


def section_header(application: str, operating_system: str) -> bytes:
    """Return the first block of a section and of a file."""
    options = [*_text(3, operating_system), *_text(4, application)]
    return block(SECTION_HEADER, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1) + _options(options))


def interface_description(interface: Interface) -> bytes:
    """Return the block of one line; interfaces are numbered in the order of these blocks."""
    options = [*_text(2, interface.name), *_text(3, interface.description)]
    if interface.speed:
        options.append((8, struct.pack("<Q", interface.speed)))
    options.append((9, b"\x09"))  # if_tsresol: 10^-9 s
    if interface.filter:
        options.append((11, b"\x00" + os.fsencode(interface.filter)))  # 0: a libpcap filter string
    options += _text(15, interface.hardware)
    return block(INTERFACE_DESCRIPTION, struct.pack("<HHI", interface.link_type, 0, 0) + _options(options))


def enhanced_packet(interface: int, time_ns: int, data: bytes, flags: int = 0) -> bytes:
    """Return a packet block; `flags` are PacketFlags."""
    head = _PACKET.pack(interface, time_ns >> 32, time_ns & 0xFFFFFFFF, len(data), len(data))
    return block(ENHANCED_PACKET, head + _padded(data) + _packet_options(flags))


@lru_cache(64)  # a capture has few different flags
def _packet_options(flags: int) -> bytes:
    return _options([(2, struct.pack("<I", flags))]) if flags else b""


def interface_statistics(interface: int, statistics: Statistics) -> bytes:
    """Return the block with the statistics of an interface."""
    counters = [(4, statistics.received), (6, statistics.accepted), (7, statistics.dropped)]
    options = [(2, _time(statistics.start_ns)), (3, _time(statistics.end_ns))]
    options += [(code, struct.pack("<Q", value)) for code, value in counters]
    return block(INTERFACE_STATISTICS, struct.pack("<I", interface) + _time(statistics.end_ns) + _options(options))


def upper_pdu(dissector: str, payload: bytes) -> bytes:
    """Wrap a payload so that Wireshark hands it to a dissector by name (LINKTYPE_WIRESHARK_UPPER_PDU)."""
    return _tags(dissector) + payload


@cache
def _tags(dissector: str) -> bytes:
    name = _padded(dissector.encode())
    return struct.pack(">HH", _TAG_DISSECTOR_NAME, len(name)) + name + bytes(4)
