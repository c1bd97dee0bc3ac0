# SPDX-License-Identifier: GPL-2.0-or-later
"""Records all USB buses of the guest as Wireshark's usbmon interfaces do, and says what adapters are told.

usbmon.main(FILE) writes a capture (pcap, link type 220) until it gets SIGTERM, and prints a JSON object for each
request that the computer sends a device and for all that it sends through a bulk endpoint.
Layout and ioctl: Documentation/usb/usbmon.rst of Linux.
"""

from __future__ import annotations

import ctypes
import fcntl
import json
import os
import signal
import struct
import sys
from typing import BinaryIO

DEVICE = "/dev/usbmon0"  # all buses
GETX = 0x4018920A  # MON_IOCX_GETX
RING_SIZE = 0x9204  # MON_IOCT_RING_SIZE
LARGEST = 1 << 16
HEADER = struct.Struct("=QBBBBHccqiiII8s")  # the first 48 bytes of 64
CONTROL, BULK = 2, 3


def main(file: str) -> int:
    """Record until SIGTERM."""
    monitor = os.open(DEVICE, os.O_RDONLY)
    fcntl.ioctl(monitor, RING_SIZE, 1 << 20)
    header, data = ctypes.create_string_buffer(64), ctypes.create_string_buffer(LARGEST)
    argument = struct.pack("PPN", ctypes.addressof(header), ctypes.addressof(data), LARGEST)
    with open(file, "wb") as output:
        output.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 1 << 18, 220))
        output.flush()

        def end(*_: object) -> None:
            output.flush()
            os._exit(0)

        signal.signal(signal.SIGTERM, end)
        print("{}", flush=True)
        while True:
            fcntl.ioctl(monitor, GETX, argument)
            _take(output, header.raw, data.raw)


def _take(output: BinaryIO, header: bytes, data: bytes) -> None:
    fields = HEADER.unpack_from(header)
    _, kind, transfer, endpoint, device, bus, has_setup, has_data, seconds, micros, _, length, captured, setup = fields
    data = data[:captured]
    output.write(struct.pack("<IIII", seconds, micros, 64 + captured, 64 + length) + header + data)
    place = {"bus": bus, "device": device, "ns": seconds * 1_000_000_000 + micros * 1000}
    if chr(kind) != "S" or endpoint & 0x80 and transfer != CONTROL:
        return
    if transfer == CONTROL and has_setup == b"\0" and not setup[0] & 0x80:
        kind, request, value, index, _ = struct.unpack("<BBHHH", setup)
        print(json.dumps(place | {"request": [kind, request, value, index], "data": data.hex()}), flush=True)
    elif transfer == BULK and has_data == b"\0":
        print(json.dumps(place | {"sent": data.hex()}), flush=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
