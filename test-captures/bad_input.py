# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes telegrams with missing, extra or wrong bytes from the good ones of this folder."""

from __future__ import annotations

import random
import struct
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from make import HERE, Scenario
from sistap.tap.files import pcapng
from sistap.tap.sis import telegram

SNAPPED_FROM = 8  # a capture is cut in the useful data; every beginning of the header is in test_cut.py
FILLINGS = (0x00, 0x01, 0x02, 0x3C, 0x41, 0x80, 0xFF)

_ORIGINAL_LENGTH = 24  # of an enhanced packet block


class Packet(NamedTuple):
    """A telegram, and its length before the capture cut it."""

    data: bytes
    original: int


def examples() -> list[bytes]:
    """Return the good telegrams: all of the specification, and every body."""
    names = ("specification", "bodies", "codes")
    telegrams = {item.data: None for name in names for item in Scenario(HERE / f"{name}.txt").items}
    return list(telegrams)  # each once, in order


def with_body(example: bytes, body: bytes) -> bytes:
    """Replace the body of a telegram, and correct lengths and checksum."""
    header = telegram.parse(example)
    return telegram.build(
        header.service,
        header.sender,
        header.receiver,
        body,
        reaction=header.reaction,
        subaddresses=header.subaddresses,
        number=header.number,
    )


def with_checksum(data: bytes) -> bytes:
    """Make the sum of all bytes 0."""
    return data[:1] + bytes([-(sum(data) - data[1]) & 0xFF]) + data[2:]


def shortened(example: bytes) -> Iterator[bytes]:
    """Cut the body at every length; the telegram is right otherwise."""
    body = telegram.parse(example).body
    return (with_body(example, body[:end]) for end in range(len(body)))


def lengthened(example: bytes) -> Iterator[bytes]:
    """Append one byte and three."""
    body = telegram.parse(example).body
    return (with_body(example, body + bytes(range(count))) for count in (1, 3))


def snapped(example: bytes) -> Iterator[Packet]:
    """Cut the capture of a telegram at every length."""
    return (Packet(example[:end], len(example)) for end in range(SNAPPED_FROM, len(example)))


def with_other_length(example: bytes, length: int) -> bytes:
    """Cut everything after the header of 8; the telegram is right otherwise."""
    return with_checksum(example[:2] + bytes([length, length]) + example[4 : telegram.STATIC_LENGTH + length])


def with_other_repetition(example: bytes) -> Iterator[bytes]:
    """Make the repetition of the data length wrong and the checksum right."""
    for wrong in {example[3] ^ 1, 0, 255} - {example[2]}:
        yield with_checksum(example[:3] + bytes([wrong]) + example[4:])


def of_every_service(reaction: bool, body: bytes, subaddresses: bytes = b"") -> list[bytes]:
    """Make this body a telegram of each of the 256 services."""
    build = telegram.build
    return [build(service, 16, 3, body, reaction=reaction, subaddresses=subaddresses) for service in range(256)]


def with_all_bodies(reaction: bool) -> Iterator[bytes]:
    """Make telegrams that are right except for their useful data. Of every service: empty, full, after seven
    subaddresses. Of every example: the original, cut anywhere, with additions, and filled up.
    """
    yield from of_every_service(reaction, b"")
    yield from of_every_service(reaction, b"", bytes(range(1, 8)))
    for filling in FILLINGS:
        yield from of_every_service(reaction, bytes([filling]) * 255)
    for example in examples():
        header = telegram.parse(example)
        if header.reaction == reaction:
            yield example
            yield from shortened(example)
            yield from lengthened(example)
            yield with_body(example, header.body.ljust(255 - len(header.subaddresses), b"\x55"))


def write(path: Path, packets: Iterable[Packet | bytes], dissector: str = "sis") -> None:
    """Write a capture of bare telegrams, or of packets for another dissector."""
    interface = pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, "bad")
    blocks = [pcapng.section_header("bad_input.py", ""), pcapng.interface_description(interface)]
    for number, packet in enumerate(packets):
        data, original = packet if isinstance(packet, Packet) else (packet, len(packet))
        block = bytearray(pcapng.enhanced_packet(0, number * 1_000_000, pcapng.upper_pdu(dissector, data)))
        (captured,) = struct.unpack_from("<I", block, _ORIGINAL_LENGTH)
        struct.pack_into("<I", block, _ORIGINAL_LENGTH, captured + original - len(data))
        blocks.append(bytes(block))
    path.write_bytes(b"".join(blocks))


_PARTS = (
    *("BCD:", "E", ":>", "21", "256", "0", "S-0-0051", "P-7-4095", "S-0-0390.0.136", "A-0-0004", "S-8-9999", ","),
    *(
        ",7,R",
        ",7,W,",
        ",2,r",
        ",8,R",
        ">",
        "<",
        "?",
        "#7004",
        "#900",
        "-12.5",
        "0013",
        "1e9",
        "9" * 40,
        "\x00",
        "\xb0C",
    ),
)


def ascii_lines(chance: random.Random, count: int) -> list[bytes]:
    """Make lines of the ASCII protocol from what such lines have, and from any characters."""
    lines = []
    for _ in range(count):
        text = "".join(chance.choices(_PARTS, k=chance.randint(0, 4))).encode("latin-1")
        if chance.random() < 0.2:
            text += chance.randbytes(chance.randint(1, 12))
        lines.append(text + chance.choice([b"\r\n", b"\r", b"\n", b""]))
    return lines
