# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap doctor`: each point good and bad, its cure, and the exit code."""

import ctypes.util
import errno
import fcntl
import os
import pty
import shutil
import subprocess
import sys
import termios
import tty
from collections.abc import Iterator
from pathlib import Path

import pytest
import serial
from portable import descriptors
from real_driver import Driver

from sistap import cli
from sistap.commands import doctor
from sistap.commands.doctor import Point
from sistap.dissected.wireshark.tshark import TsharkError
from sistap.tap.analyser import probe, reader
from sistap.tap.analyser.probe import Analyser
from sistap.tap.line import measurement, others, ports, priority
from sistap.tap.line.reader import latency

TSHARK = "TShark (Wireshark) 4.2.5 (Git v4.2.5 packaged as 4.2.5-1).\n"
PLUGIN = (
    "ciscodump \t1.0.0\textcap\t/usr/lib/extcap/ciscodump\nsis.so    \t0.1.0\tdissector\t/plugins/4.2/epan/sis.so\n"
)
LUA = "sis.lua\t0.1.0\tlua script\t/plugins/sis.lua\n"
FITTING = measurement.Result("machine", "2026-11-20", 5000, 250_000, 3_000_000, {})


class FakeTshark:
    """Returns scripted output."""

    version, plugins, complaints, error = TSHARK, PLUGIN, "", ""

    def __enter__(self) -> "FakeTshark":
        if self.error:
            raise TsharkError(self.error)
        return self

    def __exit__(self, *error: object) -> None: ...

    def answer(self, *arguments: str) -> str:
        return {("--version",): self.version, ("-G", "folders"): ""}[arguments]

    def ask(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        assert arguments == ("-G", "plugins")
        return subprocess.CompletedProcess(arguments, 0, self.plugins, self.complaints)


@pytest.fixture(autouse=True)
def healthy(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A computer without problems; return its /proc, in which one program runs."""
    (tmp_path / "1/fd").mkdir(parents=True)
    (tmp_path / "1/comm").write_text("systemd\n")
    (tmp_path / "self/ns").mkdir(parents=True)
    (tmp_path / "self/ns/pid").symlink_to("pid:[4026531836]")  # not of a container
    monkeypatch.setattr(others, "PROC", tmp_path)
    monkeypatch.setattr(doctor, "Tshark", FakeTshark)
    monkeypatch.setattr(doctor, "Filter", lambda text: None)
    monkeypatch.setattr(doctor, "UNITS", [tmp_path])
    dumpcap = tmp_path / "dumpcap"
    dumpcap.touch(0o755)
    monkeypatch.setattr(shutil, "which", lambda name, **how: str(dumpcap) if how else f"/usr/bin/{name}")
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    monkeypatch.setattr(ports, "found", lambda: [("/dev/ttyUSB0", ports.Adapter("FT232R", "ftdi_sio", latency_ms=16))])
    monkeypatch.setattr(priority, "is_real_time", lambda: True)
    monkeypatch.setattr(latency, "measured_ns", lambda: 300_000)
    measurement.store(FITTING._replace(conditions=measurement.conditions()))
    return tmp_path


@pytest.fixture
def port() -> Iterator[str]:
    master, slave = pty.openpty()
    tty.setraw(slave)
    yield os.ttyname(slave)
    for descriptor in (master, slave):
        os.close(descriptor)


def examined(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, dict[str, tuple[str, str]]]:
    """Run it; return the exit code and, by subject, mark and text of its points."""
    code = cli.main(["doctor", *arguments])
    rows = [line.split(maxsplit=2) for line in capsys.readouterr().out.splitlines()]
    assert len({row[1] for row in rows}) == len(rows)
    return code, {subject: (mark, text) for mark, subject, text in rows}


def test_all_is_well(capsys: pytest.CaptureFixture[str]) -> None:
    code, points = examined(capsys)
    assert code == 0
    assert points == {
        "pyserial": ("good", serial.__version__),
        "ports": ("good", "/dev/ttyUSB0 (FT232R (ftdi_sio, latency timer 16 ms))"),
        "priority": ("good", "a capture gets real-time priority"),
        "self-test": ("good", "of 2026-11-20: 99.9 % of 5000 characters within 0.25 ms"),
        "libpcap": ("good", "capture filters work (-f)"),
        "tshark": ("good", "4.2.5, with Wireshark"),
        "plugin": ("good", "sis.so 0.1.0"),
        "dumpcap": ("good", "Wireshark may capture"),
    }


def test_what_could_be_better_is_no_failure(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, healthy: Path
) -> None:
    (healthy / "1/comm").write_text("ModemManager\n")
    monkeypatch.setattr(ports, "found", list)
    monkeypatch.setattr(priority, "is_real_time", lambda: False)
    monkeypatch.setattr(shutil, "which", lambda name, **how: None)
    code, points = examined(capsys)
    assert code == 0
    for subject, cure in {
        "ports": "plug the adapter in",
        "others": "it writes to new ports, looking for modems: `systemctl stop ModemManager` as root",
        "priority": "run sistap as root, or put `@dialout - rtprio 1` into /etc/security/limits.conf",
        "self-test": "run `sistap selftest` again",  # it was made with real-time priority
        "tshark": "`apt-get install wireshark`",
    }.items():
        mark, text = points[subject]
        assert mark == "poor"
        assert cure in text


def test_no_libpcap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    assert [point.mark for point in doctor._libpcap()] == ["good"]
    monkeypatch.setattr(ctypes.util, "find_library", lambda name: "libMISSING.so")
    (point,) = doctor._libpcap()
    assert point == Point(
        "poor", "libpcap", "a capture filter needs libpcap: install the package libpcap0.8 (or libpcap)"
    )


def test_no_self_test(capsys: pytest.CaptureFixture[str], state: Path) -> None:
    file = state / "sistap/selftest.json"
    file.write_text("{")
    assert "is not what `sistap selftest` writes" in examined(capsys)[1]["self-test"][1]
    file.unlink()
    assert "`sistap selftest` measures how exact the times are" in examined(capsys)[1]["self-test"][1]


@pytest.mark.parametrize(
    ("attribute", "value", "subject", "text"),
    [
        (
            "error",
            "tshark is not on PATH; Debian and Ubuntu: apt-get install tshark",
            "tshark",
            "apt-get install tshark",
        ),
        ("version", "TShark (Wireshark) 3.6.2 (Git)\n", "tshark", "3.6.2 is too old: install 4.0 or later"),
        ("version", "", "tshark", "install tshark 4.0 or later"),
        ("plugins", "", "plugin", "neither sis.so nor sis.lua is loaded: `sistap install` puts it"),
        ("plugins", "sis-sanitized.so\t0.1.0\tdissector\t/x\nbasis.so\t1\tdissector\t/y\n", "plugin", "neither sis.so"),
    ],
)
def test_what_is_missing_is_a_failure(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    attribute: str,
    value: str,
    subject: str,
    text: str,
) -> None:
    monkeypatch.setattr(FakeTshark, attribute, value)
    code, points = examined(capsys)
    assert code == 1
    assert points[subject][0] == "bad"
    assert text in points[subject][1]
    assert [at for at, point in points.items() if point[0] == "bad"] == [subject]


def test_the_lua_fallback_will_do(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FakeTshark, "plugins", LUA)
    code, points = examined(capsys)
    assert (code, points["plugin"]) == (0, ("good", "sis.lua 0.1.0"))


def test_dumpcap_for_a_group_only(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, healthy: Path
) -> None:
    dumpcap = healthy / "dumpcap"
    monkeypatch.setattr(Path, "group", lambda path: "wireshark")
    dumpcap.chmod(0o644)
    code, points = examined(capsys)
    assert code == 1
    assert points["dumpcap"] == (
        "bad",
        f"Wireshark cannot capture: {dumpcap} is for group wireshark: "
        "`sudo usermod -aG wireshark $USER`, then log in again",
    )


def test_why_a_plugin_does_not_load(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    complaint = "tshark: The plugin 'sis.so' was compiled for Wireshark version 4.0"
    monkeypatch.setattr(FakeTshark, "plugins", "")
    monkeypatch.setattr(FakeTshark, "complaints", f"Running as user root.\n{complaint}\n")
    assert f"({complaint})" in examined(capsys)[1]["plugin"][1]


@pytest.mark.parametrize(("plugins", "mark"), [(PLUGIN, "good"), ("", "bad")])
def test_as_root(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, plugins: str, mark: str) -> None:
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    monkeypatch.setattr(FakeTshark, "plugins", plugins)
    at = examined(capsys)[1]["plugin"]
    assert at[0] == mark
    assert "run as root, Wireshark skips" in at[1]


@pytest.mark.skipif(sys.platform != "linux", reason="the group of Linux")
@pytest.mark.parametrize(("groups", "mark"), [([], "poor"), ([20], "")])
def test_the_group_of_ports_before_there_is_one(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, groups: list[int], mark: str
) -> None:
    """Joining it takes a new login, which nobody wants at the machine."""
    import grp  # noqa: PLC0415 - not on Windows

    monkeypatch.setattr(ports, "found", list)
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    monkeypatch.setattr(os, "getgroups", lambda: groups)
    monkeypatch.setattr(grp, "getgrnam", lambda name: grp.struct_group((name, "x", 20, [])))
    assert examined(capsys)[1].get("group", ("", ""))[0] == mark


# -- A port ------------------------------------------------------------------------------------------------------------


def test_a_port(capsys: pytest.CaptureFixture[str], port: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(others, "is_root", lambda: True)
    code, points = examined(capsys, "-i", port)
    assert code == 0
    assert points["port"] == ("good", "it exists")
    assert points["rights"] == ("good", "you may open it")
    assert points["opens"] == ("good", "it opens, and no other program has it")
    assert points["adapter"] == ("good", "pseudo terminal")
    assert points["times"][1].startswith("uncertainty 0.25 ms, measured by selftest on 2026-11-20")


def test_times_whose_bound_is_not_known_are_poor(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, port: str
) -> None:
    Driver(monkeypatch)  # of a CP2102
    assert cli.main(["doctor", "-i", port]) == 0
    times = [line for line in capsys.readouterr().out.splitlines() if line[6:].startswith("times")]
    assert [line[:4] for line in times] == ["poor", "poor"]
    assert "what the adapter adds is not known" in times[0]
    assert f"`sistap selftest -i {port} --transmit` measures it" in times[1]


@pytest.mark.parametrize(
    ("driver", "mark", "said"),
    [
        ("cp210x", "good", "line errors at their character. Some copies of the CP2102 report nothing"),
        (
            "pl2303",
            "poor",
            "their USB packet. A break looks like any other error. Lost characters are not reported",
        ),
        (
            "ch341-uart",
            "poor",
            "no line errors are reported. A damaged character looks like a good one. FTDI",
        ),
        ("unheard-of", "", ""),
    ],
)
def test_what_the_driver_says_about_line_errors(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, port: str, driver: str, mark: str, said: str
) -> None:
    Driver(monkeypatch, driver=driver)
    assert cli.main(["doctor", "-i", port]) == 0
    lines = capsys.readouterr().out.splitlines()
    found = [line for line in lines if line[6:].startswith("errors")]
    assert [line[:4] for line in found] == ([mark] if mark else [])
    assert not any("Lost characters" in line or "looks like" in line for line in lines if line not in found)
    assert said in "".join(found)


@pytest.fixture
def timer(monkeypatch: pytest.MonkeyPatch, port: str, tmp_path: Path) -> Path:
    """The latency timer of the port, as if it were an FTDI adapter; at 16 ms."""
    timer = tmp_path / "bus/usb-serial/devices" / Path(port).name / "latency_timer"
    timer.parent.mkdir(parents=True)
    timer.write_text("16\n")
    monkeypatch.setattr(ports, "SYSFS", tmp_path)
    return timer


def test_what_tuning_can_do_is_said_and_undone(capsys: pytest.CaptureFixture[str], port: str, timer: Path) -> None:
    code, points = examined(capsys, "-i", port)
    assert (code, points["times"][0]) == (0, "good")
    assert "; latency timer 16 -> 1 ms; " in points["times"][1]
    assert timer.read_text() == "16"


def test_what_tuning_cannot_do_is_poor(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, port: str, timer: Path
) -> None:
    def refuse(file: Path, text: str) -> int:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(Path, "write_text", refuse)
    assert cli.main(["doctor", "-i", port]) == 0
    (line,) = (line for line in capsys.readouterr().out.splitlines() if "latency timer stays" in line)
    assert line.startswith("poor  times")
    assert f"up to 16.0 ms late: `echo 1 | sudo tee {timer}`" in line


def test_a_port_is_let_go_and_its_lines_are_not_raised(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, port: str
) -> None:
    lines: list[int] = []
    real = fcntl.ioctl
    modem = (termios.TIOCMGET, termios.TIOCMSET, termios.TIOCMBIS, termios.TIOCMBIC)

    def ioctl(fd: int, request: int, *rest: object) -> object:
        if request in modem:  # a pty has no modem lines, a real port does
            lines.append(request)
            return rest[0]
        return real(fd, request, *rest)  # type: ignore[call-overload]

    monkeypatch.setattr(fcntl, "ioctl", ioctl)
    open_before = descriptors()
    assert examined(capsys, "-i", port)[0] == 0
    assert set(lines) == {termios.TIOCMBIC}  # DTR and RTS down
    assert descriptors() <= open_before
    serial.Serial(port, exclusive=True).close()


@pytest.mark.parametrize(
    ("name", "bad", "good"),
    [
        ("/dev/ttyMISSING7", "port", []),
        ("/dev/null", "opens", ["port", "rights"]),
        ("socket://127.0.0.1:1", "port", []),
        ("bus://127.0.0.1:1", "port", []),
    ],
)
def test_a_port_that_cannot_be_opened(capsys: pytest.CaptureFixture[str], name: str, bad: str, good: list[str]) -> None:
    code, points = examined(capsys, "-i", name)
    assert code == 3
    assert points[bad][0] == "bad"
    assert name in points[bad][1] and ": " in points[bad][1]
    assert [subject for subject in points if subject in ("port", "rights", "opens")] == [*good, bad]


def test_a_port_without_rights(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, port: str) -> None:
    def deny(self: serial.Serial) -> None:
        raise serial.SerialException(13, f"could not open port {self.port}: Permission denied")

    monkeypatch.setattr(serial.Serial, "open", deny)
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    code, points = examined(capsys, "-i", port)
    assert code == 3
    assert points["port"][0] == "good"
    assert points["rights"][0] == "bad" and points["rights"][1].startswith(f"no permission to open {port}: ")
    assert "opens" not in points


def test_a_port_that_another_program_may_read(capsys: pytest.CaptureFixture[str], port: str, healthy: Path) -> None:
    process = healthy / "4711"
    for folder in ("fd", "fdinfo"):
        (process / folder).mkdir(parents=True)
    for file, text in {"comm": "cat\n", "cmdline": f"cat\0{port}\0", "fdinfo/3": "pos:\t0\n"}.items():
        (process / file).write_text(text)
    (process / "fd/3").symlink_to(port)
    code, points = examined(capsys, "-i", port)
    said = f"another program may read {port}: cat (pid 4711, user {process.owner()}), end it with `kill 4711`"
    assert code == 3
    assert points["opens"] == ("bad", said)
    assert points["times"][0] == "good"


def test_who_cannot_see_all_programs_does_not_say_that_there_is_none(
    capsys: pytest.CaptureFixture[str], port: str
) -> None:
    code, points = examined(capsys, "-i", port)
    doubt = f"it opens; whether another program has it cannot be known: run `sistap doctor -i {port}` as root"
    assert (code, points["opens"]) == (0, ("good", doubt))


def test_a_busy_port(capsys: pytest.CaptureFixture[str], port: str) -> None:
    other = serial.Serial(port, exclusive=True)
    code, points = examined(capsys, "-i", port)
    other.close()
    assert code == 3
    assert points["opens"][0] == "bad" and "is in use by another program" in points["opens"][1]


def test_a_port_that_fails_outweighs_what_is_missing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FakeTshark, "plugins", "")
    assert examined(capsys, "-i", "/dev/ttyMISSING7")[0] == 3


WITHOUT_PYSERIAL = "import sys; sys.modules['serial'] = None; from sistap.cli import main; sys.exit(main(sys.argv[1:]))"


def test_without_pyserial() -> None:
    command = [sys.executable, "-c", WITHOUT_PYSERIAL, "doctor", "-i", "/dev/ttyUSB0"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert f"bad   pyserial   pyserial is missing for {sys.executable}: " in done.stdout
    assert f"{sys.executable} -P -m pip install pyserial" in done.stdout
    assert done.stderr == ""


@pytest.mark.parametrize(("state", "mark"), [("active", "good"), ("failed", "poor"), ("", "poor")])
def test_the_service_of_a_recorder(
    healthy: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], state: str, mark: str
) -> None:
    def run(command: list[str], **how: object) -> subprocess.CompletedProcess[str]:
        assert command == ["systemctl", "is-active", "sistap-recorder.service"]
        return subprocess.CompletedProcess(command, 0, f"{state}\n", "")

    monkeypatch.setattr(subprocess, "run", run)
    assert cli.main(["doctor"]) == 0
    assert "recorder" not in capsys.readouterr().out
    (healthy / "sistap-recorder.service").touch()
    assert cli.main(["doctor"]) == 0
    assert f"{mark}  recorder   sistap-recorder.service " in capsys.readouterr().out


def plug(monkeypatch: pytest.MonkeyPatch, device: Path) -> None:
    monkeypatch.setattr(probe, "plugged_in", lambda: [Analyser("Logic", "1.2", device)])


def test_analyser(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    device = tmp_path / "002"
    plug(monkeypatch, device)
    monkeypatch.setattr(probe, "FIRMWARE", tmp_path)

    def point() -> tuple[str, str]:
        return examined(capsys)[1]["analyser"]

    assert "no permission" in point()[1]
    assert "plugdev" in point()[1]
    device.touch()
    assert "sigrok-firmware-fx2lafw" in point()[1]
    (tmp_path / "fx2lafw-saleae-logic.fw").touch()
    assert point() == ("good", "Logic (sigrok:fx2lafw:conn=1.2?rx=D0)")
    monkeypatch.setattr(probe, "program", lambda: None)
    assert point()[0] == "poor"
    assert "apt-get install sigrok-cli" in point()[1]


def test_analyser_that_is_not_there(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(probe, "plugged_in", list)
    for module in (probe, reader):
        monkeypatch.setattr(module, "program", lambda: None)
    code, points = examined(capsys, "-i", "sigrok:fx2lafw?rx=D0")
    assert code == 3
    assert points["sigrok-cli"][0] == points["analyser"][0] == points["port"][0] == "bad"
