#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Dissects damaged copies of every capture, with the plugin under AddressSanitizer and UndefinedBehaviorSanitizer.

    python3 mutate.py --seconds 60            as long as that, each round with another seed
    python3 mutate.py --rounds 1 --seed 7     one round again

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

from sistap import pcapng  # noqa: E402
from sistap.tshark import Tshark, TsharkError  # noqa: E402

MUTANTS_PER_ROUND = 4000
INTERESTING = (0x00, 0x01, 0x02, 0x07, 0x08, 0x0F, 0x10, 0x7F, 0x80, 0xF0, 0xFE, 0xFF)


def packets(capture: Path) -> Iterator[tuple[int, bytes]]:
    """Give link type and data of every packet of one of our pcapng files."""
    data, offset, link_type = capture.read_bytes(), 0, 0
    while offset < len(data):
        kind, length = struct.unpack_from("<II", data, offset)
        if kind == pcapng.INTERFACE_DESCRIPTION:
            (link_type,) = struct.unpack_from("<H", data, offset + 8)
        elif kind == pcapng.ENHANCED_PACKET:
            (size,) = struct.unpack_from("<I", data, offset + 20)
            yield link_type, data[offset + 28 : offset + 28 + size]
        offset += length


def protected(link_type: int, data: bytes) -> int:
    """How many bytes at the start stay whole: those that lead to our dissectors."""
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


def round_capture(seed: int, link_type: int, originals: list[bytes], count: int = MUTANTS_PER_ROUND) -> bytes:
    """Make one capture of mutants."""
    chance = random.Random(seed)
    blocks = [
        pcapng.section_header("mutate.py", ""),
        pcapng.interface_description(pcapng.Interface(link_type, "m")),
    ]
    for number in range(count):
        data = chance.choice(originals)
        keep = protected(link_type, data)
        blocks.append(pcapng.enhanced_packet(0, number * 1_000_000, mutant(chance, data[:keep], data[keep:])))
    return b"".join(blocks)


def runtime() -> str:
    """Find the sanitizer's runtime of the compiler that built the plugin (gcc)."""
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


OPTIONS = {
    pcapng.LINKTYPE_WIRESHARK_UPPER_PDU: [
        ["-o", "sis.tza_ms:3", "-o", "sis.trs_ms:30"],
        ["-o", "sis.edition:ECODRIVE03"],
    ],
    pcapng.LINKTYPE_USER0: [["-o", "sis.dlt_user:user0"]],
    pcapng.LINKTYPE_RTAC_SERIAL: [["-d", "rtacser.data,sis"]],
    228: [[], ["-d", "tcp.port==4200,sis"]],
}


STATISTICS = ["-q"]
for name in (
    "sertap,tree",
    "sis,tree",
    "sis,tza",
    "sis,bus",
    "sis,srt",
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


def dissect(tshark: Tshark, capture: Path, options: list[str]) -> str | None:
    """Dissect in all the ways that take another path; give what went wrong, or None."""
    for layers in (
        ["-V"],
        ["-2"],
        STATISTICS,
    ):
        done = tshark.run(["-r", str(capture), *options, *layers], extra_environment=SANITIZERS)
        if done.returncode != 0 or any(word in done.stderr + done.stdout for word in FAULTS):
            return f"{' '.join(options + layers)}: exit {done.returncode}\n{done.stderr[-4000:]}"
    return None


def run_round(tshark: Tshark, seed: int, by_link: dict[int, list[bytes]]) -> bool:
    """One round over all link types; False, with the capture kept, if something went wrong."""
    for link_type, originals in by_link.items():
        with tempfile.NamedTemporaryFile(suffix=".pcapng", delete=False) as file:
            file.write(round_capture(seed, link_type, originals))
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
    parser.add_argument("--seconds", type=float, default=0, help="start new rounds for so long")
    parser.add_argument("--rounds", type=int, default=1, help="rounds at least (default 1)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the first round (default 1)")
    arguments = parser.parse_args()
    by_link: dict[int, list[bytes]] = {}
    for capture in sorted(HERE.rglob("*.pcapng")):
        for link_type, data in packets(capture):
            by_link.setdefault(link_type, []).append(data)
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
    print(f"{rounds} rounds, {rounds * MUTANTS_PER_ROUND * len(by_link)} damaged packets, nothing found")
    return 0


if __name__ == "__main__":
    sys.exit(main())
