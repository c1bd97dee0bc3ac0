# SPDX-License-Identifier: GPL-2.0-or-later
"""However TCP cuts a stream into segments, and wherever a capture of it ends, it has the same telegrams and lines."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from make import LINKTYPE_RAW_IPV4, START_NS, tcp_segment
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from sistap.tap.sis.telegram import START, build

PORT = 4200
NEGOTIATION = bytes.fromhex("FF FD 01  FF FB 2C")
COMMANDS = (bytes.fromhex("FF F1"), bytes.fromhex("FF FD 00"), bytes.fromhex("FF FA 2C 6A FF FF 01 FF F0"))
# The kinds of lines that nobody answers: 0 text, 1 open, 2 prompt, 3 read, 4 write, 6 asks, 7 error.
KINDS = {
    "S-0-0051,7,R\r": "3",
    "BCD:21\r": "1",
    "12.5\n": "0",
    "E21:>": "2",
    "?": "6",
    "P-0-4006,7,W,>\r": "4",
    "°C ÿ\r": "0",
    "#7004\r": "7",
}


class Unit(NamedTuple):
    """Bytes, and what a dissector must say as soon as they have come; empty: it need not say anything."""

    data: bytes
    said: str = ""


def telegrams(source: random.Random) -> Iterator[Unit]:
    """Yield telegrams, some damaged, and noise. What seems to begin a telegram does so."""
    for _ in range(8):
        body = bytes(source.choice([0x00, 0xFF, source.randrange(3, 256)]) for _ in range(source.choice([0, 1, 5, 11])))
        whole = build(0x10, 16, 3, body, reaction=source.random() < 0.4)
        damaged = whole[:-1] + bytes([whole[-1] ^ 0x40])
        if source.random() < 0.3:
            yield Unit(bytes(source.choice([0x00, 0x03, 0x07, 0xFF]) for _ in range(source.randrange(1, 20))))
        if damaged.count(START) == 1 and source.random() < 0.1:
            yield Unit(damaged)
        if whole.count(START) == 1:
            yield Unit(whole, f"{whole[1]:#04x}")


def lines(source: random.Random) -> Iterator[Unit]:
    """Yield lines and prompts of the ASCII protocol. What follows a CR says nothing more."""
    for _ in range(12):
        text = source.choice(list(KINDS))
        yield Unit(text.encode("latin-1"), KINDS[text])
        if text.endswith("\r"):
            yield Unit(source.choice([b"", b"\n", b"\n\r\n"]))


def over_telnet(units: list[Unit], source: random.Random) -> Iterator[Unit]:
    """Double FF, and put commands between the characters."""
    yield Unit(NEGOTIATION)
    for unit in units:
        doubled = [bytes([value]) * (1 + (value == 0xFF)) for value in unit.data]
        commands = [source.choice(COMMANDS) if source.random() < 0.02 else b"" for _ in doubled]
        yield Unit(b"".join(b"".join(pair) for pair in zip(commands, doubled, strict=True)), unit.said)


def cut(stream: bytes, source: random.Random, longest: int) -> Iterator[bytes]:
    """Cut a stream at random."""
    while stream:
        size = source.randint(1, longest)
        yield stream[:size]
        stream = stream[size:]


def complete(units: list[Unit], end: int) -> Iterator[str]:
    """Yield what the units say that have come before `end`."""
    for unit in units:
        end -= len(unit.data)
        if unit.said and end >= 0:
            yield unit.said


def write(path: Path, streams: list[list[Unit]], source: random.Random) -> list[list[str]]:
    """Write a capture of connections: each stream cut in several ways. Return what each of them must say."""
    blocks = [pcapng.section_header("", ""), pcapng.interface_description(pcapng.Interface(LINKTYPE_RAW_IPV4, "tcp"))]
    expected: list[list[str]] = []
    for units in streams:
        stream = b"".join(unit.data for unit in units)
        for longest in (1, 3, 8, 30, len(stream)):
            end = len(stream) if longest == 1 else source.randrange(len(stream) // 2, len(stream) + 1)
            client = (1024 + len(expected)).to_bytes(2)
            sent = 1
            for payload in cut(stream[:end], source, longest):
                segment = tcp_segment(PORT, True, sent, 1, payload)
                segment = segment[:20] + client + segment[22:]
                blocks.append(pcapng.enhanced_packet(0, START_NS + len(blocks) * 1_000_000, segment))
                sent += len(payload)
            expected.append(list(complete(units, end)))
    path.write_bytes(b"".join(blocks))
    return expected


def said(tshark: Tshark, path: Path, protocol: str, *options: str) -> dict[int, list[str]]:
    """Return what the dissector says on each connection."""
    fields = ("tcp.stream", "sis.checksum", "sis.checksum.status", "sisascii.kind")
    names = [word for name in fields for word in ("-e", name)]
    decode = ("-d", f"tcp.port=={PORT},{protocol}", "-T", "fields", "-E", "aggregator= ", *names)
    found: dict[int, list[str]] = {}
    for row in tshark.output("-r", str(path), *options, *decode).splitlines():
        stream, checksums, states, kinds = row.split("\t")
        good = [one for one, state in zip(checksums.split(), states.split(), strict=False) if state == "1"]
        found.setdefault(int(stream), []).extend(kinds.split() if protocol == "sisascii" else good)
    return found


CASES = {"telegrams": (telegrams, "sis"), "lines": (lines, "sisascii")}


@pytest.mark.parametrize(
    ("seed", "count"), [(1, 4), *(pytest.param(seed, 100, marks=pytest.mark.thorough) for seed in (2, 3, 4))]
)
@pytest.mark.parametrize("is_telnet", [False, True], ids=["plain", "telnet"])
@pytest.mark.parametrize(("make", "protocol"), CASES.values(), ids=list(CASES))
def test_segments_do_not_matter(
    make: Callable[[random.Random], Iterator[Unit]],
    protocol: str,
    is_telnet: bool,
    seed: int,
    count: int,
    plugin: Tshark,
    script: Tshark,
    tmp_path: Path,
) -> None:
    source = random.Random(seed)
    streams = [list(make(source)) for _ in range(count)]
    streams = [list(over_telnet(units, source)) for units in streams] if is_telnet else streams
    expected = write(tmp_path / "streams.pcapng", streams, source)
    for tshark in (plugin, script):
        for options in ((), ("-2",)):
            found = said(tshark, tmp_path / "streams.pcapng", protocol, *options)
            assert [found[number] for number in range(len(expected))] == expected
