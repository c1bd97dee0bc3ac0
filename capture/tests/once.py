# SPDX-License-Identifier: GPL-2.0-or-later
"""Files that several tests read are made once, for all workers of a run."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path

import pytest

_folder: Path | None = None


def begin(factory: pytest.TempPathFactory) -> None:
    """Find the folder of the run; workers have one each in it."""
    global _folder  # noqa: PLW0603 - the run is one
    own = factory.getbasetemp()
    _folder = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own


def made(content: str, make: Callable[[Path], object]) -> Path:
    """Return the file of this content. If it is not there yet, `make` makes it: two workers at once make it twice."""
    assert _folder, "conftest.py calls begin"
    path = _folder / f"once-{hashlib.sha256(content.encode()).hexdigest()[:16]}"
    if not path.exists():
        new = path.with_name(f"{path.name}-{os.getpid()}")
        make(new)
        new.rename(path)
    return path
