# SPDX-License-Identifier: GPL-2.0-or-later
"""What a program has captured: packets with their times, from sistap's pcapng or any pcap."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from itertools import accumulate
from pathlib import Path
from typing import NamedTuple

from sistap.dissected.captures.reading import records
from sistap.tap.records.record import Record, Type


class Packet(NamedTuple):
    """Characters and their times, in ns: one for each character, or one for all."""

    data: bytes
    times_ns: Sequence[int]


def sistap_records(file: Path) -> Iterator[Record]:
    """Read the records with characters in a pcapng file of ours."""
    return (taken for taken in records(file) if taken.type != Type.EVENT)


def character_times_ns(taken: Record) -> Iterator[int]:
    """Return the time of each character of a record."""
    return accumulate(taken.intervals[1:], initial=taken.time_ns)


def sistap_packets(file: Path) -> Iterator[Packet]:
    """Read the records of a pcapng file of ours as packets."""
    for taken in sistap_records(file):
        yield Packet(taken.data, list(character_times_ns(taken)))


def pcap_packets(file: Path) -> Iterator[Packet]:
    """Read a pcap file with microseconds (0xA1B2C3D4), written on this computer."""
    data = file.read_bytes()
    at = 24  # the file's header is not needed
    while at + 16 <= len(data):
        seconds, microseconds, size, _ = struct.unpack_from("=IIII", data, at)
        at += 16
        yield Packet(data[at : at + size], [seconds * 1_000_000_000 + microseconds * 1000])
        at += size
