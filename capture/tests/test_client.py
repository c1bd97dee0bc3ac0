# SPDX-License-Identifier: GPL-2.0-or-later
"""A master without any code of sistap, at a real terminal with stations of the virtual bus."""

from __future__ import annotations

import random
import subprocess
import sys
import termios
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from client import READ, READ_PHASE, SWITCH_PHASE, WRITE, Client, NoReaction, parameter

BUS = Path(__file__).with_name("answering_bus.py")
SPEED = 5  # times real time
TZA_MS = 1
TRS_MS = 20
TWM_S = 2  # nobody waits for it, unless this machine is so slow that a command runs into the broadcast before it

S_VELOCITY, S_SCALING, S_GAIN, S_RESET, S_MISSING = 36, 44, 100, 99, 999
P_CAM, P_TARGETS = 0x8000 | 72, 0x8000 | 4006
LIMIT = 30_000_000  # of the velocity, 0.0001 rpm
DRIVES = (3, 4)
FAR = 8  # behind 3 and 2


@contextmanager
def running(speed: float, baud: int) -> Iterator[str]:
    process = subprocess.Popen([sys.executable, str(BUS), str(speed), str(baud)], stdout=subprocess.PIPE, text=True)
    assert process.stdout
    try:
        yield process.stdout.readline().strip()
    finally:
        process.kill()
        process.communicate()


def word(value: int) -> bytes:
    return value.to_bytes(2, "little")


class Model:
    """What the master knows of a drive: what it wrote, and what the specification says about it."""

    def __init__(self, address: int) -> None:
        self.address = address
        self.route = bytes([2, FAR]) if address == FAR else b""
        self.receiver = 3 if address == FAR else address
        self.values = {S_VELOCITY: bytes(4), S_GAIN: b"\x2c\x01", S_SCALING: b"\x02\x00"}
        self.targets = b"".join(target.to_bytes(4, "little") for target in (0, 900000, 1800000, 2700000))
        self.cam = b"\x00\x00\x00\x10"
        self.phase = 4
        self.status = 0

    def header(self, number: int, element: int = 7, last: bool = True) -> bytes:
        return parameter(number, self.address, element, last)


class Master:
    """Does something at random, and checks the answer."""

    def __init__(self, client: Client, seed: int) -> None:
        self.client = client
        self.exchanges = 0
        self.random = random.Random(seed)
        self.models = [Model(address) for address in (*DRIVES, FAR)]
        self.number = 0

    def ask(self, model: Model, service: int, body: bytes, number: int | None = None) -> bytes:
        self.exchanges += 1
        return self.client.ask(service, model.receiver, body, model.route, number)

    def write(self, model: Model, number: int, data: bytes, code: int = 0) -> None:
        header = model.header(number)
        answer = self.ask(model, WRITE, header + data)
        assert answer == (b"\x01" + header[:2] + word(code) if code else b"\x00" + header[:2])

    def do_read(self, model: Model) -> None:
        number = self.random.choice([*model.values, S_MISSING])
        header = model.header(number)
        good = b"\x00" + header[:2] + model.values.get(number, b"")
        assert self.ask(model, READ, header) == (good if number in model.values else b"\x01" + header[:2] + b"\x01\x10")

    def do_write(self, model: Model) -> None:
        value = self.random.randint(-LIMIT - LIMIT // 10, LIMIT + LIMIT // 10)
        data = value.to_bytes(4, "little", signed=True)
        code = 0x7006 if value < -LIMIT else 0x7007 if value > LIMIT else 0
        self.write(model, S_VELOCITY, data, code)
        if not code:
            model.values[S_VELOCITY] = data

    def do_write_protected(self, model: Model) -> None:
        data = self.random.randbytes(2)
        self.write(model, S_SCALING, data, 0x7005 if model.phase == 4 else 0)
        if model.phase == 2:
            model.values[S_SCALING] = data

    def do_repeat(self, model: Model) -> None:
        """A command with the same number is answered again, and not executed."""
        self.number = self.number % 255 + 1
        header, values = model.header(S_GAIN), [self.random.randbytes(2) for _ in range(2)]
        for value, number in ((values[0], self.number), (values[1], None), (values[0], self.number)):
            assert self.ask(model, WRITE, header + value, number) == b"\x00" + header[:2]
        model.values[S_GAIN] = values[1]

    def do_segment(self, model: Model) -> None:
        offset = self.random.randrange(0, 22, 2)
        header = model.header(P_TARGETS)
        answer = self.ask(model, 0x11, header + word(offset) + word(4))
        missing = offset % 4 or offset >= 16
        assert answer == (
            b"\x01" + header[:2] + word(0x700F)
            if missing
            else b"\x00" + header[:2] + model.targets[offset : offset + 4]
        )
        if not missing:
            data = self.random.randbytes(4)
            assert self.ask(model, 0x1E, header + word(offset) + word(4) + data) == b"\x00" + header[:2]
            model.targets = model.targets[:offset] + data + model.targets[offset + 4 :]

    def do_cam(self, model: Model) -> None:
        """Write a long list in pieces; another length is allowed in phase 2 only."""
        elements = self.random.randbytes(4 * self.random.randint(1, 300))
        cam = word(len(elements)) + b"\x00\x10" + elements
        pieces = [cam[place : place + 234] for place in range(0, len(cam), 234)]
        cancelled = len(pieces) > 1 and self.random.random() < 0.2
        for place, piece in enumerate(pieces, 1):
            last = place == len(pieces)
            if last and cancelled:
                assert self.ask(model, 0x01, bytes([model.address])) == bytes([0, model.address])
                return
            answer = self.ask(model, WRITE, model.header(P_CAM, last=last) + piece)
            header = model.header(P_CAM)[:2]
            if last and model.phase == 4 and len(cam) != len(model.cam):
                assert answer == b"\x01" + header + word(0x700D)
                return
            assert answer in (b"\x00" + header, b"\x00" + model.header(P_CAM, last=last)[:2])  # fig. 8-37
        model.cam = cam

    def do_read_cam(self, model: Model) -> None:
        heard, header = b"", model.header(P_CAM)
        while True:
            answer = self.ask(model, READ, header)
            assert answer[0] == 0 and answer[2] == model.address
            heard += answer[3:]
            if answer[1] & 0x04:
                break
            if self.random.random() < 0.1:
                other = model.header(S_VELOCITY)
                assert self.ask(model, READ, other) == b"\xf8" + other[:2]
        assert heard == model.cam

    def do_phase(self, model: Model) -> None:
        target = 6 - model.phase
        assert self.ask(model, SWITCH_PHASE, bytes([target])) == b"\x00"
        again = self.ask(model, SWITCH_PHASE, bytes([target]))
        # Still active, or, on a slow machine, over.
        assert again == b"\x00" or (again[0], again[2:]) == (2, word(0xD005))
        while (answer := self.ask(model, READ_PHASE, b"")) != bytes([0, target]):
            assert answer in (bytes([0, model.phase]), b"\x00\x03")
        model.phase = target

    def do_read_phase(self, model: Model) -> None:
        assert self.ask(model, READ_PHASE, b"") == bytes([0, model.phase])

    def do_command(self, model: Model) -> None:
        written = self.random.choice([0, 3])
        self.write(model, S_RESET, word(written))
        header = model.header(S_RESET, element=1)
        assert self.ask(model, WRITE, header + word(S_RESET)) == b"\x00" + header[:2] + word(written)

    def do_broadcast(self, model: Model) -> None:
        """To the own level, or to all; the device address 0 is whoever hears it."""
        receiver, data = self.random.choice([254, 255]), self.random.randbytes(2)
        self.exchanges += 1
        self.client.tell(WRITE, receiver, parameter(S_GAIN, 0) + data)
        for other in self.models:
            if receiver == 255 or not other.route:
                other.values[S_GAIN] = data
        self.do_read_phase(model)  # who answers has heard what was before

    def do_identification(self, model: Model) -> None:
        assert self.ask(model, 0x00, bytes([model.address, 1])) == bytes([0, model.address, 1]) + b"01V01"
        assert self.ask(model, 0x00, bytes([model.address, 9])) == bytes([0xFB, model.address, 9])

    def do_list(self, model: Model) -> None:
        read = bytes([READ]) + model.header(S_GAIN)
        body = bytes([len(read)]) + read + bytes([1, READ_PHASE])
        good = bytes([6, READ, 0]) + read[1:3] + model.values[S_GAIN] + bytes([3, READ_PHASE, 0, model.phase])
        assert self.ask(model, 0x04, body) == b"\x00" + good

    def do_unknown(self, model: Model) -> None:
        assert self.ask(model, self.random.choice([0x05, 0x20, 0xA0, 0xF0]), self.random.randbytes(5)) == b"\xf0"


def set_times(client: Client, trs_ms: int, tza_ms: int) -> None:
    """TrS, TzA, Tmas; accepted by all."""
    for drive in DRIVES:
        for subservice, ms in ((1, trs_ms), (2, tza_ms), (3, 1000)):
            assert client.ask(0x03, drive, bytes([drive, subservice]) + word(ms)) == bytes([0, drive, subservice])
    client.tell(0x03, 255, b"\x00\xff")


@pytest.mark.parametrize("exchanges", [500, pytest.param(10_000, marks=pytest.mark.thorough)])
def test_no_answer_is_wrong(exchanges: int) -> None:
    with running(SPEED, 115200) as name:
        client = Client(name, TZA_MS / 1000 / SPEED, TRS_MS / 1000 / SPEED, TWM_S, repeats=2)
        client.set_rate(termios.B115200)
        set_times(client, TRS_MS, TZA_MS)
        master = Master(client, 1)
        weights = {"cam": 0.2, "read_cam": 0.2, "phase": 0.1, "broadcast": 0.3}
        actions = {name.removeprefix("do_"): getattr(master, name) for name in dir(master) if name.startswith("do_")}
        chosen = [weights.get(name, 1) for name in actions]
        while master.exchanges < exchanges:
            (action,) = master.random.choices(list(actions.values()), chosen)
            action(master.random.choice(master.models))
        client.close()


@pytest.mark.thorough
def test_a_rate_is_tested_told_and_heard_by_nobody_who_is_not_told() -> None:
    """In real time; fig. 6-20 and 6-24. At another rate a station hears other characters, and no telegrams."""
    with running(1, 9600) as name:
        client = Client(name, 0.02, 0.05, 0.5, repeats=0)
        client.set_rate(termios.B9600)
        set_times(client, 50, 5)
        assert client.ask(0x03, 3, b"\x03\x08" + word(1500) + b"\x08") == b"\x00\x03\x08"
        client.set_rate(termios.B115200)
        begun = time.monotonic()
        assert client.ask(READ_PHASE, 3, b"") == b"\x00\x04"
        while time.monotonic() < begun + 1.5:  # until it falls back, nobody else is heard, and then not we
            with pytest.raises(NoReaction):
                client.ask(READ_PHASE, 4, b"")
        client.set_rate(termios.B9600)
        assert client.ask(READ_PHASE, 4, b"") == b"\x00\x04"
        assert client.ask(0x03, 3, b"\x03\x07\x04") == b"\x00\x03\x07"
        assert client.ask(0x03, 4, b"\x04\x07\x04") == b"\x00\x04\x07"
        client.tell(0x03, 255, b"\x00\xff")
        client.set_rate(termios.B57600)
        assert client.ask(READ_PHASE, 4, b"") == b"\x00\x04"
        client.close()
