# SPDX-License-Identifier: GPL-2.0-or-later
"""The file in Wireshark's extcap folder by which it finds sistap."""

from __future__ import annotations

import shlex
from pathlib import Path

# -P: nothing is imported from the folder in which Wireshark was started. The shell becomes Python, so that Wireshark's
# signal to stop reaches it.
_SHELL = """\
#!/bin/sh
# SIS among the interfaces of Wireshark.
export PYTHONPATH={package_root}
exec {interpreter} -P -m sistap extcap "$@"
"""

_BATCH = """\
@echo off
rem SIS among the interfaces of Wireshark.
chcp 65001 >nul
set "PYTHONPATH={package_root}"
"{interpreter}" -P -m sistap extcap %*
"""


def settings(interpreter: str, package_root: Path) -> str:
    """Return the text of sistap.cfg, which says to sistap.exe what the other launchers have in themselves."""
    return f"{interpreter}\r\n{package_root}\r\n"


def launcher(interpreter: str, package_root: Path, windows: bool) -> str:
    """Return the text of the launcher: `interpreter` is to run the package `sistap` that is in `package_root`.

    A shell script, to be made executable; for Windows a .bat (in UTF-8). Both paths have to be absolute: a desktop
    starts Wireshark anywhere, with neither PATH nor PYTHONPATH as a terminal has them.
    """
    if windows:
        return _BATCH.format(
            interpreter=interpreter.replace("%", "%%"), package_root=str(package_root).replace("%", "%%")
        ).replace("\n", "\r\n")
    return _SHELL.format(interpreter=shlex.quote(interpreter), package_root=shlex.quote(str(package_root)))
