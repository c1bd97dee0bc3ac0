# SPDX-License-Identifier: GPL-2.0-or-later
"""What a program has captured: packets with their times, out of sistap's pcapng or anybody's pcap."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from itertools import accumulate
from pathlib import Path
from typing import NamedTuple

from sistap.files import pcapng
from sistap.records import record


class Packet(NamedTuple):
    """Characters and their times, in ns: one for each, or a single one for all."""

    data: bytes
    times_ns: Sequence[int]


def sistap_records(file: Path) -> Iterator[record.Record]:
    """Read the records with characters in a pcapng file of ours."""
    blocks = file.read_bytes()
    header = len(pcapng.upper_pdu("sertap", b""))
    at = 0
    while at < len(blocks):
        kind, length, _, high, low, size = struct.unpack_from("<IIIIII", blocks, at)
        if kind == pcapng.ENHANCED_PACKET:
            taken = record.unpack(blocks[at + 28 + header : at + 28 + size], high << 32 | low)
            if taken.type != record.Type.EVENT:
                yield taken
        at += length


def character_times_ns(taken: record.Record) -> Iterator[int]:
    """Give the time of each character of a record."""
    return accumulate(taken.intervals[1:], initial=taken.time_ns)


def sistap_packets(file: Path) -> Iterator[Packet]:
    """Read the records of a pcapng file of ours as packets."""
    for taken in sistap_records(file):
        yield Packet(taken.data, list(character_times_ns(taken)))


def pcap_packets(file: Path) -> Iterator[Packet]:
    """Read a pcap file with microseconds (0xA1B2C3D4), written on this machine."""
    data = file.read_bytes()
    at = 24  # of the file's header nothing more is needed
    while at + 16 <= len(data):
        seconds, microseconds, size, _ = struct.unpack_from("=IIII", data, at)
        at += 16
        yield Packet(data[at : at + size], [seconds * 1_000_000_000 + microseconds * 1000])
        at += size
