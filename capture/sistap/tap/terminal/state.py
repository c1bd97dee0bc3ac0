# SPDX-License-Identifier: GPL-2.0-or-later
"""Where sistap keeps what it remembers between runs, and how it writes that.

Root keeps it in a fixed folder that nobody else may write to. The environment must not name another one: `sudo -E` has
the environment of an ordinary user. That user could put files there that root then reads, or a link through which root
then writes.
"""

from __future__ import annotations

import os
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from sistap.tap.terminal.advice import advice
from sistap.tap.terminal.stop import held

ROOT = 0  # user
WINDOWS = os.name == "nt"
FOR_ROOT = Path("/var/lib/sistap")


class StateError(RuntimeError):
    """The folder cannot be used; the text is one line with the cure."""


class HeldOpenError(OSError):
    """A program has a file open; the text is one line with the cure."""


def is_root() -> bool:
    """Tell whether this is root, who acts for all users."""
    return hasattr(os, "geteuid") and os.geteuid() == 0


def folder() -> Path:
    """Return the folder; it may not exist. StateError if others could have written into root's folder.

    RuntimeError if an ordinary user has no home.
    """
    if not is_root():
        return of_environment()
    check(FOR_ROOT)
    return FOR_ROOT


def of_environment() -> Path:
    """Return the folder that the environment names (XDG base directories; on Windows what belongs to this computer).

    RuntimeError if this user has no home.
    """
    state = os.environ.get("XDG_STATE_HOME", "") or (os.environ.get("LOCALAPPDATA", "") if WINDOWS else "")
    return (Path(state) if Path(state).is_absolute() else home() / ".local/state") / "sistap"


def home() -> Path:
    """Return the home of this user. RuntimeError if there is none, or if it depends on the current folder."""
    named = os.environ.get("HOME")  # Python takes an empty one for the root of all folders
    if not WINDOWS and named is not None and not Path(named).is_absolute():
        raise RuntimeError(f"HOME is '{named}', which is no absolute path: set it to your home folder")
    return Path.home()


def check(path: Path) -> None:
    """Raise StateError if anybody but root could write to root's file or folder."""
    with suppress(FileNotFoundError):
        found = path.lstat()
        if stat.S_ISLNK(found.st_mode) or not only_root_writes(found):
            raise StateError(
                f"{path} is not used, because others than root could have written it: look at what is in it, then "
                f"`chown root {path}; chmod go-w {path}`, or delete it"
            )


def only_root_writes(found: os.stat_result) -> bool:
    """Tell whether nobody but root may write there, by owner and mode."""
    return found.st_uid in (0, ROOT) and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def save(name: str, content: bytes) -> Path:
    """Write a whole file into the folder, or none; return its path. Raise StateError, RuntimeError or OSError."""
    path = folder()
    path.mkdir(mode=0o755 if is_root() else 0o777, parents=True, exist_ok=True)
    replace(folder() / name, content)
    return path / name


def forget(name: str) -> None:
    """Remove a file from the folder, and the folder if nothing else is in it."""
    with suppress(OSError, RuntimeError):
        (folder() / name).unlink()
    with suppress(OSError, RuntimeError):
        folder().rmdir()


@contextmanager
def closed(file: Path, system: str = sys.platform) -> Iterator[None]:
    """Replace or remove a file in a `with`. HeldOpenError if a program has it open, which fails only on Windows."""
    try:
        yield
    except PermissionError as error:
        if system != "win32":
            raise
        raise HeldOpenError(f"{file} stays as it is: {advice(system).held}") from error


def replace(file: Path, content: bytes, *, executable: bool = False) -> None:
    """Write a whole new file or none, and replace the old one by it: a running Wireshark may have the old one mapped.

    The new file has an unpredictable name and is opened only if it does not exist, so no link leads elsewhere.
    """
    with held():
        descriptor, new = tempfile.mkstemp(prefix=f".{file.name}.", dir=file.parent)
        try:
            _fill(descriptor, content, file)
            Path(new).chmod(0o755 if executable else 0o644)
            with closed(file):
                Path(new).replace(file)
        finally:
            with suppress(OSError):
                Path(new).unlink()


def _fill(descriptor: int, content: bytes, file: Path) -> None:
    """Write the contents and close; an OSError names the file."""
    try:
        with open(descriptor, "wb") as stream:
            stream.write(content)
    except OSError as error:
        raise OSError(error.errno, f"{error.strerror}; make room", str(file)) from None
