# SPDX-License-Identifier: GPL-2.0-or-later
"""The log of a bus as text."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from sistap.bus.playing.played import Played


class Log:
    """One line for each telegram: seconds since the start, the bytes as sent, marks. The first line is a comment."""

    def __init__(self, path: Path) -> None:
        """Open the file. May raise OSError."""
        self._file = path.open("wb", buffering=0)  # unbuffered: readers see whole lines at once

    def begin(self, text: str) -> None:
        """Write the comment."""
        self._write(f"# {text}")

    def add(self, played: Played, marks: Iterable[str]) -> None:
        """Write a line for what was sent."""
        time_text = f"{played.time_ns // 1_000_000_000}.{played.time_ns % 1_000_000_000:09d}"
        self._write(" ".join([time_text, played.sent.hex().upper(), *played.marks, *marks]))

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _write(self, line: str) -> None:
        self._file.write(f"{line}\n".encode())
