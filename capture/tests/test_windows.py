# SPDX-License-Identifier: GPL-2.0-or-later
"""What Windows lacks: reported in one line, or not used."""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import errno
import os
import re
import socket
import subprocess
import sys
import threading
import types
from array import array
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import Any, NamedTuple

import pytest

from sisbus.wires import place, port
from sistap import cli
from sistap.commands.install import shell, userpath
from sistap.dissected.wireshark.tshark import Tshark, TsharkError, environment
from sistap.tap.analyser import probe
from sistap.tap.capture.filter import candidates, opened
from sistap.tap.common import pages
from sistap.tap.files.output import Output, ReaderGone
from sistap.tap.line import measurement, ports
from sistap.tap.line.reader import PortError, PortLost, computer, open_reader
from sistap.tap.line.settings import LineSettings
from sistap.tap.terminal import programs, state
from sistap.tap.terminal.advice import shell_word
from sistap.tap.terminal.console import Console, is_reader_gone
from sistap.tap.terminal.exits import Refusal
from sistap.tap.terminal.stop import Stop

PATIENCE_S = 20


class Status(NamedTuple):
    """As much of a file's status as Windows has."""

    st_mode: int = 0o100666


@pytest.fixture
def windows(monkeypatch: pytest.MonkeyPatch) -> None:
    """As much of it as these tests need."""
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.delattr(socket, "AF_UNIX", raising=False)
    monkeypatch.delattr(os, "major", raising=False)


@pytest.mark.usefixtures("windows")
def test_a_port_is_no_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Path, "stat", lambda *_, **__: Status())
    assert not ports.is_own_terminal("COM5")
    assert not ports.adapter("COM5").pseudo_terminal


@pytest.mark.usefixtures("windows")
def test_a_port_is_no_file_that_could_be_a_link(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> str:
        raise PermissionError("[WinError 31] General failure: 'COM5'")

    monkeypatch.setattr(os.path, "realpath", fail)
    assert ports.identity("COM5", ports.Adapter()) == "unknown adapter at COM5"


@pytest.mark.usefixtures("windows")
@pytest.mark.parametrize(
    ("why", "said"),
    [
        ("FileNotFoundError(2, 'File not found.', None, 2)", "COM7 does not exist: "),
        ("PermissionError(13, 'Access denied.', None, 5)", "COM7 is in use by another program: "),
    ],
)
def test_a_port_that_cannot_be_written_to(monkeypatch: pytest.MonkeyPatch, why: str, said: str) -> None:
    def refuse(name: str, settings: LineSettings) -> None:
        raise OSError(f"could not open port '{name}': {why}")

    monkeypatch.setattr(port, "closed_serial", refuse)
    with pytest.raises(PortError, match=f"^{said}"):
        port.TransmittingPort("COM7", LineSettings())


NO_SOCKETS = "Windows has no sockets that are files: .* HOST:PORT"


@pytest.mark.usefixtures("windows")
def test_a_bus_is_not_looked_for_at_a_path() -> None:
    with pytest.raises(PortError, match=NO_SOCKETS):
        open_reader("bus:///run/bus", LineSettings())


@pytest.mark.usefixtures("windows")
def test_a_bus_does_not_listen_at_a_path(capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["bus", "--listen", "./bus"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert re.fullmatch(f"sistap bus: --listen .*{NO_SOCKETS} .*\n", err)


@pytest.mark.parametrize(
    ("number", "is_file", "system", "gone"),
    [
        (errno.EPIPE, False, "linux", True),
        (errno.EPIPE, False, "win32", True),
        (errno.EINVAL, False, "win32", True),
        (errno.EINVAL, True, "win32", False),
        (errno.EINVAL, False, "linux", False),
        (errno.ENOSPC, False, "win32", False),
    ],
)
def test_who_reads_a_pipe_is_gone(number: int, is_file: bool, system: str, gone: bool) -> None:
    assert is_reader_gone(OSError(number, ""), is_file=is_file, system=system) is gone


def test_a_capture_ends_well_when_wireshark_closes_its_pipe(monkeypatch: pytest.MonkeyPatch) -> None:
    reading, writing = os.pipe()
    output = Output(f"/dev/fd/{writing}")

    def refuse(descriptor: int, data: bytes) -> int:
        raise OSError(errno.EINVAL, "Invalid argument")

    monkeypatch.setattr("sistap.tap.files.output.os.write", refuse)
    monkeypatch.setattr("sistap.tap.files.output.is_reader_gone", partial(is_reader_gone, system="win32"))
    with pytest.raises(ReaderGone):
        output.write(b"block")
    monkeypatch.undo()
    output.close()
    for descriptor in (reading, writing):
        os.close(descriptor)


def test_a_file_that_wireshark_has_open(tmp_path: Path) -> None:
    file = tmp_path / "sis.dll"
    held = f"^{re.escape(str(file))} stays as it is: a program has it open: close Wireshark, then try again"
    with pytest.raises(OSError, match=held), state.closed(file, "win32"):
        raise PermissionError(13, "Access is denied")
    with pytest.raises(PermissionError, match="Access is denied"), state.closed(file, "linux"):
        raise PermissionError(13, "Access is denied")


def places(**given: object) -> argparse.Namespace:
    return argparse.Namespace(**({"pty": False, "listen": None, "port": None} | given))


@pytest.mark.parametrize(
    ("given", "listen"),
    [
        ({}, "127.0.0.1:0"),
        ({"listen": "127.0.0.1:5000"}, "127.0.0.1:5000"),
        ({"port": "COM5"}, None),
        ({"file": "x.pcapng"}, None),
    ],
)
def test_without_pseudo_terminals_a_bus_is_at_a_socket(given: dict[str, object], listen: str | None) -> None:
    args = places(**given)
    place.settle(args, has_ptys=False)
    assert args.listen == listen


def test_a_pseudo_terminal_is_used_or_refused() -> None:
    args = places()
    place.settle(args, has_ptys=True)
    assert args.listen is None
    with pytest.raises(ValueError, match="omit --pty"):
        place.settle(places(pty=True), has_ptys=False)


def test_a_bus_says_where_it_listens_by_itself(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The whole command, with the socket instead of a pseudo terminal; a tap hears it to its end."""
    monkeypatch.setattr(place.settle, "__kwdefaults__", {"has_ptys": False})
    said: SimpleQueue[str] = SimpleQueue()
    monkeypatch.setattr("builtins.print", lambda *text, **_: said.put(str(text[0])))
    command = threading.Thread(target=cli.main, args=(["bus", "--cycles", "1", "--fast"], Deaf()))
    command.start()
    url = said.get(timeout=PATIENCE_S)
    assert re.fullmatch(r"bus://127\.0\.0\.1:\d+", url)
    reader = open_reader(url, LineSettings())
    heard = b""
    with pytest.raises(PortLost):
        while True:
            read = reader.read(PATIENCE_S)
            heard += read.data if read else b""
    reader.close()
    command.join(PATIENCE_S)
    assert len(heard) > 100


class Deaf(Stop):
    """A stop without signals: they work in the main thread only."""

    def _install(self) -> None: ...


@pytest.mark.usefixtures("windows")
def test_the_libpcap_of_windows_is_that_of_npcap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYSTEMROOT", r"D:\Windows")
    names = list(candidates("win32"))
    assert names == [r"D:\Windows\System32\Npcap\wpcap.dll", "wpcap.dll"]
    tried: list[str] = []

    def load(name: str) -> ctypes.CDLL:
        tried.append(name)
        raise OSError

    with pytest.raises(Refusal, match="^a capture filter needs libpcap: install Npcap, which"):
        opened(names, load)
    assert tried == names


@pytest.mark.usefixtures("windows")
def test_a_self_test_is_through_a_socket(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(computer, "through_socket", lambda duration_ns: array("q", range(1000, 3000)))
    assert cli.main(["selftest", "--duration", "1"]) == 0
    (result,) = measurement.load()[0]
    assert (result.place, result.characters, result.longest_ns) == (measurement.MACHINE, 2000, 2999)
    capfd.readouterr()
    assert cli.main(["selftest", "-i", "COM5", "--transmit"]) == 2
    said = "sistap: on Windows a self-test is of this computer, not of a port: leave out -i and --transmit\n"
    assert capfd.readouterr() == ("", said)


def test_progress_is_cut_to_a_terminal_that_windows_knows_by_its_number_alone(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def size(descriptor: int) -> os.terminal_size:
        if descriptor > 2:
            raise ValueError("bad file descriptor")
        return os.terminal_size((10, 24))

    monkeypatch.setattr(os, "get_terminal_size", size)
    monkeypatch.setattr(Console, "shows_progress", True)
    Console().progress("0123456789abc")
    assert capfd.readouterr().err == "\r\x1b[K012345678"


def put(file: Path) -> str:
    """Make a program; return its path."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.touch(0o755)
    return str(file)


@pytest.fixture
def registry(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[object, str]:
    """Where Wireshark is installed, by hive, for a Windows without any; and no state of this user."""
    known: dict[object, str] = {}

    def key(hive: object, name: str, *_: object) -> contextlib.nullcontext[object]:
        if not name.endswith(r"App Paths\Wireshark.exe") or hive not in known:
            raise FileNotFoundError
        return contextlib.nullcontext(hive)

    fake: Any = types.SimpleNamespace(
        HKEY_CURRENT_USER="user", HKEY_LOCAL_MACHINE="machine", KEY_READ=1, KEY_WOW64_64KEY=2, OpenKey=key
    )
    fake.QueryValue = lambda opened, _: known[opened]
    monkeypatch.setitem(sys.modules, "winreg", fake)
    monkeypatch.setattr(state, "folder", lambda: tmp_path / "state")
    monkeypatch.setenv("PROGRAMFILES", str(tmp_path / "Program Files"))
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.setenv("PATHEXT", ".COM;.EXE;.BAT")
    return known


def test_a_device_that_windows_calls_new_is_not_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`sistap record` without a ring writes to `nul`: to remove that would fail."""
    (tmp_path / "nul").touch()
    monkeypatch.setattr("sistap.tap.files.output._open", lambda *_, **__: (os.open(os.devnull, os.O_WRONLY), True))
    Output(str(tmp_path / "nul")).close()
    assert (tmp_path / "nul").exists()


@pytest.mark.usefixtures("windows", "registry")
def test_no_program_is_taken_from_the_current_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    put(tmp_path / "here/sistap.exe")
    put(tmp_path / "here/tshark.exe")
    put(tmp_path / "here/sigrok-cli.exe")
    monkeypatch.chdir(tmp_path / "here")
    assert shell.foreign([]) == ""
    assert programs.of_wireshark("tshark") is None
    assert probe.program() is None
    monkeypatch.setenv("PATH", os.pathsep.join(["", ".", str(tmp_path / "bin")]))
    assert programs.on_path("sistap") is None
    there = put(tmp_path / "bin/sistap.bat")
    assert programs.on_path("sistap") == shell.foreign([]) == there


@pytest.mark.usefixtures("windows")
def test_wireshark_is_found_where_its_installer_has_put_it(
    registry: dict[object, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pages, "FOLDERS", (tmp_path,))
    with pytest.raises(TsharkError, match="^no Wireshark was found: .* sistap install --wireshark FOLDER$"):
        Tshark()
    page = put(tmp_path / "sis.html")
    with pytest.raises(TsharkError) as refused:
        Tshark()
    assert str(refused.value).endswith(f"; without it, {page} explains logs and captures in a browser")
    default = put(tmp_path / "Program Files/Wireshark/wireshark.exe")
    with pytest.raises(TsharkError, match="^tshark is not on PATH; .* tick TShark$"):
        Tshark()
    put(Path(default).with_name("tshark.exe"))
    assert programs.of_wireshark("tshark") == str(Path(default).with_name("tshark.exe"))
    registry["machine"] = put(tmp_path / "D/Wire shark/Wireshark.exe")
    elsewhere = put(tmp_path / "D/Wire shark/tshark.exe")
    assert programs.of_wireshark("tshark") == elsewhere
    on_path = put(tmp_path / "bin/tshark.exe")
    assert programs.of_wireshark("tshark") == on_path


@pytest.mark.usefixtures("windows", "registry")
def test_a_portable_wireshark_is_used_with_its_own_settings(tmp_path: Path) -> None:
    portable = tmp_path / "WiresharkPortable64"
    tshark = put(portable / "App/Wireshark/tshark.exe")
    put(tmp_path / "bin/tshark.exe")
    (portable / "Data").mkdir()
    with pytest.raises(SystemExit):
        cli.main(["install", "--wireshark", str(tmp_path / "bin/none")])
    programs.remember(portable)
    assert programs.of_wireshark("tshark") == tshark
    assert environment(tshark)["WIRESHARK_APPDATA"] == str(portable / "Data")
    assert "WIRESHARK_APPDATA" not in environment(str(tmp_path / "bin/tshark.exe"))
    programs.forget()
    assert programs.of_wireshark("tshark") == str(tmp_path / "bin/tshark.exe")
    assert not (tmp_path / "state").exists()


def test_what_was_written_is_opened_with_the_wireshark_that_is_there(
    registry: dict[object, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    registry["machine"] = put(tmp_path / "Program Files/Wireshark/wireshark.exe")
    monkeypatch.setattr("sistap.tap.files.output.shell_word", partial(shell_word, system="win32"))
    output = Output(str(tmp_path / "my day.pcapng"))
    output.begin()
    output.write(b"block")
    output.close()
    day = subprocess.list2cmdline([str(tmp_path / "my day.pcapng")])
    monkeypatch.setattr(sys, "platform", "linux")
    assert output.written.endswith(f"; open it with: wireshark -C SIS {day}")
    monkeypatch.setattr(sys, "platform", "win32")
    assert output.written.endswith(f'; open it with: "{registry["machine"]}" -C SIS "{tmp_path / "my day.pcapng"}"')


def test_state_is_in_the_folder_for_this_computer(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(state, "WINDOWS", True)
    monkeypatch.setattr(state, "is_root", lambda: False)
    monkeypatch.delenv("XDG_STATE_HOME", raising=False)
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "local"))
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    assert state.folder() == tmp_path / "local/sistap"


@pytest.mark.parametrize(
    ("path", "added"),
    [
        ("", r"C:\sistap"),
        (r"C:\a;%USERPROFILE%\b", r"C:\a;%USERPROFILE%\b;C:\sistap"),
        (r"C:\a;", r"C:\a;;C:\sistap"),
        (r'"c:\SISTAP\";C:\a', r"C:\a;C:\sistap"),
        ("C:\\long;" * 300 + "C:\\a", "C:\\long;" * 300 + "C:\\a;C:\\sistap"),
    ],
)
def test_the_installer_changes_nothing_else_of_a_path(path: str, added: str) -> None:
    assert userpath.changed(path, "add", r"C:\sistap") == added
    assert userpath.changed(added, "add", r"C:\sistap") == added
    without = userpath.changed(added, "remove", r"C:\sistap")
    assert without == added.removesuffix(r";C:\sistap").removesuffix(r"C:\sistap")
