# SPDX-License-Identifier: GPL-2.0-or-later
"""Counts the instructions of tshark and of whoever starts it, with valgrind. Unlike times they hardly differ."""

from __future__ import annotations

import re
import shutil
import sys
from collections import Counter
from pathlib import Path

FEW, MANY = 101, 2001  # packets: the difference has no start in it
VALGRIND = "valgrind --tool=cachegrind --cache-sim=no --cachegrind-out-file=/dev/null --log-file="
_COUNTED = re.compile(r"I +refs: +([\d,]+)")


class Instructions:
    """A folder with a tshark that counts. Everybody may write down there what it has counted: root's runs as nobody."""

    def __init__(self, folder: Path) -> None:
        """Prepare. End the program if one that is needed is missing."""
        if missing := [name for name in ("valgrind", "tshark") if not shutil.which(name)]:
            sys.exit(f"{missing[0]} is not on PATH; on Debian: apt install {missing[0]}")
        self._counted = folder / "counted"
        self._counted.mkdir()
        self.tshark = folder / "tshark"
        self.tshark.write_text(f'#!/bin/sh\nexec {VALGRIND}{self._counted}/tshark-%p {shutil.which("tshark")} "$@"\n')
        for path, mode in ((folder, 0o711), (self._counted, 0o1777), (self.tshark, 0o755)):
            path.chmod(mode)

    @property
    def python(self) -> list[str]:
        """Return a Python that counts. Its file has no %p: else each of its forks would begin one, as root."""
        return [*f"{VALGRIND}{self._counted}/python".split(), sys.executable]

    def taken(self) -> Counter[str]:
        """Return the instructions of tshark and python since this was asked last."""
        counts = Counter[str]()
        for file in self._counted.iterdir():
            found = _COUNTED.search(file.read_text())
            assert found
            counts[file.name.partition("-")[0]] += int(found[1].replace(",", ""))
            file.unlink()
        return counts
