# SPDX-License-Identifier: GPL-2.0-or-later
"""The files in the folder of a recorder: their names and their number, including those of earlier runs."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from pathlib import Path

RING = "ring.pcapng"  # output names the files: ring_00001_20261122031204.pcapng

_KEPT_NAME = re.compile(r"kept_(\d{14}\.\d{3})_[\w.-]+\.pcapng", re.ASCII)
_RING_NAME = re.compile(r"ring_\d{5}_(\d{14})\.pcapng", re.ASCII)


class Shelf:
    """The files of one kind."""

    def __init__(self, folder: Path, name: re.Pattern[str], at_most: int | None, say: Callable[[str], None]) -> None:
        """Keep the newest `at_most` files with such a name, None: all."""
        self.folder = folder
        self._name = name
        self._at_most = at_most
        self._say = say
        self._stay: set[Path] = set()  # files that cannot be deleted; reported once

    def tidy(self) -> None:
        """Delete the oldest files if there are too many."""
        if self._at_most is None:
            return
        found = sorted((match[1], path) for path in self.folder.iterdir() if (match := self._name.fullmatch(path.name)))
        for _, path in found[: -self._at_most]:
            try:
                path.unlink(missing_ok=True)
            except OSError as error:
                if path not in self._stay:
                    self._stay.add(path)
                    self._say(f"{path} cannot be deleted: {error.strerror}; it stays, delete it yourself")


def kept(folder: Path, at_most: int | None, say: Callable[[str], None]) -> Shelf:
    """Return the kept files."""
    return Shelf(folder, _KEPT_NAME, at_most, say)


def ring(folder: Path, at_most: int | None, say: Callable[[str], None]) -> Shelf:
    """Return the files of the full ring."""
    return Shelf(folder, _RING_NAME, at_most, say)


def new_name(folder: Path, time_ns: int, word: str) -> Path:
    """Return an unused name for a file, from its time (local) and reason."""
    seconds, ns = divmod(time_ns, 1_000_000_000)
    base = f"kept_{time.strftime('%Y%m%d%H%M%S', time.localtime(seconds))}.{ns // 1_000_000:03d}_{word}"
    path, number = folder / f"{base}.pcapng", 1
    while path.exists():
        number += 1
        path = folder / f"{base}-{number}.pcapng"
    return path
