# SPDX-License-Identifier: GPL-2.0-or-later
"""What a shell needs: the command `sistap`, and its completion."""

from __future__ import annotations

import argparse
import os
import shutil
import sys
from collections.abc import Collection
from pathlib import Path
from typing import NamedTuple

from sistap.install import completion
from sistap.install.launching import command

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
        programs = (Path(local) if local else Path.home() / "AppData/Local") / "Programs/sistap"
        return Places(programs / "sistap.bat", programs, programs)
    shared = FOR_ALL / "share"
    if not for_all:
        named = os.environ.get("XDG_DATA_HOME", "")
        shared = Path(named) if Path(named).is_absolute() else Path.home() / ".local/share"
    program = (FOR_ALL if for_all else Path.home() / ".local") / "bin/sistap"
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
    found = shutil.which("sistap", path=os.pathsep.join(path)) if path else None
    return found if found and Path(found) not in ours else ""


def files(where: Places, package_root: Path, whole: argparse.ArgumentParser, *, windows: bool) -> dict[Path, bytes]:
    """Return the files and their paths. The first, the command, must be executable; `whole` is the parser of all
    commands.
    """
    put = {where.command: command(sys.executable, package_root, windows).encode()}
    if not windows:
        put |= {where.bash: completion.bash(whole).encode(), where.zsh: completion.zsh(whole).encode()}
    return put


def is_on_path(where: Places) -> bool:
    """Tell whether a shell finds the command."""
    return where.command.parent in [Path(folder) for folder in os.environ.get("PATH", "").split(os.pathsep)]
