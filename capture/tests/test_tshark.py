# SPDX-License-Identifier: GPL-2.0-or-later
"""Output of tshark line by line; a shell plays tshark."""

import errno
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from sistap import cli
from sistap.dissected.wireshark import tshark
from sistap.dissected.wireshark.tshark import NOBODY, Tshark, TsharkError


def test_lines_come_while_it_runs_and_the_rest_is_not_waited_for() -> None:
    with Tshark("sh") as shell:
        lines = shell.lines(["-c", "echo first; exec sleep 1000"])
        assert next(lines) == "first"
        lines.close()  # which ends the program


def test_what_it_said_comes_after_the_last_line() -> None:
    with Tshark("sh") as shell:
        lines = shell.lines(["-c", "echo one; echo why >&2; echo two; exit 3"])
        assert [next(lines), next(lines)] == ["one", "two"]
        with pytest.raises(TsharkError, match="^why$"):
            next(lines)


def test_much_on_stderr_does_not_block_it() -> None:
    with Tshark("sh") as shell:
        flood = (
            "i=0; while [ $i -lt 5000 ]; do echo 'a line as long as a pipe is deep, in the end' >&2; i=$((i+1)); done"
        )
        assert list(shell.lines(["-c", f"{flood}; echo done"])) == ["done"]


@pytest.mark.skipif(sys.platform == "win32", reason="there, a console has another way")
def test_ctrl_c_does_not_reach_one_that_still_gets_input(tmp_path: Path) -> None:
    """Otherwise `capture` as text would say that tshark has failed, at each Ctrl-C."""
    with Tshark("sh") as shell, (tmp_path / "errors").open("wb") as errors:
        process = shell.start(["-c", "read line; echo $line"], errors)
        assert os.getpgid(process.pid) != os.getpgid(0)
        assert process.communicate(b"as before\n")[0] == b"as before\n"


@pytest.mark.skipif(os.geteuid() != 0, reason="only root needs a copy")
def test_no_room_for_the_copy(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def full(source: object, copy: object, size: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    (tmp_path / "day.pcapng").touch()
    monkeypatch.chdir(tmp_path)
    with Tshark("sh") as shell:
        monkeypatch.setattr(shutil, "copyfileobj", full)
        with pytest.raises(TsharkError, match=r"no room for a copy of day\.pcapng.* TMPDIR$"):
            shell.output("-r", "day.pcapng")


@pytest.mark.skipif(os.geteuid() != 0, reason="only root needs a copy")
def test_no_room_for_the_plugins(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(shutil, "copyfileobj", full)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    with pytest.raises(TsharkError, match=r"no room for a copy of the plugins .* TMPDIR$"):
        Tshark("sh")
    assert not list(tmp_path.iterdir())


only_root = pytest.mark.skipif(os.geteuid() != 0, reason="only root runs tshark as somebody else")
SECRET = b"of root alone"


@pytest.fixture
def secret(tmp_path: Path) -> Path:
    path = tmp_path / "secret.pcapng"
    path.write_bytes(SECRET)
    path.chmod(0o600)
    return path


def run_on(capture: Path, command: str) -> list[str]:
    """The arguments of a shell that finds the capture after -r as $2, as tshark would."""
    return ["-c", command, "sh", "-r", str(capture)]


@only_root
def test_only_root_and_nobody_may_read_a_copy(secret: Path) -> None:
    with Tshark("sh") as shell:
        said = shell.output(*run_on(secret, 'stat -c "%u %a" . "$2"; cat "$2"')).splitlines()
    assert said == [f"{NOBODY} 700", f"{NOBODY} 600", SECRET.decode()]


@only_root
def test_each_capture_has_a_copy_of_its_own_that_goes_with_its_tshark(secret: Path) -> None:
    other = secret.with_name("other")
    other.write_bytes(b"another")
    command = 'echo "$2"; exec sleep 1000'
    with Tshark("sh") as shell:
        both = [shell.lines(run_on(capture, command)) for capture in (secret, other)]
        first, second = (Path(next(lines)) for lines in both)
        assert (first.read_bytes(), second.read_bytes()) == (SECRET, b"another")
        both[0].close()
        assert [path.name for path in first.parent.glob("capture*")] == [second.name]
    assert not first.parent.exists()


@only_root
def test_no_link_leads_a_copy_elsewhere(secret: Path, tmp_path: Path) -> None:
    """The folder belongs to nobody, and others may be nobody, too."""
    victim = tmp_path / "victim"
    victim.write_text("precious")
    with Tshark("sh") as shell:
        shell.output("-c", f"for name in capture capture-1 capture-2; do ln -s {victim} $name; done")
        assert shell.output(*run_on(secret, 'cat "$2"')) == SECRET.decode()
    assert victim.read_text() == "precious"


@only_root
def test_plugins_that_only_root_may_read_are_seen(tmp_path: Path) -> None:
    folder = tmp_path / "plugins/4.0/epan"
    folder.mkdir(parents=True)
    (folder / "x.so").write_text("a plugin")
    (folder / "x.so").chmod(0o600)
    with Tshark("sh", plugins=tmp_path / "plugins") as shell:
        assert shell.output("-c", "cat $WIRESHARK_PLUGIN_DIR/4.0/epan/x.so") == "a plugin"


def test_the_room_is_tshark_that_sees_the_plugin() -> None:
    command = [sys.executable, "-m", "sistap.dissected.wireshark", "-G", "plugins"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, "sis.so" in done.stdout) == (0, True), done.stderr


@only_root
@pytest.mark.attack("as root: WIRESHARK_PLUGIN_DIR names links, devices, pipes and folders of others", "not copied")
def test_only_regular_plugins_of_root_are_copied(tmp_path: Path) -> None:
    """A link led to a copy of /etc/shadow for nobody; /dev/zero filled the disk; a pipe held the command for ever."""
    folder = tmp_path / "plugins"
    (folder / "theirs").mkdir(parents=True)
    (tmp_path / "shadow").write_text("secret")
    for name in ("sis.so", "sis.lua", "notes.txt", "theirs/x.so", "foreign.lua"):
        (folder / name).write_text(name)
    (folder / "link.so").symlink_to(tmp_path / "shadow")
    (folder / "links").symlink_to(tmp_path)
    os.mkfifo(folder / "pipe.so")
    os.mknod(folder / "zero.so", 0o20444, os.makedev(1, 5))
    os.chown(folder / "theirs", NOBODY, NOBODY)
    (folder / "foreign.lua").chmod(0o666)
    with Tshark("sh", plugins=folder) as shell:
        found = shell.output("-c", 'cd "$WIRESHARK_PLUGIN_DIR" && find . ! -type d')
    assert sorted(found.split()) == ["./sis.lua", "./sis.so"]


@only_root
@pytest.mark.attack("as root: WIRESHARK_PLUGIN_DIR names links, devices, pipes and folders of others", "not copied")
def test_a_folder_in_which_others_write_is_ignored(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "plugins").mkdir()
    (tmp_path / "plugins/evil.so").touch()
    (tmp_path / "plugins").chmod(0o777)
    with Tshark("sh", plugins=tmp_path / "plugins") as shell:
        assert shell.output("-c", "echo $WIRESHARK_PLUGIN_DIR") == "\n"
    assert "WIRESHARK_PLUGIN_DIR is ignored, because others than root can write to" in capfd.readouterr().err


@pytest.mark.attack("tshark floods its standard error", "the end of it is kept")
def test_a_flood_on_stderr_fills_no_disk() -> None:
    with Tshark("sh") as shell:
        lines = shell.lines(["-c", "head -c 50000000 /dev/zero | tr '\\0' x >&2; echo; echo why >&2; exit 3"])
        assert next(lines) == ""
        with pytest.raises(TsharkError) as error:
            next(lines)
    size, end = len(str(error.value)), str(error.value)[-5:]
    assert end == "xxwhy" and size < 100_000


# What tshark is, how long sistap waits for its answer, and what it says then.
ENDLESS = {
    "a question is never answered": ("exec sleep 1000", 0.5, "does not end within 0.5 s"),
    "a program of it goes on": ("cat ${0%/*}/held & echo 4.0", 0.5, "does not end within 0.5 s"),
    "an answer ends, but tshark does not": ("exec sleep 1000 >&-", 0.5, "does not end within 0.5 s"),
    "an answer has no end": ("exec tr '\\0' x </dev/zero", tshark.ANSWER_S, "answers more than 1,000 bytes"),
}


@pytest.fixture
def open_folder() -> Iterator[Path]:
    """A folder that nobody may enter, too. Who reads the pipe `held` in it goes on until the end of the test."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o755)
        held = Path(folder, "held")
        os.mkfifo(held)
        descriptor = os.open(held, os.O_RDWR)
        yield Path(folder)
        held.unlink()  # so that nobody comes late
        os.close(descriptor)


@pytest.mark.attack("a tshark that hangs, or that answers without end", "a line names it after a while, with the cure")
@pytest.mark.parametrize("script", ENDLESS)
@pytest.mark.timeout(100)
def test_a_question_has_limits(
    monkeypatch: pytest.MonkeyPatch, open_folder: Path, capfd: pytest.CaptureFixture[str], script: str
) -> None:
    command, answer_s, what = ENDLESS[script]
    program = open_folder / "tshark"
    program.write_text(f"#!/bin/sh\n{command}\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(program.parent), prepend=os.pathsep)
    monkeypatch.setattr(tshark, "ANSWER_S", answer_s)
    monkeypatch.setattr(tshark, "ANSWER_BYTES", 1000)
    cure = "reinstall Wireshark, or take another by `sistap install --wireshark FOLDER`"
    assert cli.main(["install"]) == 1
    assert capfd.readouterr().err == f"sistap: {program} --version {what}: {cure}\n"
    assert cli.main(["doctor"]) == 1
    assert f"bad   tshark     {program} --version {what}: {cure}\n" in capfd.readouterr().out


def test_an_answer_and_what_was_said_beside_it() -> None:
    with Tshark("sh") as shell:
        done = shell.ask("-c", "echo yes; echo but >&2; exit 3")
        assert (done.returncode, done.stdout, done.stderr) == (3, "yes\n", "but")
        with pytest.raises(TsharkError, match="^sh: but$"):
            shell.answer("-c", "echo but >&2; exit 3")
