# SPDX-License-Identifier: GPL-2.0-or-later
"""One `sistap install` or `uninstall` at a time: else the list written last lacks what the other put."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from sistap.commands.install.ledger import Ledger
from sistap.tap.terminal import state
from sistap.tap.terminal.exits import FAILED, Refusal
from sistap.tap.terminal.writing import lock

WAIT_S = 10.0
_AGAIN_S = 0.1
NAME = "installing"  # only its owner may open it, so nobody else can lock it


@contextmanager
def alone(*, for_all: bool) -> Iterator[Ledger]:
    """Read the list and keep others from it until the end of a `with`. Refusal if another does for too long.

    Like Ledger, it may raise OSError and RuntimeError.
    """
    path = state.folder() / NAME
    descriptor = _locked(path)
    try:
        yield Ledger(for_all=for_all)
    finally:
        if descriptor is not None:
            _unlock(path, descriptor)


def _locked(path: Path) -> int | None:
    """Wait for the lock. None where no file can be made: then no list can be saved either, which says why."""
    end = time.monotonic() + WAIT_S
    while True:
        try:
            descriptor = _opened(path)
            if lock(descriptor) and _is(path, descriptor):
                return descriptor
            os.close(descriptor)
        except FileNotFoundError:  # the other has just removed the folder
            pass
        except OSError:
            return None
        if time.monotonic() >= end:
            raise Refusal("another `sistap install` or `uninstall` is under way: try again when it has ended", FAILED)
        time.sleep(_AGAIN_S)


def _opened(path: Path) -> int:
    path.parent.mkdir(mode=0o755 if state.is_root() else 0o777, parents=True, exist_ok=True)
    return os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o600)


def _is(path: Path, descriptor: int) -> bool:
    """Tell whether the locked file is still there: the other removes it at its end."""
    with suppress(FileNotFoundError):
        return os.path.samestat(path.stat(), os.fstat(descriptor))
    return False


def _unlock(path: Path, descriptor: int) -> None:
    """Remove the file, and the folder if nothing is in it."""
    if state.WINDOWS:  # which removes no open file
        os.close(descriptor)
    state.forget(path.name)
    if not state.WINDOWS:
        os.close(descriptor)
