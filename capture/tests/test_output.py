# SPDX-License-Identifier: GPL-2.0-or-later
"""Blocks into files and pipes: whole or not at all."""

from __future__ import annotations

import os
import re
import resource
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from sistap.output import Limits, Output, OutputError, OutputRefused, file_name


@contextmanager
def small_files() -> Iterator[None]:
    """No file may grow above 1000 bytes: what a full disk does, without one.

    Only around the writing itself: it holds for a file that the tests' own output goes to, too.
    """
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_leaves_whole_blocks(tmp_path: Path) -> None:
    path = tmp_path / "x"
    output = Output(str(path))
    output.begin()
    for _ in range(3):
        output.write(b"x" * 300)
    refused = pytest.raises(OutputError, match="File too large; everything before it is saved")
    with refused, small_files():
        output.write(b"y" * 300)
    output.close()
    assert path.read_bytes() == b"x" * 900


def test_no_space_left() -> None:
    output = Output("/dev/full")
    output.begin()
    with pytest.raises(OutputError, match="/dev/full: No space left on device"):
        output.write(b"x")


def test_a_file_is_emptied_only_when_the_capture_begins(tmp_path: Path) -> None:
    path = tmp_path / "x"
    path.write_bytes(b"an older capture")
    Output(str(path)).discard()
    assert path.read_bytes() == b"an older capture"
    output = Output(str(path))
    output.begin()
    output.close()
    assert path.read_bytes() == b""


def test_a_new_file_is_gone_if_the_capture_does_not_begin(tmp_path: Path) -> None:
    path = tmp_path / "x"
    Output(str(path)).discard()
    assert not path.exists()


@pytest.mark.parametrize("name", ["missing/x", "."])
def test_a_path_that_cannot_be_written_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(OutputRefused, match="cannot be written: .*; choose another file with -w"):
        Output(str(tmp_path / name))


def test_the_reader_of_a_pipe_is_gone(tmp_path: Path) -> None:
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    output = Output(str(fifo))
    output.begin()
    output.write(b"abc")
    output.check()
    assert os.read(reader, 10) == b"abc"
    os.close(reader)
    with pytest.raises(OutputError, match="the reader of .* is gone"):
        output.check()
    with pytest.raises(OutputError, match="the reader of .* is gone"):
        output.write(b"def")


def test_a_pipe_that_nobody_reads_does_not_hold_up_a_stop(tmp_path: Path) -> None:
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    stop = threading.Event()
    output = Output(str(fifo), stopped=stop.is_set)
    blocks = 0

    def write() -> None:
        nonlocal blocks
        with pytest.raises(OutputError, match="is not being read"):
            while True:
                output.write(bytes(4096))
                blocks += 1
                if blocks == 10:
                    stop.set()

    thread = threading.Thread(target=write, daemon=True)
    thread.start()
    thread.join(20)
    assert not thread.is_alive()
    assert blocks >= 10
    os.close(reader)


@pytest.fixture
def utc(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("TZ", "UTC")
    time.tzset()
    yield
    monkeypatch.undo()
    time.tzset()


def test_names_are_those_of_dumpcap(utc: None) -> None:
    assert file_name("/a.b/day.pcapng", 1, 1_700_000_000) == "/a.b/day_00001_20231114221320.pcapng"
    assert file_name("day", 23, 1_700_000_000) == "day_00023_20231114221320"
    assert file_name("day", 100_001, 1_700_000_000) == "day_00001_20231114221320"


def test_several_files_and_only_the_newest_kept(tmp_path: Path) -> None:
    output = Output(str(tmp_path / "x.pcapng"), Limits(size=10, several=True, keep=2, files=4))
    output.begin()
    for number in range(1, 5):
        assert not output.full
        output.write(b"%d" % number * 10)
        assert output.full
        assert output.done == (number == 4)
        if number < 4:
            output.next_file()
    output.close()
    files = sorted(tmp_path.iterdir())
    assert [file.read_bytes() for file in files] == [b"3" * 10, b"4" * 10]
    assert [bool(re.fullmatch(rf"x_0000{n}_\d{{14}}\.pcapng", f.name)) for n, f in zip((3, 4), files, strict=True)] == [
        True
    ] * 2


def test_a_file_is_full_after_its_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    output = Output(str(tmp_path / "x"), Limits(duration_s=5, several=True))
    output.begin()
    now = 104.9
    assert not output.full
    now = 105.0
    assert output.full and not output.done
    output.next_file()
    assert not output.full
    output.close()
