# SPDX-License-Identifier: GPL-2.0-or-later
"""The files by which Wireshark, in its folder of extcaps, and a shell, on PATH, start sistap."""

from __future__ import annotations

import shlex
from pathlib import Path

# -P: nothing is imported from the folder in which it was started. The shell becomes Python, so that a signal to stop
# reaches it.
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
    """Return the text of sistap.cfg, which says to sistap.exe what the other launchers have in themselves."""
    return f"{interpreter}\r\n{package_root}\r\n"


def launcher(interpreter: str, package_root: Path, windows: bool) -> str:
    """Return the text of the launcher: `interpreter` is to run the package `sistap` that is in `package_root`.

    A shell script, to be made executable; for Windows a .bat (in UTF-8). Both paths have to be absolute: a desktop
    starts Wireshark anywhere, with neither PATH nor PYTHONPATH as a terminal has them.
    """
    return _filled(interpreter, package_root, windows, "SIS among the interfaces of Wireshark.", "extcap ")


def command(interpreter: str, package_root: Path, windows: bool) -> str:
    """Return the text of the command `sistap` for a shell, made as the launcher is."""
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
