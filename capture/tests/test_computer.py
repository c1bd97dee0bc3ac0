# SPDX-License-Identifier: GPL-2.0-or-later
"""How late this computer is: measured before a capture, and then as long as a port is polled."""

from __future__ import annotations

import fcntl
import os
import pty
import termios
import time
import tty
from collections.abc import Iterator

import pytest

from sistap.tap.capture.hints import Exactness
from sistap.tap.line.reader import delay, latency, open_reader
from sistap.tap.line.reader.delay import Computer
from sistap.tap.line.reader.device import PosixReader
from sistap.tap.line.settings import LineSettings, Read

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


def opened(monkeypatch: pytest.MonkeyPatch, measured: Computer, port: str) -> PosixReader:
    monkeypatch.setattr(latency, "computer", lambda **_: measured)
    reader = open_reader(port, SETTINGS)
    assert isinstance(reader, PosixReader)
    return reader


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
    reader = opened(monkeypatch, Computer([LATE_NS] * 20), line[1])
    assert reader.timing.startswith("uncertainty 4000.00 ms, measured when the capture started and ever since; ")
    assert heard(reader, line[0]).uncertainty_ns >= LATE_NS
    end = time.monotonic() + PATIENCE_S
    while reader.uncertainty_ns >= LATE_NS and time.monotonic() < end:
        assert reader.read(0.01) is None
    assert heard(reader, line[0]).uncertainty_ns < LATE_NS
    reader.close()


def test_a_wake_that_comes_late_is_seen_at_once(line: tuple[int, str], monkeypatch: pytest.MonkeyPatch) -> None:
    """The process wakes 200 ms after both characters came."""
    measured = Computer([1] * 20)
    reader = opened(monkeypatch, measured, line[1])
    assert reader.read(0) is None
    assert reader._alone
    real = reader._alone._poll

    class Late:
        def poll(self, step_ms: float) -> list[tuple[int, int]]:
            ready: list[tuple[int, int]] = real.poll(step_ms)
            if step_ms and measured.fileno() in dict(ready):
                os.write(line[0], b"A")
                time.sleep(0.2)
                ready = real.poll(0)
            return ready

    reader._alone._poll = Late()  # type: ignore[assignment]
    end = time.monotonic() + PATIENCE_S
    while not (read := reader.read(0.1)):
        assert time.monotonic() < end
    assert read.uncertainty_ns >= 200 * MS
    reader.close()


def test_a_reader_that_was_busy_itself_says_nothing_about_the_computer() -> None:
    measured = sent()
    assert measured.read_now(0) == []
    assert measured.late_ns == 7


def test_one_character_is_under_way() -> None:
    measured = sent()
    measured.before_sleep(time.monotonic_ns() + LATE_NS)
    time.sleep(0.02)
    assert waiting(measured) == 1
    measured.read_now(1)
    measured.before_sleep(0)  # not due yet
    time.sleep(0.02)
    assert waiting(measured) == 0


def sent() -> Computer:
    """Return a computer whose character waits."""
    measured = Computer([7])
    measured.before_sleep(time.monotonic_ns())
    end = time.monotonic() + PATIENCE_S
    while not waiting(measured) and time.monotonic() < end:
        time.sleep(0.001)  # the buffer of a terminal cannot be waited for
    return measured


def waiting(measured: Computer) -> int:
    return int.from_bytes(fcntl.ioctl(measured.fileno(), termios.FIONREAD, bytes(4)), "little")


def test_before_anybody_polls_it_measures_itself() -> None:
    measured = Computer()
    measured.measure(20 * MS)
    assert measured.late_ns > 0 and not waiting(measured)


def test_one_in_a_thousand_may_be_later(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(delay, "KEPT", 1000)
    assert Computer([5 * MS, *[MS] * 998]).late_ns == 5 * MS
    assert Computer([5 * MS, *[MS] * 999]).late_ns == MS
    assert Computer([5 * MS, 5 * MS, *[MS] * 998]).late_ns == 5 * MS
    assert Computer([*[9 * MS] * 500, *[MS] * 1000]).late_ns == MS  # only the last thousand count
    assert Computer([]).late_ns == 0


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
