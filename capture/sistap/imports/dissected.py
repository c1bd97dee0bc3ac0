# SPDX-License-Identifier: GPL-2.0-or-later
"""Packets of a capture file as fields of Wireshark."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from decimal import Decimal
from pathlib import Path

from sistap.wireshark.tshark import Tshark, TsharkError

_CUT = ("cut short", "damaged")
_NOT_A_CAPTURE = "isn't a capture file"
_LATEST_NS = 1 << 63


class Rows:
    """A dictionary of fields for each packet; several values of a field are joined by commas."""

    def __init__(self, tshark: Tshark, capture: Path, fields: Sequence[str], options: Sequence[str] = ()) -> None:
        """Nothing is read yet."""
        self._tshark = tshark
        self._fields = fields
        self._arguments = ["-n", "-r", str(capture), "-T", "fields", *options]
        self._arguments += [word for name in fields for word in ("-e", name)]
        self.warning = ""  # of a capture that is cut, with what tshark says of it

    def __iter__(self) -> Iterator[dict[str, str]]:
        """Read the capture from its beginning. May raise TsharkError."""
        self.warning = ""
        try:
            for line in self._tshark.lines(self._arguments):
                yield dict(zip(self._fields, line.split("\t"), strict=True))
        except TsharkError as error:
            if not any(words in str(error) for words in _CUT):
                raise
            # As root tshark reads a copy, whose name means nothing to anybody.
            last = str(error).splitlines()[-1].removeprefix("tshark: ")
            self.warning = re.sub(r'The file "[^"]*"', "what comes before the damage is imported: it", last)


def protocols(tshark: Tshark, capture: Path) -> frozenset[str]:
    """Give the protocols of a capture's first packets; none if it is no capture at all. May raise TsharkError."""
    try:
        rows = list(Rows(tshark, capture, ["frame.protocols"], ["-c", "10"]))
    except TsharkError as error:
        if _NOT_A_CAPTURE in str(error):
            return frozenset()
        raise
    return frozenset(name for row in rows for name in row["frame.protocols"].split(":"))


def nanoseconds(seconds: str) -> int:
    """Read seconds as tshark prints them, in ns; those of a damaged capture are kept to what a file can hold."""
    return min(max(int(Decimal(seconds) * 1_000_000_000), 0), _LATEST_NS)
