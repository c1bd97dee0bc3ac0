# SPDX-License-Identifier: GPL-2.0-or-later
"""A file, or standard output, opened for writing; failures have one line.

A file is written beside its place and moved there when it is complete. So nobody reads half of it, and a failure leaves
the old one. A file that holds data is replaced only with --force. A symbolic link is refused. FIFOs, devices, and what
the system itself names in /dev and /proc are opened as they are.
"""

from __future__ import annotations

import errno
import os
import stat
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from sistap.tap.terminal.console import STANDARD_OUTPUT, is_reader_gone, leave_standard_output
from sistap.tap.terminal.exits import FAILED, Refusal, why
from sistap.tap.terminal.state import HeldOpenError, closed
from sistap.tap.terminal.stop import held
from sistap.tap.terminal.writing import WINDOWS_PIPES, lock, mode_like, no_link

_CURE = "name another file with -o"


def make_folder(folder: Path, mode: int) -> None:
    """Make a folder, and those that it is in, for those who may read a file of this mode. May raise OSError."""
    if not folder.is_dir():
        make_folder(folder.parent, mode)
        folder.mkdir(mode | (mode & 0o444) >> 2, exist_ok=True)


class Beside:
    """A new file in the folder of another, whose place it takes at the end."""

    def __init__(self, path: Path, mode: int) -> None:
        """Make it, while Stopped is held. May raise OSError."""
        self._place = path
        self._path = path.with_name(f".sistap-{os.urandom(8).hex()}")
        self.file = _new(self._path, mode)

    def replace(self) -> None:
        """Move it to its place. May raise OSError."""
        self.file.close()
        with closed(self._place):
            self._path.replace(self._place)

    def remove(self) -> None:
        """Remove it, unless it was moved."""
        with suppress(OSError):
            self.file.close()
        with suppress(OSError):
            self._path.unlink()


def _new(path: Path, mode: int) -> BinaryIO:
    """Open a file that must not exist yet, so that no link leads elsewhere."""
    return os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), mode), "wb")


@contextmanager
def opened(
    path: str | None, sources: Sequence[str | Path] = (), *, force: bool = False, grows: bool = False, cure: str = _CURE
) -> Iterator[BinaryIO]:
    """Open the output, standard output without a path; whoever may read it may read all `sources`.

    A file that `grows` is in its place from the beginning. May raise Refusal, also at the end.
    """
    if path is None or path == STANDARD_OUTPUT:
        with _standard_output(cure):
            yield sys.stdout.buffer
        return
    new: Beside | None = None
    try:
        if grows:
            file = growing(path, sources, force=force, cure=cure)
        else:
            with _refusing(path, cure):
                if _is_file(path, cure, force=force):
                    with held():
                        new = Beside(Path(path), mode_like(sources))
                file = new.file if new else open(path, "wb")  # noqa: SIM115 - closed below
        with file:
            yield file
        if new and _is_file(path, cure, force=force):  # it may have come meanwhile
            with held():
                new.replace()
    except HeldOpenError as error:
        raise Refusal(str(error), FAILED) from None
    except OSError as error:
        raise Refusal(f"{path} is incomplete: {error.strerror}; make room, or {cure}", FAILED) from None
    finally:
        if new:
            with held():
                new.remove()


def growing(path: str, sources: Sequence[str | Path] = (), *, force: bool = False, cure: str = _CURE) -> BinaryIO:
    """Open a file that others may read while it is written, with an empty file in its place. May raise Refusal."""
    with _refusing(path, cure):
        if _is_file(path, cure, force=force):
            Path(path).unlink(missing_ok=True)
            return _new(Path(path), mode_like(sources))
        return open(path, "wb")  # noqa: SIM115 - for the caller


@contextmanager
def _refusing(path: str, cure: str) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise Refusal(f"cannot write {path}: {why(error)}; {cure}") from None


def _is_file(path: str, cure: str, *, force: bool) -> bool:
    """Tell whether it is a file, or will be one. Refusal if it must stay; OSError."""
    if path.startswith(WINDOWS_PIPES):
        return False
    no_link(path)
    try:
        found = Path(path).lstat()  # links that the system made are no files
    except FileNotFoundError:
        return True
    if not stat.S_ISREG(found.st_mode):
        return False
    if found.st_size and not force:
        raise Refusal(f"{path} holds data already: {cure}, or overwrite it with --force")
    if _is_locked(Path(path)):
        raise Refusal(f"{path} is being written by a capture: {cure}")
    return True


@contextmanager
def _standard_output(cure: str) -> Iterator[None]:
    try:
        yield
        sys.stdout.buffer.flush()
    except OSError as error:
        if is_reader_gone(error):
            raise  # needs no message
        leave_standard_output()
        raise Refusal(loss(error, cure), FAILED) from None


def loss(error: OSError, cure: str = "") -> str:
    """Describe why a write to standard output failed; `cure` is what helps besides."""
    if error.errno == errno.EBADF:
        return "standard output is closed" + (cure and f"; {cure}")
    return f"standard output is incomplete: {error.strerror}; make room" + (cure and f", or {cure}")


def _is_locked(path: Path) -> bool:
    """Tell whether another program has locked a file."""
    with suppress(OSError):
        descriptor = os.open(path, os.O_RDONLY)
        try:
            return not lock(descriptor)
        finally:
            os.close(descriptor)
    return False
