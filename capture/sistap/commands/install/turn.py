# SPDX-License-Identifier: GPL-2.0-or-later
"""One `sistap install` or `uninstall` at a time: else the list written last lacks what the other put."""

from __future__ import annotations

import errno
import os
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from sistap.commands.install.ledger import Ledger
from sistap.tap.terminal import state
from sistap.tap.terminal.exits import FAILED, Refusal
from sistap.tap.terminal.stop import held
from sistap.tap.terminal.writing import lock

WAIT_S = 10.0
_AGAIN_S = 0.1
# For a moment Windows denies access to what the other is just removing, as if no list could be saved.
_DENIALS, _MOMENT_S = 5, 0.01
NAME = "installing"  # only its owner may open it, so nobody else can lock it
# With these no list can be saved either: whoever tries it says why.
_NO_LIST = {errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOSPC, errno.EDQUOT, errno.ENOTDIR}


@contextmanager
def alone(*, for_all: bool) -> Iterator[Ledger]:
    """Read the list and keep others from it until the end of a `with`. Refusal if another does for too long.

    Like Ledger, it may raise OSError and RuntimeError.
    """
    path = state.folder() / NAME
    with ExitStack() as turn:
        end = time.monotonic() + WAIT_S
        while not _took(path, turn):
            if time.monotonic() >= end:
                line = "another `sistap install` or `uninstall` is under way: try again when it has ended"
                raise Refusal(line, FAILED)
            time.sleep(_AGAIN_S)
        yield Ledger(for_all=for_all)


def _took(path: Path, turn: ExitStack) -> bool:
    """Take the lock, unless another has it; `turn` gives it back. Where no list can be saved, go on without it."""
    try:
        with held():
            descriptor = _opened(path)
            if lock(descriptor) and _is(path, descriptor):
                turn.callback(_unlock, path, descriptor)
                return True
            os.close(descriptor)
            return False
    except (FileNotFoundError, FileExistsError):  # the other has just removed the folder, or a file is in its place
        return os.path.lexists(path.parent) and not path.parent.is_dir()
    except OSError as error:
        if error.errno not in _NO_LIST:
            raise
        return True


def _opened(path: Path) -> int:
    for _ in range(_DENIALS if state.WINDOWS else 0):
        with suppress(PermissionError):
            return _open(path)
        time.sleep(_MOMENT_S)
    return _open(path)


def _open(path: Path) -> int:
    path.parent.mkdir(mode=0o755 if state.is_root() else 0o777, parents=True, exist_ok=True)
    return os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o600)


def _is(path: Path, descriptor: int) -> bool:
    """Tell whether the locked file is still there: the other removes it at its end."""
    with suppress(FileNotFoundError):
        return os.path.samestat(path.stat(), os.fstat(descriptor))
    return False


def _unlock(path: Path, descriptor: int) -> None:
    """Remove the file, and the folder if nothing is in it."""
    with held():
        if state.WINDOWS:  # which removes no open file
            os.close(descriptor)
        state.forget(path.name)
        if not state.WINDOWS:
            os.close(descriptor)
