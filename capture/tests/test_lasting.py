# SPDX-License-Identifier: GPL-2.0-or-later
"""Written data reach the disk by themselves: they are synchronised in time, in another thread."""

from __future__ import annotations

import errno
import os
import threading
from pathlib import Path
from queue import Empty, SimpleQueue

import pytest
from portable import descriptors

from sistap.tap.files import lasting
from sistap.tap.files.output import FileLimits, Output

pytestmark = pytest.mark.tap

PATIENCE_S = 60


class Disk:
    """Replaces the system's disk: the contents of each file when it was synchronised, and the thread."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.synced: SimpleQueue[tuple[str, bytes]] = SimpleQueue()
        self.threads: set[threading.Thread] = set()
        self.error: OSError | None = None
        self.takes = threading.Event()  # cleared: it does not answer
        self.takes.set()
        monkeypatch.setattr(os, "fdatasync", self._sync)
        monkeypatch.setattr(lasting, "PERIOD_S", 0.01)

    def _sync(self, descriptor: int) -> None:
        self.threads.add(threading.current_thread())
        path = Path(f"/proc/self/fd/{descriptor}").readlink()
        content = path.read_bytes()
        assert self.takes.wait(PATIENCE_S)
        self.synced.put((path.name, content))
        if self.error:
            raise self.error

    def wait_for(self, name: str, content: bytes) -> None:
        """Wait until a file was synchronised with this content."""
        try:
            while self.synced.get(timeout=PATIENCE_S) != (name, content):
                pass
        except Empty:
            pytest.fail(f"{name} was not synchronised with {content!r}")

    @property
    def is_idle(self) -> bool:
        return self.synced.empty()


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> Disk:
    return Disk(monkeypatch)


def test_what_is_written_reaches_the_disk_by_itself(tmp_path: Path, disk: Disk) -> None:
    output = Output(str(tmp_path / "x"))
    with output.lasting():
        output.begin()
        for content in (b"one", b"onetwo"):
            output.write(content[-3:])
            disk.wait_for("x", content)
    assert threading.main_thread() not in disk.threads
    output.close()


def test_the_rest_is_there_at_the_end(tmp_path: Path, disk: Disk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lasting, "PERIOD_S", PATIENCE_S)
    open_before = descriptors()
    output = Output(str(tmp_path / "x"))
    with output.lasting():
        output.begin()
        output.write(b"rest")
    assert disk.synced.get_nowait() == ("x", b"rest")
    output.close()
    assert descriptors() <= open_before


def test_all_files_of_a_ring(tmp_path: Path, disk: Disk) -> None:
    output = Output(str(tmp_path / "x"), FileLimits(size=1, several=True, keep=2))
    names = []
    with output.lasting():
        for number in range(4):
            names.append(Path(str(output)).name)
            output.begin()
            output.write(b"%d" % number)
            if number < 3:
                assert output.open_next()
                output.go_on()
                disk.wait_for(names[-1], b"%d" % number)
    disk.wait_for(names[-1], b"3")
    output.close()


def test_a_disk_that_takes_its_time_does_not_keep_the_writer(
    tmp_path: Path, disk: Disk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lasting, "PATIENCE_S", 0.01)
    disk.takes.clear()
    output = Output(str(tmp_path / "x"))
    with output.lasting():
        output.begin()
        for _ in range(100):
            output.write(b"x")
    output.close()
    assert disk.is_idle
    disk.takes.set()
    disk.wait_for("x", b"x" * 100)


def test_a_disk_in_trouble_is_told_once(tmp_path: Path, disk: Disk) -> None:
    disk.error = OSError(errno.EIO, "Input/output error")
    said: list[str] = []
    output = Output(str(tmp_path / "x"), say=said.append)
    with output.lasting():
        output.begin()
        for content in (b"1", b"12", b"123"):
            output.write(content[-1:])
            disk.wait_for("x", content)
        told = [f"{output}: Input/output error: a power cut can cost more than the last 1 s; capture to another disk"]
        assert said == told, "not only at the end"
    assert said == told
    output.close()


def test_a_file_system_without_a_disk_is_no_trouble(tmp_path: Path, disk: Disk) -> None:
    disk.error = OSError(errno.EINVAL, "Invalid argument")
    said: list[str] = []
    output = Output(str(tmp_path / "x"), say=said.append)
    with output.lasting():
        output.begin()
        output.write(b"1")
        disk.wait_for("x", b"1")
    assert said == []
    output.close()


def test_a_pipe_needs_no_disk(tmp_path: Path, disk: Disk) -> None:
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    output = Output(str(fifo))
    running = set(threading.enumerate())
    with output.lasting():
        assert set(threading.enumerate()) <= running
        output.begin()
        output.write(b"x")
    output.close()
    os.close(reader)
    assert disk.is_idle
