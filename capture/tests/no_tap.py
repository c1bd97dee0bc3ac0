# SPDX-License-Identifier: GPL-2.0-or-later
"""A tshark whose dissector has no tap for rows, as sis.lua has none."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sistap.dissected.wireshark.tshark import Tshark, TsharkError


class NoTap:
    """It prints fields only. It says so as tshark 4.0 does."""

    def pieces(self, arguments: Sequence[str]) -> Iterator[bytes]:
        assert "-z" in arguments
        raise TsharkError('tshark: Invalid -z argument "sis,rows"; it must be one of:\n     afp,srt')


class WithoutTap(NoTap):
    """The same, of a real one."""

    def __init__(self, tshark: Tshark) -> None:
        self._tshark = tshark

    def lines(self, arguments: Sequence[str]) -> Iterator[str]:
        return self._tshark.lines(arguments)
