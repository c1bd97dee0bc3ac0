# SPDX-License-Identifier: GPL-2.0-or-later
"""A temporary folder that stays behind after no signal."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sistap.terminal.stop import held


@contextmanager
def folder() -> Iterator[Path]:
    """Make a folder; remove it at the end. If a signal comes just before that, Python does it with the object."""
    with held():
        made = tempfile.TemporaryDirectory(prefix="sistap-")
    try:
        yield Path(made.name)
    finally:
        with held():
            made.cleanup()
