# SPDX-License-Identifier: GPL-2.0-or-later
"""A burst of signals in its first half second stops every command: at once, cleanly, without leaving anything.

Python itself takes some hundredths of a second before it imports sistap. From then on, as /proc shows, signals come at
random moments with a seed.
"""

from __future__ import annotations

import os
import pty
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import pytest
from logs import PHASE
from report_capture import BUS, write
from specification import TELEGRAMS
from usb_captures import STATUS, ftdi

PATIENCE_S = 60  # only reached when a test fails
BURST = 30
IMPORTING_S, RUNNING_S = (0.0, 0.15), (0.15, 0.5)  # as long as most commands import, and what then comes

# Each with files that make it last longer than that, if it does not wait for something anyway.
COMMANDS = {
    "ports": "ports",
    "capture": "capture -i PORT -w OUT --force",
    "report": "report CAPTURE -o OUT.html",
    "annotate": "annotate LOG",
    "annotate, page": "annotate LOG --format html",
    "annotate, pipe": "annotate -",
    "log": "log CAPTURE",
    "import": "import USB -w OUT --force",
    "doctor": "doctor",
    "selftest": "selftest --duration 3600",
    "extcap": "extcap --capture --extcap-interface sistap-demo --fifo OUT",
    "bus": "bus --listen FOLDER/socket",
    "bus, file": "bus -w OUT --force --cycles 1000000",
    "replay": "replay CAPTURE",
}
# One that captures, one that runs tshark, one that plays. The thorough tests try the rest.
FIRST = ("capture", "annotate", "bus")
REST = [name for name in COMMANDS if name not in FIRST]
CODES = {"doctor": {0, 1}}  # 1 if it has come to its end, and found something missing


class Place(NamedTuple):
    """Where commands run."""

    folder: Path
    temporary: Path  # that anybody may enter: root runs tshark as nobody


@pytest.fixture
def place(tmp_path: Path) -> Iterator[Place]:
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o711)
        yield Place(tmp_path, Path(folder))


def arguments(words: str, folder: Path, port: str) -> list[str]:
    """Make the files that a command needs."""
    if "CAPTURE" in words:
        write(folder / "CAPTURE", BUS * 100)
    if "LOG" in words:
        (folder / "LOG").write_text(f"{PHASE.hex(' ')}\n" * 5000)
    if "USB" in words:
        host = ftdi()
        for time_ms in range(100, 20_000, 10):
            host.receive(time_ms, time_ms + 1, STATUS + TELEGRAMS["2-12"])
        host.save(folder / "USB")
    return words.replace("FOLDER", str(folder)).replace("PORT", port).split()


def wait_until_it_knows_of_signals(process: subprocess.Popen[bytes]) -> None:
    """Return when a handler is installed, or the process has ended."""
    status = Path(f"/proc/{process.pid}/status")
    while process.poll() is None:
        caught = next((line for line in status.read_text().splitlines() if line.startswith("SigCgt:")), "SigCgt: 0")
        if int(caught.split()[1], 16) >> (signal.SIGTERM - 1) & 1:
            return


def wait_until_all_are_gone(group: int) -> None:
    """Return when no process is left: tshark was killed, and what that has started ends by itself."""
    end = time.monotonic() + PATIENCE_S
    with suppress(ProcessLookupError):
        while time.monotonic() < end:
            os.killpg(group, 0)
            time.sleep(0.01)
        pytest.fail("something still runs")


Send = Callable[[int, int], None]  # a signal to a process, or to all of its group, as Ctrl-C at a terminal does


def stopped(command: list[str], place: Place, delay_s: float, send: Send) -> tuple[int, str]:
    """Run sistap, and stop it after that time; return exit code and standard error."""
    process = subprocess.Popen(
        [sys.executable, "-m", "sistap", *command],
        cwd=place.folder,
        env=os.environ | {"TMPDIR": str(place.temporary)},
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    try:
        wait_until_it_knows_of_signals(process)
        time.sleep(delay_s)
        for number in range(BURST):
            if process.poll() is None:
                send(process.pid, (signal.SIGINT, signal.SIGTERM)[number % 2])
                time.sleep(0.001)
        _, said = process.communicate(timeout=PATIENCE_S)
        wait_until_all_are_gone(process.pid)
    finally:
        process.kill()
    return process.returncode, said.decode()


@pytest.mark.attack("30 signals in 30 ms", "ends cleanly: no traceback, no temporary file, no program still running")
@pytest.mark.parametrize("name", [*FIRST, *(pytest.param(name, marks=pytest.mark.thorough) for name in REST)])
def test_a_burst_of_signals_in_the_first_half_second(name: str, place: Place) -> None:
    master, slave = pty.openpty()
    command = arguments(COMMANDS[name], place.folder, os.ttyname(slave))
    draw = random.Random(name)
    for window, send in ((IMPORTING_S, os.kill), (RUNNING_S, os.kill), (RUNNING_S, os.killpg)):
        delay_s = draw.uniform(*window)
        for left in place.folder.glob("OUT*"):  # the burst before may have left it, and nothing is replaced
            left.unlink()
        code, said = stopped(command, place, delay_s, send)
        assert code in CODES.get(name, {0}), f"after {delay_s:.3f} s: {said}"
        assert "Traceback" not in said
        assert list(place.temporary.iterdir()) == []
        assert not (place.folder / "socket").exists()
    for descriptor in (master, slave):
        os.close(descriptor)
