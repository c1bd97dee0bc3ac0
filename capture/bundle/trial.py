# SPDX-License-Identifier: GPL-2.0-or-later
"""Tries the bundle under wine as its README.html describes, with its own Python, and times the first telegram.

Wireshark's programs are those of this system (../windows/proxy.py). They stand where no PATH leads to, as after the
installer of Wireshark.

Exit code: 0 everything works; 1 something does not; 77 it cannot be tried here, with the reason.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import subprocess
import sys
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

CAPTURE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(CAPTURE))
sys.path.append(str(CAPTURE / "windows"))
sys.path.append(str(CAPTURE / "package/trial"))

from commands import session  # noqa: E402
from proxy import Proxy  # noqa: E402

from sistap import __version__  # noqa: E402 - of the checkout
from sistap.dissected.captures.reading import records  # noqa: E402
from sistap.tap.records.record import Type  # noqa: E402
from sistap.tap.terminal.exits import NotCaptured  # noqa: E402

MADE = CAPTURE.parent / "build/windows"
FOLDER = MADE / "try"
HOME = FOLDER / "home"  # of Wireshark
LAUNCHER = HOME / ".config/wireshark/extcap/sistap.exe"
DRIVE = FOLDER / "prefix/drive_c"
PLACE = "Übung 1"  # a blank and a letter outside ASCII
PROGRAMS = "Wire shark"  # the folder of Wireshark
APP_PATHS = r"HKLM\Software\Microsoft\Windows\CurrentVersion\App Paths\Wireshark.exe"
OVERRIDES = "winemenubuilder.exe,mscoree,mshtml,wpcap="  # as in ../windows/wine.py
COMPILER = "x86_64-w64-mingw32-gcc"
NOT_RUN = 77
TIMEOUT_S = 180

# Imports every module of sistap and sisbus with this Python: one of its own that the bundle lacks is an error.
IMPORTS = """
import importlib, itertools, pkgutil, sisbus, sistap
rooms = [pkgutil.walk_packages(house.__path__, house.__name__ + ".") for house in (sistap, sisbus)]
for module in itertools.chain(*rooms):
    try:
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    except ImportError as error:
        print(error.name)
"""
NOT_ON_WINDOWS = set("fcntl grp js matplotlib numpy pwd pyarrow pyodide resource termios tty".split())


class Command(NamedTuple):
    """What is typed after sistap, words of its output, the exit code it has to have, and what plays the bus for it."""

    line: str
    words: str = ""
    code: int = 0
    bus: str = ""


DAY = r"C:\Tag Ω\day.pcapng"  # for the word DAY
BUS = "127.0.0.1:5077"  # for the word BUS
TYPED = [
    Command("--version", f"sistap {__version__}\r\n"),
    Command("bus --help", "-w FILE"),
    Command("bus --list", "late-reaction"),
    Command("ports", "Device Manager"),
    Command("doctor", "good  plugin     sis.lua"),
    Command("capture -i COM77", "does not exist", 3),
    Command("selftest --duration 10", "p99.9"),
    Command("bus late-reaction -w DAY", rf'open it with: "C:\{PROGRAMS}\wireshark.exe" -C SIS "{DAY}"'),
    Command("bus -w DAY", "overwrite it with --force", 2),
    Command("report DAY --format text", "TrS is the longest"),
    Command("report DAY --format json", "{"),
    Command("parameters DAY", "S-0-0036"),
    Command("parameters --csv DAY -o C:\\parameters.csv"),
    Command("compare DAY DAY --format html -o C:\\changed.html"),
    Command("tables DAY -o C:\\tables", "windows-full.zip has pyarrow", 1),
    Command("log DAY -o C:\\day.txt"),
    Command("annotate C:\\docklight.txt", "Read phase (SYNAX)"),
    Command("annotate --format html C:\\docklight.txt -o C:\\log.html"),
    Command("annotate C:\\docklight.txt -w C:\\log.pcapng"),
    Command("import C:\\x.sr -w C:\\sr.pcapng", "1 telegrams, 0 of them damaged"),
    Command("capture -i bus://BUS -c 2", "16 -> 3", bus="replay DAY --listen BUS"),
    Command("record -i bus://BUS -a duration:3 -w C:\\kept", bus="bus --listen BUS --duration 60"),
    Command("extcap --extcap-interfaces", "{value=sistap-demo}"),
    Command("web", "/sis.html"),
    Command("help", "/docs/index.html"),
]


@contextlib.contextmanager
def started(*command: str, cwd: Path = DRIVE) -> Iterator[subprocess.Popen[bytes]]:
    """Run a Windows program whose environment has nothing of the checkout."""
    own = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "WIRESHARK"))}
    own |= {"WINEPREFIX": str(DRIVE.parent), "WINEDEBUG": "-all", "WINEARCH": "win64", "WINEDLLOVERRIDES": OVERRIDES}
    process = subprocess.Popen(
        ["wine", *command], cwd=cwd, env=own, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def wine(*command: str, code: int = 0, cwd: Path = DRIVE) -> str:
    """Run a Windows program; return its output."""
    with started(*command, cwd=cwd) as process:
        said, _ = process.communicate(timeout=TIMEOUT_S)
    text = said.decode("utf-8", "replace")
    assert process.returncode == code, f"{command}: exit code {process.returncode}\n{text}"
    return text


def good(what: str) -> None:
    """Say what works."""
    print(f"bundle: good   {what}", flush=True)


def local_data() -> Path:
    """Return the folder in which Windows keeps what belongs to this user and computer."""
    return next(DRIVE.glob("users/*/AppData/Local"))


def installed() -> set[str]:
    """Return which files Wireshark has, without the folders in which this system keeps them."""
    files = [file for file in HOME.glob(".*/**/*") if file.is_file()]
    return {re.sub(".*/(plugins|extcap|profiles)/", r"\1/", file.as_posix()) for file in files}


def unpack(kind: str, folder: Path) -> Path:
    """Unpack a zip; return the folder in it."""
    with zipfile.ZipFile(MADE / f"sistap-{__version__}-windows{kind}.zip") as archive:
        archive.extractall(folder)
    bundle = folder / f"sistap-{__version__}"
    mend(bundle)
    return bundle


def mend(bundle: Path) -> None:
    """Remove what wine lacks: pyserial asks for this function, and wine's ports do not need it."""
    file = bundle / "app/serial/tools/list_ports_windows.py"
    lines = [line for line in file.read_text().splitlines(True) if not line.startswith("CM_MapCrToWin32Err")]
    file.write_text("".join(lines))


def put_wireshark() -> None:
    """Put Wireshark's programs into a folder, and register it as the installer of Wireshark does."""
    folder = DRIVE / PROGRAMS
    folder.mkdir()
    source = CAPTURE / "windows/proxy.c"
    subprocess.run([COMPILER, "-O2", "-static", "-o", folder / "tshark.exe", source, "-lws2_32"], check=True)
    shutil.copy(folder / "tshark.exe", folder / "wireshark.exe")
    wine("reg", "add", APP_PATHS, "/ve", "/d", rf"C:\{PROGRAMS}\wireshark.exe", "/f")
    script = FOLDER / "bin/wireshark"  # which the proxy starts
    script.parent.mkdir()
    script.write_text('#!/bin/sh\necho "$@" >"$HOME/wireshark.txt"\n')
    script.chmod(0o755)


def first_telegram() -> None:
    """Capture the demo bus, as Wireshark does with a double click, until a telegram is in the file."""
    file = DRIVE / "live.pcapng"
    asked = ["--capture", "--extcap-interface", "sistap-demo", "--fifo", "C:\\live.pcapng"]
    with started(str(LAUNCHER), *asked):
        end = time.monotonic() + TIMEOUT_S
        while time.monotonic() < end:
            with contextlib.suppress(NotCaptured, OSError):
                if any(record.type == Type.FRAME for record in records(file)):
                    return
            time.sleep(0.1)
    raise AssertionError("no telegram came")


def install(bundle: Path) -> None:
    """Follow README.html up to the first telegram."""
    begin = time.monotonic()
    said = wine("cmd", "/c", "install.cmd", cwd=bundle)
    assert "Wireshark loads sis.lua" in said, said
    names = {"extcap/sistap.exe", "extcap/sistap.cfg", "plugins/sis.lua", "profiles/SIS/preferences"}
    assert names <= installed(), installed()
    assert "{value=sistap-demo}" in wine(str(LAUNCHER), "--extcap-interfaces")
    first_telegram()
    good(f"zip, from install.cmd to the first telegram: {time.monotonic() - begin:.0f} s")
    wine("cmd", "/c", "demo.cmd", cwd=bundle)
    end = time.monotonic() + TIMEOUT_S
    while not (HOME / "wireshark.txt").exists() and time.monotonic() < end:
        time.sleep(0.1)
    assert (HOME / "wireshark.txt").read_text() == "-C SIS -k -i sistap-demo\n"


def every_command(bundle: Path) -> None:
    """Type every command in a folder with letters of two languages."""
    (DRIVE / "Tag Ω").mkdir()
    (DRIVE / "docklight.txt").write_text("14.03.2013 08:21:14.641 [TX] - 02 6C 00 00 00 92 00 00\n")
    session(DRIVE / "x.sr")
    lacking = set(wine("python\\python.exe", "-c", IMPORTS, cwd=bundle).split())
    assert lacking <= NOT_ON_WINDOWS, lacking
    for page in ("sis.html", "docs/index.html"):  # stand-ins, where `./bootstrap page` and `docs` were not run before
        (bundle / page).parent.mkdir(exist_ok=True)
        (bundle / page).touch()
    for command in TYPED:
        with playing(command.bus, bundle):
            said = wine("sistap.exe", *typed(command.line), cwd=bundle, code=command.code)
        assert command.words in said and "Traceback" not in said, f"{command.line}\n{said}"
    good(f"zip, {len(TYPED)} commands")


def typed(line: str) -> list[str]:
    """Return the words of a line as they are typed here."""
    return [DAY if word == "DAY" else word.replace("BUS", BUS) for word in line.split()]


@contextlib.contextmanager
def playing(line: str, bundle: Path) -> Iterator[None]:
    """Let sistap play a bus meanwhile, if there is a line for it."""
    if not line:
        yield
        return
    with started("sistap.exe", *typed(line), cwd=bundle) as process:
        assert process.stdout and f"bus://{BUS}\r\n".encode() in process.stdout, f"{line}: it does not play"
        yield


def uninstall(bundle: Path) -> None:
    """Remove it with uninstall.cmd; nothing is left."""
    assert list(local_data().glob("sistap/*.json"))
    wine("cmd", "/c", "uninstall.cmd", cwd=bundle)
    assert not installed(), installed()
    assert not list(local_data().glob("sistap*")), list(local_data().glob("sistap*"))
    good("zip, uninstall.cmd: nothing is left")


def elsewhere(bundle: Path) -> None:
    """Find no Wireshark, then a named one."""
    wine("reg", "delete", APP_PATHS, "/f")
    assert "install --wireshark FOLDER" in wine("sistap.exe", "install", cwd=bundle, code=1)
    assert "Wireshark loads sis.lua" in wine("sistap.exe", "install", "--wireshark", f"C:\\{PROGRAMS}", cwd=bundle)
    wine("sistap.exe", "uninstall", cwd=bundle)
    assert not installed(), installed()
    assert not list(local_data().glob("sistap*"))
    wine("reg", "add", APP_PATHS, "/ve", "/d", rf"C:\{PROGRAMS}\wireshark.exe", "/f")
    good("zip, install --wireshark")


def tables() -> None:
    """Make tables with the full zip."""
    bundle = unpack("-full", DRIVE / "full")
    wine("sistap.exe", "install", cwd=bundle)
    said = wine("sistap.exe", "tables", DAY, "-o", "C:\\tables", cwd=bundle)
    assert list((DRIVE / "tables").rglob("*.parquet")), said
    wine("sistap.exe", "uninstall", cwd=bundle)
    good("full zip, tables")


def path() -> str:
    """Return the PATH of the user in the registry."""
    return wine("reg", "query", r"HKCU\Environment", "/v", "Path")


def from_installer() -> None:
    """Install silently over an earlier one with a changed profile, and uninstall; what is not of the bundle stays."""
    place, setup = DRIVE / "elsewhere", str(MADE / f"sistap-{__version__}-setup.exe")
    mine = ["/v", "Path", "/t", "REG_EXPAND_SZ", "/d", r"C:\mine;%USERPROFILE%\bin", "/f"]
    wine("reg", "add", r"HKCU\Environment", *mine)
    wine(setup, "/S", "/D=C:\\elsewhere")
    assert "plugins/sis.lua" in installed(), installed()
    (place / "mine.pcapng").touch()
    buttons = HOME / ".config/wireshark/profiles/SIS/dfilter_buttons"
    buttons.write_text(changed := buttons.read_text() + '"TRUE","Mine","sis.station == 3",""\n')
    wine(setup, "/S", "/D=C:\\elsewhere")
    assert buttons.read_text() == changed
    menu = next(DRIVE.glob("users/*/AppData/Roaming/Microsoft/Windows/Start Menu/Programs/SIS in Wireshark"))
    names = {file.stem for file in menu.iterdir()}
    assert {"Command prompt", "Demo", "Read me first", "Uninstall"} <= names, names
    assert r"C:\mine;%USERPROFILE%\bin;C:\elsewhere" in path(), path()
    # _?= keeps the uninstaller from running as a copy, whose end nobody would notice; so it cannot delete itself.
    wine(str(place / "uninstall.exe"), "/S", "_?=C:\\elsewhere")
    assert installed() == {"profiles/SIS/dfilter_buttons"}, installed()
    left = {file.name for file in place.iterdir()}
    assert left <= {"mine.pcapng", "uninstall.exe"}, left
    assert "elsewhere" not in path() and r"C:\mine;%USERPROFILE%\bin" in path(), path()
    assert not menu.exists()
    assert not list(local_data().glob("sistap*"))
    good("installer, again over a changed profile, and uninstaller: nothing is left but what a user has made")


def missing() -> str:
    """Return why this cannot be tried here."""
    for tool, package in {"wine": "wine wine64", COMPILER: "gcc-mingw-w64-x86-64", "tshark": "tshark"}.items():
        if not shutil.which(tool):
            return f"{tool} is missing: apt-get install {package}"
    made = (MADE / f"sistap-{__version__}-windows.zip").exists()
    return "" if made else "it is not made: capture/bundle/build"


def main() -> int:
    """Try all; return the exit code."""
    if why := missing():
        print(f"bundle: not tried: {why}", file=sys.stderr)
        return NOT_RUN
    shutil.rmtree(FOLDER, ignore_errors=True)
    DRIVE.mkdir(parents=True)
    HOME.mkdir()
    here = {"HOME": str(HOME), "PATH": f"{FOLDER / 'bin'}:{os.environ['PATH']}"}
    with Proxy(DRIVE.parent, here) as proxy:
        os.environ["PROXY_PORT"] = str(proxy.port)
        try:
            wine("wineboot", "-i")
            put_wireshark()
            bundle = unpack("", DRIVE / PLACE)
            install(bundle)
            every_command(bundle)
            uninstall(bundle)
            elsewhere(bundle)
            tables()
            from_installer()
        except (AssertionError, OSError, subprocess.SubprocessError) as error:
            print(f"bundle: FAILED {error}")
            return 1
        finally:
            proxy.shutdown()
            subprocess.run(
                ["wineserver", "-k"], env=os.environ | {"WINEPREFIX": str(DRIVE.parent)}, check=False, timeout=TIMEOUT_S
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
