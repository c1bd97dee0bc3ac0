# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads capture files (pcapng): block by block, packet by packet, or as their records of protocol `sertap`."""

from __future__ import annotations

import gzip
import struct
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple, cast

from sistap.tap.files import pcapng
from sistap.tap.records import record
from sistap.tap.records.record import Record
from sistap.tap.terminal.exits import NotCaptured

_MAGIC = 0x1A2B3C4D
_LARGEST = 1 << 24  # bytes of a block; Wireshark's limit for packets is far smaller
_NAME = 12  # the tag of an exported PDU that names its dissector
_RESOLUTION = 9  # the option if_tsresol
_MICROSECONDS = 6  # decimal places without the option
# bytes of the fixed part of a body
_FIXED = {pcapng.SECTION_HEADER: 16, pcapng.INTERFACE_DESCRIPTION: 8, pcapng.ENHANCED_PACKET: 20}
_PACKED = b"\x1f\x8b"  # gzip
# The byte order of the older format pcap, by its first bytes, with times in us and ns.
_PCAP = {b"\xd4\xc3\xb2\xa1": "<", b"\x4d\x3c\xb2\xa1": "<", b"\xa1\xb2\xc3\xd4": ">", b"\xa1\xb2\x3c\x4d": ">"}
_PCAP_HEADING = 24  # bytes; the last four are the link type
OTHER_PACKETS = (2, 3)  # kinds of blocks that name no interface, or are obsolete
_CURE = "open and save it in Wireshark"

Say = Callable[[str], object]


class Block(NamedTuple):
    """A block of a file."""

    kind: int
    order: str  # byte order, as struct names it
    body: bytes


class RawPacket(NamedTuple):
    """A packet of a file."""

    link_type: int
    time_ns: int | None  # None: its interface uses units that are not supported
    data: bytes
    interface: bytes  # its description: the body of the block


class _Interface(NamedTuple):
    link_type: int
    decimals: int  # decimal places of its time stamps, in seconds
    description: bytes


def beginning(path: Path) -> tuple[set[int], bool]:
    """Return the link types that come before the first packet, and whether there is a packet.

    No link types, and a packet, of a file that is neither pcapng nor pcap. May raise OSError.
    """
    with path.open("rb") as file:
        heading = file.read(_PCAP_HEADING)
        if len(heading) == _PCAP_HEADING and (order := _PCAP.get(heading[:4])):
            return {*struct.unpack(f"{order}I", heading[-4:])}, bool(file.read(1))
    found: set[int] = set()
    try:
        with opened(path) as file:
            for kind, order, body in blocks(file, path):
                if kind == pcapng.ENHANCED_PACKET or kind in OTHER_PACKETS:
                    return found, True
                if kind == pcapng.INTERFACE_DESCRIPTION:
                    found.add(_interface(order, body).link_type)
    except NotCaptured:
        return set(), True
    return found, False


def records(path: Path, say: Say = lambda _: None) -> Iterator[Record]:
    """Yield all records in the order of the file; one that is cut off ends early, and `say` is told so.

    Raise OSError, or NotCaptured for any other file.
    """
    found = False
    for packet in packets(path, say):
        try:
            one = record_of(packet)
        except (ValueError, IndexError) as error:
            raise NotCaptured(f"{path} has a damaged record: {error}; leave it out in Wireshark") from error
        if one:
            found = True
            yield one
    if not found:
        raise NotCaptured(
            f"{path} has no records of sistap: it takes what `sistap capture -w` or `sistap bus -w` writes "
            "without --link-type"
        )


def record_of(packet: RawPacket) -> Record | None:
    """Return the record in a packet; None if it has none. ValueError or IndexError if the record is damaged."""
    if packet.link_type != pcapng.LINKTYPE_WIRESHARK_UPPER_PDU or packet.time_ns is None:
        return None
    payload = _payload(packet.data)
    return None if payload is None else record.unpack(payload, packet.time_ns)


def packets(path: Path, say: Say = lambda _: None) -> Iterator[RawPacket]:
    """Yield all packets of interfaces that the file describes. Raise OSError or NotCaptured."""
    with opened(path) as file:
        interfaces: list[_Interface] = []
        for kind, order, body in blocks(file, path, say):
            if kind == pcapng.SECTION_HEADER:
                interfaces = []
            elif kind == pcapng.INTERFACE_DESCRIPTION:
                interfaces.append(_interface(order, body))
            elif kind == pcapng.ENHANCED_PACKET:
                number, high, low, length = struct.unpack_from(f"{order}IIII", body)
                if number < len(interfaces):
                    link_type, decimals, description = interfaces[number]
                    yield RawPacket(
                        link_type, _time_ns(high << 32 | low, decimals), body[20 : 20 + length], description
                    )


def opened(path: Path) -> BinaryIO:
    """Open a capture, compressed or not. May raise OSError.

    A recorder may have compressed it since somebody listed its folder.
    """
    if not path.exists() and (packed := path.with_name(f"{path.name}.gz")).exists():
        path = packed
    with path.open("rb") as file:
        is_packed = file.read(2) == _PACKED
    return cast(BinaryIO, gzip.GzipFile(path)) if is_packed else path.open("rb")


def blocks(file: BinaryIO, path: Path, say: Say = lambda _: None) -> Iterator[Block]:
    """Yield each whole block of the file named `path`; `say` that it is cut off. Raise OSError or NotCaptured."""
    try:
        yield from _blocks(file, path)
    except EOFError:  # of a compressed one, too
        say(f"{path} is cut off")
    except (zlib.error, gzip.BadGzipFile) as error:
        raise NotCaptured(f"{path} is damaged: {error}; {_CURE}") from None


def _blocks(file: BinaryIO, path: Path) -> Iterator[Block]:
    order = ""
    while head := file.read(8):
        if len(head) < 8:
            raise EOFError
        if head[:4] == struct.pack("<I", pcapng.SECTION_HEADER):
            magic = file.read(4)
            order = {struct.pack(f"{order}I", _MAGIC): order for order in "<>"}.get(magic, "")
            file.seek(-len(magic), 1)
        if not order:
            raise NotCaptured(f"{path} is not a pcapng file: open it in Wireshark and save it as pcapng")
        kind, length = struct.unpack(f"{order}II", head)
        if length % 4 or not 12 <= length <= _LARGEST:
            raise NotCaptured(f"{path} is damaged: a block says it has {length} bytes; {_CURE}")
        body = file.read(length - 8)[:-4]
        if len(body) < length - 12:
            raise EOFError
        if len(body) < _FIXED.get(kind, 0):
            raise NotCaptured(f"{path} is damaged: a block of kind {kind} has only {len(body)} bytes; {_CURE}")
        yield Block(kind, order, body)


def _interface(order: str, body: bytes) -> _Interface:
    (link_type,) = struct.unpack_from(f"{order}H", body)
    decimals = _MICROSECONDS
    place = 8
    while place + 4 <= len(body):
        code, length = struct.unpack_from(f"{order}HH", body, place)
        if code == _RESOLUTION and length == 1 and place + 4 < len(body):
            decimals = body[place + 4]
        place += 4 + length + -length % 4
    return _Interface(link_type, decimals, body)


def _time_ns(ticks: int, decimals: int) -> int | None:
    return ticks * 10 ** (9 - decimals) if decimals <= 9 else None


def _payload(packet: bytes) -> bytes | None:
    """Return the payload for the dissector `sertap` (exported PDU: tags, the last is 0, then the payload)."""
    place, name = 0, b""
    while place + 4 <= len(packet):
        tag, length = struct.unpack_from(">HH", packet, place)
        value = packet[place + 4 : place + 4 + length]
        place += 4 + length
        if tag == 0:
            return packet[place:] if name.rstrip(b"\0") == b"sertap" else None
        if tag == _NAME:
            name = value
    return None
