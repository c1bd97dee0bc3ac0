# SPDX-License-Identifier: GPL-2.0-or-later
"""The readers: their output is what arrived, with errors at their characters and times that are bounds."""

import errno
import fcntl
import os
import pty
import select
import socket
import struct
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import serial
from hypothesis import given
from hypothesis import strategies as st
from portable import descriptors
from real_driver import Driver

from sistap.tap.line import ports
from sistap.tap.line.clock import STEADY
from sistap.tap.line.reader import (
    PortError,
    PortLost,
    Reader,
    computer,
    delay,
    device,
    latency,
    open_reader,
    opening,
    several,
)
from sistap.tap.line.reader.contract import READ_SIZE
from sistap.tap.line.reader.device import MarkDecoder, PosixReader
from sistap.tap.line.reader.tuning import Tuning
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag, LineSettings, Read
from sistap.tap.wire import protocol

pytestmark = pytest.mark.tap

SETTINGS = LineSettings(115200)
LATENCY = 300_000  # as if measured, ns
TCGETS2 = 0x802C542A  # Linux: <asm-generic/ioctls.h>
START_NS = 1_700_000_000_000_000_000
PATIENCE_S = 60  # never waited for unless something is broken


@pytest.fixture(autouse=True)
def measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(latency, "measured_ns", lambda: LATENCY)
    monkeypatch.setattr(device, "Computer", lambda _: None)  # it would measure on


class Pty:
    """A pseudo terminal: the test is the bus at its master side."""

    def __init__(self) -> None:
        self.master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)

    def write(self, data: bytes) -> None:
        assert os.write(self.master, data) == len(data)

    def hang_up(self) -> None:
        for descriptor in (self.master, self._slave):
            if descriptor >= 0:
                os.close(descriptor)
        self.master = self._slave = -1


@pytest.fixture
def bus() -> Iterator[Pty]:
    terminal = Pty()
    yield terminal
    terminal.hang_up()


def collect(source: Reader, count: int) -> list[Read]:
    """Read until that many characters have come."""
    reads: list[Read] = []
    end = time.monotonic() + PATIENCE_S
    while sum(len(read.data) for read in reads) < count and time.monotonic() < end:
        if read := source.read(0.1):
            assert len(read.flags) == len(read.data)
            reads.append(read)
    return reads


def joined(reads: list[Read]) -> bytes:
    return b"".join(read.data for read in reads)


# -- The marks of PARMRK, termios(3) ----------------------------------------------------------------------------------

OK, BAD, BREAK = 0, int(Flag.CHARACTER_ERROR), int(Flag.BREAK)

characters = st.one_of(
    st.tuples(st.integers(0, 255), st.just(OK)),
    st.just((0xFF, OK)),
    st.tuples(st.integers(1, 255), st.just(BAD)),  # a damaged 00 cannot be told from a break
    st.just((0xFF, BAD)),
    st.just((0, BREAK)),
)


def marked(value: int, flag: int) -> bytes:
    """What a terminal with PARMRK delivers for one character."""
    if flag:
        return bytes([0xFF, 0x00, value])
    return b"\xff\xff" if value == 0xFF else bytes([value])


@given(st.lists(characters), st.lists(st.integers(0, 200)))
def test_marks_decode_the_same_wherever_reads_cut_them(line: list[tuple[int, int]], cuts: list[int]) -> None:
    stream = b"".join(marked(value, flag) for value, flag in line)
    places = sorted({0, len(stream), *(cut for cut in cuts if cut < len(stream))})
    decoder = MarkDecoder()
    values, flags = b"", b""
    for start, end in zip(places, places[1:], strict=False):
        more_values, more_flags = decoder.feed(stream[start:end])
        assert len(more_values) == len(more_flags)
        values += more_values
        flags += more_flags
    assert list(zip(values, flags, strict=True)) == line
    assert decoder.pending == b""


def test_ff_that_no_terminal_sends_is_kept() -> None:
    assert MarkDecoder().feed(b"\xffA\xff\xff") == (b"\xffA\xff", b"\0\0\0")


# -- Through a pseudo terminal ----------------------------------------------------------------------------------------


def test_every_value_at_once_and_one_by_one(bus: Pty) -> None:
    everything = bytes(range(256))
    source = open_reader(bus.port, SETTINGS)
    bus.write(everything)
    assert joined(collect(source, 256)) == everything
    for value in everything:
        bus.write(bytes([value]))
        (read,) = collect(source, 1)
        assert read.data == bytes([value])
    source.close()


def test_what_is_written_before_is_not_delivered_and_nothing_is_echoed(bus: Pty) -> None:
    bus.write(b"old")
    source = open_reader(bus.port, SETTINGS)
    bus.write(b"new\xff\r\n\x03\x11")
    assert joined(collect(source, 8)) == b"new\xff\r\n\x03\x11"
    os.set_blocking(bus.master, False)
    with pytest.raises(BlockingIOError):
        os.read(bus.master, 100)
    source.close()


def test_marks_from_the_terminal_keep_their_values_when_data_is_more_than_one_read(bus: Pty) -> None:
    # Doubled FF fill the buffer of the line discipline (4096) at an odd place, so that a read cuts a mark.
    data = b"A" + b"\xff" * 6000
    source = open_reader(bus.port, SETTINGS)
    writer = threading.Thread(target=bus.write, args=(data,))
    writer.start()
    reads = collect(source, len(data))
    writer.join()
    assert joined(reads) == data
    assert not any(any(read.flags) for read in reads)
    source.close()


def test_time_is_that_of_the_wall_clock_and_bounded(bus: Pty) -> None:
    source = open_reader(bus.port, SETTINGS, line=2)
    before = time.time_ns()
    bus.write(b"A")
    (read,) = collect(source, 1)
    after = time.time_ns()
    assert before - 2_000_000 <= read.time_ns <= after + 2_000_000  # the clock may be slewing
    assert read.line == 2
    source.close()


def test_nothing_came(bus: Pty) -> None:
    source = open_reader(bus.port, SETTINGS)
    assert source.read(0) is None
    source.close()


def test_descriptions(bus: Pty) -> None:
    source = open_reader(bus.port, SETTINGS)
    assert source.name == bus.port
    assert source.adapter == "pseudo terminal"
    assert source.timing == "uncertainty 0.30 ms, measured when the capture started and ever since; ordinary priority"
    assert source.settings == SETTINGS  # 8E1, although a pty is 8N1
    source.close()


def test_a_pty_that_was_set_up_with_parity_before(bus: Pty) -> None:
    serial.Serial(bus.port, 9600, parity="E").close()
    with pytest.raises(termios.error):  # Linux strips PARENB: asked for nothing else, libc says EINVAL
        serial.Serial(bus.port, 9600, parity="E")
    source = open_reader(bus.port, LineSettings(9600, 8, "E", 2))
    assert source.settings.format == "8E1"
    source.close()


def test_format_of_a_real_port(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = Driver(monkeypatch).asked
    open_reader(bus.port, LineSettings(9600, 7, "O", 4)).close()
    control = asked[0][2]
    assert control & termios.CSIZE == termios.CS7
    assert control & termios.PARENB
    assert control & termios.PARODD
    assert control & termios.CSTOPB
    assert not control & termios.CRTSCTS
    assert not asked[-1][0] & (termios.IXON | termios.IXOFF | termios.IGNPAR | termios.IGNBRK | termios.BRKINT)
    assert asked[-1][0] & termios.INPCK


@pytest.mark.parametrize(("text", "size"), [("8M1", None), ("8S1", None), ("5N1.5", None), ("6E1", termios.CS6)])
def test_formats_that_a_driver_takes(bus: Pty, monkeypatch: pytest.MonkeyPatch, text: str, size: int | None) -> None:
    Driver(monkeypatch, size)
    source = open_reader(bus.port, LineSettings.parse(9600, text))
    assert source.settings.format == text
    source.close()


def test_a_format_that_a_driver_quietly_does_not_take(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    """Like ftdi_sio: asked for six data bits it keeps its setting, and reports that only in the kernel's log."""
    Driver(monkeypatch, termios.CS8)
    cannot = f"{bus.port} cannot do 9600 Bd 6E1 (its driver sets 9600 Bd 8E1): choose another --baud or --format"
    assert refused(bus.port, LineSettings.parse(9600, "6E1")) == cannot
    source = open_reader(bus.port, LineSettings.parse(9600, "8N1"))
    with pytest.raises(PortError) as caught:
        source.change(LineSettings.parse(9600, "6E1"))
    assert str(caught.value) == cannot
    assert source.settings.format == "8N1"
    source.close()


@pytest.fixture
def uart(bus: Pty, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The bus's port as a 16550A with its usual clock; its driver reports the requested rate."""
    kind = tmp_path / "class/tty" / Path(bus.port).name / "type"
    kind.parent.mkdir(parents=True)
    kind.write_text("4\n")
    monkeypatch.setattr(ports, "SYSFS", tmp_path)
    real = fcntl.ioctl

    def ioctl(fd: int, request: int, *rest: object) -> object:
        if request == termios.TIOCGSERIAL:  # <linux/serial.h>: type first, baud_base the eighth
            return struct.pack("8i", 4, 0, 0, 0, 0, 16, 0, 115_200) + bytes(96)
        return real(fd, request, *rest)  # type: ignore[call-overload]

    monkeypatch.setattr(fcntl, "ioctl", ioctl)


@pytest.mark.parametrize(("baud", "true"), [(76_800, 57_600), (12_000, 11_520), (187_500, 115_200)])
def test_a_rate_that_a_16550_really_has_not(bus: Pty, uart: None, baud: int, true: int) -> None:
    assert refused(bus.port, LineSettings(baud)) == (
        f"{bus.port} cannot do {baud} Bd 8E1 (its driver sets {true} Bd 8E1): choose another --baud or --format"
    )


@pytest.mark.parametrize(
    ("baud", "said"), [(10_400, "; the port really runs at 10473 Bd; "), (38_400, ""), (300, ""), (115_200, "")]
)
def test_the_true_rate_of_a_16550_is_told(bus: Pty, uart: None, baud: int, said: str) -> None:
    source = open_reader(bus.port, LineSettings(baud))
    assert ("the port really runs at" in source.timing) is bool(said)
    assert said in source.timing
    assert source.settings.baud == baud
    source.close()


def test_characters_that_another_program_took_are_no_loss_of_the_port(
    bus: Pty, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = open_reader(bus.port, SETTINGS)
    polls(source, lambda timeout_ms: [(descriptor(source), select.POLLIN)])  # there was something
    assert source.read(0.05) is None
    source.close()


def descriptor(source: Reader) -> int:
    assert isinstance(source, several.Pollable)
    return source.fileno()


def polls(source: Reader, poll: Callable[[float], list[tuple[int, int]]]) -> None:
    """Let a reader of a device poll with this."""
    alone = several.PolledReaders([source])  # type: ignore[list-item]
    alone._poll = SimpleNamespace(poll=poll)  # type: ignore[assignment]
    source._alone = alone  # type: ignore[attr-defined]


class SteppedTime:
    """Replaces the monotonic clock: as late as the test demands."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = time.monotonic_ns()
        for module in (device, several):
            monkeypatch.setattr(module, "monotonic_ns", lambda: self.now)


def test_a_reader_that_is_late_says_so(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = SteppedTime(monkeypatch)
    source = open_reader(bus.port, SETTINGS)
    bus.write(b"A")
    collect(source, 1)
    bus.write(b"B")
    wait_until_readable(bus.port)
    clock.now += 7_000_000  # 7 ms since the last read: B may have come at any moment of them
    (read,) = collect(source, 1)
    assert read.data == b"B"
    assert read.uncertainty_ns == LATENCY + 7_000_000
    clock.now += 5_000_000_000
    bus.write(b"C")
    wait_until_readable(bus.port)
    (read,) = collect(source, 1)
    assert read.uncertainty_ns == UNCERTAINTY_UNKNOWN  # more than 32 bits of ns
    source.close()


class Asleep:
    """Replaces poll: nothing is there at once; while the process sleeps, time passes and something comes."""

    def __init__(self, source: Reader, clock: SteppedTime, monkeypatch: pytest.MonkeyPatch) -> None:
        self.sleep_ns = 0
        self._clock = clock
        self._source = source
        polls(source, self._poll)

    def _poll(self, timeout_ms: float) -> list[tuple[int, int]]:
        if not timeout_ms:
            return []
        self._clock.now += self.sleep_ns
        return [(descriptor(self._source), select.POLLIN)]


def test_a_busy_process_keeps_the_kernel_from_passing_characters_on(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    """At real-time priority on one processor: a worker of the kernel moves them from the driver to the terminal."""
    clock = SteppedTime(monkeypatch)
    source = open_reader(bus.port, SETTINGS)
    asleep = Asleep(source, clock, monkeypatch)
    for busy_ns, sleep_ns, uncertainty_ns in (
        (0, 1_000_000, LATENCY),
        (2_000_000, 20_000, LATENCY + 2_020_000),  # passed on as soon as this process slept
        (2_000_000, LATENCY, LATENCY),  # the worker had the time to pass on what had come before
    ):
        clock.now += busy_ns
        asleep.sleep_ns = sleep_ns
        bus.write(b"A")
        wait_until_readable(bus.port)
        read = source.read(PATIENCE_S)
        assert read and read.uncertainty_ns == uncertainty_ns
    monkeypatch.undo()
    source.close()


def test_what_comes_without_a_sleep_may_have_come_before_the_last_read(
    bus: Pty, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The kernel has passed something on since that read: then, or just now."""
    clock = SteppedTime(monkeypatch)
    source = open_reader(bus.port, SETTINGS)
    for since_ns in (3_000_000, 6_000_000, 6_000_000):  # since the opening, then since the read before the last
        clock.now += 3_000_000
        bus.write(b"A")
        wait_until_readable(bus.port)
        (read,) = collect(source, 1)
        assert read.uncertainty_ns == LATENCY + since_ns
    source.close()


def test_several_at_once_were_not_read_in_time(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = SteppedTime(monkeypatch)
    source = open_reader(bus.port, SETTINGS)
    monkeypatch.setattr(os, "read", lambda fd, size: b"AB")
    Asleep(source, clock, monkeypatch).sleep_ns = LATENCY
    read = source.read(PATIENCE_S)
    assert read is not None
    # The next one was not there yet: so B had been there for less than the 11 bits of a character.
    assert read.uncertainty_ns == LATENCY + 11 * 1_000_000_000 // 115200
    monkeypatch.undo()
    source.close()


@pytest.mark.parametrize(
    ("data", "slept_ns", "more_ns"),
    [
        (b"A", 9_000_000, 0),  # no sleep is longer than 10 ms
        (b"A", 10_000_000 + LATENCY, 0),
        (b"A", 10_000_001 + LATENCY, 10_000_001 + LATENCY),
        (b"A", 2_000_000_000, 2_000_000_000),
        (b"A", 5_000_000_000, None),  # more than 32 bits of ns
        # A character takes 95 us: three, two of them after the first, come within the latency of 300 us.
        (b"ABC", 9_000_000, SETTINGS.character_ns),
        (b"ABCDE", 9_000_000, 9_000_000),
    ],
)
def test_a_process_that_was_stopped_says_so(
    bus: Pty, monkeypatch: pytest.MonkeyPatch, data: bytes, slept_ns: int, more_ns: int | None
) -> None:
    clock = SteppedTime(monkeypatch)
    source = open_reader(bus.port, SETTINGS)
    Asleep(source, clock, monkeypatch).sleep_ns = slept_ns
    bus.write(data)
    read = source.read(PATIENCE_S)
    assert read is not None
    assert read.data == data
    assert read.uncertainty_ns == (UNCERTAINTY_UNKNOWN if more_ns is None else LATENCY + more_ns)
    monkeypatch.undo()
    source.close()


def test_a_silent_line_makes_nothing_uncertain(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = SteppedTime(monkeypatch)
    source = open_reader(bus.port, SETTINGS)

    def silence(timeout_ms: float) -> list[tuple[int, int]]:
        clock.now += int(timeout_ms * 1_000_000)
        return []

    polls(source, silence)
    began = clock.now
    for _ in range(50):
        assert source.read(0.1) is None
    assert clock.now - began == 5_000_000_000
    source._alone = None  # type: ignore[attr-defined] # it polls as ever
    bus.write(b"A")
    wait_until_readable(bus.port)
    clock.now += 1_000_000
    (read,) = collect(source, 1)
    assert read.uncertainty_ns == LATENCY + 1_000_000
    source.close()


def test_characters_that_come_while_a_read_returns_are_no_surprise(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = SteppedTime(monkeypatch)
    source = open_reader(bus.port, SETTINGS)
    real = os.read

    def stopped(fd: int, size: int) -> bytes:
        data = real(fd, size)
        bus.write(b"B")
        clock.now += 50_000_000
        return data

    bus.write(b"A")
    wait_until_readable(bus.port)
    with monkeypatch.context() as patched:
        patched.setattr(os, "read", stopped)
        (read,) = collect(source, 1)
    wait_until_readable(bus.port)
    (read,) = collect(source, 1)
    assert (read.data, read.uncertainty_ns) == (b"B", LATENCY + 50_000_000)
    source.close()


def test_the_rest_of_a_cut_mark_is_as_old_as_its_beginning(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = SteppedTime(monkeypatch)
    source = open_reader(bus.port, SETTINGS)
    pieces = iter([b"\xff", b"\xff"])
    monkeypatch.setattr(os, "read", lambda fd, size: next(pieces))
    Asleep(source, clock, monkeypatch).sleep_ns = LATENCY
    clock.now += 1_000
    read = source.read(PATIENCE_S)
    assert read is not None
    since_ns = 2 * LATENCY  # at 1_000 there was still nothing
    assert (read.data, read.uncertainty_ns) == (b"\xff", LATENCY + since_ns)
    monkeypatch.undo()
    source.close()


def test_what_a_full_read_left_behind_is_as_old_as_that_read(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = SteppedTime(monkeypatch)
    source = open_reader(bus.port, SETTINGS)
    pieces = iter([bytes(READ_SIZE), b"rest"])
    monkeypatch.setattr(os, "read", lambda fd, size: next(pieces))
    polls(source, lambda timeout_ms: [(descriptor(source), select.POLLIN)])
    began = clock.now
    for elapsed in (1_000, 3_000):  # since everything had been read, and the second time still since then
        clock.now = began + elapsed
        read = source.read(PATIENCE_S)
        assert read is not None
        assert read.uncertainty_ns == LATENCY + elapsed
    monkeypatch.undo()
    source.close()


def wait_until_readable(port: str) -> None:
    """Wait until the line discipline has something, without reading it."""
    descriptor = os.open(port, os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)
    end = time.monotonic() + PATIENCE_S
    while not struct.unpack("i", fcntl.ioctl(descriptor, termios.FIONREAD, bytes(4)))[0]:
        assert time.monotonic() < end
    os.close(descriptor)


def test_hang_up(bus: Pty) -> None:
    source = open_reader(bus.port, SETTINGS)
    bus.hang_up()
    with pytest.raises(PortLost, match="other end has ended: start it"):
        source.read(PATIENCE_S)
    source.close()


def test_what_was_readable_comes_before_the_loss(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    source = open_reader(bus.port, SETTINGS)
    answers: Iterator[bytes | OSError] = iter([b"last words", OSError(errno.EIO, "Input/output error")])

    def unplugged(fd: int, size: int) -> bytes:
        answer = next(answers)
        if isinstance(answer, OSError):
            raise answer
        return answer

    bus.write(b"X")
    monkeypatch.setattr(os, "read", unplugged)
    assert joined(collect(source, 10)) == b"last words"
    with pytest.raises(PortLost):
        source.read(PATIENCE_S)
    monkeypatch.undo()
    source.close()


# -- Other settings in mid-capture -------------------------------------------------------------------------------------


def test_a_change_drops_nothing_and_keeps_marking_errors(bus: Pty) -> None:
    source = open_reader(bus.port, LineSettings(9600))
    bus.write(b"waiting \xff")
    wait_until_readable(bus.port)
    source.change(LineSettings(57600, 8, "N"))
    attributes = termios.tcgetattr(bus.master)  # those of the port: a pty has only one set
    assert attributes[4] == attributes[5] == termios.B57600
    assert attributes[0] & termios.PARMRK and attributes[0] & termios.INPCK
    (read,) = collect(source, 9)
    assert read.data == b"waiting \xff"
    assert source.settings == LineSettings(57600, 8, "N")
    bus.write(b"A")
    (read,) = collect(source, 1)
    assert read.settings == source.settings
    source.close()


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        (LineSettings(19200, 7, "O", 4), termios.CS7 | termios.PARENB | termios.PARODD | termios.CSTOPB),
        (LineSettings(19200, 8, "N", 2), termios.CS8),
        (LineSettings(19200, 8, "E", 2), termios.CS8 | termios.PARENB),
    ],
)
def test_a_change_of_format_at_a_real_port(
    bus: Pty, monkeypatch: pytest.MonkeyPatch, settings: LineSettings, expected: int
) -> None:
    driver = Driver(monkeypatch)
    monkeypatch.setattr(ports, "adapter", lambda port: ports.Adapter("16550A UART", "serial", fifo_trigger=8))
    source = open_reader(bus.port, LineSettings(9600, 5, "O", 4))
    driver.asked.clear()
    source.change(settings)
    (attributes,) = driver.asked
    mask = termios.CSIZE | termios.PARENB | termios.PARODD | termios.CSTOPB
    assert attributes[2] & mask == expected
    assert attributes[4] == attributes[5] == termios.B19200
    bus.write(b"A")
    (read,) = collect(source, 1)
    # With a trigger level of 8 the FIFO holds a character for ten character times, those of the new rate.
    # How late this machine was just now is added to it.
    assert source.uncertainty_ns == 10 * settings.character_ns + LATENCY  # type: ignore[attr-defined]
    assert read.uncertainty_ns >= 10 * settings.character_ns + LATENCY
    monkeypatch.undo()
    source.close()


def speed(port: str) -> int:
    """Return the rate of a port, even without a constant: c_ospeed, the last word of struct termios2."""
    descriptor = os.open(port, os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        return int(struct.unpack("11I", fcntl.ioctl(descriptor, TCGETS2, bytes(44)))[10])
    finally:
        os.close(descriptor)


def test_a_change_to_any_rate(bus: Pty) -> None:
    source = open_reader(bus.port, LineSettings(9600))
    for baud in (187_500, 12_345, 19_200, 375_000):
        source.change(LineSettings(baud))
        assert speed(bus.port) == baud
        assert termios.tcgetattr(bus.master)[0] & termios.PARMRK
        assert source.settings == LineSettings(baud)
    source.close()


@pytest.mark.parametrize(
    ("asked", "true"),
    [(300, 300), (9600, 9600), (115_200, 115_385), (921_600, 923_077), (2_500_000, 2_000_000), (5_000_000, 3_000_000)],
)
def test_the_true_rate_of_a_ch340(asked: int, true: int) -> None:
    """48 MHz through the dividers of ch341.c; low rates are exact enough."""
    assert opening.ch341_rate(asked) == true


def test_a_ch340_runs_no_faster_than_3_million(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    Driver(monkeypatch, driver="ch341-uart")
    with pytest.raises(PortError, match=r"4000000 Bd 8E1 \(its driver sets 3000000 Bd 8E1\)"):
        open_reader(bus.port, LineSettings(4_000_000))


def test_a_driver_that_reports_no_line_errors(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    Driver(monkeypatch, driver="ch341-uart")
    source = open_reader(bus.port, LineSettings(9600))
    assert source.timing.endswith("; ordinary priority; no line errors are reported")
    (note,) = (note for note in source.notes if "line errors" in note)
    assert note.startswith(f"{bus.port}: no line errors are reported. A damaged character looks like a good one.")
    source.close()


@pytest.mark.parametrize("before", [9600, 187_500])
def test_a_rate_that_the_port_cannot_do_changes_nothing(bus: Pty, monkeypatch: pytest.MonkeyPatch, before: int) -> None:
    source = open_reader(bus.port, LineSettings(before))
    with monkeypatch.context() as patched:
        patched.setattr("sistap.tap.line.reader.opening._speed", lambda fd: before)  # whatever it is told
        for settings in (LineSettings(115200), LineSettings(12345), LineSettings(3_000_000_000)):
            with pytest.raises(PortError, match=f"cannot do {settings.baud} Bd 8E1"):
                source.change(settings)
            assert speed(bus.port) == before
            assert source.settings == LineSettings(before)
    source.close()


def test_a_change_through_pyserial(bus: Pty, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = open_reader(f"spy://{bus.port}?file={tmp_path / 'spied'}", LineSettings(9600, 8, "N"))
    source.change(LineSettings(19200, 8, "N"))
    assert termios.tcgetattr(bus.master)[4] == termios.B19200
    bus.write(b"A")
    (read,) = collect(source, 1)
    assert read.settings == LineSettings(19200, 8, "N")

    def refuse(port: serial.Serial, rate: int) -> None:
        raise serial.SerialException("Cannot configure port, something went wrong")  # as Windows says it

    monkeypatch.setattr(serial.Serial, "baudrate", property(None, refuse))
    with pytest.raises(PortError, match="cannot do 38400 Bd 8N1"):
        source.change(LineSettings(38400, 8, "N"))
    assert source.settings == LineSettings(19200, 8, "N")
    monkeypatch.undo()
    source.close()


# -- The driver's counters ---------------------------------------------------------------------------------------------


class Counters:
    """A driver that counts errors."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.words = [0] * 20
        real = fcntl.ioctl

        def ioctl(fd: int, request: int, *rest: object) -> object:
            if request == termios.TIOCGICOUNT:
                return struct.pack("20i", *self.words)
            return real(fd, request, *rest)  # type: ignore[call-overload]

        monkeypatch.setattr(fcntl, "ioctl", ioctl)


# The words of struct serial_icounter_struct (Linux, include/uapi/linux/serial.h).
FRAME, OVERRUN, PARITY, BRK, BUFFER_OVERRUN = range(6, 11)
LOST, SOMEWHERE = int(Flag.LOST_BEFORE), int(Flag.UNLOCATED_ERROR)


@pytest.mark.parametrize(
    ("counter", "data", "flags"),
    [
        (OVERRUN, b"A", [LOST]),
        (BUFFER_OVERRUN, b"A", [LOST]),
        (OVERRUN, b"ABC", [LOST | SOMEWHERE, SOMEWHERE, SOMEWHERE]),
        (PARITY, b"AB", [SOMEWHERE, SOMEWHERE]),
        (FRAME, b"A", [SOMEWHERE]),
        (BRK, b"A", [SOMEWHERE]),
        (PARITY, b"A\xff\x00B", [0, BAD]),  # marked: it is known where
        (4, b"A", [0]),  # rx: characters received
    ],
)
def test_errors_that_the_driver_only_counts(
    bus: Pty, monkeypatch: pytest.MonkeyPatch, counter: int, data: bytes, flags: list[int]
) -> None:
    driver = Counters(monkeypatch)
    driver.words[counter] = 41  # what happened before the capture does not count
    source = open_reader(bus.port, SETTINGS)
    driver.words[counter] += 1
    bus.write(data)  # the marks as well: nobody doubles an FF here
    monkeypatch.setattr(os, "read", unmarked(data))
    (read,) = collect(source, len(flags))
    assert list(read.flags) == flags
    bus.write(data)
    (read,) = collect(source, len(flags))  # nothing was counted since
    assert list(read.flags) == [flag & BAD for flag in flags]
    source.close()


def unmarked(data: bytes) -> Callable[[int, int], bytes]:
    """Read from a pseudo terminal, but return `data`, as a port with errors delivers it."""
    real = os.read

    def read(fd: int, size: int) -> bytes:
        real(fd, size)
        return data

    return read


def test_what_is_held_back_is_delivered_when_asked_for_what_is_there(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    driver = Counters(monkeypatch)
    clock = SteppedTime(monkeypatch)
    source = open_reader(bus.port, SETTINGS)
    driver.words[PARITY] += 1
    bus.write(b"A")
    wait_until_readable(bus.port)
    read = source.read(0)
    assert read is not None
    assert (read.data, list(read.flags)) == (b"A", [SOMEWHERE])
    assert clock.now  # it stood still: nothing was waited for
    source.close()


def test_a_port_that_is_lost_delivers_first_what_was_held_back(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    driver = Counters(monkeypatch)
    SteppedTime(monkeypatch)
    source = open_reader(bus.port, SETTINGS)
    driver.words[PARITY] += 1
    bus.write(b"A")
    wait_until_readable(bus.port)
    assert isinstance(source, PosixReader)
    assert source.read_now(0) == []
    bus.hang_up()
    (read,) = source.read_now(0)
    assert (read.data, list(read.flags)) == (b"A", [SOMEWHERE])
    with pytest.raises(PortLost):
        source.read(PATIENCE_S)
    source.close()


# -- How times are bounded ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("behind", "ns", "phrase"),
    [
        (
            ports.Adapter("FT232R", "ftdi_sio", latency_ms=16),
            16_300_000,
            "uncertainty 16.30 ms: latency timer 16 ms and 0.30 ms, measured when the capture started and ever since",
        ),
        (  # its first of seven characters waits for six more and a time-out of four: ten of 11 bits at 9600 Bd
            ports.Adapter("16550A UART", "serial", fifo_trigger=8),
            10 * 1_145_833 + LATENCY,
            "uncertainty 11.76 ms: FIFO trigger 8 and 0.30 ms, measured when the capture started and ever since",
        ),
        (
            ports.Adapter("16550A UART", "serial", fifo_trigger=1),
            LATENCY,
            "uncertainty 0.30 ms, measured when the capture started and ever since",
        ),
        (
            ports.Adapter("CP2102", "cp210x"),
            LATENCY,
            "uncertainty 0.30 ms, measured when the capture started and ever since; what the adapter adds is not known",
        ),
    ],
)
def test_latency_of_adapters(
    bus: Pty, monkeypatch: pytest.MonkeyPatch, behind: ports.Adapter, ns: int, phrase: str
) -> None:
    Driver(monkeypatch)
    monkeypatch.setattr(ports, "adapter", lambda port: behind._replace(pseudo_terminal=False))
    source = open_reader(bus.port, LineSettings(9600))
    assert source.timing == "; ".join(filter(None, [phrase, "ordinary priority", behind.tells.clause]))
    clock = SteppedTime(monkeypatch)
    assert isinstance(source, PosixReader)
    source._emptied_ns = clock.now  # not late
    bus.write(b"A")
    (read,) = collect(source, 1)
    assert read.uncertainty_ns == ns
    source.close()


@pytest.fixture
def tuned(bus: Pty, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The latency timer of the bus's port, as if it were an FTDI adapter; at 16 ms."""
    timer = tmp_path / "bus/usb-serial/devices" / Path(bus.port).name / "latency_timer"
    timer.parent.mkdir(parents=True)
    timer.write_text("16\n")
    Driver(monkeypatch)
    monkeypatch.setattr(ports, "SYSFS", tmp_path)
    monkeypatch.setattr(ports, "adapter", lambda port: ports.Adapter("FT232R", latency_ms=ports.number(timer)))
    return timer


def test_the_uncertainty_is_that_of_the_tuned_port(bus: Pty, tuned: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    SteppedTime(monkeypatch)
    source = open_reader(bus.port, SETTINGS)
    assert source.timing == (
        "uncertainty 1.30 ms: latency timer 1 ms and 0.30 ms, measured when the capture started and ever since; "
        "latency timer 16 -> 1 ms; ordinary priority"
    )
    assert source.adapter == "FT232R (latency timer 1 ms)"
    assert source.notes == ()
    bus.write(b"A")
    (read,) = collect(source, 1)
    assert read.uncertainty_ns == 1_300_000
    source.close()
    assert tuned.read_text() == "16"


def test_what_came_before_the_port_was_tuned_is_dropped(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    """Setting the trigger of a FIFO clears the FIFO: after that there would be a gap without a flag."""
    clock = SteppedTime(monkeypatch)

    def tuning(*arguments: Any) -> Tuning:
        bus.write(b"before the gap")
        assert select.select([arguments[1]], [], [], PATIENCE_S)[0]
        clock.now += 5_000_000
        return Tuning(*arguments)

    monkeypatch.setattr(device, "Tuning", tuning)
    source = open_reader(bus.port, SETTINGS)
    bus.write(b"A")
    (read,) = collect(source, 1)
    assert (read.data, read.uncertainty_ns) == (b"A", LATENCY)  # it cannot be older than the end of tuning
    source.close()


def test_a_port_that_cannot_be_tuned_is_captured_all_the_same(
    bus: Pty, tuned: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(file: Path, text: str) -> int:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(Path, "write_text", refuse)
    source = open_reader(bus.port, SETTINGS)
    assert source.timing.startswith("uncertainty 16.30 ms: latency timer 16 ms and 0.30 ms, ")
    (note,) = source.notes
    assert "up to 16.0 ms late" in note
    bus.write(b"A")
    assert joined(collect(source, 1)) == b"A"
    source.close()


def test_a_lost_port_is_put_back_too(bus: Pty, tuned: Path) -> None:
    source = open_reader(bus.port, SETTINGS)
    bus.hang_up()
    with pytest.raises(PortLost):
        collect(source, 1)
    source.close()
    assert tuned.read_text() == "16"


def test_measuring_leaves_nothing_open_and_gives_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    open_before = descriptors()
    assert 0 < computer.measured_ns.__wrapped__() < UNCERTAINTY_UNKNOWN
    assert descriptors() <= open_before


def test_a_signal_while_measuring_leaves_the_writer_nothing_to_stumble_over(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    stumbled: list[object] = []
    monkeypatch.setattr(threading, "excepthook", stumbled.append)
    writers: list[threading.Thread] = []

    def interrupted(reading: int, written: list[int], writer: threading.Thread) -> list[int]:
        writers.append(writer)
        raise KeyboardInterrupt

    monkeypatch.setattr(delay, "_read", interrupted)
    open_before = descriptors()
    with pytest.raises(KeyboardInterrupt):
        delay.through_pty(1_000_000)
    writers[0].join(PATIENCE_S)
    assert not stumbled
    assert descriptors() <= open_before


# -- Ports that cannot be opened ---------------------------------------------------------------------------------------


def refused(port: str, settings: LineSettings = SETTINGS) -> str:
    with pytest.raises(PortError) as caught:
        open_reader(port, settings)
    text = str(caught.value)
    assert "\n" not in text
    return text


def test_missing_port() -> None:
    assert refused("/dev/ttyMISSING7") == "/dev/ttyMISSING7 does not exist: `sistap ports` lists the ports there are"


def test_not_a_serial_port(tmp_path: Path) -> None:
    file = tmp_path / "capture.pcapng"
    file.touch()
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    for path in (file, fifo, tmp_path, Path("/dev/null")):
        assert refused(str(path)) == f"{path} is not a serial port: `sistap ports` lists the ports there are"


def test_busy(bus: Pty) -> None:
    source = open_reader(bus.port, SETTINGS)
    text = refused(bus.port)
    assert "is in use by another program" in text
    assert "ModemManager" in text
    assert f"`sudo fuser -v {bus.port}`" in text
    source.close()


def denied(monkeypatch: pytest.MonkeyPatch, bus: Pty, mode: int, gid: int) -> str:
    Path(bus.port).chmod(mode)
    os.chown(bus.port, -1, gid)

    def deny(self: serial.Serial) -> None:
        raise serial.SerialException(errno.EACCES, f"could not open port {self.port}: Permission denied")

    monkeypatch.setattr(serial.Serial, "open", deny)
    return refused(bus.port)


@pytest.mark.skipif(os.geteuid() != 0, reason="gives the port to another group, which takes root")
def test_no_permission(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    import grp  # noqa: PLC0415

    dialout = grp.getgrnam("dialout").gr_gid
    assert denied(monkeypatch, bus, 0o660, dialout) == (
        f"no permission to open {bus.port}: it is for group dialout: "
        "`sudo usermod -aG dialout $USER`, then log in again"
    )
    assert denied(monkeypatch, bus, 0o600, 0) == (
        f"no permission to open {bus.port}: it belongs to root: run sistap as that user"
    )


def test_no_hardware(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    def dead(fd: int) -> None:
        raise termios.error(errno.EIO, "Input/output error")  # a ttyS that has only its file in /dev

    monkeypatch.setattr(termios, "tcgetattr", dead)
    assert refused(bus.port).startswith(f"there is no working hardware behind {bus.port}: ")


def test_unsupported_rates(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    cannot = "cannot do {} Bd 8E1{}: choose another --baud or --format"
    assert refused(bus.port, LineSettings(3_000_000_000)).endswith(cannot.format(3_000_000_000, ""))
    assert "needs a rate" in refused(bus.port, LineSettings(0))

    real = fcntl.ioctl

    def quietly_9600(fd: int, request: int, *rest: object) -> object:
        if request == TCGETS2:  # c_ospeed is the last of its eleven words
            return struct.pack("11I", *[0] * 10, 9600)
        return real(fd, request, *rest)  # type: ignore[call-overload]

    monkeypatch.setattr(fcntl, "ioctl", quietly_9600)
    quietly = cannot.format(187_500, " (its driver sets 9600 Bd 8E1)")
    assert refused(bus.port, LineSettings(187_500)).endswith(quietly)
    open_reader(bus.port, LineSettings(9600)).close()  # and the refused one let the port go


def test_format_the_driver_refuses(bus: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(fd: int, when: int, attributes: object) -> None:
        raise termios.error(errno.EINVAL, "Invalid argument")

    monkeypatch.setattr(termios, "tcsetattr", refuse)
    assert refused(bus.port, LineSettings(9600, 5, "M", 3)).endswith(
        "cannot do 9600 Bd 5M1.5: choose another --baud or --format"
    )


def test_a_rate_of_its_own_survives_the_marking_of_errors(bus: Pty) -> None:
    source = open_reader(bus.port, LineSettings(187_500))
    assert speed(bus.port) == 187_500
    assert termios.tcgetattr(bus.master)[0] & termios.PARMRK
    source.close()


# -- URLs --------------------------------------------------------------------------------------------------------------


@pytest.fixture
def server() -> Iterator[socket.socket]:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        yield listening


def test_socket_url(server: socket.socket) -> None:
    url = f"socket://127.0.0.1:{server.getsockname()[1]}"
    source = open_reader(url, SETTINGS, line=1)
    connection, _ = server.accept()
    times = f"times are those of arrival at this program over socket://; {STEADY}; uncertainty unknown"
    assert source.timing == f"{times}; no line errors are reported"
    (note,) = source.notes
    assert "no verdict on its times is possible" in note
    assert source.adapter == url
    everything = bytes(range(256))
    connection.sendall(everything)
    reads = collect(source, 256)
    assert [read.data for read in reads] == [everything]  # came together, is one read
    assert {read.uncertainty_ns for read in reads} == {UNCERTAINTY_UNKNOWN}
    assert {read.line for read in reads} == {1}
    assert source.read(0) is None
    connection.sendall(b"last words")
    connection.close()
    assert joined(collect(source, 10)) == b"last words"
    with pytest.raises(PortLost, match="is gone"):
        source.read(PATIENCE_S)
    source.close()


def test_refused_connection(server: socket.socket) -> None:
    number = server.getsockname()[1]
    server.close()
    for kind in ("socket", "rfc2217", "bus"):
        url = f"{kind}://127.0.0.1:{number}"
        assert refused(url) == f"nothing listens at {url}: start the other end first"


@pytest.mark.parametrize(
    "url",
    [
        "carrier://pigeon",
        "socket://",
        "socket://host",
        "socket://host:99999",
        "socket://[x",
        "socket://a..b:1",
        "rfc2217://h",
        "loop://?x=y",
    ],
)
def test_wrong_url(url: str) -> None:
    assert refused(url).startswith(f"{url} is not the URL of a port: write bus://HOST:PORT, ")


def test_a_url_of_a_device() -> None:
    assert refused("spy:///dev/nope").startswith("spy:///dev/nope does not exist: ")
    assert refused("loop://", LineSettings(99_999_999_999)) == (
        "loop:// cannot do 99999999999 Bd 8E1: choose another --baud or --format"
    )


# -- The virtual bus ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "url", ["bus://", "bus://host", "bus://host:0x7", "bus://host:99999", "bus://[x", "bus://a..b:5000"]
)
def test_wrong_bus_address(url: str) -> None:
    assert refused(url) == f"{url} is not the address of a bus: write bus://HOST:PORT or bus:///SOCKET"


def test_no_bus_at_the_socket(tmp_path: Path) -> None:
    assert refused(f"bus://{tmp_path}/bus").startswith("nothing listens at bus:///")


HELLO = protocol.Hello(START_NS, "virtual bus", "as the bus says")


def accept(listening: socket.socket, connections: list[socket.socket], said: bytes) -> None:
    connections.append(listening.accept()[0])
    connections[0].settimeout(PATIENCE_S)
    connections[0].sendall(said)


@pytest.fixture
def tapped(tmp_path: Path) -> Iterator[tuple[Reader, socket.socket]]:
    """A reader and the bus's end of its connection."""
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(tmp_path / "bus"))
        listening.listen()
        connections: list[socket.socket] = []
        bus = threading.Thread(target=accept, args=(listening, connections, protocol.pack_hello(HELLO)))
        bus.start()
        source = open_reader(f"bus://{tmp_path}/bus", LineSettings(19200, 7, "O", 4))
        bus.join()
        assert (source.adapter, source.timing) == ("virtual bus", "as the bus says")
        with connections[0]:
            yield source, connections[0]
        source.close()


@pytest.mark.parametrize(
    ("said", "cure"),
    [
        (
            b"HTTP/1.1 400 Bad Request\r\n",
            "is not a sistap bus: give the address",
        ),
        (protocol.pack_settings(LineSettings()), "it does not say what it is"),
        (protocol.pack_hello(HELLO._replace(version=1)), "version 1 of the wire, and this sistap 2"),
        (b"", "the other end closes the connection at once"),
    ],
)
def test_a_stranger_at_the_socket(tmp_path: Path, said: bytes, cure: str) -> None:
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(tmp_path / "bus"))
        listening.listen()
        connections: list[socket.socket] = []

        def answer() -> None:
            accept(listening, connections, said)
            connections[0].close()

        stranger = threading.Thread(target=answer)
        stranger.start()
        assert cure in refused(f"bus://{tmp_path}/bus")
        stranger.join()


def test_wire(tapped: tuple[Reader, socket.socket]) -> None:
    source, connection = tapped
    settings = LineSettings(19200, 7, "O", 4)
    assert protocol.Decoder().feed(connection.recv(100)) == [protocol.Time(0), settings]
    assert source.read(0) is None
    sent = [
        Read(0, 1_700_000_000_123_456_789, b"\x02\xff\x00", b"\x00\x02\x04", 1_000_000, settings),
        Read(2, 1_700_000_000_223_456_789, b"A", b"\x18", settings=settings),
    ]
    stream = b"".join(map(protocol.pack_read, sent))
    connection.sendall(stream[:20])
    assert source.read(0) is None  # half a message is not delivered
    connection.sendall(stream[20:])
    assert [source.read(PATIENCE_S), source.read(PATIENCE_S)] == sent
    connection.close()
    with pytest.raises(PortLost, match="the bus has ended"):
        source.read(PATIENCE_S)


def test_a_bus_says_from_where_on_it_is_heard_otherwise(tapped: tuple[Reader, socket.socket]) -> None:
    source, connection = tapped
    before, after = LineSettings(19200, 7, "O", 4), LineSettings(38400)
    connection.recv(100)
    source.change(after)
    assert protocol.Decoder().feed(connection.recv(100)) == [after]
    on_its_way, later = Read(0, START_NS, b"A", b"\0", 0), Read(0, START_NS + 1, b"B", b"\0", 0)
    connection.sendall(protocol.pack_read(on_its_way) + protocol.pack_settings(after) + protocol.pack_read(later))
    assert source.read(PATIENCE_S) == on_its_way._replace(settings=before)
    assert source.read(PATIENCE_S) == later._replace(settings=after)


def test_simulated_time_goes_on_only_when_the_reader_may_wait(tapped: tuple[Reader, socket.socket]) -> None:
    source, connection = tapped
    connection.recv(100)
    connection.sendall(protocol.pack_time(START_NS))
    read = source.read(PATIENCE_S)
    assert read and (read.time_ns, read.data) == (START_NS, b"")
    assert source.read(0) is None
    connection.setblocking(False)
    with pytest.raises(BlockingIOError):
        connection.recv(100)
    assert source.read(0.001) is None
    assert protocol.Decoder().feed(connection.recv(100)) == [protocol.Time(START_NS)]


def test_not_a_wire(tapped: tuple[Reader, socket.socket]) -> None:
    source, connection = tapped
    connection.sendall(b"HTTP/1.1 400 Bad Request\r\n")
    with pytest.raises(PortLost, match="is not a sistap bus"):
        source.read(PATIENCE_S)
