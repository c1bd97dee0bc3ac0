# SPDX-License-Identifier: GPL-2.0-or-later
"""Tries the bundle under wine as its README.html describes, without the checkout, and times the first telegram.

Exit code: 0 everything works; 1 something does not; 77 it cannot be tried here, with the reason.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path

CAPTURE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(CAPTURE))

from sistap import __version__  # noqa: E402 - of the checkout
from sistap.files.reading import NotCaptured, records  # noqa: E402
from sistap.records.record import Type  # noqa: E402

MADE = CAPTURE.parent / "build/windows"
FOLDER = MADE / "try"
DRIVE = FOLDER / "prefix/drive_c"
PLACE = "Übung 1"  # a blank and a letter outside ASCII
PROGRAMS = "Program Files/Wireshark"
NOT_RUN = 77
TIMEOUT_S = 180

# Replaces the tshark of a Wireshark for Windows, as far as `sistap install` calls it.
TSHARK = r"""
import os, sys
own = os.environ["APPDATA"] + r"\Wireshark"
script = own + r"\plugins\sis.lua"
if "--version" in sys.argv:
    print("TShark (Wireshark) 4.6.0.")
elif "folders" in sys.argv:
    for kind, folder in ("Personal", own), ("Global", os.path.dirname(__file__)):
        print(f"{kind} configuration:\t{folder}")
        print(f"{kind} Plugins:\t{folder}\\plugins\\4.6")
        print(f"{kind} Lua Plugins:\t{folder}\\plugins")
        print(f"{kind} Extcap path:\t{folder}\\extcap")
elif "plugins" in sys.argv and os.path.exists(script):
    print("sis.lua", "1.0", "lua script", script, sep="\t")
"""


def wine(*command: str, code: int = 0, cwd: Path = DRIVE) -> str:
    """Run a Windows program; return its output."""
    with started(*command, cwd=cwd) as process:
        said, _ = process.communicate(timeout=TIMEOUT_S)
    text = said.decode("utf-8", "replace")
    assert process.returncode == code, f"{command}: exit code {process.returncode}\n{text}"
    return text


@contextlib.contextmanager
def started(*command: str, cwd: Path = DRIVE) -> Iterator[subprocess.Popen[bytes]]:
    """Run a Windows program whose environment has nothing of the checkout."""
    own = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    own |= {"WINEPREFIX": str(DRIVE.parent), "WINEDEBUG": "-all", "WINEARCH": "win64"}
    own["BUNDLE"] = f"C:\\{PLACE}\\sistap-{__version__}"  # for tshark.cmd
    own["WINEPATH"] = "C:\\" + PROGRAMS.replace("/", "\\")
    process = subprocess.Popen(
        ["wine", *command], cwd=cwd, env=own, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def app_data() -> Path:
    """Return the folder of the user's Wireshark."""
    return next(DRIVE.glob("users/*/AppData/Roaming")) / "Wireshark"


def installed() -> set[str]:
    """Return which files are there."""
    return {file.relative_to(app_data()).as_posix() for file in app_data().rglob("*") if file.is_file()}


def unpack() -> Path:
    """Unpack the zip; return the folder in it."""
    with zipfile.ZipFile(MADE / f"sistap-{__version__}-windows.zip") as archive:
        archive.extractall(DRIVE / PLACE)
    bundle = DRIVE / PLACE / f"sistap-{__version__}"
    mend(bundle)
    return bundle


def mend(bundle: Path) -> None:
    """Remove what wine lacks: pyserial asks for this function, and wine's ports do not need it."""
    file = bundle / "app/serial/tools/list_ports_windows.py"
    lines = [line for line in file.read_text().splitlines(True) if not line.startswith("CM_MapCrToWin32Err")]
    file.write_text("".join(lines))


def put_tshark() -> None:
    """Put a tshark where Wireshark's installer puts it."""
    folder = DRIVE / PROGRAMS
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "tshark.py").write_text(TSHARK)
    command = '@"%BUNDLE%\\python\\python.exe" "%~dp0tshark.py" %*\r\n'
    (folder / "tshark.cmd").write_text(command, newline="")


def first_telegram() -> None:
    """Capture the demo bus, as Wireshark does with a double click, until a telegram is in the file."""
    file = DRIVE / "live.pcapng"
    asked = ["--capture", "--extcap-interface", "sistap-demo", "--fifo", "C:\\live.pcapng"]
    with started(str(app_data() / "extcap/sistap.exe"), *asked):
        end = time.monotonic() + TIMEOUT_S
        while time.monotonic() < end:
            with contextlib.suppress(NotCaptured, OSError):
                if any(record.type == Type.FRAME for record in records(file)):
                    return
            time.sleep(0.1)
    raise AssertionError("no telegram came")


def from_zip() -> None:
    """Follow README.html."""
    begin = time.monotonic()
    bundle = unpack()
    put_tshark()
    said = wine("cmd", "/c", "install.cmd", cwd=bundle)
    assert "Wireshark loads sis.lua" in said, said
    names = {"extcap/sistap.exe", "extcap/sistap.cfg", "plugins/sis.lua", "profiles/SIS/preferences"}
    assert names <= installed(), installed()
    assert "{value=sistap-demo}" in wine(str(app_data() / "extcap/sistap.exe"), "--extcap-interfaces")
    first_telegram()
    print(f"bundle: good   zip, from unpacking to the first telegram: {time.monotonic() - begin:.0f} s", flush=True)
    assert wine("sistap.exe", "--version", cwd=bundle) == f"sistap {__version__}\r\n"
    assert "late-reaction" in wine("sistap.exe", "bus", "--list", cwd=bundle)
    assert "Traceback" not in wine("sistap.exe", "ports", cwd=bundle)
    wine("sistap.exe", "bus", "demo", "--cycles", "1", "--force", "-w", "C:\\demo.pcapng", cwd=bundle)
    assert any(record.type == Type.FRAME for record in records(DRIVE / "demo.pcapng"))
    wine("sistap.exe", "capture", "-i", "COM77", code=3, cwd=bundle)
    wine("cmd", "/c", "uninstall.cmd", cwd=bundle)
    assert not installed(), installed()
    print("bundle: good   zip, commands and uninstall.cmd", flush=True)


def from_installer() -> None:
    """Install silently into a folder, and uninstall; files that are not of the bundle stay."""
    place = DRIVE / "elsewhere"
    wine(str(MADE / f"sistap-{__version__}-setup.exe"), "/S", "/D=C:\\elsewhere")
    assert "plugins/sis.lua" in installed(), installed()
    (place / "mine.pcapng").touch()
    # _?= keeps the uninstaller from running as a copy, whose end nobody would notice; so it cannot delete itself.
    wine(str(place / "uninstall.exe"), "/S", "_?=C:\\elsewhere")
    assert not installed(), installed()
    left = {file.name for file in place.iterdir()}
    assert left == {"mine.pcapng", "uninstall.exe"}, left
    print("bundle: good   installer and uninstaller", flush=True)


def main() -> int:
    """Try all; return the exit code."""
    if not shutil.which("wine"):
        print("bundle: not tried: wine is missing: apt-get install wine wine64", file=sys.stderr)
        return NOT_RUN
    if not (MADE / f"sistap-{__version__}-windows.zip").exists():
        print("bundle: not tried: it is not made: capture/bundle/build", file=sys.stderr)
        return NOT_RUN
    shutil.rmtree(FOLDER, ignore_errors=True)
    DRIVE.mkdir(parents=True)
    wine("wineboot", "-i")
    try:
        from_zip()
        from_installer()
    except (AssertionError, OSError, subprocess.TimeoutExpired) as error:
        print(f"bundle: FAILED {error}")
        return 1
    finally:
        subprocess.run(
            ["wineserver", "-k"], env=os.environ | {"WINEPREFIX": str(DRIVE.parent)}, check=False, timeout=TIMEOUT_S
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
