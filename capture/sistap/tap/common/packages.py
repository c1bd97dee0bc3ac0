# SPDX-License-Identifier: GPL-2.0-or-later
"""Which Python this is, and how it gets a package that is missing."""

from __future__ import annotations

import sys
import sysconfig
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sistap.tap.terminal.advice import shell_word
from sistap.tap.terminal.exits import FAILED, Refusal
from sistap.tap.terminal.stop import held

_ROOT = Path(__file__).resolve().parents[3]  # of the package sistap


@contextmanager
def needing(package: str) -> Iterator[None]:
    """Import in a `with` what needs a package. Refusal says how to get it, or how to get one that works."""
    try:
        with held():
            yield
    except ModuleNotFoundError as error:
        raise Refusal(missing(package) if error.name == package else _broken(package, error), FAILED) from None
    except Exception as error:  # noqa: BLE001 - whatever a package of another version or a damaged one may raise
        raise Refusal(_broken(package, error), FAILED) from None


def missing(package: str) -> str:
    """Say for which Python a package is missing, and how to get it there."""
    return f"{package} is missing for {sys.executable}: {_how_to_get(package)}"


def _broken(package: str, error: Exception) -> str:
    why = next(iter(str(error).splitlines()), "") or type(error).__name__
    return f"{package} does not work with {sys.executable} ({why}): {_how_to_get(package, '--force-reinstall ')}"


def is_bundle() -> bool:
    """Tell whether this is the bundle for Windows, with a Python of its own and the command `sistap`."""
    return any(Path(sys.executable).parent.glob("python3*._pth"))


def _how_to_get(package: str, again: str = "") -> str:
    python = Path(sys.executable)
    if is_bundle():
        return f"this Python has no pip; the file sistap-...-windows-full.zip has {package}: unpack it, and use that"
    if sys.platform == "win32":
        return f"type {shell_word(str(python))} -P -m pip install {again}{package}"
    if sys.prefix != sys.base_prefix or not Path(sysconfig.get_path("stdlib"), "EXTERNALLY-MANAGED").exists():
        return f"`{shell_word(str(python))} -P -m pip install {again}{package}`"
    if sys.platform == "linux" and package == "pyserial":
        return "`sudo apt-get install python3-serial`"  # Debian's own Python takes no others from pip
    before = "`sudo apt-get install python3-venv`, " if sys.platform == "linux" else ""
    return (
        f"{before}`{shell_word(str(python))} -P -m venv --system-site-packages ~/sistap-python`, "
        f"`~/sistap-python/bin/pip install {again}{package}`; then type "
        f"`PYTHONPATH={shell_word(str(_ROOT))} ~/sistap-python/bin/python3 -P -m sistap` in place "
        "of `sistap`"
    )
