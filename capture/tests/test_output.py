# SPDX-License-Identifier: GPL-2.0-or-later
"""Blocks into files and pipes: whole or not at all."""

from __future__ import annotations

import os
import re
import select
import stat
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from portable import descriptors, fifos, keep, modes, posix, take_over_zone, terminals

from sistap.tap.files.output import NO_LIMITS, FileLimits, Output, OutputError, OutputRefused, file_name
from sistap.tap.terminal.console import leave_standard_output, never_waiting

pytestmark = pytest.mark.tap

PATIENCE_S = 60  # never waited for unless something is broken

if sys.platform != "win32":
    import fcntl
    import pty
    import resource


def test_a_single_file_is_done_when_it_is_full(tmp_path: Path) -> None:
    output = Output(str(tmp_path / "x"), FileLimits(size=2))
    output.write(b"1")
    assert not output.done
    output.write(b"2")
    assert output.done
    output.close()


def test_a_file_without_contents_is_none_to_be_opened(tmp_path: Path) -> None:
    output = Output(str(tmp_path / "x"), FileLimits(size=2))
    assert output.written == "written to no file"
    output.close()


@contextmanager
def small_files() -> Iterator[None]:
    """Limit files to 1000 bytes, like a full disk.

    Use it only around the writing itself: the limit also applies to a file with the tests' own output.
    """
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@posix("no limit of the size of a file")
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


def test_no_space_left(full: Path) -> None:
    output = Output(str(full))
    output.begin()
    with pytest.raises(OutputError, match="/dev/full: No space left on device"):
        output.write(b"x")


def test_a_file_is_emptied_only_when_the_capture_begins(tmp_path: Path) -> None:
    path = tmp_path / "x"
    path.write_bytes(b"an older capture")
    Output(str(path), force=True).close()
    assert path.read_bytes() == b"an older capture"
    output = Output(str(path), force=True)
    output.begin()
    output.close()
    assert path.read_bytes() == b""


@pytest.mark.parametrize("limits", [NO_LIMITS, FileLimits(size=10)])
def test_a_file_that_holds_something_is_not_overwritten(tmp_path: Path, limits: FileLimits) -> None:
    path = tmp_path / "x"
    path.write_bytes(b"an older capture")
    with pytest.raises(OutputRefused, match="x holds data already: choose another file with -w, or overwrite it with"):
        Output(str(path), limits)
    assert path.read_bytes() == b"an older capture"
    path.write_bytes(b"")
    Output(str(path), limits).close()
    assert path.exists()


def test_a_new_file_is_gone_if_the_capture_does_not_begin(tmp_path: Path) -> None:
    path = tmp_path / "x"
    Output(str(path)).close()
    assert not path.exists()


@pytest.mark.parametrize("limits", [NO_LIMITS, FileLimits(duration_s=1, several=True)])
@pytest.mark.parametrize("name", ["{}/missing/x", "{}", "{}/.", "{}/..", ".", "/"])
def test_a_path_that_cannot_be_written_is_refused(tmp_path: Path, name: str, limits: FileLimits) -> None:
    with pytest.raises(OutputRefused, match="cannot be written: .*; choose another file with -w"):
        Output(name.format(tmp_path), limits)


@fifos
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


def test_a_file_has_no_reader_who_could_go(tmp_path: Path) -> None:
    output = Output(str(tmp_path / "x"))
    output.check()
    output.close()


@fifos
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
    thread.join(PATIENCE_S)
    assert not thread.is_alive()
    assert blocks >= 10
    os.close(reader)


@fifos
def test_a_block_larger_than_the_pipe_does_not_hold_up_a_stop(tmp_path: Path) -> None:
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    output = Output(str(fifo), stopped=lambda: True)
    refused: list[str] = []

    def write() -> None:
        try:
            output.write(bytes(1_000_000))
        except OutputError as error:
            refused.append(str(error))

    thread = threading.Thread(target=write, daemon=True)
    thread.start()
    thread.join(PATIENCE_S)
    assert refused == [f"{fifo} is not being read; the last records are missing in it"]
    os.close(reader)


@fifos
def test_a_large_block_comes_whole_through_a_pipe(tmp_path: Path) -> None:
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    os.set_blocking(reader, True)
    output = Output(str(fifo))
    block = os.urandom(1_000_000)

    def write() -> None:
        output.write(block)
        output.close()

    thread = threading.Thread(target=write, daemon=True)
    thread.start()
    with os.fdopen(reader, "rb") as stream:
        assert stream.read() == block
    thread.join()


def test_two_captures_do_not_write_one_file(tmp_path: Path) -> None:
    path = tmp_path / "x"
    first = Output(str(path))
    for force in (False, True):
        with pytest.raises(OutputRefused, match="x is being written by another capture; choose another file with -w"):
            Output(str(path), force=force)
    first.begin()
    first.write(b"abc")
    assert path.read_bytes() == b"abc"  # whoever reads it is not hindered
    first.close()
    Output(str(path), force=True).close()
    assert path.read_bytes() == b"abc"


@posix("no limit of the size of a file")
def test_only_a_file_that_was_there_stays_empty(tmp_path: Path) -> None:
    """A full disk at the very beginning."""
    new, old = tmp_path / "new", tmp_path / "old"
    old.touch()
    for path in (new, old):
        output = Output(str(path))
        output.begin()
        with pytest.raises(OutputError, match="File too large"), small_files():
            output.write(bytes(2000))
        output.close()
    assert [path.name for path in tmp_path.iterdir()] == ["old"]
    assert old.read_bytes() == b""


@posix("no limit for the size of files")
def test_files_that_do_not_stay_are_not_said_to_be_there(tmp_path: Path) -> None:
    """A full disk at the beginning of the only file, and of the third one."""
    output = Output(str(tmp_path / "x"))
    with pytest.raises(OutputError), small_files():
        output.write(bytes(2000))
    output.close()
    assert output.summary == "no file"

    for written, summary in ((1, "{0}"), (2, "2 files: {0} to {1}")):
        folder = tmp_path / str(written)
        folder.mkdir()
        ring = Output(str(folder / "y"), FileLimits(size=1, several=True))
        for _ in range(written):
            ring.begin()
            ring.write(b"x")
            assert ring.open_next()
            ring.go_on()
        with pytest.raises(OutputError), small_files():
            ring.write(bytes(2000))
        ring.close()
        assert ring.summary == summary.format(*sorted(folder.iterdir()))


@pytest.fixture
def utc(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("TZ", "UTC")
    take_over_zone()
    yield
    monkeypatch.undo()
    take_over_zone()


@modes
@pytest.mark.parametrize(("umask", "mode"), [(0, 0o640), (0o022, 0o640), (0o077, 0o600)])
def test_a_new_capture_is_read_by_its_owner_and_its_group_at_most(tmp_path: Path, umask: int, mode: int) -> None:
    """The umask of the user can only remove more rights; an existing file keeps its mode."""
    new, old = tmp_path / "new", tmp_path / "old"
    old.touch()
    old.chmod(0o664)
    before = os.umask(umask)
    try:
        for path in (new, old):
            Output(str(path)).write(b"x")
    finally:
        os.umask(before)
    assert [stat.S_IMODE(path.stat().st_mode) for path in (new, old)] == [mode, 0o664]


@posix("no locks")
def test_a_file_that_another_capture_writes_leaves_nothing_open(tmp_path: Path) -> None:
    first = Output(str(tmp_path / "x"))
    before = descriptors()
    with pytest.raises(OutputRefused):
        Output(str(tmp_path / "x"))
    assert descriptors() <= before
    first.close()


# -- Standard output ------------------------------------------------------------------------------------------------


@contextmanager
def standard_output(descriptor: int) -> Iterator[None]:
    """Let it be this for a while."""
    before = os.dup(1)
    os.dup2(descriptor, 1)
    try:
        yield
    finally:
        os.dup2(before, 1)
        os.close(before)
        os.close(descriptor)


def test_a_shell_may_append_a_capture_to_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    minus, path = tmp_path / "-", tmp_path / "x"
    minus.touch()  # a file, as any other: `-w -` does not mean it
    path.write_bytes(b"before, ")
    pieces: list[int] = []

    with standard_output(os.open(path, os.O_WRONLY | os.O_APPEND)):
        Output("-").close()
        output = Output("-")

        def write_some(data: memoryview, real: Callable[[memoryview], int] = output._file.write_some) -> int:
            pieces.append(len(data))
            return real(data)

        monkeypatch.setattr(output._file, "write_some", write_some)
        output.begin()
        output.write(b"x" * 100_000)
        output.close()
        assert str(output) == "standard output"
    assert path.read_bytes() == b"before, " + b"x" * 100_000
    assert pieces == [100_000]  # a block is one write
    assert minus.exists()


@posix("writing nothing fails nowhere")
def test_a_standard_output_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x").touch()
    refused = pytest.raises(OutputRefused, match="standard output cannot be written: Bad file descriptor")
    with standard_output(os.open(tmp_path / "x", os.O_RDONLY)), refused:
        Output("-")


def test_a_standard_output_that_was_left_takes_nothing_more() -> None:
    reader, writer = os.pipe()
    with standard_output(writer):
        leave_standard_output()
        assert os.write(1, b"x") == 1
    assert os.read(reader, 1) == b""
    os.close(reader)


@posix("a pipe always waits")
def test_a_pipe_is_written_as_it_is() -> None:
    reader, writer = os.pipe()
    copy = never_waiting(writer)
    os.write(copy, b"x")
    assert (os.read(reader, 2), os.get_blocking(copy)) == (b"x", True)
    for descriptor in (reader, writer, copy):
        os.close(descriptor)


@terminals
def test_a_terminal_is_written_without_waiting_and_keeps_its_mode() -> None:
    master, slave = pty.openpty()
    own = never_waiting(slave)
    os.write(own, b"x")
    assert os.read(master, 2) == b"x"
    assert (os.get_blocking(own), os.get_blocking(slave)) == (False, True)
    for descriptor in (master, slave, own):
        os.close(descriptor)


def test_two_captures_may_be_appended_to_one_file(tmp_path: Path) -> None:
    outputs = []
    for _ in range(2):
        with standard_output(os.open(tmp_path / "x", os.O_WRONLY | os.O_APPEND | os.O_CREAT)):
            outputs.append(Output("-"))
    for output in outputs:
        output.begin()
        output.write(b"x")
    assert (tmp_path / "x").read_bytes() == b"xx"


# -- Who reads a pipe slowly, or not at all -------------------------------------------------------------------------


class Announced:
    """Replaces poll: says whether a pipe accepts data, and remembers the requested time-out."""

    def __init__(self, output: Output, monkeypatch: pytest.MonkeyPatch, *takes: bool) -> None:
        self.waited_ms: list[float] = []
        self._takes = iter(takes)
        self._events = [(output._file.descriptor, select.POLLOUT)]
        monkeypatch.setattr(output._file, "_poll", self)

    def poll(self, wait_ms: float) -> list[tuple[int, int]]:
        self.waited_ms.append(wait_ms)
        return self._events if next(self._takes, True) else []


Pipe = tuple[Path, int]


@pytest.fixture
def pipe(tmp_path: Path) -> Iterator[Pipe]:
    """A named one, and its reading end, which waits."""
    path = tmp_path / "pipe"
    os.mkfifo(path)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    os.set_blocking(reader, True)
    yield path, reader
    os.close(reader)


@fifos
def test_it_waits_for_a_reader_a_tenth_of_a_second_at_a_time(pipe: Pipe, monkeypatch: pytest.MonkeyPatch) -> None:
    path, reader = pipe
    output = Output(str(path))
    announced = Announced(output, monkeypatch, False, False, True)
    output.write(b"abc")
    assert os.read(reader, 10) == b"abc"
    assert announced.waited_ms == [100] * 3


@fifos
def test_looking_for_the_reader_does_not_wait(pipe: Pipe, monkeypatch: pytest.MonkeyPatch) -> None:
    output = Output(str(pipe[0]))
    announced = Announced(output, monkeypatch, False)
    output.check()
    assert announced.waited_ms == [0]


@fifos
def test_a_stop_cuts_off_no_block_that_is_being_read(pipe: Pipe, monkeypatch: pytest.MonkeyPatch) -> None:
    path, reader = pipe
    output = Output(str(path), stopped=lambda: True)
    Announced(output, monkeypatch)
    block = os.urandom(100_000)

    def write() -> None:
        output.write(block)
        output.close()

    thread = threading.Thread(target=write, daemon=True)
    thread.start()
    received = b""
    while data := os.read(reader, 65536):
        received += data
    thread.join()
    assert received == block


@fifos
def test_a_terminal_that_promises_too_much_is_tried_again(pipe: Pipe, monkeypatch: pytest.MonkeyPatch) -> None:
    """A full pipe plays it: it says that it has room, and has none until somebody reads."""
    path, reader = pipe
    output = Output(str(path))
    descriptor = output._file.descriptor
    os.set_blocking(descriptor, False)  # as that of a terminal
    full = fcntl.fcntl(descriptor, fcntl.F_GETPIPE_SZ)
    assert os.write(descriptor, bytes(full)) == full

    class Promising(Announced):
        def poll(self, wait_ms: float) -> list[tuple[int, int]]:
            if len(self.waited_ms) == 3:
                assert os.read(reader, full) == bytes(full)
            return super().poll(wait_ms)

    promising = Promising(output, monkeypatch)
    begun = time.monotonic()
    output.write(b"abc")
    assert time.monotonic() - begun >= 0.03  # a hundredth of a second after each refusal
    assert os.read(reader, 10) == b"abc"
    assert len(promising.waited_ms) == 4


# -- Several files --------------------------------------------------------------------------------------------------


def test_names_are_those_of_dumpcap(utc: None) -> None:
    assert file_name("/a.b/day.pcapng", 1, 1_700_000_000) == str(Path("/a.b/day_00001_20231114221320.pcapng"))
    assert file_name("day", 23, 1_700_000_000) == "day_00023_20231114221320"
    assert file_name("day", 99_999, 1_700_000_000) == "day_99999_20231114221320"
    assert file_name("day", 100_000, 1_700_000_000) == "day_00000_20231114221320"


def test_a_capture_started_anew_in_the_same_second_empties_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(time, "time", lambda: 1_700_000_000.5)
    for content in (b"before", b"after"):
        output = Output(str(tmp_path / "x"), FileLimits(duration_s=5, several=True))
        output.begin()
        output.write(content)
        output.close()
    assert [path.read_bytes() for path in sorted(tmp_path.iterdir())] == [b"before", b"after"]


def test_several_files_and_only_the_newest_kept(tmp_path: Path) -> None:
    output = Output(str(tmp_path / "x.pcapng"), FileLimits(size=10, several=True, keep=2, files=4))
    output.begin()
    for number in range(1, 5):
        assert not output.full
        output.write(b"%d" % number * 10)
        assert output.full
        assert output.done == (number == 4)
        if number < 4:
            assert output.open_next()
            output.go_on()
            output.begin()
    output.close()
    files = sorted(tmp_path.iterdir())
    assert [file.read_bytes() for file in files] == [b"3" * 10, b"4" * 10]
    assert [bool(re.fullmatch(rf"x_0000{n}_\d{{14}}\.pcapng", f.name)) for n, f in zip((3, 4), files, strict=True)] == [
        True
    ] * 2


def test_a_file_is_full_after_its_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    output = Output(str(tmp_path / "x"), FileLimits(duration_s=5, several=True))
    output.begin()
    now = 104.9
    assert not output.full
    now = 105.0
    assert output.full and not output.done
    assert output.open_next()
    output.go_on()
    output.begin()
    assert not output.full
    output.close()


def ring(tmp_path: Path, said: list[str]) -> Output:
    """Two files are kept, a byte fills one."""
    output = Output(str(tmp_path / "x"), FileLimits(size=1, several=True, keep=2), say=said.append)
    output.begin()
    output.write(b"1")
    return output


def go_on(output: Output) -> None:
    assert output.open_next()
    output.go_on()
    output.begin()
    output.write(b"x")


def test_an_oldest_file_that_somebody_reads_in_windows_goes_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is said once. An immutable file stays."""
    said: list[str] = []
    output = ring(tmp_path, said)
    oldest = next(tmp_path.iterdir())
    with monkeypatch.context() as reading:
        keep(reading, oldest)
        for _ in range(4):
            go_on(output)
    assert said == [f"{oldest} cannot be deleted: it is read; each new file tries again"]
    assert sorted(file.name[:7] for file in tmp_path.iterdir()) == ["x_00001", "x_00004", "x_00005"]
    go_on(output)
    output.close()
    assert sorted(file.name[:7] for file in tmp_path.iterdir()) == ["x_00005", "x_00006"]


def test_the_summary_names_all_files_that_are_there(tmp_path: Path) -> None:
    output = ring(tmp_path, [])
    before = descriptors()
    base = re.escape(str(tmp_path / "x"))
    assert re.fullmatch(rf"{base}_00001_\d+", output.summary)
    go_on(output)
    assert re.fullmatch(rf"2 files: {base}_00001_\d+ to {base}_00002_\d+", output.summary)
    go_on(output)
    kept = rf"3 files, of which the last 2 were kept: {base}_00002_\d+ to {base}_00003_\d+"
    assert re.fullmatch(kept, output.summary)
    assert len(descriptors()) <= len(before)  # those of the files before are closed
    output.close()


def test_if_the_next_file_cannot_be_opened_this_one_is_the_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    output = ring(tmp_path, said)
    monkeypatch.setattr("sistap.tap.files.output.file_name", lambda *_: "/missing/x")
    assert not output.done
    assert not output.open_next()
    assert output.done and output.failed
    assert said == [
        "/missing/x cannot be written: No such file or directory; choose another file with -w; "
        "everything before it is saved"
    ]
    output.write(b"2")
    output.close()
    (file,) = tmp_path.iterdir()
    assert file.read_bytes() == b"12"
    assert output.summary == str(file)


@posix("it plays Windows, with a file for a pipe")
def test_a_pipe_of_windows_is_opened_but_never_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(OutputRefused, match="No such file"):
        Output(r"\\.\pipe\capture")
    assert not list(tmp_path.iterdir())
    pipe = tmp_path / r"\\.\pipe\capture"
    pipe.touch()
    Output(pipe.name).close()
    assert pipe.exists()  # it was not made here
