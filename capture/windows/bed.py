# SPDX-License-Identifier: GPL-2.0-or-later
"""The checks of capture/windows/check: sistap in a Python for Windows, its ports pseudo terminals of ours."""

from __future__ import annotations

import os
import pty
import shutil
import subprocess
import sys
import time
import tty
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

CAPTURE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(CAPTURE))

from sistap.files.reading import NotCaptured, records  # noqa: E402 - of the checkout
from sistap.install.launching import settings  # noqa: E402
from sistap.records.record import Type  # noqa: E402

TIMEOUT_S = 120
PORTS = ("COM5", "COM15")  # names above COM9 are another kind to Windows
SENT = bytes(range(256)) * 2
FILTER = 'link[5]==0x10&&link[6]==16 %PATH% "a  b" \\'

# What the portable part of the suite is: no terminals, no tshark, no compiler.
TESTS = (
    "advice assembler assembling bus_socket clock clocks follow framer options order record registry rooms scan "
    "windows_reader"
).split()


class Wine(NamedTuple):
    """A Windows of our own with one Python."""

    folder: Path
    python: Path

    def environment(self) -> dict[str, str]:
        """Return the variables that its programs see."""
        path = ";".join(map(drive, (CAPTURE, CAPTURE / "tests", self.folder / "packages")))
        own = {"WINEPREFIX": str(self.folder / "prefix"), "WINEDEBUG": "-all", "WINEARCH": "win64", "PYTHONPATH": path}
        return os.environ | own | {"PYTHONDONTWRITEBYTECODE": "1", "PYTHONUTF8": "1"}

    def start(self, *command: str | Path) -> subprocess.Popen[str]:
        """Start a program of Windows; what it says comes together."""
        return subprocess.Popen(
            ["wine", *map(str, command)],
            env=self.environment(),
            cwd=CAPTURE.parent,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def run(self, *command: str | Path, code: int = 0) -> str:
        """Run a program of Windows to its end; return what it said."""
        process = self.start(*command)
        try:
            said, _ = process.communicate(timeout=TIMEOUT_S)
        finally:
            process.kill()
        assert process.returncode == code, f"exit code {process.returncode}\n{said}"
        return said

    def sistap(self, *arguments: str | Path) -> str:
        """Run sistap; return what it said."""
        return self.run(self.python, "-m", "sistap", *arguments)

    def server(self, *arguments: str) -> None:
        """Tell wine's server something."""
        subprocess.run(["wineserver", *arguments], env=self.environment(), check=False, timeout=TIMEOUT_S)

    def connect(self) -> dict[str, int]:
        """Put a pseudo terminal behind each port; return our ends."""
        ours = {}
        for port in PORTS:
            ours[port], theirs = pty.openpty()
            tty.setraw(theirs)
            self.run("reg", "add", r"HKLM\Software\Wine\Ports", "/v", port, "/d", os.ttyname(theirs), "/f")
        self.server("-k")
        self.server("-w")
        return ours


def drive(path: Path) -> str:
    """Return a path as Windows has it."""
    return "Z:" + str(path).replace("/", "\\")


def version(wine: Wine) -> None:
    """It starts."""
    assert wine.sistap("--version").startswith("sistap ")


def ports(wine: Wine) -> None:
    """The list of ports, or what to do in the words of Windows."""
    said = wine.sistap("ports")
    assert "Traceback" not in said
    assert "sudo" not in said


def capture(wine: Wine) -> None:
    """Every character that is sent is in the capture, and no other."""
    for port, ours in wine.connect().items():
        file = wine.folder / "out.pcapng"
        process = wine.start(
            wine.python, *"-m sistap capture --format 8N1 -a duration:8 -i".split(), port, "-w", drive(file)
        )
        said = until(process, "capturing on")
        for value in SENT:
            os.write(ours, bytes([value]))
            time.sleep(0.002)
        said += process.communicate(timeout=TIMEOUT_S)[0]
        try:
            received = b"".join(record.data for record in records(file) if record.type != Type.EVENT)
        except NotCaptured:
            received = b""
        assert received == SENT, f"{port}: {len(received)} of {len(SENT)} characters\n{said}"


def until(process: subprocess.Popen[str], words: str) -> str:
    """Read what a program says up to a line with these words; return all of it."""
    assert process.stdout
    said = ""
    for line in process.stdout:
        said += line
        if words in line:
            break
    time.sleep(0.5)
    return said


def own_bus(wine: Wine) -> None:
    """A bus that nobody told where to be listens, and says where."""
    process = wine.start(wine.python, "-m", "sistap", "bus", "--cycles", "1")
    assert process.stdout
    url = process.stdout.readline().strip()
    assert url.startswith("bus://127.0.0.1:"), url
    said = wine.sistap("capture", "-i", url, "-c", "9")
    process.communicate(timeout=TIMEOUT_S)
    assert "16 -> 3     Command   Node identification" in said, said


def launched(wine: Wine) -> tuple[Path, Path]:
    """Put the launcher into a folder as install does, with a package that shows its arguments; return both."""
    folder, stub = wine.folder / "ex tcap", wine.folder / "stub"
    shutil.rmtree(folder, ignore_errors=True)
    (stub / "sistap").mkdir(parents=True, exist_ok=True)
    (stub / "sistap/__init__.py").touch()
    (stub / "sistap/__main__.py").write_text("import sys\nprint(ascii(sys.argv[1:]))\nsys.exit(7)\n")
    folder.mkdir()
    shutil.copy(wine.folder / "sistap.exe", folder)
    return folder, stub


def launcher(wine: Wine) -> None:
    """The launcher passes every argument on as it was, and the exit code back."""
    folder, stub = launched(wine)
    (folder / "sistap.cfg").write_text(settings(drive(wine.python), Path(drive(stub))), newline="")
    arguments = ["--extcap-capture-filter", FILTER, 'x\\"y', "", "ü"]
    said = wine.run(folder / "sistap.exe", *arguments, code=7)
    assert said.strip() == ascii(["extcap", *arguments]), said


def extcap(wine: Wine) -> None:
    """Interfaces, dialog, and a capture into a named pipe whose reader closes it first."""
    folder, _ = launched(wine)
    package = ";".join(map(drive, (CAPTURE, wine.folder / "packages")))
    (folder / "sistap.cfg").write_text(f"{drive(wine.python)}\r\n{package}\r\n", newline="")
    program = folder / "sistap.exe"
    assert "{value=sistap-demo}" in wine.run(program, "--extcap-interfaces")
    assert "arg {number=" in wine.run(program, "--extcap-config", "--extcap-interface", "sistap-demo")
    file = wine.folder / "piped.pcapng"
    asked = ["--capture", "--extcap-interface", "sistap-demo", "--fifo", "PIPE"]
    wine.run(wine.python, drive(CAPTURE / "windows/pipe.py"), drive(file), "3000", drive(program), *asked)
    assert file.read_bytes()[:4] == b"\x0a\x0d\x0d\x0a"


def tests(wine: Wine) -> None:
    """The portable part of the suite."""
    files = [f"capture/tests/test_{name}.py" for name in TESTS]
    options = ["-q", "-c", "capture/pyproject.toml", "--rootdir", ".", "-p", "no:cacheprovider", "--tb=line"]
    said = wine.run(wine.python, "-m", "pytest", *options, *files)
    print(said.strip().splitlines()[-1])


CHECKS: tuple[Callable[[Wine], None], ...] = (version, ports, capture, own_bus, launcher, extcap, tests)


def main(folder: str, *versions: str) -> int:
    """Run all checks with each Python; return the exit code."""
    failed = 0
    for name in versions:
        (python,) = Path(folder, name).rglob("windows-x86_64/python.exe")
        wine = Wine(Path(folder), python)
        wine.run("wineboot", "-i")
        for check in CHECKS:
            try:
                check(wine)
                print(f"windows: good   Python {name}: {check.__name__}", flush=True)
            except (AssertionError, OSError, subprocess.TimeoutExpired) as error:
                failed += 1
                print(f"windows: FAILED Python {name}: {check.__name__}: {error}", flush=True)
        wine.server("-k")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
