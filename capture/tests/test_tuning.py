# SPDX-License-Identifier: GPL-2.0-or-later
"""Tuning a port and restoring it, with a simulated sysfs and driver."""

import errno
import os
import signal
import struct
import subprocess
import sys
import termios
from collections.abc import Iterator
from pathlib import Path

import pytest
from portable import descriptors

from sistap.tap.line.reader.tuning import Tuning
from sistap.tap.line.settings import LineSettings

pytestmark = pytest.mark.tap

LOW_LATENCY = 0x2000  # ASYNC_LOW_LATENCY, <linux/tty_flags.h>: bit 13
OTHER_FLAGS = 0x40  # ASYNC_SKIP_TEST
SETTINGS = LineSettings(9600)


class Driver:
    """The driver's answer to TIOCGSERIAL and TIOCSSERIAL; flags are the fifth int (<linux/serial.h>)."""

    def __init__(self, refuse: int = 0, has_mode: bool = True, timer: Path | None = None) -> None:
        self.flags = OTHER_FLAGS
        self.sets = 0
        self._refuse = refuse
        self._has_mode = has_mode
        self._timer = timer
        self._stored = timer.read_text() if timer else ""

    def ioctl(self, descriptor: int, request: int, state: bytes) -> bytes:
        if request == termios.TIOCGSERIAL:
            return struct.pack("16xi108x", self.flags)
        assert request == termios.TIOCSSERIAL
        self.sets += 1
        if self._refuse:
            raise OSError(self._refuse, os.strerror(self._refuse))
        if self._has_mode:
            (self.flags,) = struct.unpack("16xi108x", state)
        if self._timer:  # as ftdi_sio: in this mode the timer is 1 ms, and shows it
            self._timer.write_text("1" if self.flags & LOW_LATENCY else self._stored)
        return state


def no_driver(descriptor: int, request: int, state: bytes) -> bytes:
    raise OSError(errno.ENOTTY, "Inappropriate ioctl for device")


@pytest.fixture
def descriptor() -> Iterator[int]:
    descriptor = os.open("/dev/null", os.O_RDONLY)
    yield descriptor
    os.close(descriptor)


@pytest.fixture
def timer(tmp_path: Path) -> Path:
    file = tmp_path / "bus/usb-serial/devices/ttyUSB0/latency_timer"
    file.parent.mkdir(parents=True)
    file.write_text("16\n")
    return file


@pytest.fixture
def trigger(tmp_path: Path) -> Path:
    file = tmp_path / "class/tty/ttyS0/rx_trig_bytes"
    file.parent.mkdir(parents=True)
    file.write_text("8\n")
    return file


def test_low_latency_mode_is_enough_for_ftdi(tmp_path: Path, timer: Path, descriptor: int) -> None:
    driver = Driver(timer=timer)
    tuning = Tuning("/nowhere/ttyUSB0", descriptor, SETTINGS, tmp_path, driver.ioctl)
    assert driver.flags == OTHER_FLAGS | LOW_LATENCY
    assert timer.read_text() == "1"
    assert tuning.done == ["low latency mode"]
    assert tuning.missed == []
    tuning.undo()
    assert driver.flags == OTHER_FLAGS
    assert timer.read_text() == "16\n"


def test_numbers_of_sysfs(tmp_path: Path, timer: Path, trigger: Path, descriptor: int) -> None:
    usb = Tuning("/nowhere/ttyUSB0", descriptor, SETTINGS, tmp_path, no_driver)
    uart = Tuning("/nowhere/ttyS0", descriptor, SETTINGS, tmp_path, no_driver)
    assert (timer.read_text(), trigger.read_text()) == ("1", "1")
    assert (usb.done, uart.done) == (["latency timer 16 -> 1 ms"], ["FIFO trigger 8 -> 1"])
    assert usb.missed == uart.missed == []
    usb.undo()
    uart.undo()
    assert (timer.read_text(), trigger.read_text()) == ("16", "8")


def test_a_link_to_a_port(tmp_path: Path, timer: Path, descriptor: int) -> None:
    by_id = tmp_path / "usb-FTDI-if00"
    by_id.symlink_to("/nowhere/ttyUSB0")
    Tuning(str(by_id), descriptor, SETTINGS, tmp_path, no_driver).undo()
    assert timer.read_text() == "16"  # written, so it was found


def test_what_is_best_already_is_let_be(tmp_path: Path, timer: Path, descriptor: int) -> None:
    timer.write_text("1\n")
    driver = Driver()
    driver.flags |= LOW_LATENCY
    tuning = Tuning("/nowhere/ttyUSB0", descriptor, SETTINGS, tmp_path, driver.ioctl)
    assert tuning.done == tuning.missed == []
    tuning.undo()
    assert driver.sets == 0
    assert driver.flags == OTHER_FLAGS | LOW_LATENCY
    assert timer.read_text() == "1\n"


def test_what_cannot_be_set_is_said_with_its_cost_and_cure(
    tmp_path: Path, timer: Path, trigger: Path, descriptor: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(file: Path, text: str) -> int:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(Path, "write_text", refuse)
    usb = Tuning("/nowhere/ttyUSB0", descriptor, SETTINGS, tmp_path, no_driver)
    uart = Tuning("/nowhere/ttyS0", descriptor, SETTINGS, tmp_path, no_driver)
    assert usb.done == uart.done == []
    (line,) = usb.missed
    assert line.startswith("/nowhere/ttyUSB0: its latency timer stays at 16 ms, so times are up to 16.0 ms late: ")
    assert f"`echo 1 | sudo tee {timer}`" in line
    assert 'ATTR{latency_timer}="1"' in line
    (line,) = uart.missed  # 8 - 2 + 4 characters of 11 bits at 9600 Bd are 11.46 ms
    assert line.startswith("/nowhere/ttyS0: its FIFO trigger stays at 8, so times are up to 11.5 ms late: ")
    assert f"`echo 1 | sudo tee {trigger}`" in line
    usb.undo()
    uart.undo()


@pytest.mark.parametrize(
    ("driver", "missed"),
    [
        (Driver(refuse=errno.EPERM), 1),
        (Driver(refuse=errno.EINVAL), 0),  # it has no such mode: nothing can be done about it
        (Driver(has_mode=False), 0),  # takes it and forgets it
    ],
)
def test_low_latency_mode_that_does_not_come(tmp_path: Path, descriptor: int, driver: Driver, missed: int) -> None:
    tuning = Tuning("/nowhere/ttyUSB0", descriptor, SETTINGS, tmp_path, driver.ioctl)
    assert tuning.done == []
    assert len(tuning.missed) == missed
    assert all("run sistap with sudo" in line and "\n" not in line for line in tuning.missed)
    tuning.undo()


def test_undone_when_the_port_has_gone(tmp_path: Path, timer: Path, descriptor: int) -> None:
    open_before = descriptors()
    driver = Driver()
    tuning = Tuning("/nowhere/ttyUSB0", descriptor, SETTINGS, tmp_path, driver.ioctl)
    timer.unlink()
    timer.parent.rmdir()
    driver._refuse = errno.EIO
    tuning.undo()
    tuning.undo()
    assert descriptors() <= open_before


FORGETFUL = """
import os, sys
from pathlib import Path
from sistap.tap.line.settings import LineSettings
from sistap.tap.line.reader.tuning import Tuning
Tuning("/nowhere/ttyUSB0", 0, LineSettings(), Path(sys.argv[1]))
print(Path(sys.argv[2]).read_text(), flush=True)
sys.stdin.read()
"""


def test_undone_at_the_end_of_the_program_at_the_latest(tmp_path: Path, timer: Path) -> None:
    child = subprocess.Popen(
        [sys.executable, "-c", FORGETFUL, tmp_path, timer],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    assert child.stdout and child.stdin
    assert child.stdout.readline() == "1\n"
    child.send_signal(signal.SIGINT)
    child.stdout.close()
    child.stdin.close()
    child.wait()
    assert timer.read_text() == "16"
