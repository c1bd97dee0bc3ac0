#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Dissects damaged copies of every capture, with the plugin under AddressSanitizer and UndefinedBehaviorSanitizer.

    python3 mutate.py --seconds 60            as long as that, each round with another seed
    python3 mutate.py --rounds 1 --seed 7     one round again

The pcapng around the packets is mutated, too, but stays readable: times jump and claim any year, resolutions and
options change, and packets are spread over sections and interfaces.

The sanitized plugin (CMake target sis_sanitized) has to be the one in WIRESHARK_PLUGIN_DIR; its runtime is preloaded
into tshark, and Wireshark's own allocator is set to plain malloc, so that the sanitizer sees the end of every block.
"""

from __future__ import annotations

import argparse
import random
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "capture"))

from sistap.dissected.captures.reading import packets  # noqa: E402
from sistap.dissected.wireshark.tshark import Tshark, TsharkError  # noqa: E402
from sistap.tap.files import pcapng  # noqa: E402

MUTANTS_PER_ROUND = 4000
INTERESTING = (0x00, 0x01, 0x02, 0x07, 0x08, 0x0F, 0x10, 0x7F, 0x80, 0xF0, 0xFE, 0xFF)

START_NS = 1_700_000_000_000_000_000
PACKETS_PER_SECTION = 200
RESOLUTIONS = (9, 9, 9, 6, 3, 0, 12, 0x80, 0x80 | 10, 0x80 | 30, 0x80 | 62)  # if_tsresol: 10^-n s, with bit 7 2^-n s
FAR_TIMES = (0, 1, 2**31, 2**32, 2**53, 2**62, 2**63 - 1, 2**63, 2**63 + 1, 2**64 - 1)  # in units of the resolution
STEPS = (0, 1, 1_000, 1_000_000, 1_000_000, 20_000_000, 999_999_999, 1_000_000_000, 5_000_000_000, -1, -2_000_000_000)
OFFSETS = (0, 1, -1, 2**31, 2**33, -(2**33), 2**62, -(2**63))  # if_tsoffset: seconds


def protected(link_type: int, data: bytes) -> int:
    """Return how many bytes at the start stay intact: those that lead to our dissectors."""
    if link_type != pcapng.LINKTYPE_WIRESHARK_UPPER_PDU:
        return 40 if link_type == 228 else 0
    return data.index(b"\0\0\0\0", 4) + 4 if b"\0\0\0\0" in data[4:] else 16


def mutant(chance: random.Random, head: bytes, body: bytes) -> bytes:
    """Change some bytes, cut, or lengthen."""
    changed = bytearray(body)
    for _ in range(chance.choice((0, 1, 1, 2, 3, 8))):
        if changed:
            value = chance.choice((chance.randrange(256), chance.choice(INTERESTING)))
            changed[chance.randrange(len(changed))] = value
    match chance.randrange(5):
        case 0:
            del changed[chance.randrange(len(changed) + 1) :]
        case 1:
            changed += chance.randbytes(chance.randrange(1, 300))
        case 2:
            at = chance.randrange(len(changed) + 1)
            changed[at:at] = changed[: chance.randrange(len(changed) + 1)]
    return head + bytes(changed)


def padded(data: bytes) -> bytes:
    """Fill up to a multiple of four."""
    return data + bytes(-len(data) % 4)


def block(kind: int, body: bytes, options: dict[int, bytes]) -> bytes:
    """Make a block of a pcapng with any options."""
    packed = b"".join(struct.pack("<HH", code, len(value)) + padded(value) for code, value in options.items())
    length = 16 + len(body) + len(packed)
    return struct.pack("<II", kind, length) + body + packed + bytes(4) + struct.pack("<I", length)


def interface_block(chance: random.Random, link_type: int, *, far: bool) -> bytes:
    """Describe an interface; where far times are wanted, its clock has any resolution and offset."""
    resolution = chance.choice(RESOLUTIONS) if far else 9
    options = {2: chance.randbytes(chance.randrange(9)).hex().encode(), 9: bytes([resolution])}
    if far and chance.random() < 0.2:
        options[14] = struct.pack("<q", chance.choice(OFFSETS))
    if chance.random() < 0.2:
        options[chance.randrange(100, 200)] = chance.randbytes(chance.randrange(40))  # codes that nobody knows
    return block(pcapng.INTERFACE_DESCRIPTION, struct.pack("<HHI", link_type, 0, 0), options)


def packet_block(chance: random.Random, interface: int, time: int, data: bytes) -> bytes:
    """Make a packet; some have flags, a comment, a count of lost packets, or what nobody knows."""
    options = {}
    if chance.random() < 0.2:
        options[chance.choice((1, 3, 7, 99))] = chance.randbytes(chance.randrange(1, 20)).hex().encode()
    if chance.random() < 0.2:
        options[2] = chance.randbytes(4)
    if chance.random() < 0.1:
        options[4] = chance.randbytes(8)
    head = struct.pack("<IIIII", interface, time >> 32, time & 0xFFFFFFFF, len(data), len(data))
    return block(pcapng.ENHANCED_PACKET, head + padded(data), options)


def times(chance: random.Random, *, far: bool) -> Iterator[int]:
    """Yield times endlessly in steps; with far times, some clocks jump anywhere."""
    now, is_wild = START_NS, far and chance.random() < 0.5
    while True:
        yield now % 2**64
        now += chance.choice(STEPS)
        if is_wild and chance.random() < 0.2:
            now = chance.choice((*FAR_TIMES, START_NS, chance.randrange(2**64)))


def section(chance: random.Random, link_type: int, originals: list[bytes], *, far: bool) -> bytes:
    """Make a section of mutants, on up to three interfaces."""
    interfaces = chance.choice((1, 1, 1, 2, 3))
    clock = times(chance, far=far)
    blocks = [pcapng.section_header("mutate.py", "")]
    blocks += [interface_block(chance, link_type, far=far) for _ in range(interfaces)]
    for _ in range(PACKETS_PER_SECTION):
        data = chance.choice(originals)
        keep = protected(link_type, data)
        changed = mutant(chance, data[:keep], data[keep:])
        blocks.append(packet_block(chance, chance.randrange(interfaces), next(clock), changed))
    return b"".join(blocks)


def round_capture(
    seed: int, link_type: int, originals: list[bytes], count: int = MUTANTS_PER_ROUND, *, far: bool = True
) -> bytes:
    """Make one capture of that many mutants in whole sections, of any time or of a valid one."""
    chance = random.Random(seed)
    sections = count // PACKETS_PER_SECTION
    return b"".join(section(chance, link_type, originals, far=far) for _ in range(sections))


def runtime() -> str:
    """Return the sanitizer's runtime of the compiler that built the plugin (gcc)."""
    paths = [
        subprocess.run(
            ["gcc", f"-print-file-name={name}"],
            capture_output=True,
            text=True,
            check=True,
        ).stdout.strip()
        for name in ("libasan.so", "libubsan.so")
    ]
    return ":".join(paths)


# By link type. `arcnet7f` is called by name: Wireshark's own dissector of ARCNET may have faults.
OPTIONS = {
    pcapng.LINKTYPE_WIRESHARK_UPPER_PDU: [
        ["-o", "sis.tza_ms:3", "-o", "sis.trs_ms:30"],
        ["-o", "sis.edition:ECODRIVE03", "-o", "synaxpk.layout:indradrive"],
    ],
    pcapng.LINKTYPE_USER0: [["-o", r'uat:user_dlts:"User 0 (DLT=147)","sis","0","","0",""']],
    pcapng.LINKTYPE_RTAC_SERIAL: [["-d", "rtacser.data,sis"]],
    228: [["-o", "synaxpd.ports:7001-7004"], ["-d", "tcp.port==4200,sis"]],
}


STATISTICS = ["-q"]
for name in (
    "sertap,tree",
    "sis,tree",
    "sis,srt",
    "rk512i,srt",
    "sisascii,srt",
    "conv,sis",
    "endpoints,sis",
):
    STATISTICS += ["-z", name]

FAULTS = (
    "runtime error",
    "AddressSanitizer",
    "Dissector bug",
    "Malformed Packet: S",
)  # S: SERTAP, SIS

SANITIZERS = {
    "LD_PRELOAD": runtime(),
    "ASAN_OPTIONS": "detect_leaks=0:exitcode=99",
    "UBSAN_OPTIONS": "print_stacktrace=1",
    "WIRESHARK_DEBUG_WMEM_OVERRIDE": "simple",
    "G_SLICE": "always-malloc",
}


# Each takes a different path.
WAYS = (["-V"], ["-2"], STATISTICS)


def dissect(tshark: Tshark, capture: Path, options: list[str]) -> str | None:
    """Dissect; return the error, or None."""
    for layers in WAYS:
        done = tshark.run(["-r", str(capture), *options, *layers], extra_environment=SANITIZERS)
        if done.returncode != 0 or any(word in done.stderr + done.stdout for word in FAULTS):
            return f"{' '.join(options + layers)}: exit {done.returncode}\n{done.stderr[-4000:]}"
    return None


def run_round(tshark: Tshark, seed: int, by_link: dict[int, list[bytes]]) -> bool:
    """One round over all link types; False, with the capture kept, if something went wrong."""
    for link_type, originals in by_link.items():
        if link_type not in OPTIONS:
            continue
        with tempfile.NamedTemporaryFile(suffix=".pcapng", delete=False) as file:
            file.write(round_capture(seed, link_type, originals, MUTANTS_PER_ROUND))
        for options in OPTIONS[link_type]:
            fault = dissect(tshark, Path(file.name), options)
            if fault is not None:
                print(f"seed {seed}, {file.name}: {fault}")
                return False
        Path(file.name).unlink()
    return True


def main() -> int:
    """Run rounds until the time or the count is used up."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=0, help="start new rounds for this time")
    parser.add_argument("--rounds", type=int, default=1, help="rounds at least (default 1)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the first round (default 1)")
    arguments = parser.parse_args()
    by_link: dict[int, list[bytes]] = {}
    for capture in sorted(HERE.rglob("*.pcapng")):
        for packet in packets(capture):
            by_link.setdefault(packet.link_type, []).append(packet.data)
    end = time.monotonic() + arguments.seconds
    rounds = 0
    try:
        with Tshark() as tshark:
            first = tshark.run(["-r", str(HERE / "specification.pcapng")], extra_environment=SANITIZERS)
            if "SIS" not in first.stdout:
                print(first.stderr[-4000:], file=sys.stderr)
                raise TsharkError("nothing is dissected: is the sanitized plugin in WIRESHARK_PLUGIN_DIR?")
            while rounds < arguments.rounds or time.monotonic() < end:
                if not run_round(tshark, arguments.seed + rounds, by_link):
                    return 1
                rounds += 1
    except TsharkError as error:
        print(f"mutate.py: {error}", file=sys.stderr)
        return 2
    mutants = rounds * len(by_link) * MUTANTS_PER_ROUND
    print(f"{rounds} rounds, {mutants} damaged packets, nothing found")
    return 0


if __name__ == "__main__":
    sys.exit(main())
