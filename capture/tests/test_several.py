# SPDX-License-Identifier: GPL-2.0-or-later
"""Two ports as the two directions of one line."""

from __future__ import annotations

import fcntl
import os
import pty
import signal
import socket
import subprocess
import sys
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import cast

import pytest
from independent import blocks, packets
from pcapng.blocks import InterfaceDescription, InterfaceStatistics
from specification import TELEGRAMS

from sistap.tap.line.reader import PortLost, Reader, device, latency, open_reader, several, together
from sistap.tap.line.reader.several import PolledReaders, ThreadedReaders
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.record import Event, Type

# python-pcapng warns of itself.
pytestmark = [
    pytest.mark.tap,
    pytest.mark.filterwarnings("ignore:Field type should not be:DeprecationWarning"),
]

SETTINGS = LineSettings(115200)
LATENCY = 300_000  # as if measured, ns
PATIENCE_S = 60  # never waited for unless something is broken
INBOUND, OUTBOUND = 1, 2  # of epb_flags
COMMAND, REACTION = TELEGRAMS["6-14"], TELEGRAMS["8-21"]


class Line:
    """A pseudo terminal: the test talks at its master side."""

    def __init__(self) -> None:
        self.master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)

    def say(self, data: bytes) -> None:
        assert os.write(self.master, data) == len(data)

    def unplug(self) -> None:
        for descriptor in (self.master, self._slave):
            if descriptor >= 0:
                os.close(descriptor)
        self.master = self._slave = -1


@pytest.fixture
def lines() -> Iterator[tuple[Line, Line]]:
    pair = Line(), Line()
    yield pair
    for line in pair:
        line.unplug()


# -- Readers --------------------------------------------------------------------------------------------------------


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., list[Reader]]]:
    monkeypatch.setattr(latency, "measured_ns", lambda: LATENCY)
    monkeypatch.setattr(device, "Computer", lambda _: None)  # it would measure on
    readers: list[Reader] = []

    def open_both(*ports: str) -> list[Reader]:
        readers.extend(open_reader(port, SETTINGS, line) for line, port in enumerate(ports, start=1))
        return readers

    yield open_both
    for reader in readers:
        reader.close()


def collect(source: several.Source, count: int) -> list[Read]:
    reads: list[Read] = []
    end = time.monotonic() + PATIENCE_S
    while sum(len(read.data) for read in reads) < count and time.monotonic() < end:
        if read := source.read(0.1):
            reads.append(read)
    return reads


def test_characters_come_from_both_with_their_line(
    lines: tuple[Line, Line], opened: Callable[..., list[Reader]]
) -> None:
    with together(opened(lines[0].port, lines[1].port)) as source:
        assert isinstance(source, PolledReaders)
        for i in range(50):
            line = i % 2
            lines[line].say(bytes([i]))
            (read,) = collect(source, 1)
            assert (read.line, read.data) == (line + 1, bytes([i]))
        assert source.read(0) is None


class SteppedTime:
    """Replaces the monotonic clock: as late as the test demands."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = time.monotonic_ns()
        for module in (device, several):
            monkeypatch.setattr(module, "monotonic_ns", lambda: self.now)


def waiting(line: Line) -> int:
    """Return how many characters nobody has read yet."""
    return int.from_bytes(fcntl.ioctl(line._slave, termios.FIONREAD, bytes(4)), sys.byteorder)


def wait_for(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.001)  # neither a file nor a terminal's buffer can be waited for


def test_what_came_while_the_other_line_was_dealt_with_says_so(
    lines: tuple[Line, Line], opened: Callable[..., list[Reader]], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = SteppedTime(monkeypatch)
    with together(opened(lines[0].port, lines[1].port)) as source:
        assert isinstance(source, PolledReaders)
        real = source._poll

        class Passing:
            """Time passes while nothing comes."""

            def poll(self, step_ms: int) -> list[tuple[int, int]]:
                if not (ready := real.poll(step_ms)):
                    clock.now += step_ms * 1_000_000
                return ready

        monkeypatch.setattr(source, "_poll", Passing())
        assert source.read(0.01) is None  # both lines are silent for 10 ms
        clock.now += 2_000_000
        lines[0].say(b"A")
        wait_for(lambda: bool(waiting(lines[0])))
        (read,) = collect(source, 1)
        assert (read.line, read.uncertainty_ns) == (1, LATENCY + 2_000_000)
        clock.now += 3_000_000  # that long A was dealt with
        lines[1].say(b"B")
        wait_for(lambda: bool(waiting(lines[1])))
        (read,) = collect(source, 1)
        assert (read.line, read.uncertainty_ns) == (2, LATENCY + 5_000_000)  # since the sleep before A


def test_waiting_is_not_being_late(
    lines: tuple[Line, Line], opened: Callable[..., list[Reader]], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = SteppedTime(monkeypatch)
    with together(opened(lines[0].port, lines[1].port)) as source:
        assert isinstance(source, PolledReaders)
        real = source._poll

        class Announced:
            """Nothing is there at first; it comes during the wait, after 8 ms."""

            def poll(self, step_ms: float) -> list[tuple[int, int]]:
                if step_ms and not clock_moved:
                    clock_moved.append(True)
                    clock.now += 8_000_000
                    lines[1].say(b"B")
                return real.poll(step_ms and PATIENCE_S * 1000)

        clock_moved: list[bool] = []
        monkeypatch.setattr(source, "_poll", Announced())
        read = source.read(PATIENCE_S)
        assert read is not None
        assert (read.line, read.data, read.uncertainty_ns) == (2, b"B", LATENCY)
        clock.now += 1_000_000  # that long B was dealt with; line 1 was silent until then
        lines[0].say(b"A")
        wait_for(lambda: bool(waiting(lines[0])))
        (read,) = collect(source, 1)
        assert (read.line, read.uncertainty_ns) == (1, LATENCY + 1_000_000)


def test_the_loss_of_one_is_told_once_and_the_other_goes_on(
    lines: tuple[Line, Line], opened: Callable[..., list[Reader]]
) -> None:
    with together(opened(lines[0].port, lines[1].port)) as source:
        lines[0].unplug()
        with pytest.raises(PortLost, match="other end has ended") as lost:
            source.read(PATIENCE_S)
        assert lost.value.line == 1
        lines[1].say(b"still here")
        assert b"".join(read.data for read in collect(source, 10)) == b"still here"
        lines[1].unplug()
        with pytest.raises(PortLost) as lost:
            source.read(PATIENCE_S)
        assert lost.value.line == 2


def test_ports_that_cannot_be_polled_get_a_thread_each(opened: Callable[..., list[Reader]]) -> None:
    listeners = [socket.create_server(("127.0.0.1", 0)) for _ in range(2)]
    readers = opened(*(f"socket://127.0.0.1:{listener.getsockname()[1]}" for listener in listeners))
    connections = [listener.accept()[0] for listener in listeners]
    before = set(threading.enumerate())
    with together(readers) as source:
        assert isinstance(source, ThreadedReaders)
        for i in range(10):
            connections[i % 2].sendall(bytes([i]))
            (read,) = collect(source, 1)
            assert (read.line, read.data) == (1 + i % 2, bytes([i]))
        connections[1].close()
        with pytest.raises(PortLost) as lost:
            while True:
                source.read(PATIENCE_S)
        assert lost.value.line == 2
        connections[0].sendall(b"x")
        (read,) = collect(source, 1)
        assert (read.line, read.data) == (1, b"x")
        assert source.read(0) is None
    assert set(threading.enumerate()) <= before
    for each in (*listeners, *connections):
        each.close()


class Flooding:
    """A port that never pauses."""

    line, timing = 0, "nothing known"

    def __init__(self, data: bytes) -> None:
        self._read = Read(0, 1, data, bytes(len(data)))
        self.taken = 0

    def read(self, timeout_s: float) -> Read:
        self.taken += 1
        return self._read

    def memory(self) -> int:
        return self.taken * (sys.getsizeof(self._read) + 2 * len(self._read.data))


@pytest.mark.parametrize("size", [0, 60_000])
@pytest.mark.attack("a port that is waited for floods", "it has to wait: memory stays below 100 MB")
def test_a_port_that_floods_has_to_wait(size: int) -> None:
    reader = Flooding(bytes(size))
    with together([cast(Reader, reader)], may_change=True) as source:
        before = -1
        while reader.taken != before and reader.memory() < 100_000_000:
            before = reader.taken
            time.sleep(0.5)  # nobody takes what it has read
        assert reader.memory() < 100_000_000
        for _ in range(reader.taken + 10):  # then it goes on
            assert source.read(PATIENCE_S) is not None


# -- As people run it -----------------------------------------------------------------------------------------------


class Captured:
    """`sistap capture` on two ports."""

    def __init__(self, *arguments: str) -> None:
        command = [sys.executable, "-m", "sistap", "capture", *arguments]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.said = ""

    def wait_until_it_listens(self) -> None:
        assert self.process.stderr
        self.said = self.process.stderr.readline() + self.process.stderr.readline()
        assert "capturing on line 2: " in self.said

    def stop(self) -> tuple[int, str, str]:
        self.process.send_signal(signal.SIGTERM)
        return self.end()

    def end(self) -> tuple[int, str, str]:
        out, err = self.process.communicate(timeout=PATIENCE_S * 3)
        return self.process.returncode, out, self.said + err


@pytest.fixture
def capture(lines: tuple[Line, Line]) -> Iterator[Callable[..., Captured]]:
    started: list[Captured] = []

    def start(*arguments: str) -> Captured:
        started.append(Captured("-i", lines[0].port, "-i", lines[1].port, *arguments))
        started[-1].wait_until_it_listens()
        return started[-1]

    yield start
    for captured in started:
        captured.process.kill()
        captured.process.communicate()


def test_one_file_two_interfaces_two_directions(
    lines: tuple[Line, Line], capture: Callable[..., Captured], tmp_path: Path
) -> None:
    path = tmp_path / "x.pcapng"
    captured = capture("-w", str(path))
    for i in range(3):
        lines[0].say(COMMAND)
        wait_for(lambda done=2 + 2 * i + 1: len(packets(path)) == done)  # type: ignore[misc]
        lines[1].say(REACTION)
        wait_for(lambda done=2 + 2 * i + 2: len(packets(path)) == done)  # type: ignore[misc]
    code, _, err = captured.stop()
    assert code == 0
    assert f"capturing on line 1: {lines[0].port} (pseudo terminal)" in err
    first_blocks = blocks(path)[1:3]
    assert all(isinstance(block, InterfaceDescription) for block in first_blocks)
    assert [block.options["if_name"] for block in first_blocks] == [lines[0].port, lines[1].port]
    found = packets(path)
    assert [(record.line, record.event) for record, _, _ in found[:2]] == [
        (1, Event.CAPTURE_STARTED),
        (2, Event.CAPTURE_STARTED),
    ]
    assert [(r.line, r.data, interface, flags) for r, interface, flags in found[2:]] == [
        (1, COMMAND, 0, INBOUND),
        (2, REACTION, 1, OUTBOUND),
    ] * 3
    times = [record.time_ns for record, _, _ in found]
    assert times == sorted(times)
    statistics = [block for block in blocks(path) if isinstance(block, InterfaceStatistics)]
    assert [(block.interface_id, block.options["isb_ifrecv"]) for block in statistics] == [(0, 3), (1, 3)]


def test_each_file_of_a_ring_has_both_interfaces(
    lines: tuple[Line, Line], capture: Callable[..., Captured], tmp_path: Path
) -> None:
    captured = capture("-w", str(tmp_path / "x"), "-b", "filesize:1", "-c", "30")
    lines[1].say(REACTION * 30)  # only line 2 speaks
    code, _, _ = captured.end()
    assert code == 0
    files = sorted(tmp_path.iterdir())
    assert len(files) > 1
    for file in files:
        described = [block for block in blocks(file) if isinstance(block, InterfaceDescription)]
        assert [block.options["if_name"] for block in described] == [lines[0].port, lines[1].port]
        assert [record.line for record, _, _ in packets(file)[:2]] == [1, 2]
        assert {interface for _, interface, _ in packets(file)[2:]} == {1}
    assert sum(record.type == Type.FRAME for file in files for record, _, _ in packets(file)) == 30


def test_text_says_which_line(lines: tuple[Line, Line], capture: Callable[..., Captured]) -> None:
    captured = capture("-c", "2")
    lines[0].say(COMMAND)
    assert captured.process.stdout
    first = captured.process.stdout.readline()
    lines[1].say(REACTION)
    code, rest, _ = captured.end()
    assert code == 0
    assert first.split()[2:] == ["RX", *COMMAND.hex(" ").upper().split()]
    assert "  TX  02 " in rest


def test_what_began_first_is_written_first(
    lines: tuple[Line, Line], capture: Callable[..., Captured], tmp_path: Path
) -> None:
    path = tmp_path / "x.pcapng"
    captured = capture("-w", str(path), "-c", "2")
    lines[0].say(COMMAND[:4])
    wait_for(lambda: not waiting(lines[0]))
    lines[1].say(REACTION)
    wait_for(lambda: not waiting(lines[1]))
    lines[0].say(COMMAND[4:])
    assert captured.end()[0] == 0
    assert [record.data for record, _, _ in packets(path)[2:]] == [COMMAND, REACTION]


def test_both_lines_follow_what_is_told_on_one(
    lines: tuple[Line, Line], capture: Callable[..., Captured], tmp_path: Path
) -> None:
    path = tmp_path / "x.pcapng"
    captured = capture("-w", str(path), "--follow-baud")
    lines[1].say(b"x")
    # All shall have 57600 Bd (checksum by hand), and accept it.
    lines[0].say(bytes.fromhex("02 DB 03 03 00 03 10 FF 00 07 04") + TELEGRAMS["6-24"])
    wait_for(lambda: all(termios.tcgetattr(line.master)[4] == termios.B57600 for line in lines))
    lines[1].say(REACTION)
    wait_for(lambda: packets(path)[-1][0].data == REACTION)
    code, _, err = captured.stop()
    assert code == 0
    assert "sistap: line 2: 57600 Bd 8E1: 16 let all accept 57600 Bd\n" in err
    second = [record for record, _, _ in packets(path) if record.line == 2]
    assert [(record.type, record.settings.baud) for record in second] == [
        (Type.EVENT, 9600),
        (Type.OTHER, 9600),
        (Type.EVENT, 57600),
        (Type.FRAME, 57600),
    ]


def test_one_port_is_lost_and_the_other_goes_on(
    lines: tuple[Line, Line], capture: Callable[..., Captured], tmp_path: Path
) -> None:
    path = tmp_path / "x.pcapng"
    captured = capture("-w", str(path))
    lines[0].say(COMMAND[:3])
    wait_for(lambda: path.stat().st_size > 0)
    lines[0].unplug()
    wait_for(lambda: packets(path)[-1][0].event == Event.ADAPTER_LOST)
    lines[1].say(REACTION)
    wait_for(lambda: packets(path)[-1][0].type == Type.FRAME)
    code, _, err = captured.stop()
    assert code == 1
    assert f"sistap: line 1: {lines[0].port}: the program at its other end has ended" in err
    assert "; the other line goes on\n" in err
    found = packets(path)[2:]
    assert [(record.line, record.type) for record, _, _ in found if record.type != Type.OTHER] == [
        (1, Type.EVENT),
        (2, Type.FRAME),
    ]


def test_both_ports_lost_end_it(lines: tuple[Line, Line], capture: Callable[..., Captured], tmp_path: Path) -> None:
    path = tmp_path / "x.pcapng"
    captured = capture("-w", str(path))
    for line in lines:
        line.unplug()
    code, _, err = captured.end()
    assert code == 1
    assert "line 1: " in err and "line 2: " in err and err.count("goes on") == 1
    assert sorted(record.line for record, _, _ in packets(path)[2:]) == [1, 2]


def test_the_second_port_does_not_open(lines: tuple[Line, Line], tmp_path: Path) -> None:
    missing = str(tmp_path / "ttyUSB9")
    captured = Captured("-i", lines[0].port, "-i", missing, "-w", str(tmp_path / "x"))
    code, _, err = captured.end()
    assert (code, err.count("\n")) == (3, 1)
    assert f"{missing} does not exist" in err
    assert list(tmp_path.iterdir()) == []


def test_one_port_for_both_directions_is_refused(lines: tuple[Line, Line], tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(lines[0].port)
    for again in (lines[0].port, str(tmp_path / "link")):
        code, _, err = Captured("-i", lines[0].port, "-i", again).end()
        assert (code, err.count("\n")) == (2, 1)
        assert f"{again} is the same port again" in err
