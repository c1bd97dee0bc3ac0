# SPDX-License-Identifier: GPL-2.0-or-later
"""A FT232R in software, plugged into the guest's own vhci_hcd (USB/IP over a pair of sockets), for ftdi_sio.

It gathers characters as the chip does: a packet goes when 62 characters are there, or when the latency timer is over.
Line errors are bits in the status of a whole packet, as in the chip: which character they belong to, nobody can tell.

Input, a JSON object a line:
  {"play": [[character, error bits], ...]}  come in at once, with "pace" one after the other in so many seconds each
  {"loop": true}                            what is sent comes back
  {"idle": true}                            a packet without characters whenever the timer is over, as the chip does
Output: {} when it is plugged in, {"played": total} when the computer has taken all, {"sent": hex} for what it sent.
"""

from __future__ import annotations

import asyncio
import json
import os
import socket
import struct
import sys
from collections import deque
from contextlib import suppress
from pathlib import Path

ATTACH = Path("/sys/devices/platform/vhci_hcd.0/attach")
FULL_SPEED = 2
FULL = 62  # characters of a packet, beside two bytes of status
MODEM_STATUS, LINE_STATUS = 0x01, 0x60
STALL, RESET = -32, -104  # EPIPE, ECONNRESET

# USB 2.0, chapter 9: device, configuration with one interface of two bulk endpoints, strings.
DEVICE = struct.pack("<BBHBBBBHHHBBBB", 18, 1, 0x0200, 0, 0, 0, 8, 0x0403, 0x6001, 0x0600, 1, 2, 3, 1)
CONFIGURATION = bytes.fromhex("09022000010100a02d 0904000002ffffff02 07058102400000 07050202400000")
SERIALS = ("A6008isP", "A6008isQ")

# Linux: drivers/usb/usbip/usbip_common.h.
SUBMIT, UNLINK = 1, 2
SUBMITTED, UNLINKED = 3, 4


class Chip:
    """The adapter, with a coroutine for each of its ends."""

    def __init__(self, number: int) -> None:
        """Create the first (0) or the second adapter."""
        self._strings = ["", "FTDI", "FT232R USB UART", SERIALS[number]]
        self._latency_s = 0.016
        self._received: deque[tuple[int, int, bool]] = deque()  # characters, errors, and whether they were played
        self._asked: deque[int] = deque()  # numbers of the computer's requests for characters
        self._something = asyncio.Event()
        self._loop = self._idle = False
        self._played = 0
        self._to_computer: asyncio.StreamWriter | None = None

    async def run(self, number: int) -> None:
        """Plug it in, and work until the computer releases it."""
        ours, theirs = socket.socketpair()
        from_computer, self._to_computer = await asyncio.open_connection(sock=ours)
        ATTACH.write_text(f"{number} {theirs.fileno()} {0x10002 + number} {FULL_SPEED}")
        theirs.close()
        says = asyncio.StreamReader()
        await asyncio.get_running_loop().connect_read_pipe(lambda: asyncio.StreamReaderProtocol(says), sys.stdin)
        _tell({})
        ends = [self._pour(), self._obey(says)]
        tasks = [asyncio.create_task(end) for end in ends]
        with suppress(asyncio.IncompleteReadError, ConnectionError):
            await self._serve(from_computer)
        for task in tasks:
            task.cancel()

    async def _serve(self, computer: asyncio.StreamReader) -> None:
        """Answer the requests of the host controller."""
        while True:
            head = await computer.readexactly(48)
            command, number, _, inbound, endpoint = struct.unpack_from(">5I", head)
            if command == UNLINK:
                (meant,) = struct.unpack_from(">I", head, 20)
                was_there = meant in self._asked
                if was_there:
                    self._asked.remove(meant)
                self._answer(UNLINKED, number, RESET if was_there else 0)
                continue
            (length,) = struct.unpack_from(">i", head, 24)
            data = b"" if inbound or not length else await computer.readexactly(length)
            if endpoint == 0:
                status, reply = self._control(*struct.unpack_from("<BBHHH", head, 40))
                self._answer(SUBMITTED, number, status, reply, len(reply) if inbound else len(data))
            elif inbound:
                self._asked.append(number)
                self._something.set()
            else:
                self._answer(SUBMITTED, number, 0, b"", len(data))
                self._send(data)

    def _control(self, kind: int, request: int, value: int, _: int, length: int) -> tuple[int, bytes]:
        """Return status and data of a control request."""
        if (kind, request) == (0x40, 9):
            self._latency_s = (value & 0xFF) / 1000
        if (kind, request) == (0x80, 6):
            found = {1: DEVICE, 2: CONFIGURATION}.get(value >> 8)
            if value >> 8 == 3:
                found = self._string(value & 0xFF)
            return (0, found[:length]) if found else (STALL, b"")
        answers = {(0x80, 0): b"\0\0", (0xC0, 5): b"\x31\x60", (0xC0, 0x90): b"\xff\xff"}
        answers[0xC0, 10] = bytes([round(self._latency_s * 1000)])
        return 0, answers.get((kind, request), b"")[:length]

    def _string(self, number: int) -> bytes:
        text = self._strings[number].encode("utf-16-le") if number else b"\x09\x04"
        return bytes([len(text) + 2, 3]) + text

    def _send(self, data: bytes) -> None:
        _tell({"sent": data.hex()})
        if self._loop:
            self._received += ((value, 0, False) for value in data)
            self._something.set()

    async def _pour(self) -> None:
        """Send the computer what came, a packet at a time; the timer restarts with each."""
        now = asyncio.get_running_loop().time
        last = now()
        while True:
            while not self._asked or not (self._received or self._idle):
                self._something.clear()
                await self._something.wait()
            while len(self._received) < FULL and (left := last + self._latency_s - now()) > 0:
                self._something.clear()
                with suppress(asyncio.TimeoutError):
                    await asyncio.wait_for(self._something.wait(), left)
            if not self._asked:
                continue
            part = [self._received.popleft() for _ in range(min(FULL, len(self._received)))]
            status = LINE_STATUS
            for _, error, _ in part:
                status |= error
            last = now()
            packet = bytes([MODEM_STATUS, status, *(value for value, _, _ in part)])
            self._answer(SUBMITTED, self._asked.popleft(), 0, packet, len(packet))
            self._played += sum(was_played for _, _, was_played in part)
            if part and not self._received:
                _tell({"played": self._played})

    async def _obey(self, says: asyncio.StreamReader) -> None:
        while line := await says.readline():
            message = json.loads(line)
            self._loop = message.get("loop", self._loop)
            self._idle = message.get("idle", self._idle)
            pace_s = message.get("pace", 0)
            due = asyncio.get_running_loop().time()
            for value, error in message.get("play", ()):
                if pace_s:
                    due += pace_s
                    await asyncio.sleep(due - asyncio.get_running_loop().time())
                self._received.append((value, error, True))
                if pace_s:
                    self._something.set()
            self._something.set()

    def _answer(self, kind: int, number: int, status: int, data: bytes = b"", length: int = 0) -> None:
        assert self._to_computer
        head = struct.pack(">5I", kind, number, 0, 0, 0) + struct.pack(">5i8x", status, length, 0, 0, 0)
        self._to_computer.write(head + data)


def _tell(message: dict[str, object]) -> None:
    print(json.dumps(message), flush=True)


def main(number: str) -> int:
    """Run an adapter until it is unplugged or this ends."""
    os.environ.pop("PYTHONASYNCIODEBUG", None)
    asyncio.run(Chip(int(number)).run(int(number)))
    return 0
