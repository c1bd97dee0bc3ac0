# SPDX-License-Identifier: GPL-2.0-or-later
"""The files by which Wireshark (in its extcap folder) and a shell (on PATH) start sistap."""

from __future__ import annotations

import shlex
from pathlib import Path

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
"{interpreter}" -P -m sistap {arguments}%*
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
