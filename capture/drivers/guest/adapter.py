# SPDX-License-Identifier: GPL-2.0-or-later
"""A USB serial adapter in software, plugged into the guest's own vhci_hcd (USB/IP over a pair of sockets).

adapter.main(CHIP, NUMBER, SERIAL): a chip of chips.py. It gathers characters as the chip does: a packet goes when it is
full, or when the latency timer is over.

Input, a JSON object a line:
  {"play": [[character, line status], ...]}  come in together, with "pace" one after the other in so many seconds each
  {"loop": true}                             what is sent comes back
  {"idle": true}                             a packet without characters whenever the timer is over, as an FT232R does
  {"sticky": true}                           of an FT232R: the packet after a break reports the break, too
Output: {} when it is plugged in, {"played": total} when the computer has taken all, {"sent": hex} for what it sent,
{"told": {...}, "ns": time} for what it set: baud, format, dtr, rts.
"""

from __future__ import annotations

import asyncio
import json
import os
import socket
import struct
import sys
import time
from collections import defaultdict, deque
from contextlib import suppress
from pathlib import Path

from chips import CHIPS, Character, Chip, together

ATTACH = Path("/sys/devices/platform/vhci_hcd.0/attach")
FULL_SPEED = 2
BULK_IN, INTERRUPT_IN = 1, 2
PRIORITY = 2  # before a capture with real-time priority; drivers wait no longer than 100 ms for an answer
STALL, RESET = -32, -104  # EPIPE, ECONNRESET

# Linux: drivers/usb/usbip/usbip_common.h.
SUBMIT, UNLINK = 1, 2
SUBMITTED, UNLINKED = 3, 4


class Adapter:
    """The adapter, with a coroutine for each of its ends."""

    def __init__(self, chip: type[Chip], serial: str) -> None:
        """Create one."""
        self._chip = chip(_told)
        self._strings = ["", "Maker", chip.product, serial]
        self._received: deque[tuple[Character, bool]] = deque()  # characters, and whether they were played
        self._asked: defaultdict[int, deque[int]] = defaultdict(deque)  # requests of the computer, by endpoint
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
        _say({})
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
                self._unlink(number, *struct.unpack_from(">I", head, 20))
                continue
            (length,) = struct.unpack_from(">i", head, 24)
            data = b"" if inbound or not length else await computer.readexactly(length)
            if endpoint == 0:
                kind, request, value, index, most = struct.unpack_from("<BBHHH", head, 40)
                answer = self._control(kind, request, value, index, data)
                answer = answer and answer[:most]
                reply = b"" if answer is None or not inbound else answer
                self._answer(number, STALL if answer is None else 0, reply, len(reply) if inbound else len(data))
            elif inbound:
                self._asked[endpoint].append(number)
                self._something.set()
            else:
                self._answer(number, 0, b"", len(data))
                self._send(data)

    def _unlink(self, number: int, meant: int) -> None:
        queue = next((queue for queue in self._asked.values() if meant in queue), None)
        if queue is not None:
            queue.remove(meant)
        self._answer(number, RESET if queue is not None else 0, b"", 0, UNLINKED)

    def _control(self, kind: int, request: int, value: int, index: int, data: bytes) -> bytes | None:
        """Return the answer to a control request; None: a stall."""
        if kind & 0x60:  # not one of USB itself
            return self._chip.control(kind, request, value, index, data)
        if (kind, request) == (0x80, 6):
            found = dict(zip((1, 2), self._chip.descriptors, strict=True))
            return self._string(value & 0xFF) if value >> 8 == 3 else found.get(value >> 8)
        return b"\0\0" if (kind, request) == (0x80, 0) else b""

    def _string(self, number: int) -> bytes:
        text = self._strings[number].encode("utf-16-le") if number else b"\x09\x04"
        return bytes([len(text) + 2, 3]) + text

    def _send(self, data: bytes) -> None:
        _say({"sent": data.hex()})
        if self._loop:
            self._received += (((value, 0), False) for value in data)
            self._something.set()

    async def _pour(self) -> None:
        """Send the computer what came, a packet at a time; the timer restarts with each."""
        now = asyncio.get_running_loop().time
        last = now()
        while True:
            while not (self._received or self._idle) or not self._may_send():
                self._something.clear()
                await self._something.wait()
            while not self._is_full() and (left := last + self._chip.latency_s - now()) > 0:
                self._something.clear()
                with suppress(asyncio.TimeoutError):
                    await asyncio.wait_for(self._something.wait(), left)
            if self._may_send():
                last = now()
                self._send_packet()

    def _may_send(self) -> bool:
        return bool(self._asked[BULK_IN]) and (bool(self._asked[INTERRUPT_IN]) or not self._chip.notifies)

    def _next(self) -> int:
        """Return how many of the waiting characters go into the next packet."""
        room = self._chip.full - self._chip.head
        for count, ((_, status), _) in enumerate(self._received):
            room -= self._chip.room(status)
            if room < 0 or (count and self._chip.stands_alone(status)):
                return count
            if self._chip.stands_alone(status):
                return 1
            if self._chip.closes(status):
                return count + 1
        return len(self._received)

    def _is_full(self) -> bool:
        return self._next() < len(self._received)

    def _send_packet(self) -> None:
        taken = [self._received.popleft() for _ in range(self._next())]
        part = [character for character, _ in taken]
        status = together(part)
        if status and self._chip.notifies:
            self._answer_next(INTERRUPT_IN, self._chip.notice(status))
        packet = self._chip.packet(part)
        if packet:
            self._answer_next(BULK_IN, packet)
        self._played += sum(was_played for _, was_played in taken)
        if taken and not self._received:
            _say({"played": self._played})

    async def _obey(self, says: asyncio.StreamReader) -> None:
        while line := await says.readline():
            message = json.loads(line)
            self._loop = message.get("loop", self._loop)
            self._idle = message.get("idle", self._idle)
            self._chip.sticky = message.get("sticky", self._chip.sticky)
            pace_s = message.get("pace", 0)
            due = asyncio.get_running_loop().time()
            for value, status in message.get("play", ()):
                if pace_s:
                    due += pace_s
                    await asyncio.sleep(due - asyncio.get_running_loop().time())
                self._received.append(((value, status), True))
                if pace_s:
                    self._something.set()
            self._something.set()

    def _answer_next(self, endpoint: int, data: bytes) -> None:
        """Answer the oldest request at an endpoint."""
        self._answer(self._asked[endpoint].popleft(), 0, data, len(data))

    def _answer(self, number: int, status: int, data: bytes, length: int, kind: int = SUBMITTED) -> None:
        assert self._to_computer
        head = struct.pack(">5I", kind, number, 0, 0, 0) + struct.pack(">5i8x", status, length, 0, 0, 0)
        self._to_computer.write(head + data)


def _say(message: dict[str, object]) -> None:
    print(json.dumps(message), flush=True)


def _told(**settings: object) -> None:
    _say({"told": settings, "ns": time.monotonic_ns()})


def main(chip: str, number: str, serial: str) -> int:
    """Run an adapter until it is unplugged or this ends."""
    os.environ.pop("PYTHONASYNCIODEBUG", None)
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    asyncio.run(Adapter(CHIPS[chip], serial).run(int(number)))
    return 0
