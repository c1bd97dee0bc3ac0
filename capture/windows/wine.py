# SPDX-License-Identifier: GPL-2.0-or-later
"""A separate Windows under wine, with a Python for it, and two ports whose other ends are here."""

from __future__ import annotations

import os
import pty
import shutil
import subprocess
import sys
import threading
import tty
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType

ROOT = Path(__file__).resolve().parents[2]
CAPTURE = ROOT / "capture"
TIMEOUT_S = 180
GRACE_S = 5  # for the rest of the output: processes that wine starts may hold the pipe open, and stay
PORTS = ("COM5", "COM15")  # Windows handles names above COM9 differently
NOTHING: Mapping[str, str] = MappingProxyType({})  # no variables besides those of all programs

# COM5 is an FTDI adapter with a latency timer of 1 ms, registered as its driver does it, so its times have a bound.
_FTDI = r"HKLM\SYSTEM\CurrentControlSet\Enum\FTDIBUS\VID_0403+PID_6001+A50285BIA\0000"
_REGISTRY = (
    *((r"HKLM\Software\Wine\Ports", port, "REG_SZ", f"{{ports}}/{port}") for port in PORTS),
    (_FTDI, "FriendlyName", "REG_SZ", "USB Serial Port (COM5)"),
    (_FTDI + r"\Device Parameters", "PortName", "REG_SZ", "COM5"),
    (_FTDI + r"\Device Parameters", "LatencyTimer", "REG_DWORD", "1"),
)

# For wine: no menus, no .NET, no browser. Its wpcap.dll is off, because it ends any process that asks for a filter.
_OVERRIDES = "winemenubuilder.exe,mscoree,mshtml,wpcap="


class Wine:
    """One Windows, and one Python in it."""

    def __init__(self, folder: Path, python: Path, **more: str) -> None:
        """Take the folder for everything, the Python, and variables for its programs."""
        self.folder = folder
        self.python = python
        self.version = python.relative_to(folder).parts[0].partition("-")[0]
        self.prefix = folder / "prefix"
        self.home = folder / "home"  # of Wireshark
        self._ports = folder / "ports"
        self.environment = os.environ | {
            "WINEPREFIX": str(self.prefix),
            "WINEARCH": "win64",
            "WINEDEBUG": "-all",
            "WINEDLLOVERRIDES": _OVERRIDES,
            "WINEPATH": drive(folder / "programs"),
            "PYTHONPATH": f"{drive(CAPTURE)};{drive(CAPTURE / 'tests')}",
            "PYTHONPYCACHEPREFIX": drive(folder / "bytecode"),
            "PYTHONUTF8": "1",
            "HOME": str(self.home),
            **more,
        }
        self.environment.pop("PYTHONDONTWRITEBYTECODE", None)

    def start_up(self) -> None:
        """Make the Windows, if it is new, and add the registry entries."""
        self._ports.mkdir(exist_ok=True)
        self._ports.joinpath("COM5").unlink(missing_ok=True)
        self.run("wineboot", "-i")
        for key, name, kind, value in _REGISTRY:
            text = value.format(ports=self._ports)
            self.run("reg", "add", key, "/v", name, "/t", kind, "/d", text, "/f")
        for port in PORTS:
            self._lead(port, "/dev/null")
        for state in self.prefix.glob("drive_c/users/*/.local/state/sistap"):
            shutil.rmtree(state)  # from another Python
        self.shut_down()

    def shut_down(self) -> None:
        """End all that runs in it."""
        for option in ("-k", "-w"):
            subprocess.run(["wineserver", option], env=self.environment, check=False, timeout=TIMEOUT_S)

    def start(self, *command: str | Path, more: Mapping[str, str] = NOTHING) -> subprocess.Popen[str]:
        """Start a Windows program; its output streams are joined."""
        return subprocess.Popen(
            ["wine", *map(str, command)],
            env={**self.environment, **more},
            cwd=ROOT,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding="utf-8",
            errors="replace",
        )

    def run(
        self,
        *command: str | Path,
        code: int | None = 0,
        timeout_s: float = TIMEOUT_S,
        more: Mapping[str, str] = NOTHING,
    ) -> str:
        """Run a Windows program to its end, check its exit code (None: any); return its output."""
        process = self.start(*command, more=more)
        assert process.stdout
        said: list[str] = []
        reading = threading.Thread(target=said.extend, args=(process.stdout,), daemon=True)
        reading.start()
        try:
            process.wait(timeout_s)
        finally:
            process.kill()
        reading.join(GRACE_S)
        assert code in (process.returncode, None), f"exit code {process.returncode}\n{''.join(said)}"
        return "".join(said)

    def sistap(self, *arguments: str | Path, code: int = 0, more: Mapping[str, str] = NOTHING) -> str:
        """Run sistap; return its output."""
        return self.run(self.python, "-m", "sistap", *arguments, code=code, more=more)

    @contextmanager
    def terminal(self, port: str) -> Iterator[int]:
        """Put a new pseudo terminal behind a port and return our end: wine does not open the same one twice."""
        ours, theirs = pty.openpty()
        tty.setraw(theirs)
        self._lead(port, os.ttyname(theirs))
        try:
            yield ours
        finally:
            os.close(ours)
            os.close(theirs)

    @contextmanager
    def bus(self, port: str, *arguments: str) -> Iterator[None]:
        """Put a virtual bus behind a port."""
        command = [sys.executable, "-m", "sistap", "bus", *arguments]
        environment = os.environ | {"PYTHONPATH": str(CAPTURE)}
        with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout
            self._lead(port, process.stdout.readline().strip())
            try:
                yield
            finally:
                process.terminate()

    def _lead(self, port: str, device: str) -> None:
        """Make a port lead to another device, without restarting Windows."""
        link = self._ports / port
        link.unlink(missing_ok=True)
        link.symlink_to(device)


def here(*arguments: str | Path) -> str:
    """Run sistap on this system; return its output."""
    done = subprocess.run(
        [sys.executable, "-m", "sistap", *map(str, arguments)],
        env=os.environ | {"PYTHONPATH": str(CAPTURE)},
        cwd=ROOT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        encoding="utf-8",
        check=True,
        timeout=TIMEOUT_S,
    )
    return done.stdout


def drive(path: Path) -> str:
    """Return a path as a Windows path."""
    return "Z:" + str(path).replace("/", "\\")


def emptied(folder: Path) -> Path:
    """Return an empty folder."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def until(process: subprocess.Popen[str], words: str) -> str:
    """Read a program's output up to a line with these words; return all of it. AssertionError if it ends before."""
    assert process.stdout
    said = ""
    for line in process.stdout:
        said += line
        if words in line:
            return said
    raise AssertionError(f"it ended without saying {words!r}:\n{said}")
