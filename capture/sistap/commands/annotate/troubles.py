# SPDX-License-Identifier: GPL-2.0-or-later
"""Reports lines that could not be read: the first ones individually, the others as a count. In a log that has other
bytes, but no telegram at all, none of them is news. In a log without bytes, the first tells why.
"""

from __future__ import annotations

from collections.abc import Callable

_SHOWN = 10


class Troubles:
    """Reports lines that could not be read."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._first: list[str] = []
        self._count = 0

    def add(self, number: int, why: str) -> None:
        """Note a line."""
        self._count += 1
        if self._count <= _SHOWN:
            self._first.append(f"line {number}: {why}")

    @property
    def first(self) -> str:
        """The first of them, if there is any."""
        return self._first[0] if self._first else ""

    def end(self) -> None:
        """Report them."""
        for text in self._first:
            self._say(text)
        more = self._count - _SHOWN
        if more > 0:
            self._say(f"{more} more line{'' if more == 1 else 's'} could not be read")
