# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap record`: files around what matters, on a virtual bus whose time does not wait."""

from __future__ import annotations

import errno
import os
import re
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from independent import blocks, records
from pcapng.blocks import InterfaceDescription, SectionHeader
from portable import posix, sockets

from sistap import cli
from sistap.commands.recorder import notifier, retention
from sistap.commands.recorder import recorder as recorder_module
from sistap.commands.recorder.keeper import Around
from sistap.commands.recorder.notifier import Notifier
from sistap.commands.recorder.reasons import word
from sistap.commands.recorder.recorder import Recorder, Wanted
from sistap.commands.recorder.watching import Judge, judges
from sistap.dissected.captures import reading
from sistap.dissected.episodes.live import LIVE
from sistap.dissected.explain.relay import Entry, Judged, Seams
from sistap.dissected.explain.running import ordinary_children
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import output as output_module
from sistap.tap.files.output import Limits, Output, OutputError, file_name
from sistap.tap.files.pcapng import Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.line import priority
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Event, Record, Type, event
from sistap.tap.terminal.exits import UsageError

SECOND = 1_000_000_000
PATIENCE_S = 60
FULL = pytest.mark.attack(
    "the disk becomes full while a recorder compresses", "no part stays; the file stays, and a line says so; it goes on"
)
LINE = {0: Interface(252, "a line of a test")}


@pytest.fixture(scope="module")
def traffic(tmp_path_factory: pytest.TempPathFactory) -> list[Record]:
    """A bus on which a telegram is damaged now and then."""
    path = tmp_path_factory.mktemp("traffic") / "x.pcapng"
    assert cli.main(["bus", "demo", "--cycles", "30", "--faults", "checksum=0.02", "-w", str(path)]) == 0
    return list(reading.records(path))


@pytest.fixture(autouse=True)
def _busy_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder_module, "PATIENCE_S", PATIENCE_S)


def play(recorder: Recorder, traffic: list[Record]) -> None:
    recorder.begin(traffic[0])
    for record in traffic[1:]:
        recorder.write(record)
    recorder.end(traffic[-1].time_ns)


def by(tshark: Tshark, *keep: str) -> list[Judge]:
    return judges(tshark, keep, LIVE)


Keep = Callable[..., Recorder]


@pytest.fixture
def keep(tshark: Tshark, tmp_path: Path, traffic: list[Record]) -> Keep:
    def keep(
        *filters: str, before_s: float = 0.2, after_s: float = 0.1, at_most: int = 100, **more: object
    ) -> Recorder:
        around = Around(int(before_s * SECOND), int(after_s * SECOND))
        wanted = Wanted(tmp_path, by(tshark, *filters), around, at_most, **more)  # type: ignore[arg-type]
        recorder = Recorder(wanted, tshark, LINE, lambda said: pytest.fail(said))
        play(recorder, traffic)
        return recorder

    return keep


def numbers(tshark: Tshark, traffic: list[Record], filter_: str, path: Path) -> list[int]:
    """Return the records that a single tshark finds."""
    output = Output(str(path))
    writer = PcapngWriter(output, LINE, Counters())
    writer.begin(traffic[0])
    for record in traffic[1:]:
        writer.write(record)
    output.close()
    return [
        int(n) - 1 for n in tshark.output("-r", str(path), "-Y", filter_, "-T", "fields", "-e", "frame.number").split()
    ]


def kept(folder: Path) -> list[Path]:
    return sorted(folder.glob("kept_*.pcapng"))


def identity(record: Record) -> tuple[int, bytes]:
    return record.time_ns, record.data


@pytest.mark.thorough
def test_each_file_has_its_window_and_each_record_once(
    keep: Keep, tshark: Tshark, traffic: list[Record], tmp_path: Path
) -> None:
    filter_ = "sis.checksum.status == 0"
    recorder = keep(filter_, before_s=0.6, after_s=0.2)
    windows: list[list[int]] = []
    for number in numbers(tshark, traffic, filter_, tmp_path / "all.pcapng"):
        since, until = traffic[number].time_ns - 6 * SECOND // 10, traffic[number].time_ns + 2 * SECOND // 10
        if windows and since <= windows[-1][1]:
            windows[-1][1] = until
        else:
            windows.append([since, until])
    files = kept(tmp_path)
    assert len(files) == len(windows) == recorder.kept > 3
    for file, (since, until) in zip(files, windows, strict=True):
        started, *content = map(identity, reading.records(file))
        inside = [identity(record) for record in traffic[1:] if since <= record.time_ns <= until]
        told = [one for one in reading.records(file) if one.type == Type.BEFORE]
        assert content == [*map(identity, told), *inside]
        assert bool(told) == (inside[0] != identity(traffic[1]))
        assert {started[0], *(one.time_ns for one in told)} == {inside[0][0]}
        assert b"; kept: sis.checksum.status-0 at " in started[1]


def test_a_file_begins_with_the_rate_of_its_first_telegram(
    tshark: Tshark, tmp_path: Path, traffic: list[Record]
) -> None:
    """The rate changes before the reason, and the file begins before that."""
    filter_ = "sis.checksum.status == 0"
    fast = traffic[0].settings._replace(baud=19200)
    found = numbers(tshark, traffic, filter_, tmp_path / "all.pcapng")
    reason = next(number for number in found if number > 40)
    changing = [record._replace(settings=fast) if number < reason else record for number, record in enumerate(traffic)]
    changing[0] = traffic[0]  # how the capture began
    around = Around(2 * SECOND // 10, SECOND // 10)
    wanted = Wanted(tmp_path, by(tshark, filter_), around, 100)
    play(Recorder(wanted, tshark, LINE, lambda said: pytest.fail(said)), changing)
    files = [list(reading.records(file)) for file in kept(tmp_path)]
    begins = [record for file in files for record in file if record.time_ns == changing[reason].time_ns]
    assert begins, "the reason is in a file"
    for file in files:
        assert file[0].settings == next(record.settings for record in file if record.type != Type.EVENT)


@pytest.mark.thorough
def test_a_file_stands_alone(keep: Keep, tmp_path: Path) -> None:
    keep("sis.checksum.status == 0")
    files = kept(tmp_path)
    assert files
    for file in files:
        first, second, *_ = blocks(file)
        assert isinstance(first, SectionHeader) and isinstance(second, InterfaceDescription)
        started, *others = records(file)
        assert (started.type, started.event) == (Type.EVENT, Event.CAPTURE_STARTED)
        assert all(record.event != Event.CAPTURE_STARTED for record in others)


def test_it_is_named_by_time_and_reason(keep: Keep, traffic: list[Record], tmp_path: Path) -> None:
    keep("faults", "sis.status > 0")
    names = [file.name for file in kept(tmp_path)]
    word = r"(_(damaged|sis\.status-0))+"
    assert all(re.fullmatch(rf"kept_\d{{14}}\.\d{{3}}{word}\.pcapng", name) for name in names), names
    assert any(name.endswith("_damaged.pcapng") for name in names)
    assert any("_damaged_" in name for name in names) and len(names) == len({name[:22] for name in names})


@pytest.mark.thorough
def test_the_oldest_go_and_other_files_stay(keep: Keep, tmp_path: Path) -> None:
    old = tmp_path / "kept_19990101000000.000_of-an-earlier-run.pcapng"
    others = [tmp_path / "kept_mine.pcapng", tmp_path / "ring_00001_20010101000000.pcapng"]
    for file in (old, *others):
        file.write_bytes(b"x")
    recorder = keep("sis.checksum.status == 0", at_most=2)
    assert recorder.kept > 2
    assert len(kept(tmp_path)) == 3 and not old.exists() and all(file.exists() for file in others)


def test_files_of_an_earlier_ring_go_too(tmp_path: Path) -> None:
    for number in range(5):
        (tmp_path / f"ring_0000{9 - number}_2026010100000{number}.pcapng").write_bytes(b"x")
    retention.ring(tmp_path, 2, lambda said: pytest.fail(said), tuple).prune()
    assert [file.name[-6:-7:-1] + file.name[-8] for file in sorted(tmp_path.iterdir())]
    assert sorted(file.name.rpartition("_")[2] for file in tmp_path.iterdir()) == [
        "20260101000003.pcapng",
        "20260101000004.pcapng",
    ]


def test_repeats_go_before_the_first_of_each_reason(tmp_path: Path) -> None:
    """A wrong value is written twice, and late reactions follow."""
    names = ["write", "write_late", *["late"] * 9, "lost", "late"]
    for number, name in enumerate(names):
        retention.new_name(tmp_path, number * SECOND, name).touch()
    for at_most, left in ((20, range(13)), (6, [0, 1, 9, 10, 11, 12]), (4, [0, 1, 11, 12]), (1, [12])):
        retention.kept(tmp_path, at_most, lambda said: pytest.fail(said), tuple).prune()
        assert [int(path.name[17:19]) for path in kept(tmp_path)] == [*left]


def test_a_second_name_in_a_moment_is_no_reason(tmp_path: Path) -> None:
    for _ in range(3):
        retention.new_name(tmp_path, 0, "lost").touch()
    retention.kept(tmp_path, 2, lambda said: pytest.fail(said), tuple).prune()
    assert [path.name.rpartition("_")[2] for path in kept(tmp_path)] == ["lost-2.pcapng", "lost.pcapng"]


def test_two_files_of_one_moment_have_two_names(tmp_path: Path) -> None:
    first = retention.new_name(tmp_path, 5 * SECOND, "late")
    first.touch()
    second = retention.new_name(tmp_path, 5 * SECOND, "late")
    assert first != second and not second.exists()


@pytest.mark.thorough
@posix("a line for sh")
def test_a_command_is_told_of_each_file_and_not_waited_for(keep: Keep, tmp_path: Path) -> None:
    """It ends when this test says so."""
    go, told = tmp_path / "go", tmp_path / "told"
    waits = f"while [ ! -e {go} ]; do sleep 0.1; done; echo >> {told}"  # and the file
    recorder = keep("sis.checksum.status == 0", command=waits, before_s=1, after_s=1)
    assert recorder.kept > 1 and not told.exists()
    go.touch()
    end_s = time.monotonic() + PATIENCE_S
    while not told.exists() or told.read_text().count("\n") < recorder.kept:
        assert time.monotonic() < end_s
        time.sleep(0.01)
    assert sorted(told.read_text().splitlines()) == [str(file) for file in kept(tmp_path)]


@posix("a line for sh")
def test_a_command_that_fails_is_told(tmp_path: Path) -> None:
    said: list[str] = []
    notifying = Notifier("exit 7; true", said.append)
    notifying.notify(tmp_path / "it's")
    end_s = time.monotonic() + PATIENCE_S
    while not said:
        assert time.monotonic() < end_s
        notifying.reap()
    assert said == [f"--on-keep ended with exit code 7 for {tmp_path}/it's"]


@posix("a line for sh")
def test_commands_that_never_end_are_not_started_for_ever(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(notifier, "MOST", 2)
    said: list[str] = []
    notifying = Notifier("exec sleep 1000; #", said.append)
    for _ in range(3):
        notifying.notify(tmp_path / "x")
    assert said == [f"--on-keep was not started for {tmp_path}/x: 2 earlier ones are still running"]
    for process, _ in notifying._running:
        process.kill()
        process.wait()


def test_a_disk_that_is_full_is_told_once_and_the_capture_goes_on(
    tshark: Tshark, traffic: list[Record], full: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(output_module, "_open", lambda *_, **__: (os.open(full, os.O_WRONLY), False))
    monkeypatch.setattr(retention, "new_name", lambda *_: tmp_path / "kept.pcapng")
    said: list[str] = []
    wanted = Wanted(tmp_path, by(tshark, "sis.checksum.status == 0"), Around(SECOND, SECOND), 5)
    recorder = Recorder(wanted, tshark, LINE, said.append)
    recorder.begin(traffic[0])
    assert all(map(recorder.write, traffic[1:]))
    recorder.end(0)
    assert len(said) == 1 and "No space left" in said[0] and recorder.kept == 0


def test_a_ring_alone_is_compressed_up_to_its_newest_file(
    tshark: Tshark, traffic: list[Record], tmp_path: Path
) -> None:
    """So after kill -9 all files open, the newest up to its last whole record."""
    output = Output(str(tmp_path / "ring.pcapng"), Limits(size=50_000, several=True))
    ring = PcapngWriter(output, LINE, Counters())
    wanted = Wanted(tmp_path, by(tshark, "nothing"), Around(SECOND, SECOND), 5, compress=True)
    recorder = Recorder(wanted, tshark, LINE, lambda said: pytest.fail(said), ring=ring)
    play(recorder, traffic)
    recorder._tidy()
    output.close()
    *packed, newest = sorted(tmp_path.iterdir())
    assert packed and all(path.name.endswith(".pcapng.gz") for path in packed) and newest.suffix == ".pcapng"
    assert recorder.kept == 0 and "0 files kept" in recorder.summary(Counters())
    content = [record for file in (*packed, newest) for record in list(reading.records(file))[1:]]
    assert [identity(one) for one in content if one.type != Type.BEFORE] == list(map(identity, traffic[1:]))


@pytest.fixture
def clock_set_back(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each file of a ring has an earlier name than the one before, as when summer time ends."""
    monkeypatch.setattr(
        output_module, "file_name", lambda path, number, _: file_name(path, number, 1_000_000_000 - 3600 * number)
    )


@pytest.mark.usefixtures("clock_set_back")
def test_the_file_that_is_written_stays_when_the_clock_is_set_back(
    tshark: Tshark, traffic: list[Record], tmp_path: Path
) -> None:
    output = Output(str(tmp_path / "ring.pcapng"), Limits(size=50_000, several=True))
    ring = PcapngWriter(output, LINE, Counters())
    wanted = Wanted(tmp_path, by(tshark, "nothing"), Around(SECOND, SECOND), 5, ring_files=2, compress=True)
    recorder = Recorder(wanted, tshark, LINE, lambda said: pytest.fail(said), ring=ring)
    play(recorder, traffic)
    recorder._tidy()
    written = Path(str(output))
    output.close()
    (packed,) = set(tmp_path.iterdir()) - {written}
    assert written.is_file() and packed.name.endswith(".pcapng.gz")


def test_a_kept_file_that_is_written_stays_when_the_clock_is_set_back(tmp_path: Path) -> None:
    for second in range(4):
        retention.new_name(tmp_path, second * SECOND, "late").touch()
    written = kept(tmp_path)[1].name
    retention.kept(tmp_path, 2, lambda said: pytest.fail(said), lambda: [written]).prune()
    assert [path.name for path in kept(tmp_path)][1] == written


def fill(folder: Path, leaving: int) -> Path:
    """Fill a disk up to some bytes; return the file that does it."""
    ballast = folder / "ballast"
    ballast.write_bytes(bytes(shutil.disk_usage(folder).free - leaving))
    return ballast


@FULL
def test_a_disk_without_room_for_a_compressed_ring(tshark: Tshark, traffic: list[Record], small_disk: Path) -> None:
    """The room that is left is the ring's. What stays as it is is said once, and compressed when there is room."""
    said: list[str] = []
    output = Output(str(small_disk / "ring.pcapng"), Limits(size=50_000, several=True))
    ring = PcapngWriter(output, LINE, Counters())
    wanted = Wanted(small_disk, by(tshark, "nothing"), Around(SECOND, SECOND), 5, compress=True)
    recorder = Recorder(wanted, tshark, LINE, said.append, ring=ring)
    recorder._tidy_s = float("inf")  # only when this test says so
    play(recorder, traffic)
    files = {path: path.read_bytes() for path in small_disk.iterdir()}
    ballast = fill(small_disk, leaving=40_000)
    for _ in range(2):
        recorder._tidy()
    assert {path: path.read_bytes() for path in small_disk.iterdir() if path != ballast} == files
    first = min(files)
    assert said == [f"{first} cannot be compressed: No space left on device; it stays as it is"]
    ballast.unlink()
    recorder._tidy()
    assert {path.suffix for path in small_disk.iterdir() if path != Path(str(output))} == {".gz"} and len(said) == 1
    output.close()


@FULL
def test_a_disk_without_room_for_compressed_kept_files(tshark: Tshark, traffic: list[Record], small_disk: Path) -> None:
    said: list[str] = []
    wanted = Wanted(
        small_disk, by(tshark, "sis.checksum.status == 0"), Around(SECOND // 5, SECOND // 10), 50, compress=True
    )
    recorder = Recorder(wanted, tshark, LINE, said.append)
    ballast = fill(small_disk, leaving=40_000)
    play(recorder, traffic)
    packed, left = sorted(small_disk.glob("*.gz")), kept(small_disk)
    assert packed and len(left) > 1 and {*packed, *left, ballast} == set(small_disk.iterdir())
    not_packed, not_written = said
    assert not_packed == f"{left[0]} cannot be compressed: No space left on device; it stays as it is"
    assert not_written.endswith(": No space left on device; everything before it is saved")
    assert all(len(list(reading.records(file))) > 1 for file in (*packed, *left))


def test_the_ring_has_all(tshark: Tshark, traffic: list[Record], tmp_path: Path) -> None:
    output = Output(str(tmp_path / "ring.pcapng"), Limits(size=50_000, several=True))
    ring = PcapngWriter(output, LINE, Counters())
    wanted = Wanted(tmp_path, by(tshark, "faults"), Around(SECOND, SECOND), 5)
    recorder = Recorder(wanted, tshark, LINE, lambda said: pytest.fail(said), ring=ring)
    play(recorder, traffic)
    output.close()
    files = sorted(tmp_path.glob("ring_*.pcapng"))
    assert len(files) > 1
    content = [record for file in files for record in list(reading.records(file))[1:]]
    assert [identity(one) for one in content if one.type != Type.BEFORE] == list(map(identity, traffic[1:]))


@pytest.mark.attack("the folder of a recorder is moved away", "a message; the capture goes on, the ring too")
def test_a_folder_that_is_moved_away_ends_nothing(tshark: Tshark, traffic: list[Record], tmp_path: Path) -> None:
    said: list[str] = []
    output = Output(str(tmp_path / "ring.pcapng"))
    wanted = Wanted(tmp_path / "kept", by(tshark, "sis.checksum.status == 0"), Around(SECOND, SECOND), 5)
    wanted.folder.mkdir()
    recorder = Recorder(wanted, tshark, LINE, said.append, ring=PcapngWriter(output, LINE, Counters()))
    wanted.folder.rename(tmp_path / "elsewhere")
    play(recorder, traffic)
    output.close()
    assert sum(" until it is back" in text for text in said) == 1, said
    # Windows has two texts for it.
    with pytest.raises(FileNotFoundError) as refused:
        os.scandir(wanted.folder)
    reasons = (str(refused.value.strerror), os.strerror(errno.ENOENT))
    assert all(any(reason in text for reason in reasons) for text in said), said
    assert len(list(reading.records(tmp_path / "ring.pcapng"))) == len(traffic)


def test_a_recorder_that_fails_leaves_the_ring(
    tshark: Tshark, traffic: list[Record], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    output = Output(str(tmp_path / "ring.pcapng"))
    wanted = Wanted(tmp_path, by(tshark, "faults"), Around(SECOND, SECOND), 5)
    recorder = Recorder(wanted, tshark, LINE, said.append, ring=PcapngWriter(output, LINE, Counters()))
    monkeypatch.setattr(recorder, "_keep", lambda _: 1 // 0)
    with pytest.raises(OutputError, match="ZeroDivisionError"):
        play(recorder, traffic)
    output.close()
    assert len(said) == 1 and said[0].endswith("; the ring goes on")
    assert len(list(reading.records(tmp_path / "ring.pcapng"))) == len(traffic)


def test_a_disk_that_does_not_answer_holds_nobody_up(
    tshark: Tshark, traffic: list[Record], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder_module, "MOST_WAITING", 10)
    said: list[str] = []
    disk = threading.Event()
    recorder = Recorder(Wanted(tmp_path, by(tshark, "faults"), Around(1, 1), 5), tshark, LINE, said.append)
    monkeypatch.setattr(recorder, "_tidy", disk.wait)
    recorder.begin(traffic[0])
    for record in traffic[1:100]:
        recorder.write(record)
    assert recorder._queue.qsize() <= 11
    disk.set()
    recorder.close()
    recorder._check()
    assert said and "is too slow" in said[0]


def silent_of_limits(traffic: list[Record]) -> list[Record]:
    """Return the traffic as a tap hears it that joins after the start: without service 0x03."""
    return [one for one in traffic if one.type != Type.FRAME or one.data[5] != 0x03]


def test_without_a_limit_it_says_once_what_is_not_kept(tshark: Tshark, traffic: list[Record], tmp_path: Path) -> None:
    """Not if the bus sets one, nor if the user tells it."""
    told = [event(traffic[0].time_ns, 0, traffic[0].settings, Event.LIMITS_TOLD, "TzA = 8 ms")]
    joined = silent_of_limits(traffic)
    for number, (started, heard, count) in enumerate([([], joined, 1), ([], traffic, 0), (told, joined, 0)]):
        folder = tmp_path / str(number)
        folder.mkdir()
        said: list[str] = []
        recorder = Recorder(Wanted(folder, by(tshark, "faults"), Around(1, 1), 5), tshark, LINE, said.append)
        recorder.begin(traffic[0], *started)
        for record in heard[1:]:
            recorder.write(record)
        recorder.end(traffic[-1].time_ns)
        assert [text.partition(":")[0] for text in said] == ["No limit is known"] * count


@pytest.mark.parametrize(
    ("filter_", "expected"),
    [
        ("sis.error == 0x7004", "sis.error-0x7004"),
        ('sis.parameter == "S-0-0044"', "sis.parameter-S-0-0044"),
        ("../../x", "x"),
        ("!!", "found"),
        ("sis.service " * 20, "sis.service-sis.service-sis.service-sis"),
    ],
)
def test_a_filter_becomes_a_word(filter_: str, expected: str) -> None:
    assert word(filter_) == expected


def test_a_wrong_filter_is_refused(tshark: Tshark) -> None:
    with pytest.raises(UsageError, match=r"--keep 'sis.foo == 1': .*sis.foo"):
        by(tshark, "faults", "sis.foo == 1")
    with pytest.raises(UsageError, match="needs a filter"):
        by(tshark, "faults", " ")


def test_every_fault_is_found_in_one_pass_and_has_its_reason(tshark: Tshark, tmp_path: Path) -> None:
    """On buses where it happens."""
    found: set[str] = set()
    deciding = by(tshark, "writes", "faults")
    buses = [["late-reaction"], ["damaged"], ["silent-station"], ["slow-characters"], ["noise"], ["demo"], ["token"]]
    buses += [["phase-switch"], ["demo", "--faults", "parity=0.01,loss=0.01,break=0.01"]]  # one refuses a write
    for number, bus in enumerate(buses):
        path = tmp_path / f"{number}.pcapng"
        assert cli.main(["bus", *bus, "-w", str(path)]) == 0
        for judge in deciding:
            for line in tshark.lines(["-r", str(path), *judge.arguments(None)]):
                reason = judge.reason(Judged(Entry(0, b""), judge.columns(line)))
                found.add(reason.word if reason else "")
    assert found >= {"damaged", "lost", "line-error", "interval", "late", "error", "repeated", "silent", "write"}


def test_tshark_has_ordinary_priority(tshark: Tshark, monkeypatch: pytest.MonkeyPatch) -> None:
    if sys.platform != "linux" or not _may_be_real_time():
        pytest.skip("real-time priority is not permitted here")
    with priority.real_time():
        with ordinary_children():
            done = subprocess.run(["chrt", "-p", "0"], capture_output=True, text=True, check=False)
        assert priority.is_real_time()
    assert "SCHED_FIFO" not in done.stdout


def _may_be_real_time() -> bool:
    with priority.real_time():
        return priority.is_real_time()


@pytest.mark.thorough
def test_small_seams_change_nothing(tshark: Tshark, traffic: list[Record], tmp_path: Path) -> None:
    contents = []
    for name, seams in (("one", Seams()), ("many", Seams(packets=301))):
        folder = tmp_path / name
        folder.mkdir()
        wanted = Wanted(folder, by(tshark, "faults"), Around(SECOND, SECOND), 100)
        recorder = Recorder(wanted, tshark, LINE, lambda said: pytest.fail(said), seams=seams)
        play(recorder, traffic)
        contents.append({file.name: file.read_bytes() for file in kept(folder)})
        assert all((relay.successions > 0) == (name == "many") for relay in recorder.relays)
    assert contents[0] == contents[1]


UNIT = Path(recorder_module.__file__).with_name("sistap-recorder.service")


def test_the_unit_calls_the_recorder_as_it_is() -> None:
    """Its command line is one that the command takes."""
    lines = [line for line in UNIT.read_text().splitlines() if line and not line.startswith("#")]
    environment = dict(
        line.partition("=")[2].strip('"').split("=", 1) for line in lines if line.startswith("Environment=")
    )
    (start,) = (line.partition("=")[2] for line in lines if line.startswith("ExecStart="))
    words: list[str] = []
    for word_ in start.replace("%S", "/var/lib").split():
        variable = word_.strip("${}")
        words += environment[variable].split() if word_.startswith("$") else [word_]
    assert words[:2] == ["/usr/bin/env", "sistap"]
    args = cli.parser().parse_args(words[2:])
    assert (args.keep, args.wait_for_port, args.folder) == (["faults"], True, "/var/lib/sistap-recorder")


@pytest.mark.skipif(not shutil.which("systemd-analyze"), reason="systemd-analyze is not installed")
def test_the_unit_is_understood_and_confined(tmp_path: Path) -> None:
    verified = subprocess.run(["systemd-analyze", "verify", UNIT], capture_output=True, text=True, check=False)
    assert (verified.returncode, verified.stderr) == (0, "")
    command = ["systemd-analyze", "security", "--offline=yes", "--threshold=20", str(UNIT)]  # 2.0 of 10
    judged = subprocess.run(command, capture_output=True, text=True, check=False)
    assert judged.returncode == 0, judged.stdout[-200:]


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["--keep", "sis.foo", "-w", "k"], 2, "--keep 'sis.foo': "),
        (["--keep", "faults"], 2, "a recorder needs a folder for its files: say it with -w"),
        (["--keep", "faults", "-w", "-"], 2, "a recorder needs a folder"),
        (["--keep", "faults", "-w", "file"], 2, "file is no folder"),
        (["--keep", "faults", "-w", "k", "-a", "filesize:5"], 2, "-a filesize: is for the full ring"),
        (["--keep", "nothing", "-w", "k"], 2, "--keep nothing is for a full ring alone, or --values: add -b"),
        (["--keep", "nothing", "--keep", "faults", "-w", "k", "-b", "duration:5"], 2, "leave out other --keep"),
        (["-w", "k", "-b", "files:5"], 2, "-b files: does not say when a file is full"),
    ],
)
def test_what_cannot_be_kept_is_refused_at_once(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    arguments: list[str],
    code: int,
    said: str,
) -> None:
    """Also where the port is waited for."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    assert cli.main(["record", "-i", str(tmp_path / "no-port"), "--wait-for-port", *arguments]) == code
    err = capfd.readouterr().err
    assert said in err and err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize("option", [["--keep", "faults", "--before", "3"], ["--compress", "-b", "duration:60"]])
def test_capture_says_who_has_an_option(capfd: pytest.CaptureFixture[str], option: list[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(["capture", "-i", "x", *option, "-w", "kept"])
    err = capfd.readouterr().err
    assert ended.value.code == 2 and "`sistap record`" in err and err.count("\n") == 1


@pytest.mark.thorough
@sockets
def test_the_command_keeps_what_a_bus_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """End to end: a bus, two lines that appear while it runs, and the full ring beside the kept files."""
    command = [sys.executable, "-m", "sistap"]
    address = f"{tmp_path}/bus"
    bus = subprocess.Popen(
        [*command, "bus", "s5-faults", "--listen", address, "--fast"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    assert bus.stdout
    bus.stdout.readline()
    options = ["--framing", "3964r", "--keep", "sertap.type == 1", "--before", "1", "--after", "1", "-w", "kept"]
    options += ["-b", "filesize:1000", "-c", "2000", "-q"]
    done = subprocess.run(
        [*command, "record", "-i", f"bus://{address}", *options],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    bus.kill()
    bus.communicate()
    assert done.returncode in (0, 1), done.stderr  # 1: the bus has ended before
    ring = [record for file in (tmp_path / "kept").glob("ring_*") for record in reading.records(file)]
    assert kept(tmp_path / "kept") and ring
    assert {record.line for record in ring} >= {1, 2}
    known = set(map(identity, ring))
    for file in kept(tmp_path / "kept"):
        started, *content = reading.records(file)
        assert started.event == Event.CAPTURE_STARTED and content
        assert {identity(record) for record in content if record.type != Type.BEFORE} <= known


def test_kept_files_are_compressed_and_told_so(keep: Keep, tmp_path: Path) -> None:
    told, tell = tmp_path / "told", tmp_path / "tell.py"
    tell.write_text("import sys\nopen(sys.argv[1], 'a').write(sys.argv[2] + '\\n')\n")
    command = f'"{sys.executable}" "{tell}" "{told}"'  # every shell takes that
    recorder = keep("sis.checksum.status == 0", compress=True, command=command)
    packed = sorted(tmp_path.glob("kept_*.pcapng.gz"))
    assert len(packed) == recorder.kept > 0
    assert not kept(tmp_path)
    until_s = time.monotonic() + PATIENCE_S
    while not told.exists() or len(told.read_text().splitlines()) < len(packed):
        assert time.monotonic() < until_s
        time.sleep(0.05)
    assert sorted(told.read_text().splitlines()) == [str(path) for path in packed]
    assert [one for path in packed for one in reading.records(path)]
