# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes USB captures in the guest for the tests of `sistap import`: usbmon, both directions, with what was sent.

record.py FOLDER puts them into tests/real-captures/, and the true contents into truth.json there. FOLDER has the guest.
"""

from __future__ import annotations

import json
import lzma
import signal
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

CAPTURE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(CAPTURE))

from machine import Guest, Program, accelerator, eventually  # noqa: E402
from truth import BREAK, FRAMING, LOST, PARITY  # noqa: E402

from drivers import Cdc, Line, QemuFtdi, Software, Usb  # noqa: E402

PLACE = CAPTURE / "tests/real-captures"
RECORDED = "/tmp/usbmon.pcap"
READ = bytes.fromhex("02 71 05 05 00 10 10 03 3c 00 24 00 00")  # a telegram, and ...
ANSWERED = bytes.fromhex("02 50 08 08 10 10 03 10 00 3c 00 24 00 e8 03 00")  # ... what may come back
EVERY_VALUE = bytes(range(256))
CLEAN = [(ANSWERED, 0)] * 20 + [(EVERY_VALUE[start : start + 32], 0) for start in range(0, 256, 32)]
DAMAGED = [
    *CLEAN,
    *[(ANSWERED, PARITY), (ANSWERED, 0), (ANSWERED, FRAMING), (b"\x55", PARITY), (ANSWERED, LOST)],
    *[(b"\0", BREAK | FRAMING), (ANSWERED, 0)],
]


class Recording(NamedTuple):
    """A recording to make: packets of characters with their errors."""

    name: str
    adapter: Callable[[], Usb]
    baud: int
    format: str
    packets: list[tuple[bytes, int]]


RECORDINGS = (
    Recording("usbmon-ftdi-38400-8n1", QemuFtdi, 38400, "8N1", CLEAN),
    Recording("usbmon-ft232r-115200-8e1", partial(Software, "ftdi_sio, FT232R", "ft232r"), 115200, "8E1", DAMAGED),
    Recording("usbmon-cdc-115200-8n1", Cdc, 115200, "8N1", CLEAN),
)


def recorded(folder: Path, runs_on: str, wanted: Recording) -> tuple[bytes, dict[str, Any]]:
    """Return the capture, and what went over the line."""
    adapter = wanted.adapter()
    guest = Guest(folder, runs_on, adapter.devices)
    try:
        usbmon = guest.start("usbmon", RECORDED)
        usbmon.until("{}")
        adapter.start(guest)
        line: Line = adapter.lines[0]
        if isinstance(adapter, Software):
            adapter.lines[0].say(idle=True)
        terminal = guest.start("terminal", line.port, str(wanted.baud), wanted.format)
        terminal.until("{}")
        received = sent = b""
        for data, errors in wanted.packets:
            terminal.say(READ.hex())
            sent += READ
            _await(lambda: len(line.sent), len(sent))
            line.play(data, errors)
            received += data
            _await(lambda: _count(terminal), len(received))
        assert line.sent == sent
        usbmon.signal(signal.SIGTERM)
        usbmon.wait()
        packets = [[len(data), errors] for data, errors in wanted.packets]
        return guest.read(RECORDED), {"received": received.hex(), "sent": sent.hex(), "packets": packets}
    finally:
        guest.kill()


def _await(counted: Callable[[], int], count: int) -> None:
    eventually(lambda: counted() >= count, lambda: f"{counted()} of {count} characters came")


def _count(terminal: Program) -> int:
    told = [json.loads(line) for line in terminal.look().splitlines()]
    return sum(len(one["received"]) // 2 for one in told if "received" in one)


def main() -> int:
    """Record them all."""
    folder = Path(sys.argv[1])
    runs_on = accelerator(folder)
    file = PLACE / "truth.json.xz"
    truth = json.loads(lzma.decompress(file.read_bytes()))
    for wanted in RECORDINGS:
        content, truth[wanted.name] = recorded(folder, runs_on, wanted)
        (PLACE / f"{wanted.name}.pcap.xz").write_bytes(lzma.compress(content, preset=9))
        print(f"{wanted.name}: {len(content)} bytes", flush=True)
    file.write_bytes(lzma.compress(json.dumps(truth).encode(), preset=9))
    return 0


if __name__ == "__main__":
    sys.exit(main())
