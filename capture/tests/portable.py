# SPDX-License-Identifier: GPL-2.0-or-later
"""What tests need from the system and Windows lacks: why a test, or a whole file, cannot run there."""

from __future__ import annotations

import ast
import ctypes
import errno
import importlib
import importlib.util
import os
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from sistap.tap.terminal.advice import advice

WINDOWS = sys.platform == "win32"

# Those that import nothing special.
_REASONS = {
    "test_stop.py": "needs SIGHUP, which Windows has not",
    "test_tshark.py": "a shell plays tshark",
    "test_extcap_tshark.py": "tshark finds an extcap that is a shell script",
    "test_hostile_text.py": "names of files are not bytes there",
    "test_lasting.py": "needs fdatasync, which Windows has not",
    "test_package.py": "needs setuptools, which the Python of the test bed has not",
}

SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT") if hasattr(signal, name)]


def posix(reason: str) -> pytest.MarkDecorator:
    """Mark what Windows cannot run; `reason` names what it lacks."""
    return pytest.mark.skipif(WINDOWS, reason=f"not on Windows: {reason}")


terminals = posix("no pseudo terminals")
signals = posix("no signals from another process")
sockets = posix("no sockets that are files")
fifos = posix("no pipes in folders")
links = posix("links are for administrators")
modes = posix("files have no modes")
libpcap = pytest.mark.skipif(
    WINDOWS and not Path(os.environ.get("SYSTEMROOT", ""), "System32/Npcap/wpcap.dll").exists(), reason="no Npcap"
)
unpackaged = pytest.mark.skipif(
    Path("/usr/bin/sistap").exists(), reason="the package sistap is installed here: Wireshark loads its dissector"
)
WRITES_TABLES = importlib.util.find_spec("pyarrow") is not None
tables = pytest.mark.skipif(not WRITES_TABLES, reason="pyarrow writes the tables: pip install pyarrow")
# What a command says, and the cure, where PATH leads nowhere.
NO_TSHARK = ("no Wireshark was found", advice().no_wireshark) if WINDOWS else ("tshark is not on PATH", advice().tshark)
compiled = posix("no gcc that makes modules of Linux")


# With summer time, by rules that need no file.
BERLIN = "CET-1" if WINDOWS else "CET-1CEST,M3.5.0,M10.5.0/3"


def descriptors() -> set[str]:
    """Return which descriptors are open: none is new after a test, but some of an earlier one may have gone."""
    return set() if WINDOWS else set(os.listdir("/proc/self/fd"))


def take_over_zone() -> None:
    """Let this process take over the time zone in TZ. Windows knows summer time of its own zone alone."""
    if sys.platform == "win32":
        ctypes.CDLL("ucrtbase")._tzset()
    else:
        time.tzset()


def zone(monkeypatch: pytest.MonkeyPatch, name: str) -> Iterator[None]:
    """Set the time zone, in a fixture."""
    with monkeypatch.context() as patched:
        patched.setenv("TZ", name)
        take_over_zone()
        yield
    take_over_zone()


def keep(patch: pytest.MonkeyPatch, kept: Path) -> None:
    """Let nobody delete a file, as in Windows while somebody reads it."""
    real = Path.unlink

    def unlink(path: Path, *, missing_ok: bool) -> None:
        if path == kept:
            raise PermissionError(errno.EACCES, "it is read", str(path))
        real(path, missing_ok=missing_ok)

    patch.setattr(Path, "unlink", unlink)


def lacking(file: Path, system: str = sys.platform) -> str:
    """Return what a file of tests needs and Windows lacks; empty if it can run. On other systems this is an error."""
    if system != "win32":
        return ""
    if file.name in _REASONS:
        return _REASONS[file.name]
    for module, name in _imported(file):
        try:
            loaded = importlib.import_module(module)
            if name and not hasattr(loaded, name):
                importlib.import_module(f"{module}.{name}")
        except ImportError as error:
            return f"needs {module}: {error}"
    return ""


def _imported(file: Path) -> Iterator[tuple[str, str]]:
    """Yield the modules that it imports at its beginning, each with a name that it takes from it."""
    for node in ast.parse(file.read_text("utf-8")).body:
        if isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from ((node.module, alias.name) for alias in node.names)
