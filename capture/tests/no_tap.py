# SPDX-License-Identifier: GPL-2.0-or-later
"""A tshark whose dissector has no tap for rows, as sis.lua has none."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path

from sistap.dissected.wireshark.tshark import Tshark, TsharkError


class NoTap:
    """It prints fields only. It says so as tshark 4.0 does."""

    def pieces(self, arguments: Sequence[str]) -> Iterator[bytes]:
        assert "-z" in arguments
        raise TsharkError('tshark: Invalid -z argument "sis,rows"; it must be one of:\n     afp,srt')


class Printing(NoTap):
    """One that knows these fields, prints rows of some captures, and may fail at the end of each."""

    def __init__(
        self, captures: Mapping[str, Sequence[Mapping[str, object]]], known: Collection[str], error: str = ""
    ) -> None:
        self._captures, self._known, self._error = captures, known, error
        self.asked: list[str] = []

    def lines(self, arguments: Sequence[str]) -> Iterator[str]:
        self.asked = [*arguments]
        names = [name for name in arguments if name in self._known]
        yield "\t".join(names)
        for row in self._captures[Path(arguments[1]).name]:
            yield "\t".join(str(row.get(name, "")) for name in names)
        if self._error:
            raise TsharkError(self._error)


class WithoutTap(NoTap):
    """The same, of a real one."""

    def __init__(self, tshark: Tshark) -> None:
        self._tshark = tshark

    def lines(self, arguments: Sequence[str]) -> Iterator[str]:
        return self._tshark.lines(arguments)
