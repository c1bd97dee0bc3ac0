# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap capture`: in this process with a simulated reader, then as users run it, on a pseudo terminal."""

from __future__ import annotations

import errno
import os
import re
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from independent import blocks, records
from pcapng.blocks import EnhancedPacket, InterfaceStatistics
from portable import NO_TSHARK, SIGNALS, WINDOWS, libpcap, posix, terminals
from specification import TELEGRAMS

from sistap import cli
from sistap.dissected.explain import live
from sistap.dissected.explain.plain import PlainText
from sistap.tap.capture import running as capture_ports
from sistap.tap.capture import session
from sistap.tap.capture.tap import Conditions
from sistap.tap.files.output import Output
from sistap.tap.files.pcapng import Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.line import others, ports
from sistap.tap.line.clock import Clock
from sistap.tap.line.others import Others
from sistap.tap.line.reader import PortError, PortLost, latency
from sistap.tap.line.settings import ERROR_FLAGS, Flag, LineSettings, Read
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Event, Framing, Type
from sistap.tap.sis.telegram import checksum_good
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.stop import Stop

pytestmark = pytest.mark.tap

if sys.platform != "win32":
    import fcntl
    import pty
    import resource
    import termios
    import tty

    from sistap.tap.line.reader.several import PolledReaders

START_NS = 1_700_000_000_000_000_000
ALL = list(TELEGRAMS.values())
DEADLINE_S = 60  # only reached when a test fails


class FakeReader:
    """Returns scripted reads, then nothing, and at last SIGTERM to this process, or the loss of the port."""

    name = "/dev/ttyFAKE"
    adapter = "adapter of a test (latency timer 1 ms)"
    timing = "uncertainty 1 ms"
    notes: tuple[str, ...] = ()
    line = 0

    def __init__(self, reads: list[Read], lost: str = "") -> None:
        self.settings = LineSettings()
        self.closed = False
        self._reads = iter(reads)
        self._lost = lost

    def read(self, timeout_s: float) -> Read | None:
        assert timeout_s <= 0.1
        read = next(self._reads, None)
        if read is None:
            if self._lost:
                raise PortLost(self._lost)
            signal.raise_signal(signal.SIGTERM)
        return read

    def change(self, settings: LineSettings) -> None:
        self.settings = settings

    def close(self) -> None:
        self.closed = True


def reads(*pieces: bytes, line: int = 0, flag: int = 0) -> list[Read]:
    return [
        Read(line, START_NS + i * 10_000_000, piece, bytes([flag]) * len(piece), 1000) for i, piece in enumerate(pieces)
    ]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> Callable[..., int]:
    """Run the command with a simulated reader."""

    def run(reader: FakeReader, *arguments: str) -> int:
        def open_reader(port: str, settings: LineSettings, line: int) -> FakeReader:
            reader.settings = settings
            return reader

        monkeypatch.setattr(capture_ports, "open_reader", open_reader)
        return cli.main(["capture", "-i", reader.name, *arguments])

    return run


Run = Callable[..., int]


def frames(path: Path) -> list[bytes]:
    return [record.data for record in records(path) if record.type == Type.FRAME]


# -- In this process ------------------------------------------------------------------------------------------------


def test_the_first_record_says_how_the_file_was_taken(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "x.pcapng"
    assert run(FakeReader([]), "-w", str(path), "--baud", "19200", "--format", "8N1") == 0
    (record,) = records(path)
    assert (record.type, record.event) == (Type.EVENT, Event.CAPTURE_STARTED)
    assert record.settings == LineSettings(19200, 8, "N", 2)
    for part in (FakeReader.name, FakeReader.adapter, FakeReader.timing, "19200 Bd 8N1"):
        assert part in record.data.decode()


def test_what_makes_the_times_worse_is_said_once_each(
    run: Run, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    reader = FakeReader([])
    reader.notes = ("its latency timer stays at 16 ms", "the self-test does not hold here")
    assert run(reader, "-w", str(tmp_path / "x")) == 0
    started, *notes, _ = capfd.readouterr().err.splitlines()
    assert started.startswith("sistap: capturing on ")  # first, for scripts that wait for it
    assert notes == [f"sistap: {note}" for note in reader.notes]


@posix("no real-time priority")
def test_a_capture_runs_with_real_time_priority_and_leaves_it(
    run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    policy, asked = [os.SCHED_OTHER], []

    def setscheduler(pid: int, new: int, parameter: os.sched_param) -> None:
        policy[0] = new
        asked.append((pid, new, parameter.sched_priority))

    monkeypatch.setattr(os, "sched_getscheduler", lambda pid: policy[0])
    monkeypatch.setattr(os, "sched_setscheduler", setscheduler)

    class Reader(FakeReader):
        def read(self, timeout_s: float) -> Read | None:
            assert policy == [os.SCHED_FIFO]
            return super().read(timeout_s)

    assert run(Reader(reads(*ALL), lost="gone"), "-w", str(tmp_path / "x")) == 1
    assert asked == [(0, os.SCHED_FIFO, 1), (0, os.SCHED_OTHER, 0)]  # sched(7): 1 is the smallest


@posix("no real-time priority")
def test_a_capture_runs_without_real_time_priority_too(
    run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    def refuse(pid: int, new: int, parameter: os.sched_param) -> None:
        raise PermissionError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    assert run(FakeReader(reads(*ALL)), "-w", str(tmp_path / "x"), "-q") == 0
    assert frames(tmp_path / "x") == ALL
    assert len(capfd.readouterr().err.splitlines()) == 1  # the summary


@pytest.mark.thorough
@terminals
@pytest.mark.parametrize("number", SIGNALS)
def test_a_port_is_put_back_when_a_signal_ends_a_capture(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, number: signal.Signals
) -> None:
    master, slave = pty.openpty()
    tty.setraw(slave)
    timer = tmp_path / "bus/usb-serial/devices" / Path(os.ttyname(slave)).name / "latency_timer"
    timer.parent.mkdir(parents=True)
    timer.write_text("16\n")
    monkeypatch.setattr(ports, "SYSFS", tmp_path)
    monkeypatch.setattr(latency, "measured_ns", lambda: 0)

    def read(reader: PolledReaders, timeout_s: float) -> None:
        assert timer.read_text() == "1"
        signal.raise_signal(number)

    monkeypatch.setattr(PolledReaders, "read", read)
    assert cli.main(["capture", "-i", os.ttyname(slave), "-q"]) == 0
    assert timer.read_text() == "16"
    for descriptor in (master, slave):
        os.close(descriptor)


def test_everything_is_written_and_counted(run: Run, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "x.pcapng"
    damaged = ALL[0][:-1] + b"\xff"
    what = [*reads(*ALL, damaged, b"text"), *reads(b"lost", flag=Flag.LOST_BEFORE)]
    reader = FakeReader(what)
    assert run(reader, "-w", str(path)) == 0
    assert reader.closed
    assert b"".join(r.data for r in records(path)[1:]) == b"".join(read.data for read in what)
    assert frames(path) == [*ALL, damaged]
    (statistics,) = (block for block in blocks(path) if isinstance(block, InterfaceStatistics))
    # The 18 telegrams, the damaged one, and the other characters in one record; each of "lost" has a gap before it.
    assert statistics.options["isb_ifrecv"] == statistics.options["isb_filteraccept"] == 20
    assert statistics.options["isb_osdrop"] == 4
    characters = sum(len(read.data) for read in what)
    counted = f"19 telegrams, 1 of them damaged, {characters} characters, 4 faulty characters"
    assert capfd.readouterr().err.endswith(
        f"sistap: 20 records ({counted}) written to {path}; open it with: wireshark -C SIS {path}\n"
    )


def test_where_no_errors_are_reported_none_are_counted(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(FakeReader, "timing", "uncertainty 1 ms; no line errors are reported")
    path = tmp_path / "x.pcapng"
    assert run(FakeReader(reads(b"abc")), "-w", str(path)) == 0
    assert "(0 telegrams, 0 of them damaged, 3 characters, no line errors are reported)" in capfd.readouterr().err
    assert "no line errors are reported" in records(path)[0].data.decode()


@pytest.mark.attack(
    "the disk becomes full at different moments", "only whole packets are saved; the last line on stderr counts them"
)
@pytest.mark.parametrize("room", [600, 1500, 3000, 4097])
@pytest.mark.parametrize("options", [(), pytest.param(("-f", "link[5] != 0x03"), marks=libpcap), ("-b", "filesize:1")])
def test_what_a_full_disk_leaves_is_what_the_summary_counts(
    run: Run,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    options: tuple[str],
    room: int,
) -> None:
    left = [room]

    def write(descriptor: int, data: memoryview) -> int:
        if not left[0]:
            raise OSError(errno.ENOSPC, "No space left on device")
        count = min(len(data), left[0])
        left[0] -= count
        return write_really(descriptor, data[:count])

    write_really = os.write
    monkeypatch.setattr("sistap.tap.files.output._OpenFile.write_some", lambda file, data: write(file.descriptor, data))
    damaged = ALL[0][:-1] + b"\xff"
    what = [*reads(*ALL, damaged), *reads(b"lost", flag=Flag.LOST_BEFORE), *reads(*ALL * 4)]
    assert run(FakeReader(what), "-w", str(tmp_path / "x.pcapng"), *options) == 1
    said = capfd.readouterr().err.splitlines()[-1]
    there = sorted(tmp_path.iterdir())
    taken = [record for path in there for record in records(path) if record.type in (Type.FRAME, Type.OTHER)]
    good = sum(checksum_good(record.data) for record in taken if record.type == Type.FRAME)
    faults = sum(bool(flags & ERROR_FLAGS) for record in taken for flags in record.flags)
    wrong = sum(record.type == Type.FRAME for record in taken) - good
    numbers = [int(number) for number in re.findall(r"\d+", said.partition(" written to ")[0])]
    of_received = [numbers.pop(1)] if re.search(r"\d of \d", said) else []
    assert numbers == [len(taken), good + wrong, wrong, sum(len(record.data) for record in taken), faults]
    assert all(number > len(taken) for number in of_received)
    names = [str(path) for path in there]
    one = f"{names[0]}; open it with: wireshark -C SIS {names[0]}"
    written_to = one if len(names) == 1 else f"{len(names)} files: {names[0]} to {names[-1]}"
    assert said.endswith(f" written to {written_to}")


def test_two_directions_are_two_interfaces(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "x.pcapng"
    command, reaction = TELEGRAMS["8-20"], TELEGRAMS["8-21"]
    # Character by character in turn: each line has a framer of its own.
    mixed = [
        read
        for i in range(10)
        for line, telegram in ((1, command), (2, reaction))
        for read in reads(telegram[i : i + 1], line=line)
        if read.data
    ]
    assert run(FakeReader(mixed), "-w", str(path)) == 0
    assert [(r.line, r.data) for r in records(path)[1:]] == [(1, command), (2, reaction)]
    packets = [block for block in blocks(path) if isinstance(block, EnhancedPacket)]
    assert [packet.interface_id for packet in packets] == [0, 1, 2]


def test_c_counts_records_that_were_written(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "x.pcapng"
    assert run(FakeReader(reads(b"".join(ALL))), "-w", str(path), "-c", "3") == 0
    assert frames(path) == ALL[:3]


@libpcap
def test_c_counts_records_that_a_filter_leaves(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "x.pcapng"
    assert run(FakeReader(reads(*ALL)), "-w", str(path), "-c", "2", "-f", "link[5] == 0x9d") == 0
    assert frames(path) == [TELEGRAMS["8-23"], TELEGRAMS["8-24"]]


@libpcap
def test_a_filter_lets_other_characters_and_events_pass(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "x.pcapng"
    assert run(FakeReader(reads(b"text", *ALL)), "-w", str(path), "-f", "link[5] == 0x04") == 0
    assert [r.type for r in records(path)] == [Type.EVENT, Type.OTHER, Type.FRAME, Type.FRAME]
    (statistics,) = (block for block in blocks(path) if isinstance(block, InterfaceStatistics))
    assert (statistics.options["isb_ifrecv"], statistics.options["isb_filteraccept"]) == (19, 3)


def test_framing_by_silence(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "x.pcapng"
    assert run(FakeReader(reads(b"abc", b"def")), "-w", str(path), "--framing", "silence:5") == 0
    assert [(r.framing, r.data) for r in records(path)[1:]] == [(Framing.SILENCE, b"abc"), (Framing.SILENCE, b"def")]
    assert "5 ms of silence" in records(path)[0].data.decode()


def test_filesize_stops(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "x.pcapng"
    assert run(FakeReader(reads(*ALL * 5)), "-w", str(path), "-a", "filesize:1") == 0
    count = len(frames(path))
    size = path.stat().st_size
    statistics_size = 12 + 4 + 8 + 5 * 12 + 4  # block, interface, time, five options of 8 bytes, their end
    assert frames(path) == (ALL * 5)[:count]
    # At least 1000 bytes before the statistics; and the last packet (at most 400 bytes) was needed to reach them.
    assert 1000 <= size - statistics_size < 1400


def test_ring_files_begin_with_the_event_and_end_with_statistics(run: Run, tmp_path: Path) -> None:
    what = reads(*ALL * 3)
    assert run(FakeReader(what), "-w", str(tmp_path / "x.pcapng"), "-b", "filesize:2", "-b", "files:2") == 0
    files = sorted(tmp_path.iterdir())
    assert len(files) == 2
    for file in files:
        first, *_ = records(file)
        assert first.event == Event.CAPTURE_STARTED
        assert isinstance(blocks(file)[-1], InterfaceStatistics)
    kept = [data for file in files for data in frames(file)]
    assert kept == (ALL * 3)[-len(kept) :]


def test_limits_that_the_user_tells_are_in_each_file(run: Run, tmp_path: Path) -> None:
    arguments = ("-w", str(tmp_path / "x.pcapng"), "-b", "filesize:2", "--tza", "8", "--trs", "40")
    assert run(FakeReader(reads(*ALL * 3)), *arguments) == 0
    files = sorted(tmp_path.iterdir())
    assert len(files) > 1
    for file in files:
        _, told, *rest = records(file)
        assert (told.event, told.data) == (Event.LIMITS_TOLD, b"TzA = 8 ms, TrS = 40 ms")
        assert (rest[0].type == Type.BEFORE) == (file != files[0])
        assert all(record.event == Event.NONE for record in rest)


def test_files_stops(run: Run, tmp_path: Path) -> None:
    base = str(tmp_path / "x.pcapng")
    assert run(FakeReader(reads(*ALL * 9)), "-w", base, "-b", "filesize:1", "-a", "files:3") == 0
    files = sorted(tmp_path.iterdir())
    assert [file.name[:7] for file in files] == ["x_00001", "x_00002", "x_00003"]
    kept = [data for file in files for data in frames(file)]
    assert kept == (ALL * 9)[: len(kept)]


def test_a_ring_file_has_the_statistics_of_what_is_in_it(run: Run, tmp_path: Path) -> None:
    what = reads(*ALL * 3)
    assert run(FakeReader(what), "-w", str(tmp_path / "x.pcapng"), "-b", "filesize:2") == 0
    files = sorted(tmp_path.iterdir())
    assert len(files) > 2
    written = 0
    for file in files:
        written += len(frames(file))
        (statistics,) = (block for block in blocks(file) if isinstance(block, InterfaceStatistics))
        assert statistics.options["isb_ifrecv"] == statistics.options["isb_filteraccept"] == written


@pytest.mark.parametrize("arguments", [["-c", "5"], ["--link-type", "rtac"]])
def test_accepted_is_what_was_written(run: Run, tmp_path: Path, arguments: list[str]) -> None:
    path = tmp_path / "x.pcapng"
    assert run(FakeReader(reads(b"text" + b"".join(ALL))), "-w", str(path), *arguments) == 0
    (statistics,) = (block for block in blocks(path) if isinstance(block, InterfaceStatistics))
    packets = sum(isinstance(block, EnhancedPacket) for block in blocks(path))
    events = 0 if "rtac" in arguments else 1
    assert statistics.options["isb_ifrecv"] == 1 + len(ALL)
    assert statistics.options["isb_filteraccept"] == packets - events


class SilentReader(FakeReader):
    """Nothing comes; a tenth of a second passes at each read."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, count: int = 1000) -> None:
        super().__init__([])
        self.now = 100.0
        self.count = count
        monkeypatch.setattr("sistap.tap.files.output.time.monotonic", lambda: self.now)

    def read(self, timeout_s: float) -> Read | None:
        self.now += 0.1
        self.count -= 1
        return super().read(timeout_s) if self.count < 0 else None


def test_files_change_on_a_silent_line(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    reader = SilentReader(monkeypatch)
    assert run(reader, "-w", str(tmp_path / "x"), "-b", "duration:2", "-a", "files:3") == 0
    files = sorted(tmp_path.iterdir())
    assert [file.name[:7] for file in files] == ["x_00001", "x_00002", "x_00003"]
    assert 106 <= reader.now < 107
    for file in files:
        assert [record.event for record in records(file)] == [Event.CAPTURE_STARTED]
        assert isinstance(blocks(file)[-1], InterfaceStatistics)


def test_a_file_does_not_change_inside_a_telegram(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its first character would be older than the beginning of its file."""

    class Reader(SilentReader):
        def read(self, timeout_s: float) -> Read | None:
            super().read(timeout_s)
            return next(self._reads, None)

    reader = Reader(monkeypatch, count=30)
    reader._reads = iter([*reads(ALL[0][:5]), None, *reads(ALL[0][5:])])  # type: ignore[list-item]
    assert run(reader, "-w", str(tmp_path / "x"), "-b", "duration:0.15") == 0
    for file in tmp_path.iterdir():
        packets = [block for block in blocks(file) if isinstance(block, EnhancedPacket)]
        times = [packet.timestamp_high << 32 | packet.timestamp_low for packet in packets]
        assert times == sorted(times)
    assert [data for file in sorted(tmp_path.iterdir()) for data in frames(file)] == [ALL[0]]


def test_if_the_next_file_cannot_be_opened_all_is_in_the_one_before(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "x"
    names = iter([str(path), "/missing/x"])
    monkeypatch.setattr("sistap.tap.files.output.file_name", lambda *_: next(names))
    what = reads(b"".join(ALL), b"text")
    assert run(FakeReader(what), "-w", str(path), "-b", "filesize:1") == 1
    assert b"".join(record.data for record in records(path)[1:]) in (b"".join(ALL), b"".join(ALL) + b"text")
    assert isinstance(blocks(path)[-1], InterfaceStatistics)
    err = capfd.readouterr().err
    assert "/missing/x cannot be written: No such file or directory" in err
    assert err.endswith(f"written to {path}; open it with: wireshark -C SIS {path}\n")


def test_what_had_arrived_before_a_stop_is_saved(run: Run, tmp_path: Path) -> None:
    class Stopped(FakeReader):
        def read(self, timeout_s: float) -> Read | None:
            if timeout_s:
                signal.raise_signal(signal.SIGTERM)
                return None
            if waiting := next(self._reads, None):
                return waiting
            raise PortLost("/dev/ttyFAKE is gone")  # at the same time, by the same Ctrl-C

    path = tmp_path / "x"
    assert run(Stopped(reads(*ALL)), "-w", str(path)) == 0
    assert frames(path) == ALL


@posix("names are UTF-16")
def test_names_that_are_not_utf_8(run: Run, tmp_path: Path) -> None:
    path = tmp_path / os.fsdecode(b"\xff.pcapng")
    reader = FakeReader(reads(*ALL))
    reader.name = os.fsdecode(b"/dev/tty\xff")
    assert run(reader, "-w", str(path)) == 0
    assert frames(path) == ALL
    assert "/dev/tty\\udcff" in records(path)[0].data.decode()


def test_a_lost_port_saves_what_came(run: Run, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "x.pcapng"
    reader = FakeReader(reads(ALL[0], ALL[1][:5]), lost="/dev/ttyFAKE is gone: plug it in again")
    assert run(reader, "-w", str(path)) == 1
    types = [(r.type, r.event) for r in records(path)]
    assert types == [
        (Type.EVENT, Event.CAPTURE_STARTED),
        (Type.FRAME, Event.NONE),
        (Type.OTHER, Event.NONE),
        (Type.EVENT, Event.ADAPTER_LOST),
    ]
    assert isinstance(blocks(path)[-1], InterfaceStatistics)
    err = capfd.readouterr().err
    assert "sistap: /dev/ttyFAKE is gone: plug it in again\n" in err
    counted = f"1 telegrams, 0 of them damaged, {len(ALL[0]) + 5} characters"  # the text of an event has none
    assert f"sistap: 2 records ({counted}, " in err


def test_without_w_each_telegram_and_what_it_is(
    run: Run, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live, "PATIENCE_S", DEADLINE_S)  # of a busy machine
    assert run(FakeReader(reads(*ALL)), "-q") == 0
    out, err = capfd.readouterr()
    assert out.count("\n") == 2 * len(ALL) and out.count("  ^-- ") == len(ALL)
    assert err == ""


def test_without_w_nor_tshark_a_line_per_telegram(
    run: Run, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert run(FakeReader(reads(*ALL)), "-q") == 0
    out, err = capfd.readouterr()
    assert out.count("\n") == len(ALL) and out.count("checksum ok") == len(ALL)
    assert err.startswith(f"sistap: {NO_TSHARK[0]}") and err.count("\n") == 1


def test_a_port_that_does_not_open_leaves_the_old_file(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    def open_reader(port: str, settings: LineSettings, line: int) -> FakeReader:
        raise PortError(f"{port} does not exist: try another")

    monkeypatch.setattr(capture_ports, "open_reader", open_reader)
    path = tmp_path / "x"
    path.write_bytes(b"old")
    assert cli.main(["capture", "-i", "/dev/x", "-w", str(path), "--force"]) == 3
    assert path.read_bytes() == b"old"
    assert capfd.readouterr().err == "sistap: /dev/x does not exist: try another\n"


@pytest.mark.parametrize(
    ("options", "code", "says"),
    [
        ([], 3, "/dev/x does not exist: try another"),
        pytest.param(["-f", "link[5] ="], 2, "filter 'link[5] ='", marks=libpcap),
        (["--tza", "2", "--framing", "ascii"], 2, "--tza and --trs are kept only with SIS"),
    ],
)
def test_whoever_reads_the_pipe_learns_why_there_is_no_capture(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capfdbinary: pytest.CaptureFixture[bytes],
    options: list[str],
    code: int,
    says: str,
) -> None:
    def open_reader(port: str, settings: LineSettings, line: int) -> FakeReader:
        raise PortError(f"{port} does not exist: try another")

    monkeypatch.setattr(capture_ports, "open_reader", open_reader)
    assert cli.main(["capture", "-i", "/dev/x", "-w", "-", *options]) == code
    out, err = capfdbinary.readouterr()
    path = tmp_path / "x"
    path.write_bytes(out)
    (told,) = records(path)
    assert told.event == Event.MARKER and says in told.data.decode()
    assert err.decode() == f"sistap: {told.data.decode()}\n"


def test_an_older_capture_is_overwritten_only_by_force(
    run: Run, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "x.pcapng"
    assert run(FakeReader(reads(*ALL)), "-w", str(path)) == 0
    older = path.read_bytes()
    capfd.readouterr()
    assert run(FakeReader(reads(*ALL[:1])), "-w", str(path)) == 2
    assert (path.read_bytes(), capfd.readouterr().err.count("\n")) == (older, 1)
    assert run(FakeReader(reads(*ALL[:1])), "-w", str(path), "--force") == 0
    assert frames(path) == ALL[:1]


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["--format", "9E1"], "format '9E1' is not"),
        pytest.param(["-f", "link[5"], "filter 'link[5': can't parse filter expression: syntax error", marks=libpcap),
        (["-w", "/missing/x"], "/missing/x cannot be written: No such file or directory"),
        pytest.param(["-w", "/dev/ttyFAKE/."], "cannot be written", marks=posix("no /dev")),
        (["-w", "-", "-b", "duration:5"], "-b needs files"),
        (["-b", "duration:5"], "need a file"),
        (["-w", "x", "-b", "files:5"], "-b files: does not say when a file is full"),
        (["-w", "x", "-a", "files:5"], "-a files: needs several files"),
        (["--link-type", "rtac"], "need a file"),
        (["--link-type", "rtac", "-w", "x", "--tza", "8"], "--tza and --trs are kept only with"),
        (["--framing", "3964r", "--trs", "8"], "--tza and --trs are kept only with"),
        (["-w", ".", "-b", "duration:1"], "cannot be written: Is a directory"),
        (["-w", "/", "-b", "duration:1"], "cannot be written: Is a directory"),
    ],
)
def test_wrong_options_are_one_line(
    run: Run, arguments: list[str], text: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(FakeReader([]), *arguments) == 2
    err = capfd.readouterr().err
    assert text in err and err.count("\n") == 1


@pytest.mark.parametrize(
    "arguments",
    [
        ["nonsense"],
        ["capture", "-i", "x", "-c", "0"],
        ["capture", "-i", "x", "-a", "duration:-1"],
        ["capture", "-i", "x", "-a", "duration:nan"],
        ["capture", "-i", "x", "-b", "nonsense:1"],
        ["capture", "-i", "x", "--framing", "silence:"],
        ["capture", "-i", "x", "--link-type", "user16"],
        ["capture", "-i", "x", "--baud", "fast"],
        ["capture", "-i", "x", "--tza", "0"],
        ["capture", "-i", "x", "--tza", "8.5"],
        ["capture", "-i", "x", "--trs", "65536"],
        ["capture", "-i", "x", "--baud", "4294967296"],
        ["capture", "-i", "x", "-a", "duration:1e300"],
        ["capture", "-i", "x", "--framing", "silence:1e305"],
        ["capture", "-i", "x", "-i", "y", "-i", "z"],
        ["capture", "-i", "x", "-w", "y", "-w", "z"],
        ["capture", "-i", "x", "-w", ""],
        ["capture", "-i", ""],
    ],
)
def test_wrong_usage(run: Run, arguments: list[str], capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        cli.main(arguments)
    assert end.value.code == 2
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.thorough
@pytest.mark.parametrize("descriptor", [0, 1, 2])
def test_the_port_must_not_be_the_terminal_it_runs_in(tap: Tap, descriptor: int) -> None:
    streams = [subprocess.DEVNULL, subprocess.DEVNULL, subprocess.DEVNULL]
    streams[descriptor] = tap.slave
    command = [sys.executable, "-m", "sistap", "capture", "-i", tap.port]
    process = subprocess.Popen(command, stdin=streams[0], stdout=streams[1], stderr=streams[2])
    try:
        assert process.wait(DEADLINE_S) == 2
    finally:
        process.kill()


def test_dev_tty_is_the_terminal_it_runs_in(tap: Tap) -> None:
    def own_terminal() -> None:
        os.setsid()
        fcntl.ioctl(tap.slave, termios.TIOCSCTTY, 0)

    port, tap.port = tap.port, "/dev/tty"
    tap.start(stdin=subprocess.DEVNULL, preexec_fn=own_terminal)
    text = "sistap: /dev/tty is the terminal that sistap itself reads or writes: choose another port with -i\n"
    assert tap.end() == (2, "", text)
    tap.port = port


@terminals
def test_the_file_must_not_be_the_port(run: Run, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    master, slave = pty.openpty()
    reader = FakeReader([])
    reader.name = os.ttyname(slave)
    assert run(reader, "-w", reader.name) == 2
    assert "is the port itself" in capfd.readouterr().err
    assert select.select([master], [], [], 0)[0] == []
    os.close(master)
    os.close(slave)


class FakeClock:
    """A clock that advances with each read, or by its timeout."""

    def __init__(self) -> None:
        self.ns = 0

    def __call__(self) -> int:
        return self.ns


def test_hints_and_progress_come_with_the_clock(
    capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Console, "shows_progress", True)
    clock = FakeClock()

    class Slow(FakeReader):
        def read(self, timeout_s: float) -> Read | None:
            clock.ns += 500_000_000
            return None

    stop = Stop()
    output = Output(str(tmp_path / "x"))
    conditions = Conditions(duration_s=7)
    made = session.Capture(
        [Slow([])], PlainText(output), output, Counters(), Console(), conditions, progress=True, clock_ns=clock
    )
    assert made.run(stop) == 0
    err = capfd.readouterr().err
    assert err.count("\r\x1b[Ksistap: nothing received for 5 s") == 1  # not behind the progress
    assert (
        err.count(
            "\r\x1b[K0 telegrams, 0 of them damaged, 0 characters, 0 faulty characters, longest interval not known"
        )
        == 7
    )
    assert clock.ns == 7_000_000_000


def marked_in_silence(clock: FakeClock, path: Path, duration_s: float) -> list[str]:
    """Capture silence; return the texts of the markers in the file."""

    class Idle(FakeReader):
        def read(self, timeout_s: float) -> Read | None:
            clock.ns += 500_000_000
            return None

    output, counters = Output(str(path)), Counters()
    sink = PcapngWriter(output, {0: Interface(252, "x")}, counters)
    conditions = Conditions(duration_s=duration_s)
    session.Capture([Idle([])], sink, output, counters, Console(), conditions, clock_ns=clock).run(Stop())
    output.close()
    return [record.data.decode() for record in records(path) if record.event == Event.MARKER]


def test_a_wall_clock_that_is_set_is_an_event(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    clock = FakeClock()
    hour = 3_600_000_000_000
    monkeypatch.setattr(
        "sistap.tap.capture.tap.CLOCK", Clock(clock, lambda: START_NS + clock.ns + (hour if clock.ns else 0))
    )
    (said,) = marked_in_silence(clock, tmp_path / "x.pcapng", duration_s=4)
    assert said.startswith("the wall clock moved by +3600.000 s (it was set, or the computer slept); ")
    assert capfd.readouterr().err.count("the wall clock moved") == 1


def test_a_hint_is_an_event(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """Whoever opens the capture later does not see the messages."""
    (said,) = marked_in_silence(FakeClock(), tmp_path / "x.pcapng", duration_s=7)
    assert said.startswith("nothing received for 5 s: ")
    assert capfd.readouterr().err.count("nothing received for 5 s") == 1


def test_another_program_at_the_port_is_said_at_once_in_the_file_and_at_the_end(
    capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(others, "look", lambda port: Others("cat (pid 7, user eve), end it with `kill 7`"))
    hint = "another program may read /dev/ttyFAKE: cat (pid 7, user eve), end it with `kill 7`"
    said = marked_in_silence(FakeClock(), tmp_path / "x.pcapng", duration_s=7)
    assert said[0] == hint and said[1].startswith("nothing received for 5 s")
    lines = capfd.readouterr().err.splitlines()
    assert [line.removeprefix("sistap: ") for line in lines[1:]] == [*said, hint]


def test_one_silent_line_does_not_wait_for_a_busy_one(tmp_path: Path) -> None:
    clock = FakeClock()
    path = tmp_path / "x"
    waiting = b"\x02\x00\xff\xff" + ALL[0]
    seen: list[int] = []

    class Busy(FakeReader):
        def read(self, timeout_s: float) -> Read | None:
            clock.ns += 50_000_000
            seen.append(path.stat().st_size)
            return (
                Read(2, START_NS + clock.ns, b"x", b"\0")
                if clock.ns > 50_000_000
                else Read(1, START_NS, waiting, bytes(len(waiting)))
            )

    output = Output(str(path))
    conditions = Conditions(duration_s=3)
    session.Capture([Busy([])], PlainText(output), output, Counters(), Console(), conditions, clock_ns=clock).run(
        Stop()
    )
    output.close()
    assert seen[-1] > 0  # before the end


# -- As people run it -----------------------------------------------------------------------------------------------


class Tap:
    """A pseudo terminal and `sistap capture` on it."""

    def __init__(self) -> None:
        self.master, self.slave = pty.openpty()
        tty.setraw(self.slave)
        self.port = os.ttyname(self.slave)
        self.process: subprocess.Popen[bytes] | None = None
        self.said = ""

    def start(self, *arguments: str, **popen: Any) -> subprocess.Popen[bytes]:
        """Start, and wait until it says that it listens."""
        command = [sys.executable, "-m", "sistap", "capture", "-i", self.port, *arguments]
        self.process = subprocess.Popen(command, **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **popen})
        assert self.process.stderr
        self.said = self.process.stderr.readline().decode()
        return self.process

    def send(self, *pieces: bytes) -> None:
        for piece in pieces:
            os.write(self.master, piece)

    def end(self) -> tuple[int, str, str]:
        """Wait for its end; return exit code, standard output and standard error."""
        assert self.process
        out, err = self.process.communicate(timeout=DEADLINE_S)
        return self.process.returncode, (out or b"").decode(), self.said + err.decode()

    def close(self) -> None:
        if self.process:
            self.process.kill()
            self.process.wait()
            for stream in (self.process.stdout, self.process.stderr):
                if stream:
                    stream.close()
        self.unplug()
        os.close(self.slave)

    def unplug(self) -> None:
        if self.master >= 0:
            os.close(self.master)
        self.master = -1


@pytest.fixture
def tap() -> Iterator[Tap]:
    if WINDOWS:
        pytest.skip("not on Windows: no pseudo terminals")
    tap = Tap()
    yield tap
    tap.close()


def wait_for(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)  # a file cannot be waited for


def test_the_telegrams_of_the_specification(tap: Tap, tmp_path: Path) -> None:
    path = tmp_path / "x.pcapng"
    before = time.time()
    tap.start("-w", str(path), "-c", str(len(ALL)))
    assert tap.said.startswith(f"sistap: capturing on {tap.port} (pseudo terminal); 9600 Bd 8E1; ")
    tap.send(*ALL)
    code, _, err = tap.end()
    after = time.time()
    assert code == 0
    assert err.endswith(f" characters) written to {path}; open it with: wireshark -C SIS {path}\n")
    assert f"{len(ALL)} records ({len(ALL)} telegrams, " in err
    out = subprocess.run(
        ["tshark", "-r", str(path), "-T", "fields", "-e", "frame.time_epoch", "-e", "frame.packet_flags"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    rows = [line.split("\t") for line in out.splitlines()]
    assert len(rows) == 1 + len(ALL)
    times = [float(row[0]) for row in rows]
    assert before <= times[0] and times == sorted(times) and times[-1] <= after
    assert frames(path) == ALL


@pytest.mark.thorough
def test_with_cat_at_the_same_port(tap: Tap, tmp_path: Path) -> None:
    """It is named at the start, and after 5 s without a telegram: `cat` takes nearly every character."""
    with subprocess.Popen(["cat", tap.port], stdout=subprocess.PIPE) as cat:
        assert cat.stdout
        tap.send(b"x")
        assert cat.stdout.read(1) == b"x"
        process = tap.start("-w", str(tmp_path / "x"))
        assert process.stderr
        for _ in range(2):
            line = process.stderr.readline().decode()
            assert line.startswith(f"sistap: another program may read {tap.port}: cat (pid {cat.pid}, ")
        cat.kill()
    process.send_signal(signal.SIGTERM)
    _, _, err = tap.end()
    assert err.count("another program") == 0  # it has ended


def test_live_into_a_pipe(tap: Tap, tmp_path: Path) -> None:
    process = tap.start("-w", "-")
    assert process.stdout
    received = b""
    tap.send(ALL[0])
    while ALL[0] not in received:  # before the end, so nothing waits in a buffer
        received += os.read(process.stdout.fileno(), 65536)
    process.send_signal(signal.SIGTERM)
    rest, err = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 0
    path = tmp_path / "x.pcapng"
    path.write_bytes(received + rest)
    assert frames(path) == [ALL[0]]
    assert err.decode().endswith("written to standard output\n")


def test_what_a_shell_appends_to_is_kept(tap: Tap, tmp_path: Path) -> None:
    """capture -w - >> FILE."""
    path = tmp_path / "x.pcapng"
    path.write_bytes(b"an older capture")
    with path.open("ab") as file:
        tap.start("-w", "-", "-c", "1", stdout=file)
    tap.send(ALL[0])
    assert tap.end()[0] == 0
    older, added = path.read_bytes()[:16], path.read_bytes()[16:]
    assert older == b"an older capture"
    path.write_bytes(added)
    assert frames(path) == [ALL[0]]


def test_kill_9_leaves_whole_packets(tap: Tap, tmp_path: Path) -> None:
    path = tmp_path / "x.pcapng"
    process = tap.start("-w", str(path))
    tap.send(*ALL, ALL[0][:4])
    wait_for(lambda: path.read_bytes().find(ALL[-1]) > 0 and len(frames(path)) == len(ALL))
    process.kill()
    assert tap.end()[0] == -signal.SIGKILL
    assert frames(path) == ALL
    assert subprocess.run(["tshark", "-r", str(path)], capture_output=True, check=False).returncode == 0


def test_a_full_disk_leaves_whole_packets(tap: Tap, tmp_path: Path) -> None:
    path = tmp_path / "x.pcapng"
    limit = 3000
    tap.start("-w", str(path), preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
    tap.send(*ALL * 2)
    code, _, err = tap.end()
    assert code == 1
    assert err.splitlines()[1] == f"sistap: {path}: File too large; everything before it is saved"
    assert limit - 400 < path.stat().st_size <= limit  # no packet of these is longer
    kept = frames(path)
    assert kept == (ALL * 2)[: len(kept)]


def test_dev_full(tap: Tap, full: Path) -> None:
    tap.start("-w", str(full))
    code, _, err = tap.end()
    assert code == 1
    assert "sistap: /dev/full: No space left on device" in err and "Traceback" not in err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_well_even_if_it_was_ignored(tap: Tap, tmp_path: Path, number: signal.Signals) -> None:
    path = tmp_path / "x.pcapng"
    process = tap.start("-w", str(path), preexec_fn=lambda: signal.signal(number, signal.SIG_IGN))
    unfinished = ALL[1][:5]
    tap.send(ALL[0], unfinished)
    wait_for(lambda: len(frames(path)) == 1 and not _waiting(tap.slave))
    process.send_signal(number)
    assert tap.end()[0] == 0
    assert [r.data for r in records(path)[1:]] == [ALL[0], unfinished]
    assert isinstance(blocks(path)[-1], InterfaceStatistics)


def _waiting(descriptor: int) -> int:
    """Return how many characters nobody has read yet."""
    return int.from_bytes(fcntl.ioctl(descriptor, termios.FIONREAD, bytes(4)), sys.byteorder)


def test_a_capture_that_was_stopped_does_not_claim_good_times(tap: Tap, tmp_path: Path) -> None:
    path = tmp_path / "x.pcapng"
    process = tap.start("-w", str(path), "-c", "1")
    process.send_signal(signal.SIGSTOP)
    os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WNOWAIT)
    tap.send(ALL[0])
    time.sleep(0.1)  # this long it is stopped
    process.send_signal(signal.SIGCONT)
    assert tap.end()[0] == 0
    assert records(path)[1].uncertainty_ns > 100_000_000


def test_unplugged(tap: Tap, tmp_path: Path) -> None:
    path = tmp_path / "x.pcapng"
    tap.start("-w", str(path))
    tap.send(ALL[0])
    wait_for(lambda: len(frames(path)) == 1)
    tap.unplug()
    code, _, err = tap.end()
    assert code == 1
    assert records(path)[-1].event == Event.ADAPTER_LOST
    assert isinstance(blocks(path)[-1], InterfaceStatistics)
    assert records(path)[-1].data.decode() in err and "Traceback" not in err


def test_a_missing_port(tap: Tap, tmp_path: Path) -> None:
    tap.port = str(tmp_path / "ttyUSB9")
    tap.start("-w", str(tmp_path / "x"))
    code, out, err = tap.end()
    assert (code, out, err.count("\n")) == (3, "", 1)
    assert "does not exist" in err
    assert list(tmp_path.iterdir()) == []


def test_a_wrong_filter(tap: Tap) -> None:
    tap.start("-f", "link[5")
    assert tap.end() == (2, "", "sistap: filter 'link[5': can't parse filter expression: syntax error\n")


@pytest.mark.parametrize("arguments", [[], ["-w", "-"]])
def test_the_reader_of_the_output_is_gone(tap: Tap, arguments: list[str]) -> None:
    """It ends without waiting for the next telegram, and without a traceback."""
    process = tap.start(*arguments)
    assert process.stdout
    process.stdout.close()
    process.stdout = None
    code, _, err = tap.end()
    assert code == 1
    assert "sistap: the reader of standard output is gone" in err and "Traceback" not in err


def test_closed_standard_streams_are_no_way_into_the_port(tap: Tap, tmp_path: Path) -> None:
    command = f"exec {sys.executable} -m sistap capture -i {tap.port} -w {tmp_path / 'x'} -c 1 >&- 2>&- <&-"
    process = subprocess.Popen(["sh", "-c", command])
    try:
        # Its end closes the port: send again until then, as nothing tells when it listens.
        while process.poll() is None:
            tap.send(ALL[0])
            time.sleep(0.05)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 0
    assert select.select([tap.master], [], [], 0)[0] == []


@pytest.mark.parametrize("arguments", [[], ["-w", "-"]])
def test_a_closed_standard_output_is_refused(tap: Tap, arguments: list[str]) -> None:
    tap.start(*arguments, stdout=None, preexec_fn=lambda: os.close(1))
    code, _, err = tap.end()
    text = "sistap: standard output cannot be written: Bad file descriptor; choose another file with -w\n"
    assert (code, err) == (2, text)


class Stuck:
    """A terminal that accepts nothing more: stopped by Ctrl-S, or without a reader at its other end."""

    def __init__(self, how: str) -> None:
        self.master, self.slave = pty.openpty()
        if how == "Ctrl-S":
            termios.tcflow(self.slave, termios.TCOOFF)
        else:
            os.set_blocking(self.slave, False)
            while select.select([], [self.slave], [], 0.1)[1]:  # what it takes moves on, and makes room again
                with suppress(BlockingIOError):
                    os.write(self.slave, b"x" * 64)
            os.set_blocking(self.slave, True)

    def close(self) -> None:
        os.close(self.master)
        os.close(self.slave)


@pytest.fixture(params=["Ctrl-S", "not read"])
def stuck(request: pytest.FixtureRequest) -> Iterator[Stuck]:
    terminal = Stuck(request.param)
    yield terminal
    terminal.close()


def launch(tap: Tap, *arguments: str, **popen: Any) -> subprocess.Popen[bytes]:
    """Start without waiting for its output."""
    tap.process = subprocess.Popen([sys.executable, "-m", "sistap", "capture", "-i", tap.port, *arguments], **popen)
    return tap.process


@pytest.mark.thorough
@pytest.mark.parametrize("number", SIGNALS[1:])
@pytest.mark.parametrize("arguments", [[], ["-q"]])
def test_a_stuck_terminal_does_not_hold_up_a_capture(
    tap: Tap, tmp_path: Path, stuck: Stuck, arguments: list[str], number: signal.Signals
) -> None:
    path = tmp_path / "x"
    process = launch(tap, "-w", str(path), *arguments, stderr=stuck.slave)
    wait_for(lambda: path.exists() and path.stat().st_size > 0)
    tap.send(*ALL, ALL[0][:4])
    wait_for(lambda: len(frames(path)) == len(ALL) and not _waiting(tap.slave))
    process.send_signal(number)
    assert process.wait(DEADLINE_S) == 0
    assert records(path)[-1].data == ALL[0][:4]
    assert isinstance(blocks(path)[-1], InterfaceStatistics)


@pytest.mark.thorough
def test_text_on_a_stuck_terminal_does_not_hold_up_a_stop(tap: Tap, stuck: Stuck) -> None:
    process = tap.start(stdout=stuck.slave)
    tap.send(*ALL)
    process.send_signal(signal.SIGTERM)
    code, _, err = tap.end()
    assert code == 1
    assert "standard output is not being read; the last records are missing in it\n" in err


@pytest.mark.thorough
@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("arguments", [[], ["-w", "-"]])
def test_a_pipe_that_is_not_read_does_not_hold_up_a_stop(
    tap: Tap, arguments: list[str], number: signal.Signals
) -> None:
    """A block is many times larger than the pipe."""
    process = tap.start(*arguments, pipesize=8192)
    assert process.stdout
    pipe = process.stdout.fileno()
    tap.send(bytes(4096))
    wait_for(lambda: _waiting(pipe) >= 4096 and not _waiting(tap.slave))
    process.send_signal(number)
    assert process.wait(DEADLINE_S) == 1
    assert process.stderr
    assert b"standard output is not being read; the last records are missing in it" in process.stderr.read()


def test_a_pipe_that_does_not_wait_loses_nothing(tap: Tap, tmp_path: Path) -> None:
    """Such as a pipe shared with a program that made it non-blocking."""
    process = tap.start("-w", "-", pipesize=8192, preexec_fn=lambda: os.set_blocking(1, False))
    assert process.stdout
    tap.send(bytes(4096), bytes(4096))
    received = b""
    while len(received) < 6 * 8192 and (piece := os.read(process.stdout.fileno(), 65536)):
        received += piece
    process.send_signal(signal.SIGTERM)
    rest, err = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 0, err
    path = tmp_path / "x"
    path.write_bytes(received + rest)
    assert b"".join(record.data for record in records(path)[1:]) == bytes(8192)


def test_a_terminal_that_goes_away_ends_it_well(tap: Tap, tmp_path: Path) -> None:
    master, slave = pty.openpty()

    def own_terminal() -> None:
        os.setsid()
        fcntl.ioctl(slave, termios.TIOCSCTTY, 0)

    path = tmp_path / "x"
    process = launch(tap, "-w", str(path), stdin=slave, stdout=slave, stderr=slave, preexec_fn=own_terminal)
    os.close(slave)
    wait_for(lambda: path.exists() and path.stat().st_size > 0)
    tap.send(ALL[0], ALL[1][:4])
    wait_for(lambda: len(frames(path)) == 1 and not _waiting(tap.slave))
    os.close(master)
    assert process.wait(DEADLINE_S) == 0
    assert [record.data for record in records(path)[1:]] == [ALL[0], ALL[1][:4]]


def test_nohup_keeps_it_running(tap: Tap, tmp_path: Path) -> None:
    path = tmp_path / "x"
    process = tap.start("-w", str(path), preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    process.send_signal(signal.SIGHUP)
    tap.send(*ALL)
    wait_for(lambda: len(frames(path)) == len(ALL))
    process.send_signal(signal.SIGTERM)
    assert tap.end()[0] == 0


def test_a_full_disk_for_what_it_says_changes_no_exit_code(tap: Tap, tmp_path: Path, full: Path) -> None:
    tap.port = str(tmp_path / "ttyUSB9")
    with full.open("wb") as said:
        assert launch(tap, stderr=said).wait(DEADLINE_S) == 3


WITHOUT_PYSERIAL = "import sys; sys.modules['serial'] = None; from sistap.cli import main; sys.exit(main(sys.argv[1:]))"


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (["capture", "--help"], 0, ""),
        (["capture", "-i", "bus://127.0.0.1:1"], 3, "nothing listens at bus://127.0.0.1:1"),
        (["bus", "--baud", "0"], 2, "--baud 0 is no rate"),
        (["ports"], 1, f"{sys.executable} -P -m pip install pyserial"),
        (["capture", "-i", "socket://127.0.0.1:1"], 1, "pyserial is missing"),
    ],
)
def test_without_pyserial(arguments: list[str], code: int, text: str) -> None:
    command = [sys.executable, "-c", WITHOUT_PYSERIAL, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=DEADLINE_S)
    assert done.returncode == code
    assert text in done.stderr and done.stderr.count("\n") == bool(text)


def test_progress_on_a_terminal(tap: Tap, tmp_path: Path) -> None:
    master, slave = pty.openpty()
    tap.process = subprocess.Popen(
        [sys.executable, "-m", "sistap", "capture", "-i", tap.port, "-w", str(tmp_path / "x")], stderr=slave
    )
    os.close(slave)
    said = b""
    while b"longest interval" not in said:
        said += os.read(master, 4096)
    tap.process.send_signal(signal.SIGINT)
    while b"written to" not in said:
        said += os.read(master, 4096)
    assert b"\r\x1b[Ksistap: 0 records" in said and b"not known\r\x1b[K" in said
    assert b"\r\x1b[K0 telegrams, 0 of them damaged, 0 characters, 0 faulty characters" in said
    assert tap.process.wait(DEADLINE_S) == 0
    os.close(master)


@pytest.mark.parametrize("arguments", [["--help"], ["capture", "--help"]])
def test_help_into_a_pipe_that_closes(arguments: list[str]) -> None:
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    process = subprocess.Popen(
        [sys.executable, "-m", "sistap", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=buffered
    )
    assert process.stdout
    process.stdout.close()
    process.stdout = None
    _, err = process.communicate(timeout=DEADLINE_S)
    assert err == b""
