#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""How exact are the times of other public tools that capture a serial line, compared with `sistap capture`?

python3 others.py --mstpcap bacnet-stack/bin/mstpcap --modbus-sniffer modbus-sniffer/sniffer [--seconds 60]

One writer plays BACnet MS/TP frames at 115200 Bd, with a pause before each, through a pseudo terminal for each tool.
mstpcap is part of the project bacnet-stack (`make mstpcap`), the sniffer is the project modbus-sniffer of alerighi
(`make`); both are on GitHub. They run with the priority that sistap gives itself. README.md explains the table.
"""

from __future__ import annotations

import argparse
import functools
import itertools
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

from crc import crc  # noqa: E402
from playing import (  # noqa: E402
    PATIENCE_S,
    SETTINGS,
    Broken,
    Character,
    Program,
    play,
    start_sistap,
    stop_sistap,
    terminals,
)
from quantiles import QUANTILES, quantiles  # noqa: E402
from recorded import Packet, pcap_packets, sistap_packets  # noqa: E402

from sistap.tap.line import priority  # noqa: E402

PAUSE_NS = 5_000_000  # before each frame
SILENCE_US = 1500  # ends a frame for tools that cut by silence: the sniffer's default

# ANSI/ASHRAE 135, clause 9 and annex G: preamble, type, destination, source, length, check; data and their check.
_PREAMBLE = b"\x55\xff"
_TOKEN, _TEST_REQUEST = 0, 3
_HEADER_CHECK = 0x81, 0xFF  # X^8 + X^7 + 1; start
_DATA_CHECK = 0x8408, 0xFFFF  # X^16 + X^12 + X^5 + 1; start


class Tool(NamedTuple):
    """A program that listens, and how to read its file."""

    name: str
    program: Program
    packets: Callable[[], Iterable[Packet]]


class Matched(NamedTuple):
    """What a tool captured of the stream; errors of a packet's time against its first and last character, in ns."""

    name: str
    packets: int
    lost: int  # characters
    times: int
    first_ns: list[int]
    last_ns: list[int]
    share: float  # of a core


def mstp_frame(kind: int, destination: int, source: int, data: bytes = b"") -> bytes:
    """Return an MS/TP frame."""
    header = struct.pack(">BBBH", kind, destination, source, len(data))
    header += struct.pack("<B", ~crc(header, *_HEADER_CHECK) & 0xFF)
    return _PREAMBLE + header + (data + struct.pack("<H", ~crc(data, *_DATA_CHECK) & 0xFFFF) if data else b"")


def frames() -> Iterator[bytes]:
    """Yield frames endlessly, of 8 to 60 characters: tokens, and numbered test requests, so that none repeats."""
    for number in itertools.count():
        yield mstp_frame(_TOKEN, 4, 3)
        yield mstp_frame(_TEST_REQUEST, 3, 4, struct.pack(">I", number) * (1 + number % 12))


def stream(seconds: float) -> list[Character]:
    """Return as many frames as fit into the time."""
    characters, left_ns = list[Character](), int(seconds * 1e9)
    for frame in frames():
        pauses_ns = [PAUSE_NS] + [SETTINGS.character_ns] * (len(frame) - 1)
        left_ns -= sum(pauses_ns)
        if left_ns < 0:
            break
        characters += map(Character, frame, pauses_ns)
    return characters


def sistap_tool(folder: Path, port: str) -> Tool:
    """Start sistap."""
    file = folder / "sistap.tap.files.pcapng"
    program, _ = start_sistap(file, [port], "--framing", f"silence:{SILENCE_US / 1000}")
    return Tool("sistap", program, lambda: sistap_packets(file))


def mstpcap_tool(path: Path, folder: Path, port: str) -> Tool:
    """Start mstpcap, which writes a file with its own name into the working folder."""
    program = start([str(path), port, str(SETTINGS.baud)], folder)
    file = written(program, folder, "mstp_*.cap")
    return Tool("mstpcap", program, lambda: pcap_packets(file))


def sniffer_tool(path: Path, folder: Path, port: str) -> Tool:
    """Start modbus-sniffer with no parity, because a pseudo terminal has none."""
    line = ["-s", str(SETTINGS.baud), "-P", "N", "-t", str(SILENCE_US), "-l"]
    program = start([str(path), "-p", port, *line, "-o", "sniffer.pcap"], folder)
    file = written(program, folder, "sniffer.pcap")
    return Tool("modbus-sniffer", program, lambda: pcap_packets(file))


def start(command: list[str], folder: Path) -> Program:
    """Start a program with the priority of sistap."""
    with priority.real_time():
        return subprocess.Popen(command, cwd=folder, text=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def written(program: Program, folder: Path, pattern: str) -> Path:
    """Wait for the file of a program: it appears when the port is open, the only sign."""
    end_s = time.monotonic() + PATIENCE_S
    while not (files := list(folder.glob(pattern))):
        if program.poll() is not None or time.monotonic() > end_s:
            program.kill()
            raise Broken(f"{program.args!r} does not listen: run it by hand to see why")
        time.sleep(0.01)
    return files[0]


def measure(folder: Path, seconds: float, mstpcap_path: Path, sniffer_path: Path) -> list[Matched]:
    """Play to all tools at the same time and measure."""
    characters = stream(seconds)
    starters: tuple[Callable[[Path, str], Tool], ...] = (
        functools.partial(mstpcap_tool, mstpcap_path),
        functools.partial(sniffer_tool, sniffer_path),
        sistap_tool,
    )
    with terminals(len(starters)) as ends, ExitStack() as killed:
        tools = list[Tool]()
        for starter, end in zip(starters, ends, strict=True):
            tools.append(starter(folder, end.path))
            killed.callback(tools[-1].program.kill)  # mstpcap would loop endlessly after its terminal closes
        played = play(folder, characters, ends, [tool.program for tool in tools])
        for tool in tools[:-1]:
            tool.program.terminate()
            tool.program.wait(PATIENCE_S)
        stop_sistap(tools[-1].program)
    data = bytes(character.value for character in characters)
    print(f"{len(data)} characters in {played.elapsed_s:.1f} s\n")
    return [
        match(tool, data, instants_ns, share)
        for tool, instants_ns, share in zip(tools, played.instants_ns, played.shares, strict=True)
    ]


def match(tool: Tool, data: bytes, instants_ns: list[int], share: float) -> Matched:
    """Find each packet of a tool in what was played."""
    at = packets = found = times = 0
    first_ns, last_ns = list[int](), list[int]()
    for packet in tool.packets():
        packets += 1
        start_at = data.find(packet.data, at)
        if start_at >= 0 and instants_ns[start_at] <= packet.times_ns[-1]:  # otherwise it is not what was played there
            at = start_at + len(packet.data)
            found += len(packet.data)
            times += len(packet.times_ns)
            first_ns.append(packet.times_ns[0] - instants_ns[start_at])
            last_ns.append(packet.times_ns[-1] - instants_ns[at - 1])
    if not found:
        raise Broken(f"{tool.name} has captured nothing of what was played")
    return Matched(tool.name, packets, len(data) - found, times, first_ns, last_ns, share)


def report(tools: list[Matched]) -> None:
    """Print the table."""
    row("", [tool.name for tool in tools])
    row("characters lost", [f"{tool.lost}" for tool in tools])
    row("packets", [f"{tool.packets}" for tool in tools])
    row("times a packet", [f"{tool.times / len(tool.first_ns):.1f}" for tool in tools])
    row("share of core", [f"{tool.share:.1%}" for tool in tools])
    for title, errors in (
        ("first character: late by, us", [tool.first_ns for tool in tools]),
        ("last character: late by, us", [tool.last_ns for tool in tools]),
    ):
        print(f"\n{title}")
        of_tools = [quantiles(of_tool) for of_tool in errors]
        for name in QUANTILES:
            row(name, [f"{of_tool[name] / 1e3:.1f}" for of_tool in of_tools])


def row(name: str, figures: list[str]) -> None:
    """Print a line of the table."""
    print(f"{name:<16}" + "".join(f"{figure:>16}" for figure in figures))


def main() -> int:
    """Measure once."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mstpcap", type=Path, required=True, metavar="PATH", help="the program of bacnet-stack")
    parser.add_argument("--modbus-sniffer", type=Path, required=True, metavar="PATH", help="the program `sniffer`")
    parser.add_argument("--seconds", type=float, default=60, help="how long to play (default 60)")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="sistap-benchmark-") as folder:
        try:
            paths = arguments.mstpcap.resolve(), arguments.modbus_sniffer.resolve()
            report(measure(Path(folder), arguments.seconds, *paths))
        except (Broken, OSError, subprocess.SubprocessError) as error:
            print(f"others.py: {error}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
