#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Does the work of the dissector grow faster than hostile traffic?

python3 hostile.py [--script] [SHAPE...]

Each shape is traffic that makes the dissector remember as much as possible of one kind. Its packets are dissected 5,000
and 40,000 at a time, and the processor time for each packet is compared. Work that grows with the traffic has a ratio
near 1; work that grows with its square has one near 8. --script measures sis.lua instead of the plugin.

Exit code 1 if a shape has a ratio above 2.
"""

from __future__ import annotations

import argparse
import itertools
import shutil
import struct
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

from sistap.dissected.wireshark.tshark import Tshark  # noqa: E402
from sistap.tap.files import pcapng  # noqa: E402
from sistap.tap.line.settings import Flag, LineSettings  # noqa: E402
from sistap.tap.records.record import Record, Type  # noqa: E402
from sistap.tap.sis.telegram import build  # noqa: E402

FEW, MANY = 5_000, 40_000
LIMIT = 2.0
ASKING = ["-Y", 'sis.sequence.whole_in == 0 || sis.value == "-"']  # otherwise the bodies are not dissected
START_NS = 1_700_000_000_000_000_000
STEP_NS = 20_000_000
SIS_LUA = HERE.parent.parent / "lua-fallback" / "sis.lua"

READ, WRITE, LIST_READ, FLASH = 0x10, 0x1F, 0x81, 0x97
WHOLE, PIECE = 0x3C, 0x38  # parameter control: operating data; bit 2: the last telegram


def _ident(number: int) -> bytes:
    """Return one of the possible parameters: 8 types and 65,536 numbers."""
    return struct.pack("<BH", number >> 16 & 7, number & 0xFFFF)


def _transfers() -> Iterator[bytes]:
    """Begin a long write to another parameter each time, and end none."""
    for number in itertools.count():
        yield build(WRITE, 16, 3, bytes([PIECE, number & 0xFF]) + _ident(number) + b"\x01\x02")


def _pieces() -> Iterator[bytes]:
    """Write one list in pieces of a byte, without an end."""
    for number in itertools.count():
        yield build(WRITE, 16, 3, bytes([PIECE, 3]) + _ident(36) + bytes([number & 0xFF]))
        yield build(WRITE, 16, 3, bytes([0, PIECE, 3]), reaction=True)


def _finished_pieces() -> Iterator[bytes]:
    """Write lists of 2,000 pieces, each to its end."""
    for number in itertools.count():
        control = WHOLE if number % 2000 == 1999 else PIECE
        yield build(WRITE, 16, 3, bytes([control, 3]) + _ident(36) + bytes([number & 0xFF]))
        yield build(WRITE, 16, 3, bytes([0, control, 3]), reaction=True)


def _list_pieces() -> Iterator[bytes]:
    """Read segments of a list in pieces without an end."""
    for number in itertools.count():
        command = bytes([PIECE, 3]) + _ident(36) + struct.pack("<HH", 0, 0xFFFF)
        yield build(LIST_READ, 16, 3, command)
        yield build(LIST_READ, 16, 3, bytes([0, PIECE, 3, number & 0xFF, 0]), reaction=True)


def _flash() -> Iterator[bytes]:
    """Send pieces of a firmware without a pause."""
    for number in itertools.count():
        yield build(FLASH, 16, 3, struct.pack("<II", number * 64, 64) + bytes(64))


def _routes() -> Iterator[bytes]:
    """Send commands through routers that do not forward them."""
    for number in itertools.count():
        yield build(READ, 16, 3, bytes([WHOLE, 3]) + _ident(number), subaddresses=bytes([number >> 8 & 0x7F, 7]))


def _same_route() -> Iterator[bytes]:
    """Send one command through a router again and again."""
    while True:
        yield build(READ, 16, 3, bytes([WHOLE, 3]) + _ident(44), subaddresses=bytes([4, 7]))


def _repeats() -> Iterator[bytes]:
    """Repeat one command without end."""
    while True:
        yield build(READ, 16, 3, bytes([WHOLE, 3]) + _ident(44))


def _streams() -> Iterator[bytes]:
    """Let every station speak to every other."""
    for number in itertools.count():
        yield build(READ, number & 0x7F, number >> 7 & 0x7F, bytes([WHOLE, 3]) + _ident(44))


def _marks() -> Iterator[bytes]:
    """Trigger every note of the dissector."""
    for number in itertools.count():
        yield build(0x60 + number % 32, 128 + number % 100, 200, bytes(200), subaddresses=bytes(range(7)))


def _names() -> Iterator[bytes]:
    """Send the names of more parameters than the dissector remembers."""
    for number in itertools.count():
        control = 0x14  # element 2, the name
        yield build(READ, 16, 3, bytes([control, number >> 13 & 0xFF]) + _ident(number))
        body = bytes([0, control, number >> 13 & 0xFF]) + f"Name {number}".encode()
        yield build(READ, 16, 3, body, reaction=True)


def _rates() -> Iterator[bytes]:
    """Set limits and rates at every station endlessly."""
    for number in itertools.count():
        yield build(0x03, 16, number & 0x7F, bytes([number & 0x7F, 1 + number % 3, number >> 7 & 0xFF, 0]))
        yield build(0x03, 16, number & 0x7F, bytes([0, number & 0x7F, 0xFF]), reaction=True)


def _unanswered() -> Iterator[bytes]:
    """Ask with a telegram number, without any answer."""
    for number in itertools.count():
        yield build(READ, 16, 3, bytes([WHOLE, 3]) + _ident(number), number=number & 0xFF)


SHAPES: dict[str, Callable[[], Iterator[bytes]]] = {
    function.__name__.strip("_").replace("_", "-"): function
    for function in (
        _transfers,
        _pieces,
        _finished_pieces,
        _list_pieces,
        _flash,
        _routes,
        _same_route,
        _repeats,
        _streams,
        _marks,
        _names,
        _rates,
        _unanswered,
    )
}


def write_capture(file: Path, telegrams: Iterator[bytes], count: int) -> None:
    """Write the first telegrams as records."""
    settings = LineSettings(115200, 8, "E", 2)
    with file.open("wb") as out:
        out.write(pcapng.section_header("hostile.py", ""))
        out.write(pcapng.interface_description(pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, "hostile")))
        for number, telegram in enumerate(itertools.islice(telegrams, count)):
            intervals = [STEP_NS] + [settings.character_ns] * (len(telegram) - 1)
            flags = bytes([0 if number else Flag.INTERVAL_UNKNOWN]) + bytes(len(telegram) - 1)
            time_ns = START_NS + number * STEP_NS
            record = Record(time_ns, Type.FRAME, 0, settings, telegram, intervals, flags, 100_000)
            out.write(pcapng.enhanced_packet(0, time_ns, pcapng.upper_pdu("sertap", record.pack())))


def growth(tshark: Tshark, folder: Path, shape: str) -> tuple[float, float, float]:
    """Return the times in s for FEW and MANY packets, and the ratio of the cost of a packet."""
    times = []
    for count in (1, FEW, MANY):
        file = folder / f"{shape}-{count}.pcapng"
        write_capture(file, SHAPES[shape](), count)
        times.append(tshark.usage(["-r", str(file), "-2", *ASKING]).seconds)
        file.unlink()
    start, few, many = times
    return few, many, (many - start) / MANY / max((few - start) / FEW, 1e-9)


def main() -> int:
    """Measure the shapes; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("shapes", metavar="SHAPE", nargs="*", help=f"of {', '.join(SHAPES)} (default: all)")
    parser.add_argument("--script", action="store_true", help="measure sis.lua instead of the plugin")
    args = parser.parse_args()
    if unknown := set(args.shapes) - set(SHAPES):
        parser.error(f"no shape {', '.join(sorted(unknown))}; the shapes are {', '.join(SHAPES)}")
    worst = 0.0
    print(f"{'shape':16} {FEW:>9,} {MANY:>9,}   a packet among {MANY:,} costs")
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        folder = Path(name)
        folder.chmod(0o755)  # as root, tshark runs as nobody
        plugins = None
        if args.script:
            plugins = folder / "script"
            plugins.mkdir()
            shutil.copy(SIS_LUA, plugins)
        tshark = stack.enter_context(Tshark(plugins=plugins) if plugins else Tshark())
        for shape in args.shapes or SHAPES:
            few, many, ratio = growth(tshark, folder, shape)
            worst = max(worst, ratio)
            print(f"{shape:16} {few:8.2f}s {many:8.2f}s   {ratio:.2f} times as much", flush=True)
    return int(worst > LIMIT)


if __name__ == "__main__":
    sys.exit(main())
