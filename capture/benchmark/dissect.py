#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""What does a telegram cost in tshark, compared with a Modbus RTU frame of the same size?

python3 dissect.py [--count 200000] [--rounds 3]

The cost of a record is the increase: the instructions (or the time) for many of them minus those for few, divided by
the difference of their numbers. The goals are ratios of instructions, which hold on a busy machine. For times, the two
protocols take turns, and the best of the rounds counts. README.md says more. Exit code 1 if something broke; a missed
goal is only reported.
"""

from __future__ import annotations

import argparse
import itertools
import struct
import sys
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

from instructions import FEW, MANY, Instructions  # noqa: E402
from telegrams import telegrams  # noqa: E402

from sistap.dissected.wireshark.tshark import Tshark, TsharkError, Used  # noqa: E402
from sistap.tap.files import pcapng  # noqa: E402
from sistap.tap.line.settings import Flag, LineSettings  # noqa: E402
from sistap.tap.records.record import Record, Type  # noqa: E402

SETTINGS = LineSettings(115200, 8, "E", 2)
START_NS = 1_700_000_000_000_000_000
SILENCE_NS = 2_000_000  # before each telegram
UNCERTAINTY_NS = 100_000
GOALS = {"list": 1.0, "-Y FILTER": 1.0, "-T fields": 2.2, "-V": 1.9}  # times the instructions of Modbus RTU
GOAL_MEMORY = 1.6

# The options of tshark, and the share of the packets that is enough to time a slow way.
MODES: dict[str, tuple[list[str], int]] = {
    "list": ([], 1),
    "-Y FILTER": (["-Y", "frame.number == 0"], 1),
    "-T fields": (["-T", "fields", "-e", "frame.number"], 4),
    "-V": (["-V"], 10),
}


class Protocol(NamedTuple):
    """One side of the comparison."""

    name: str
    link_type: int
    packet: Callable[[int, bytes, int], bytes]  # arguments: number, telegram, time in ns
    options: list[str]
    layers: str  # as Wireshark lists them for every packet


def sis_packet(number: int, telegram: bytes, time_ns: int) -> bytes:
    """Return the record of a telegram without a pause."""
    intervals = [SILENCE_NS] + [SETTINGS.character_ns] * (len(telegram) - 1)
    flags = bytes([Flag.INTERVAL_UNKNOWN if number == 0 else 0]) + bytes(len(telegram) - 1)
    record = Record(time_ns, Type.FRAME, 0, SETTINGS, telegram, intervals, flags, UNCERTAINTY_NS)
    return pcapng.upper_pdu("sertap", record.pack())


def modbus_packet(number: int, telegram: bytes, time_ns: int) -> bytes:
    """Return a Modbus RTU frame as long as the telegram, after the header of LINKTYPE_RTAC_SERIAL."""
    seconds, rest = divmod(time_ns, 1_000_000_000)
    header = struct.pack(">IIBBH", seconds, rest // 1000, 1 + number % 2, 0, 0)  # sent and received take turns
    receiver = telegram[7:8]  # 3 and 4 take turns, so every response has its query a few frames before
    frame = receiver + modbus_body(number, len(telegram) - 3)
    return header + frame + struct.pack("<H", crc(frame))


def crc(data: bytes) -> int:
    """Return the check of a Modbus RTU frame."""
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0xA001 if value & 1 else 0)
    return value


def modbus_body(number: int, size: int) -> bytes:
    """Return function and data: read registers (query, response), write registers (query), or diagnostics."""
    registers = bytes((number + i) & 0xFF for i in range(size))
    if size == 5:
        return struct.pack(">BHH", 3, number % 1000, 7)
    if size % 2:
        return struct.pack(">BH", 8, 0) + registers[3:]
    if number % 2 or size == 6:
        return struct.pack(">BB", 3, size - 2) + registers[2:]
    return struct.pack(">BHHB", 16, number % 1000, (size - 6) // 2, size - 6) + registers[6:]


PROTOCOLS = [
    Protocol("SIS", pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, sis_packet, [], "exported_pdu:sertap:sis"),
    Protocol(
        "Modbus RTU",
        pcapng.LINKTYPE_RTAC_SERIAL,
        modbus_packet,
        ["-d", "rtacser.data,mbrtu"],
        "rtacser:mbrtu:modbus",
    ),
]


def write_capture(file: Path, protocol: Protocol, count: int) -> None:
    """Write that many packets."""
    time_ns = START_NS
    with file.open("wb") as out:
        out.write(pcapng.section_header("dissect.py", ""))
        out.write(pcapng.interface_description(pcapng.Interface(protocol.link_type, protocol.name)))
        for number, telegram in enumerate(itertools.islice(telegrams(), count)):
            out.write(pcapng.enhanced_packet(0, time_ns, protocol.packet(number, telegram, time_ns)))
            time_ns += SILENCE_NS + (len(telegram) - 1) * SETTINGS.character_ns


class Benchmark:
    """Captures of each protocol, the tshark that reads them, and one that counts its instructions."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        """Make captures in `folder` when they are needed."""
        self._folder = folder
        self._instructions = Instructions(folder)
        self._tshark = stack.enter_context(Tshark())
        self._counting = stack.enter_context(Tshark(str(self._instructions.tshark)))

    def capture(self, protocol: Protocol, count: int) -> str:
        """Return the path of a capture with that many packets."""
        file = self._folder / f"{protocol.link_type}-{count}.pcapng"
        if not file.exists():
            write_capture(file, protocol, count)
        return str(file)

    def check(self, protocol: Protocol) -> None:
        """Raise TsharkError unless the right dissectors decode every packet without a problem."""
        fields = ["-T", "fields", "-e", "frame.protocols", "-e", "_ws.expert"]
        said = self._tshark.output("-r", self.capture(protocol, 1000), *protocol.options, *fields)
        if set(said.splitlines()) != {f"{protocol.layers}\t"}:
            raise TsharkError(f"{protocol.name} is not decoded; is WIRESHARK_PLUGIN_DIR a folder with the plugin?")

    def instructions(self, mode: str) -> list[float]:
        """Return the instructions that a packet adds, for each protocol."""
        options, _ = MODES[mode]
        return [
            (self._counted(protocol, MANY, options) - self._counted(protocol, FEW, options)) / (MANY - FEW)
            for protocol in PROTOCOLS
        ]

    def cost_us(self, mode: str, count: int, rounds: int) -> list[float]:
        """Return the time that a packet adds, in us, for each protocol."""
        options, part = MODES[mode]
        many, one = max(count // part, 2), 1
        best_s = {(protocol.name, number): float("inf") for protocol in PROTOCOLS for number in (many, one)}
        for _ in range(rounds):
            for protocol, number in itertools.product(PROTOCOLS, (many, one)):
                used = self._usage(self._tshark, protocol, number, options)
                key = protocol.name, number
                best_s[key] = min(best_s[key], used.seconds)
        return [
            (best_s[protocol.name, many] - best_s[protocol.name, one]) / (many - one) * 1e6 for protocol in PROTOCOLS
        ]

    def memory(self, count: int) -> list[float]:
        """Return the bytes of memory that a packet adds to tshark, for each protocol, from half of the packets to
        all.
        """
        sizes = [
            [self._usage(self._tshark, protocol, number, []).kilobytes for number in (count // 2, count)]
            for protocol in PROTOCOLS
        ]
        return [(many - half) * 1024 / (count - count // 2) for half, many in sizes]

    def _counted(self, protocol: Protocol, number: int, options: list[str]) -> int:
        self._usage(self._counting, protocol, number, options)
        return self._instructions.taken().total()

    def _usage(self, tshark: Tshark, protocol: Protocol, number: int, options: list[str]) -> Used:
        return tshark.usage(["-r", self.capture(protocol, number), *protocol.options, *options])


def head(unit: str) -> None:
    """Print the head of a table."""
    print(f"\n{unit:<24}" + "".join(f"{protocol.name:>12}" for protocol in PROTOCOLS) + f"{'ratio':>8}")


def row(name: str, figures: list[float], decimals: int, goal: float | None = None) -> None:
    """Print a line of the table."""
    ours, theirs = figures
    met = "" if goal is None else f"  goal {goal}: {'met' if ours <= goal * theirs else 'NOT MET'}"
    print(f"{name:<24}{ours:>12,.{decimals}f}{theirs:>12,.{decimals}f}{ours / theirs:>8.2f}{met}", flush=True)


def compare(benchmark: Benchmark, count: int, rounds: int) -> None:
    """Measure and print the tables."""
    head("instructions a packet")
    for mode in MODES:
        row(mode, benchmark.instructions(mode), 0, GOALS[mode])
    head("us a packet")
    for mode in MODES:
        row(mode, benchmark.cost_us(mode, count, rounds), 2)
    head("bytes a packet")
    for packets in (count, 5 * count):  # equal if memory grows in proportion to their number
        row(f"of {packets:,}", benchmark.memory(packets), 0, GOAL_MEMORY)


def main() -> int:
    """Measure once."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200_000, help="packets of each protocol (default 200000)")
    parser.add_argument("--rounds", type=int, default=3, help="how often each time is measured (default 3)")
    arguments = parser.parse_args()
    try:
        with tempfile.TemporaryDirectory(prefix="sistap-benchmark-") as folder, ExitStack() as stack:
            benchmark = Benchmark(Path(folder), stack)
            for protocol in PROTOCOLS:
                benchmark.check(protocol)
            compare(benchmark, arguments.count, arguments.rounds)
    except (TsharkError, OSError) as error:
        print(f"dissect.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
