# SPDX-License-Identifier: GPL-2.0-or-later
"""How late this computer is: measured before a capture, and then as long as a port is polled."""

from __future__ import annotations

import fcntl
import os
import pty
import termios
import time
import tty
from collections.abc import Callable, Iterator

import pytest

from sistap.tap.capture.hints import Exactness
from sistap.tap.line.reader import PortError, delay, latency, open_reader
from sistap.tap.line.reader.delay import Computer
from sistap.tap.line.reader.device import PosixReader
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, LineSettings, Read

pytestmark = pytest.mark.tap

MS = 1_000_000
LATE_NS = 4_000 * MS  # later than a quiet computer ever is
PATIENCE_S = 60
SETTINGS = LineSettings(115200)


@pytest.fixture(autouse=True)
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the last characters be few and soon sent."""
    monkeypatch.setattr(delay, "KEPT", 20)
    monkeypatch.setattr(delay, "_PAUSES_S", (0.0005, 0.001))


@pytest.fixture
def line() -> Iterator[tuple[int, str]]:
    """Yield a line: where a character is written, and the name of its port."""
    writing, reading = pty.openpty()
    tty.setraw(reading)
    yield writing, os.ttyname(reading)
    os.close(writing)
    os.close(reading)


def opened(monkeypatch: pytest.MonkeyPatch, port: str, measured_ns: int) -> PosixReader:
    monkeypatch.setattr(latency, "measured_ns", lambda: measured_ns)
    reader = open_reader(port, SETTINGS)
    assert isinstance(reader, PosixReader)
    return reader


class Poll:
    """The poll of a reader, and what happens when it returns nothing or something."""

    def __init__(self, reader: PosixReader, then: Callable[[list[int]], None]) -> None:
        assert reader.read(0) is None and reader._alone
        self._real, self._then = reader._alone._poll, then
        reader._alone._poll = self  # type: ignore[assignment]

    def poll(self, step_ms: int) -> list[tuple[int, int]]:
        ready = self._real.poll(step_ms)
        if step_ms:
            self._then([descriptor for descriptor, _ in ready])
        return ready or self._real.poll(0)


def heard(reader: PosixReader, writing: int) -> Read:
    """Say a character; return the read with it."""
    os.write(writing, b"A")
    end = time.monotonic() + PATIENCE_S
    while not (read := reader.read(0.1)):
        assert time.monotonic() < end
    return read


def test_when_a_busy_computer_is_quiet_again_times_are_exact_again(
    line: tuple[int, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    reader = opened(monkeypatch, line[1], LATE_NS)
    assert reader.timing.startswith("uncertainty 4000.00 ms, measured when the capture started and ever since; ")
    assert heard(reader, line[0]).uncertainty_ns >= LATE_NS
    end = time.monotonic() + PATIENCE_S
    while reader.uncertainty_ns >= LATE_NS and time.monotonic() < end:
        assert reader.read(0.01) is None
    assert heard(reader, line[0]).uncertainty_ns < LATE_NS
    reader.close()


def test_a_wake_that_comes_late_is_seen_at_once(line: tuple[int, str], monkeypatch: pytest.MonkeyPatch) -> None:
    """The process wakes 200 ms after both characters came: its own, and one of the line."""
    reader = opened(monkeypatch, line[1], 1)

    def late(ready: list[int]) -> None:
        if reader.beside and reader.beside.fileno() in ready:
            os.write(line[0], b"A")
            time.sleep(0.2)

    Poll(reader, late)
    end = time.monotonic() + PATIENCE_S
    while not (read := reader.read(0.1)):
        assert time.monotonic() < end
    assert read.uncertainty_ns >= 200 * MS
    reader.close()


def test_a_sleep_that_ends_too_late_counts(line: tuple[int, str], monkeypatch: pytest.MonkeyPatch) -> None:
    """The process is stopped for 300 ms while no character is under way."""
    reader = opened(monkeypatch, line[1], 1)
    stops: list[bool] = []

    def stopped(ready: list[int]) -> None:
        if not ready and not stops:
            time.sleep(0.3)
            stops.append(True)

    Poll(reader, stopped)
    end = time.monotonic() + PATIENCE_S
    while not stops:
        assert reader.read(0.1) is None and time.monotonic() < end
    assert reader.uncertainty_ns >= 300 * MS
    reader.close()


def test_a_character_that_does_not_come_back_makes_times_as_inexact_as_its_wait() -> None:
    measured = Computer()
    measured.before_sleep(1)
    time.sleep(0.02)
    assert measured.late_ns >= 20 * MS
    measured.close()


def test_a_reader_that_was_busy_itself_says_nothing_about_the_computer() -> None:
    measured = sent()
    assert measured.read_now(0) == []
    assert measured.late_ns == 7
    measured.close()


def test_one_character_is_under_way() -> None:
    measured = sent()
    measured.before_sleep(time.monotonic_ns() + LATE_NS)
    time.sleep(0.02)
    assert waiting(measured) == 1
    measured.read_now(1)
    assert measured.before_sleep(measured._due_ns - 3_500_000) == 4  # not due yet: in 3.5 ms
    time.sleep(0.02)
    assert waiting(measured) == 0
    measured.close()


def sent() -> Computer:
    """Return a computer whose character waits."""
    measured = Computer(7)
    measured.before_sleep(time.monotonic_ns())
    end = time.monotonic() + PATIENCE_S
    while not waiting(measured) and time.monotonic() < end:
        time.sleep(0.001)  # the buffer of a terminal cannot be waited for
    return measured


def waiting(measured: Computer) -> int:
    return int.from_bytes(fcntl.ioctl(measured.fileno(), termios.FIONREAD, bytes(4)), "little")


def test_before_anybody_polls_it_measures_itself() -> None:
    measured = Computer()
    assert measured.measure(0) == measured.late_ns > 0  # at least once, however late this process is
    assert not waiting(measured)
    measured.close()


def test_a_first_character_that_does_not_come_back_is_not_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(delay, "PATIENCE_NS", 20 * MS)
    monkeypatch.setattr(Computer, "before_sleep", lambda *_: 0)
    measured = Computer()
    assert measured.measure(0) == 20 * MS
    measured.close()


def test_the_longest_of_the_last_thousand_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(delay, "KEPT", 1000)
    for delays, longest in (
        ([5, *[1] * 999], 5),
        ([5, *[1] * 1000], 1),
        ([9, 5, *[1] * 998, 7, 1], 7),
        ([9, 5, *[1] * 999], 5),
        ([], 0),
    ):
        measured = Computer(*delays)
        assert measured.late_ns == longest, (delays[:2], len(delays))
        measured.close()


def test_a_port_that_comes_and_goes_leaves_nothing_open(line: tuple[int, str], monkeypatch: pytest.MonkeyPatch) -> None:
    opened(monkeypatch, line[1], 1).close()
    before = os.listdir("/proc/self/fd")
    for _ in range(3):
        reader = opened(monkeypatch, line[1], 1)
        reader.read(0.001)
        reader.close()
        with pytest.raises(PortError):
            open_reader("/dev/none", SETTINGS)
    assert os.listdir("/proc/self/fd") == before


def test_what_changes_much_is_told() -> None:
    exactness = Exactness("/dev/ttyUSB0", 28 * MS)
    assert exactness.look(400_000, 9.9) == ""  # too soon
    assert exactness.look(15 * MS, 10) == ""  # not half as much
    assert exactness.look(400_000, 11) == (
        "/dev/ttyUSB0: uncertainty 0.40 ms now, 28.00 ms before: this computer is less busy"
    )
    assert exactness.look(1_200_000, 40) == ""  # three times as much, but no millisecond
    assert exactness.look(1_500_000, 30.9) == ""  # twenty seconds have not passed
    assert exactness.look(1_500_000, 41) == (
        "/dev/ttyUSB0: uncertainty 1.50 ms now, 0.40 ms before: this computer is busier"
    )
    assert exactness.look(30 * MS, 80.9) == ""  # forty seconds
    for elapsed_s in range(100, 4000, 100):
        exactness.look((elapsed_s % 200 + 1) * MS, elapsed_s)
    assert exactness.look(UNCERTAINTY_UNKNOWN, 4300).startswith("/dev/ttyUSB0: uncertainty unknown now, ")
