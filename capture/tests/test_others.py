# SPDX-License-Identifier: GPL-2.0-or-later
"""Other programs at a port: who is found, what is said where that cannot be known, and ports that are exclusive."""

from __future__ import annotations

import errno
import os
import pty
import shutil
import subprocess
import sys
import tty
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from sistap.tap.line import others, ports
from sistap.tap.line.others import Others
from sistap.tap.line.reader import PortError, latency, open_reader
from sistap.tap.line.settings import LineSettings

pytestmark = pytest.mark.tap

needs_root = pytest.mark.skipif(os.geteuid() != 0, reason="becomes another user, which takes root")
NOBODY = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
OF_ALL = "pid:[4026531836]"  # Linux, <linux/proc_ns.h>: PROC_PID_INIT_INO is 0xEFFFFFFC


@pytest.fixture
def line(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[int, str]]:
    """A pseudo terminal, of which this process has both ends: that of the bus, and the name of the other."""
    monkeypatch.setattr(latency, "measured_ns", lambda: 0)
    master, slave = pty.openpty()
    tty.setraw(slave)
    yield master, os.ttyname(slave)
    for descriptor in (master, slave):
        os.close(descriptor)


@pytest.fixture
def port(line: tuple[int, str]) -> str:
    return line[1]


Start = Callable[..., "subprocess.Popen[bytes]"]


@pytest.fixture
def start() -> Iterator[Start]:
    """Start programs; they end with the test."""
    with ExitStack() as ended:

        def start(*command: str) -> subprocess.Popen[bytes]:
            process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
            ended.callback(process.__exit__, None, None, None)
            ended.callback(process.kill)
            return process

        yield start


@pytest.fixture
def cat(start: Start, line: tuple[int, str]) -> subprocess.Popen[bytes]:
    """The program `cat`, which has read a character of the port."""
    process = start("cat", line[1])
    assert process.stdout
    os.write(line[0], b"x")
    assert process.stdout.read(1) == b"x"
    return process


def ready(process: subprocess.Popen[bytes]) -> str:
    """Wait until a program says something."""
    assert process.stdout
    return process.stdout.readline().decode().strip()


# -- In the real /proc -------------------------------------------------------------------------------------------------


def test_a_program_that_reads_too(cat: subprocess.Popen[bytes], port: str, tmp_path: Path) -> None:
    link = tmp_path / "usb-FTDI-if00-port0"
    link.symlink_to(port)
    user = Path("/proc/self").owner()
    said = f"cat (pid {cat.pid}, user {user}), end it with `kill {cat.pid}`"
    for name in (port, str(link)):
        assert others.look(name).known == said
    assert others.look(port).warning(port) == f"another program may read {port}: {said}"


def test_this_program_is_no_other_nor_who_only_writes_nor_who_has_ended(
    cat: subprocess.Popen[bytes], start: Start, port: str
) -> None:
    writes = start("sh", "-c", 'exec 3>"$0"; echo; read x', port)
    ready(writes)
    assert f"pid {writes.pid}," not in others.look(port).known
    cat.kill()
    cat.wait()
    assert others.look(port).known == ""


BUS = """
import os
master, slave = os.openpty()
print(os.ttyname(slave), flush=True)
input()
"""


def test_the_bus_at_the_other_end_is_no_other(start: Start) -> None:
    port = ready(start(sys.executable, "-c", BUS))
    assert others.look(port).known == ""
    start("cat", port)  # of another bus
    assert "python" not in others.look(port).known


CONTAINER = """
mount -t devpts -o newinstance,ptmxmode=666 none "$1" && exec "$2" -c '
import fcntl, os, struct, subprocess, sys
folder, number = sys.argv[1], int(sys.argv[2])
for _ in range(number + 1):
    last = os.open(folder + "/ptmx", os.O_RDWR | os.O_NOCTTY)
    fcntl.ioctl(last, 0x40045431, struct.pack("i", 0))  # TIOCSPTLCK
with subprocess.Popen(["cat", f"{folder}/{number}"], stdout=subprocess.PIPE) as cat:
    os.write(last, b"ready\\n")
    print(os.read(cat.stdout.fileno(), 9), flush=True)
    input()
    cat.kill()
' "$1" "$3"
"""


@needs_root
def test_a_container_has_pseudo_terminals_of_its_own_with_the_same_numbers(
    start: Start, port: str, tmp_path: Path
) -> None:
    if not shutil.which("unshare") or subprocess.run(["unshare", "-m", "true"], check=False).returncode:
        pytest.skip("unshare, which makes something like a container, is missing or not permitted, as in a chroot")
    folder = tmp_path / "dev/pts"
    folder.mkdir(parents=True)
    container = start("unshare", "-m", "sh", "-c", CONTAINER, "sh", str(folder), sys.executable, Path(port).name)
    assert "ready" in ready(container)
    assert others.look(port).known == ""
    assert container.stdin
    container.stdin.write(b"\n")
    container.stdin.flush()
    container.wait()


@needs_root
def test_who_is_not_root_cannot_know(start: Start, cat: subprocess.Popen[bytes], port: str) -> None:
    script = "import sys; from sistap.tap.line import others; print(*others.look(sys.argv[1]), sep='|')"
    known, unknown = ready(start(*NOBODY, sys.executable, "-c", script, port)).split("|")
    assert (known, unknown) == ("", f"run `sistap doctor -i {port}` as root")


@pytest.mark.parametrize("port", ["socket://127.0.0.1:1", "rfc2217://h:1", "bus://h:1", "", "a\0b", "/missing"])
def test_what_is_no_device_has_no_others(port: str) -> None:
    assert others.look(port) == Others()


def test_files_and_pipes_have_no_others(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    os.mkfifo(tmp_path / "fifo")
    for path in (tmp_path, tmp_path / "file", tmp_path / "fifo"):
        assert others.look(str(path)) == Others()


# -- In a /proc of the test --------------------------------------------------------------------------------------------


class Proc:
    """A /proc in which nothing runs yet."""

    def __init__(self, folder: Path, port: str) -> None:
        self._folder, self._port = folder, port
        self.pids = OF_ALL

    @property
    def pids(self) -> str:
        return str((self._folder / "self/ns/pid").readlink())

    @pids.setter
    def pids(self, kind: str) -> None:
        link = self._folder / "self/ns/pid"
        link.parent.mkdir(parents=True, exist_ok=True)
        link.unlink(missing_ok=True)
        link.symlink_to(kind)

    def add(self, pid: int, comm: str, *words: str, file: str = "") -> Path:
        """Add a process that has a file open: the port, if it is not given."""
        process = self._folder / str(pid)
        (process / "fd").mkdir(parents=True)
        (process / "fdinfo").mkdir()
        (process / "fd/3").symlink_to(file or self._port)
        (process / "fdinfo/3").write_text("pos:\t0\nflags:\t02100002\n")
        (process / "comm").write_text(comm + "\n")
        (process / "cmdline").write_text("".join(f"{word}\0" for word in words))
        return process


@pytest.fixture
def proc(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, port: str) -> Proc:
    monkeypatch.setattr(others, "PROC", tmp_path)
    monkeypatch.setattr(others, "is_root", lambda: True)
    return Proc(tmp_path, port)


def test_root_sees_that_there_is_no_other(proc: Proc, port: str) -> None:
    proc.add(7, "sshd", file="/dev/null")
    proc.add(8, "bash", file="socket:[1234]")
    proc.add(os.getpid(), "python3")
    assert others.look(port) == Others()


@pytest.mark.parametrize(
    ("comm", "words", "said"),
    [
        (
            "ModemManager",
            [],
            "ModemManager (pid 9, user {}), it writes to new ports, looking for modems: `sudo",
        ),
        ("brltty", [], "brltty (pid 9, user {}), it takes adapters for braille displays: "),
        ("agetty", [], "agetty (pid 9, user {}), it offers a login: `sudo systemctl stop serial-getty@{}`"),
        ("sistap", [], "sistap (pid 9, user {}), end it with `kill 9`"),
        ("python3", ["python3", "-m", "sistap", "capture"], "sistap (pid 9, user {}), "),
        ("python3", ["python3", "-c", "sistap()"], "python3 (pid 9, user {}), "),
    ],
)
def test_names_and_cures(proc: Proc, port: str, comm: str, words: list[str], said: str) -> None:
    process = proc.add(9, comm, *words)
    assert others.look(port).known.startswith(said.format(process.owner(), Path(port).name))


@pytest.mark.parametrize("gone", ["comm", "fd/3", "fdinfo/3", "fd"])
def test_a_process_that_ends_meanwhile_is_none(proc: Proc, port: str, tmp_path: Path, gone: str) -> None:
    (proc.add(5, "cat") / gone).rename(tmp_path / "gone")
    assert others.look(port) == Others()


def test_a_file_that_was_just_closed_hides_no_other(proc: Proc, port: str) -> None:
    (proc.add(5, "cat") / "fd/2").symlink_to("/dev/missing")
    assert others.look(port).known.startswith("cat (pid 5,")


def test_a_process_that_cannot_be_looked_at_leaves_a_doubt(
    proc: Proc, port: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    scan = os.scandir

    def deny(path: Path) -> Iterator[os.DirEntry[str]]:
        if "/5/" in str(path):
            raise PermissionError(errno.EACCES, "Permission denied")
        return scan(path)

    proc.add(5, "hidden")
    monkeypatch.setattr(os, "scandir", deny)
    assert others.look(port) == Others("", f"run `sistap doctor -i {port}` as root outside of any container")
    proc.add(6, "cat")
    assert others.look(port).known.startswith("cat (pid 6,")
    monkeypatch.setattr(others, "is_root", lambda: False)
    assert others.look(port).unknown == f"run `sistap doctor -i {port}` as root"


def test_a_container_hides_what_runs_outside(proc: Proc, port: str) -> None:
    proc.pids = "pid:[4026532201]"
    assert others.look(port) == Others("", f"run `sistap doctor -i {port}` as root outside of any container")


def test_without_proc_another_program_knows(proc: Proc, port: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(others, "PROC", Path("/missing"))
    assert others.look(port) == Others("", f"`sudo lsof {port}` names it")


def test_a_file_that_is_no_device_is_not_asked(proc: Proc, port: str, tmp_path: Path) -> None:
    """One on a network drive that is gone would never answer."""
    device = tmp_path / "not in the folder of devices"
    device.symlink_to(port)
    proc.add(9, "tail", file=str(device))
    assert others.look(port) == Others()


# -- Exclusive ports ---------------------------------------------------------------------------------------------------


@needs_root
def test_nobody_else_can_open_a_port_that_is_read(port: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """One with hardware: its claim ends when it is closed."""
    monkeypatch.setattr(ports, "adapter", lambda _: ports.Adapter())
    os.chown(port, 65534, 65534)
    opening = [*NOBODY, "sh", "-c", 'exec 3<"$0"', port]
    assert subprocess.run(opening, check=False).returncode == 0
    reader = open_reader(port, LineSettings(parity="N"))
    refused = subprocess.run(opening, capture_output=True, text=True, check=False)
    assert refused.returncode and "busy" in refused.stderr
    reader.close()


READ = """
import sys
from sistap.tap.line.reader import open_reader
from sistap.tap.line.settings import LineSettings
reader = open_reader(sys.argv[1], LineSettings())
print("reads", flush=True)
reader.read(60)
"""


@needs_root
def test_a_reader_that_is_killed_leaves_no_claim_of_a_pseudo_terminal(start: Start, port: str) -> None:
    """There a claim would stay, and stop an ordinary user, until the bus closes its end."""
    os.chown(port, 65534, 65534)
    for _ in range(2):
        reader = start(*NOBODY, sys.executable, "-c", READ, port)
        assert ready(reader) == "reads"
        reader.kill()
        reader.wait()


HOLD = "import fcntl, sys, termios; port = open(sys.argv[1]); {}; print(flush=True); input()"
CLAIM, LOCK = HOLD.format("fcntl.ioctl(port, termios.TIOCEXCL)"), HOLD.format("fcntl.flock(port, fcntl.LOCK_EX)")


@needs_root
def test_root_does_not_ignore_a_claim(start: Start, port: str) -> None:
    other = start(sys.executable, "-c", CLAIM, port)
    ready(other)
    with pytest.raises(PortError, match=rf"^{port} is in use by python[\d.]* \(pid {other.pid}, user root\), end"):
        open_reader(port, LineSettings())


def test_who_reads_before_is_named_when_the_port_is_opened(cat: subprocess.Popen[bytes], port: str) -> None:
    reader = open_reader(port, LineSettings())
    reader.close()
    assert reader.notes[0].startswith(f"another program may read {port}: cat (pid {cat.pid}, ")


def test_a_locked_port_names_who_has_it(start: Start, port: str) -> None:
    other = start(sys.executable, "-c", LOCK, port)
    ready(other)
    with pytest.raises(PortError, match=rf"^{port} is in use by .*\(pid {other.pid}, "):
        open_reader(port, LineSettings())
