# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds programs: on PATH, and those of Wireshark also where its installers put them."""

from __future__ import annotations

import os
import shutil
import sys
from contextlib import suppress
from pathlib import Path

from sistap.tap.terminal import state

_REMEMBERED = "wireshark"  # the file in the state folder
_APP_PATHS = r"Software\Microsoft\Windows\CurrentVersion\App Paths\Wireshark.exe"
PORTABLE = Path("App", "Wireshark")  # of the folder of a portable Wireshark, with its settings in Data


def on_path(name: str, path: str | None = None) -> str | None:
    """Return a program of PATH. On Windows, never one of the current folder, where anybody may have put it."""
    if sys.platform != "win32":
        return shutil.which(name, path=path)
    suffixes = os.environ.get("PATHEXT", ".COM;.EXE;.BAT;.CMD").split(";")
    for folder in (os.environ.get("PATH", "") if path is None else path).split(os.pathsep):
        if Path(folder).is_absolute():
            for suffix in suffixes:
                if (file := Path(folder, name + suffix.lower())).is_file():
                    return str(file)
    return None


def of_wireshark(name: str) -> str | None:
    """Return the path of a program of Wireshark: in the folder that the user named, on PATH, or as installed."""
    if (folder := remembered()) and (found := in_folder(name, folder)):
        return found
    return on_path(name) or next((found for folder in _installed() if (found := in_folder(name, folder))), None)


def typed(name: str) -> str:
    """Return what a person types to start a program of Wireshark: its path, if a shell would not find this one."""
    found = of_wireshark(name)
    return found if found and found != on_path(name) else name


def in_folder(name: str, folder: Path) -> str | None:
    """Return a program of Wireshark in a folder, which may be that of a portable Wireshark."""
    return on_path(name, os.pathsep.join(map(str, (folder, folder / PORTABLE))))


def remember(folder: Path) -> None:
    """Use the Wireshark of this folder from now on. May raise OSError, RuntimeError."""
    state.save(_REMEMBERED, str(folder.resolve()).encode("utf-8", "surrogateescape"))


def remembered() -> Path | None:
    """Return the folder that the user named."""
    with suppress(OSError, RuntimeError, ValueError):
        return Path((state.folder() / _REMEMBERED).read_bytes().decode("utf-8", "surrogateescape"))
    return None


def forget() -> None:
    """Use no special Wireshark any more."""
    state.forget(_REMEMBERED)


def _installed() -> list[Path]:
    """Return folders that are not on PATH."""
    if sys.platform == "darwin":
        return [Path("/Applications/Wireshark.app/Contents/MacOS")]
    if sys.platform != "win32":
        return []
    import winreg  # noqa: PLC0415 - on Windows only

    found = []
    for whose in (winreg.HKEY_CURRENT_USER, winreg.HKEY_LOCAL_MACHINE):
        with (
            suppress(OSError),
            winreg.OpenKey(whose, _APP_PATHS, 0, winreg.KEY_READ | winreg.KEY_WOW64_64KEY) as key,
        ):
            found.append(Path(str(winreg.QueryValue(key, None))).parent)
    return [*found, Path(os.environ.get("PROGRAMFILES", r"C:\Program Files"), "Wireshark")]
