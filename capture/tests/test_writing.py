# SPDX-License-Identifier: GPL-2.0-or-later
"""Files that commands write: not through a link, not over data without --force, not for more readers than before."""

from __future__ import annotations

import os
import shutil
import stat
import threading
from pathlib import Path

import pytest
from attacks import ROOT
from commands import run, run_with
from portable import fifos, links, modes, posix

from sistap.commands.recorder import retention
from sistap.tap.common.writing import opened
from sistap.tap.files.output import FileLimits, Output, file_name
from sistap.tap.terminal.exits import Refusal

HOUR_NS = 3600 * 1_000_000_000
NAME = "x.out"  # of the file to write
# What the commands are called with; DAY is a capture. These derive a file from another.
DERIVED = {
    "report": "report DAY --format text -o",
    "parameters": "parameters DAY -o",
    "compare": "compare DAY DAY -o",
    "log": "log DAY -o",
    "annotate": "annotate log.txt -o",
    "annotate -w": "annotate log.txt -w",
    "import": "import table.csv --baud 9600 -w",
}
COMMANDS = DERIVED | {
    "annotate live": "annotate - -o",
    "import messages": "import messages.csv --dissector synaxpcp -w",
    "bus": "bus -w",
    "bus --log": "bus --duration 1 -w other.pcapng --log",
    "capture": "capture -i socket://127.0.0.1:1 -w",
}


@pytest.mark.parametrize("grows", [False, True])
def test_no_force_replaces_what_a_capture_writes(tmp_path: Path, grows: bool) -> None:
    """On Linux the capture would go on writing into a file that nobody finds."""
    output = Output(str(tmp_path / "x"))
    output.begin()
    output.write(b"abc")
    with (
        pytest.raises(Refusal, match="is being written by a capture: name another file with -o"),
        opened(str(tmp_path / "x"), force=True, grows=grows) as file,
    ):
        file.write(b"d")
    output.close()
    assert (tmp_path / "x").read_bytes() == b"abc"


def words(command: str) -> list[str]:
    return [*COMMANDS[command].replace("DAY", "day.pcapng").split(), NAME]


def refused(place: Path, command: list[str], *why: str) -> None:
    """Check that it said so in one line, and did nothing else."""
    before = {path: path.is_file() and path.read_bytes() for path in place.iterdir()}
    done = run(place, *command)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    assert all(word in done.stderr for word in why), done.stderr
    assert {path: path.is_file() and path.read_bytes() for path in place.iterdir()} == before


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A folder with what the commands read."""
    shutil.copy(ROOT / "test-captures/commands.pcapng", tmp_path / "day.pcapng")
    (tmp_path / "log.txt").write_text("02 6C 00 00 00 92 00 00\n")
    (tmp_path / "table.csv").write_text("Time [s],Value,Parity Error,Framing Error\n0.001,0x02,,\n0.002,0x6C,,\n")
    (tmp_path / "messages.csv").write_text("0.125,M,0082 000C 0002\n")
    return tmp_path


@links
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.attack("a symbolic link where a command writes its file", "refused; nothing is written where it leads")
def test_a_link_is_refused(place: Path, command: str) -> None:
    (place / NAME).symlink_to(place / "victim")
    refused(place, words(command), NAME, "symbolic link")


@links
@pytest.mark.attack("a symbolic link in the place of the next file of a ring or a recorder", "another name is taken")
def test_a_link_in_the_place_of_the_next_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Their names can be foreseen."""
    monkeypatch.setattr("time.time", lambda: 1e9)
    ring, kept = tmp_path / "ring.pcapng", retention.new_name(tmp_path, HOUR_NS, "damaged")
    for foreseen in (Path(file_name(str(ring), 1, 1e9)), kept):
        foreseen.symlink_to(tmp_path / "victim")
    output = Output(str(ring), FileLimits(several=True))
    output.write(b"x")
    output.close()
    assert retention.new_name(tmp_path, HOUR_NS, "damaged") != kept
    assert not (tmp_path / "victim").exists()


@fifos
@pytest.mark.timeout(60)
@pytest.mark.attack("a pipe in the place of the next file of a ring or a recorder", "never waited for")
def test_a_pipe_in_the_place_of_the_next_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It comes after the name was chosen: whoever looks for a free name before opening is too early."""
    monkeypatch.setattr("time.time", lambda: 1e9)
    ring = tmp_path / "ring.pcapng"
    names = [Path(file_name(str(ring), 1, 1e9 + second)) for second in range(2)]
    os.mkfifo(names[0])
    monkeypatch.setattr("os.path.lexists", lambda _: False)
    output = Output(str(ring), FileLimits(several=True))
    output.write(b"x")
    output.close()
    assert names[1].read_bytes() == b"x"
    with pytest.raises(FileExistsError):
        Output(str(names[0]), is_new=True)


@pytest.mark.parametrize("command", COMMANDS)
def test_data_stay_without_force(place: Path, command: str) -> None:
    (place / NAME).write_text("precious")
    refused(place, words(command), f"{NAME} holds data already", "--force")


@modes
@pytest.mark.parametrize(
    "command",
    [pytest.param(command, marks=pytest.mark.thorough if command in ("compare", "log") else ()) for command in DERIVED],
)
@pytest.mark.attack("a file made from a private capture", "whoever may not read the capture may not read it")
def test_with_force_they_go_and_nobody_may_read_more(place: Path, command: str) -> None:
    """The old file is for all, one of the sources for its owner alone."""
    (place / NAME).write_text("precious")
    (place / NAME).chmod(0o644)
    for source in ("day.pcapng", "log.txt", "table.csv"):
        (place / source).chmod(0o600)
    done = run(place, *words(command), "--force")
    assert done.returncode == 0, done.stderr
    assert b"precious" not in (place / NAME).read_bytes()
    assert stat.S_IMODE((place / NAME).stat().st_mode) == 0o600
    assert not list(place.glob(".sistap-*"))


@modes
@pytest.mark.thorough
@pytest.mark.attack("a file made from a private capture", "whoever may not read the capture may not read it")
def test_tables_are_for_those_who_may_read_the_capture(place: Path) -> None:
    (place / "day.pcapng").chmod(0o600)
    assert run(place, "tables", "day.pcapng", "-o", "t").returncode == 0
    there = [place / "t", *(place / "t").rglob("*")]
    modes = {
        is_folder: {stat.S_IMODE(one.stat().st_mode) for one in there if one.is_dir() == is_folder}
        for is_folder in (False, True)
    }
    assert modes == {False: {0o600}, True: {0o700}}


@pytest.mark.parametrize("command", DERIVED)
def test_that_it_cannot_be_written_is_noticed_before_the_work(place: Path, command: str) -> None:
    """What is to be read is no good either, but only the work would notice that."""
    for source in ("day.pcapng", "table.csv", "log.txt"):
        (place / source).write_text("\0this is no capture at all, nor a text\n" * 9 + "0" * 19)
    missing = str(Path("no", NAME))
    refused(place, [*words(command)[:-1], missing], missing, "No such file or directory")


@posix("no /proc")
def test_that_a_folder_cannot_be_written_is_noticed_before_the_work(place: Path) -> None:
    refused(place, ["tables", "day.pcapng", "-o", "/proc"], "cannot write /proc")


@fifos
@pytest.mark.parametrize("command", ["parameters", "annotate -w"])
def test_a_fifo_is_written_as_it_is(place: Path, command: str) -> None:
    os.mkfifo(place / NAME)
    came: list[bytes] = []
    reader = threading.Thread(target=lambda: came.append((place / NAME).read_bytes()), daemon=True)
    reader.start()
    assert run(place, *words(command)).returncode == 0
    reader.join(60)
    assert came[0] and (place / NAME).is_fifo()


@posix("no /dev")
def test_standard_output_has_several_names(place: Path) -> None:
    plain = run(place, "parameters", "day.pcapng")
    for name in ("-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"):
        assert run(place, "parameters", "day.pcapng", "-o", name).stdout == plain.stdout
        assert run_with(place, b"", "annotate", "log.txt", "-w", name).stdout.startswith(b"\x0a\x0d\x0d\x0a")


def test_a_failure_leaves_the_old_file(tmp_path: Path) -> None:
    (tmp_path / "x").write_text("old")
    with pytest.raises(Refusal, match="x is incomplete: No space"), opened(str(tmp_path / "x"), force=True) as file:
        file.write(b"new")
        raise OSError(28, "No space left on device")
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("x", "old")]


def test_what_came_meanwhile_stays(tmp_path: Path) -> None:
    with pytest.raises(Refusal, match="x holds data already"), opened(str(tmp_path / "x")):
        (tmp_path / "x").write_text("of another")
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("x", "of another")]


def test_a_log_that_grows_is_in_its_place(tmp_path: Path) -> None:
    with opened(str(tmp_path / "x"), grows=True) as file:
        file.write(b"line")
        file.flush()
        assert (tmp_path / "x").read_text() == "line"
