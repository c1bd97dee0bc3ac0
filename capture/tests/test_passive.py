# SPDX-License-Identifier: GPL-2.0-or-later
"""Proof that a capture only listens: the system calls of a whole one, and the modem lines of a port that has them."""

import fcntl
import os
import pty
import re
import select
import shutil
import signal
import struct
import subprocess
import sys
import termios
import time
import tty
from collections.abc import Callable
from pathlib import Path

import pytest

from sistap.tap.line.reader import latency, open_reader
from sistap.tap.line.settings import LineSettings

pytestmark = pytest.mark.tap

CAPTURE = Path(__file__).parents[1]
TELEGRAM = bytes.fromhex("02 D7 03 03 00 03 10 03 04 07 00")  # fig. 6-14
# All shall have 57600 Bd (checksum by hand), and accept it (fig. 6-24).
NEW_RATE = bytes.fromhex("02 DB 03 03 00 03 10 FF 00 07 04") + bytes.fromhex("02 E9 02 02 00 03 10 FF 00 FF")
PATIENCE_S = 60

# All that a capture may ask of a port. A list of what is allowed: so that a new way to drive a line is noticed.
ALLOWED = {
    *("TCGETS", "TCGETS2", "TCSETS", "TCSETS2", "TIOCMBIC", "TIOCGICOUNT", "FIONREAD", "TIOCINQ"),
    *("TIOCEXCL", "TIOCGEXCL"),  # nobody else can open the port
    *("TIOCGSERIAL", "TIOCSSERIAL"),  # low latency mode
}

needs_strace = pytest.mark.skipif(not shutil.which("strace"), reason="strace is not installed (apt install strace)")


def traced(command: list[str], trace: Path) -> list[str]:
    """Run a command on a pty that sends telegrams until it ends; return the system calls on that port."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    port = os.ttyname(slave)
    calls = "trace=write,writev,pwrite64,ioctl,openat,fdatasync"
    child = subprocess.Popen(
        ["strace", "-f", "-y", "-e", calls, "-o", trace, sys.executable, *[word.format(port=port) for word in command]],
        cwd=CAPTURE,
        stdin=subprocess.DEVNULL,
        start_new_session=True,  # so that strace and what it watches end together
    )
    ended = os.pidfd_open(child.pid)
    end = time.monotonic() + PATIENCE_S
    try:
        while not select.select([ended], [], [], 0.02)[0] and time.monotonic() < end:
            os.write(master, NEW_RATE + TELEGRAM)
    finally:
        if child.poll() is None:
            os.killpg(child.pid, signal.SIGKILL)
    assert child.wait() == 0
    for descriptor in (ended, master, slave):
        os.close(descriptor)
    lines = trace.read_text().splitlines()
    opened = [line for line in lines if re.search(rf'openat\(.*"{port}".* = \d', line)]
    assert opened, "strace did not see the port being opened"
    return [line for line in lines if re.search(rf"\(\d+<{port}>", line)]


def assert_only_listens(calls: list[str]) -> None:
    asked: set[str] = set()
    for call in calls:
        assert "write" not in call.split("(")[0], call
        if match := re.search(r"ioctl\(\d+<[^>]*>, ([^,)]+)", call):
            names = set(match[1].split(" or "))  # strace cannot tell TCSETS from SNDCTL_TMR_START
            assert names & ALLOWED or ("TCFLSH" in names and "TCIFLUSH" in call), call  # flushes its input only
            asked |= names
    assert "TIOCMBIC" in asked, "strace did not see the port being configured"


READ_SOME = """
import sys
from sistap.tap.line.settings import LineSettings
from sistap.tap.line.reader import open_reader
source = open_reader(sys.argv[1], LineSettings())
count = 0
while count < 100:
    read = source.read(1)
    count += len(read.data) if read else 0
source.close()
"""


@needs_strace
def test_reader_only_listens(tmp_path: Path) -> None:
    assert_only_listens(traced(["-c", READ_SOME, "{port}"], tmp_path / "trace"))


@needs_strace
@pytest.mark.parametrize("options", [[], ["--follow-baud"]])
def test_capture_only_listens(tmp_path: Path, options: list[str]) -> None:
    file = tmp_path / "capture.pcapng"
    command = ["-m", "sistap", "capture", "-i", "{port}", "-w", str(file), "-c", "6", *options]
    calls = traced(command, tmp_path / "trace")
    assert_only_listens(calls)
    assert TELEGRAM in file.read_bytes()
    assert re.search(rf"fdatasync\(\d+<{file}>\) += 0", (tmp_path / "trace").read_text())
    assert any("B57600" in call for call in calls) is bool(options)


TCGETS2, TIOCGICOUNT, TIOCGEXCL = 0x802C542A, 0x545D, 0x80045440  # Linux: <asm-generic/ioctls.h>


def test_tuning_changes_a_flag_of_the_driver_and_nothing_else(monkeypatch: pytest.MonkeyPatch) -> None:
    master, slave = pty.openpty()
    state = [bytes(range(0x40, 0x40 + 128))]
    changed: list[bytes] = []
    real = fcntl.ioctl

    def ioctl(fd: int, request: int, *rest: object) -> object:
        if request == termios.TIOCGSERIAL:  # a pty has none, a real port does
            return state[0]
        if request == termios.TIOCSSERIAL:
            assert isinstance(rest[0], bytes)
            state[0] = rest[0]
            changed.append(rest[0])
            return rest[0]
        assert request in (termios.TIOCMBIC, TCGETS2, TIOCGICOUNT, TIOCGEXCL, termios.TIOCEXCL)
        return real(fd, request, *rest)  # type: ignore[call-overload]

    before = state[0]
    monkeypatch.setattr(fcntl, "ioctl", ioctl)
    monkeypatch.setattr(latency, "measured_ns", lambda: 0)
    open_reader(os.ttyname(slave), LineSettings()).close()
    on, off = changed
    assert off == before
    assert [at for at in range(128) if on[at] != before[at]] == [17]  # of the flags, at 16, their second byte
    assert on[17] == before[17] | 0x20  # ASYNC_LOW_LATENCY, <linux/tty_flags.h>: bit 13
    for descriptor in (master, slave):
        os.close(descriptor)


def test_modem_lines_of_a_real_port_only_go_down(monkeypatch: pytest.MonkeyPatch) -> None:
    master, slave = pty.openpty()
    asked: list[tuple[int, int]] = []
    real = fcntl.ioctl
    modem = (termios.TIOCMGET, termios.TIOCMSET, termios.TIOCMBIS, termios.TIOCMBIC)

    def configure(fd: int, when: int, attributes: list[int], real: Callable[..., None] = termios.tcsetattr) -> None:
        assert asked, "configuring takes some adapters 40 ms: until then the lines would be up"
        real(fd, when, attributes)

    def ioctl(fd: int, request: int, *rest: object) -> object:
        if request in modem:  # a pty has no modem lines, a real port does
            assert isinstance(rest[0], bytes)
            asked.append((request, struct.unpack("I", rest[0])[0]))
            return rest[0]
        return real(fd, request, *rest)  # type: ignore[call-overload]

    monkeypatch.setattr(fcntl, "ioctl", ioctl)
    monkeypatch.setattr(termios, "tcsetattr", configure)
    monkeypatch.setattr(latency, "measured_ns", lambda: 0)
    source = open_reader(os.ttyname(slave), LineSettings())
    os.write(master, TELEGRAM)
    assert source.read(10)
    source.close()
    assert asked[0] == (termios.TIOCMBIC, termios.TIOCM_DTR | termios.TIOCM_RTS)
    assert {request for request, _ in asked} == {termios.TIOCMBIC}
    for descriptor in (master, slave):
        os.close(descriptor)
