# SPDX-License-Identifier: GPL-2.0-or-later
"""What a shell and Wireshark need to start sistap: the command, its launchers, and its completion."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from collections.abc import Collection
from pathlib import Path
from typing import NamedTuple

from sistap.commands.install import completion
from sistap.tap.terminal.programs import on_path
from sistap.tap.terminal.state import home

# -P: import nothing from the current folder. exec replaces the shell by Python, so that a stop signal reaches it.
_SHELL = """\
#!/bin/sh
# {what}
export PYTHONPATH={package_root}
exec {interpreter} -P -m sistap {arguments}"$@"
"""

_BATCH = """\
@echo off
rem {what}
chcp 65001 >nul
set "PYTHONPATH={package_root}"
"{interpreter}" -P -X utf8 -m sistap {arguments}%*
"""


def settings(interpreter: str, package_root: Path) -> str:
    """Return the text of sistap.cfg, which configures sistap.exe; the other launchers contain these settings."""
    return f"{interpreter}\r\n{package_root}\r\n"


def launcher(interpreter: str, package_root: Path, windows: bool) -> str:
    """Return the text of the launcher: `interpreter` runs the package `sistap` in `package_root`.

    It is a shell script, to be made executable; for Windows a .bat (in UTF-8). Both paths must be absolute: a desktop
    starts Wireshark in any folder, without the PATH and PYTHONPATH of a terminal.
    """
    return _filled(interpreter, package_root, windows, "SIS among the interfaces of Wireshark.", "extcap ")


def command(interpreter: str, package_root: Path, windows: bool) -> str:
    """Return the text of the command `sistap` for a shell, made like the launcher."""
    return _filled(interpreter, package_root, windows, "The command sistap.", "")


def _filled(interpreter: str, package_root: Path, windows: bool, what: str, arguments: str) -> str:
    if windows:
        return _BATCH.format(
            what=what,
            arguments=arguments,
            interpreter=interpreter.replace("%", "%%"),
            package_root=str(package_root).replace("%", "%%"),
        ).replace("\n", "\r\n")
    return _SHELL.format(
        what=what,
        arguments=arguments,
        interpreter=shlex.quote(interpreter),
        package_root=shlex.quote(str(package_root)),
    )


# -- A shell: where its files are ------------------------------------------------------------------------------------

FOR_ALL = Path("/usr/local")


class Places(NamedTuple):
    """The paths of the command and its completion."""

    command: Path  # the file
    bash: Path
    zsh: Path


def places(*, for_all: bool, windows: bool) -> Places:
    """Return the paths for this user, or for all. RuntimeError if this user has no home."""
    if windows:
        local = os.environ.get("LOCALAPPDATA", "")
        programs = (Path(local) if local else home() / "AppData/Local") / "Programs/sistap"
        return Places(programs / "sistap.bat", programs, programs)
    shared = FOR_ALL / "share"
    if not for_all:
        named = os.environ.get("XDG_DATA_HOME", "")
        shared = Path(named) if Path(named).is_absolute() else home() / ".local/share"
    program = (FOR_ALL if for_all else home() / ".local") / "bin/sistap"
    return Places(program, shared / "bash-completion/completions/sistap", shared / "zsh/site-functions/_sistap")


def folders(where: Places) -> list[Path]:
    """Return the folders of these paths."""
    return sorted({file.parent for file in where})


def foreign(ours: Collection[Path]) -> str:
    """Return a command `sistap` on PATH that is not in `ours`; None if there is none.

    The command of an active virtual environment is ignored: it goes away with the environment.
    """
    active = Path(sys.prefix) if sys.prefix != sys.base_prefix else None
    path = [
        folder
        for folder in os.environ.get("PATH", os.defpath).split(os.pathsep)
        if folder and Path(folder).is_absolute() and not (active and Path(folder).is_relative_to(active))
    ]
    found = on_path("sistap", os.pathsep.join(path)) if path else None
    return found if found and Path(found) not in ours else ""


def files(where: Places, package_root: Path, whole: argparse.ArgumentParser, *, windows: bool) -> dict[Path, bytes]:
    """Return the files and their paths. The first, the command, must be executable; `whole` is the parser of all
    commands.
    """
    put = {where.command: command(sys.executable, package_root, windows).encode()}
    if not windows:
        put |= {where.bash: completion.bash(whole).encode(), where.zsh: completion.zsh(whole).encode()}
    return put
