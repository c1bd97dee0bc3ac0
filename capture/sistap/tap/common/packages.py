# SPDX-License-Identifier: GPL-2.0-or-later
"""Which Python this is, and how it gets a package that is missing."""

from __future__ import annotations

import importlib
import sys
import sysconfig
from pathlib import Path
from typing import Any

from sistap.tap.terminal.advice import shell_word
from sistap.tap.terminal.exits import FAILED, Refusal
from sistap.tap.terminal.stop import held

_ROOT = Path(__file__).resolve().parents[3]  # of the package sistap


def needed(package: str) -> Any:
    """Import a package that one command needs. Refusal says how to get it."""
    try:
        with held():
            return importlib.import_module(package)
    except ImportError:
        raise Refusal(missing(package), FAILED) from None


def missing(package: str) -> str:
    """Say for which Python a package is missing, and how to get it there."""
    return f"{package} is missing for {sys.executable}: {_how_to_get(package)}"


def is_bundle() -> bool:
    """Tell whether this is the bundle for Windows, with a Python of its own and the command `sistap`."""
    return any(Path(sys.executable).parent.glob("python3*._pth"))


def _how_to_get(package: str) -> str:
    python = Path(sys.executable)
    if is_bundle():
        return f"this Python has no pip; the file sistap-...-windows-full.zip has {package}: unpack it, and use that"
    if sys.platform == "win32":
        return f"type {shell_word(str(python))} -m pip install {package}"
    if sys.prefix != sys.base_prefix or not Path(sysconfig.get_path("stdlib"), "EXTERNALLY-MANAGED").exists():
        return f"`{shell_word(str(python))} -m pip install {package}`"
    if sys.platform == "linux" and package == "pyserial":
        return "`sudo apt-get install python3-serial`"  # Debian's own Python takes no others from pip
    before = "`sudo apt-get install python3-venv`, " if sys.platform == "linux" else ""
    return (
        f"{before}`{shell_word(str(python))} -m venv --system-site-packages ~/sistap-python`, "
        f"`~/sistap-python/bin/pip install {package}`; then type "
        f"`PYTHONPATH={shell_word(str(_ROOT))} ~/sistap-python/bin/python3 -m sistap` in place "
        "of `sistap`"
    )
