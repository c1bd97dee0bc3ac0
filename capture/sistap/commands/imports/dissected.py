# SPDX-License-Identifier: GPL-2.0-or-later
"""Packets of a capture file as fields of Wireshark."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from decimal import Decimal
from pathlib import Path

from sistap.dissected.wireshark import rows
from sistap.dissected.wireshark.trouble import is_cut, is_no_capture, last_words
from sistap.dissected.wireshark.tshark import Tshark, TsharkError

_JOINT = ","
_LATEST_NS = 1 << 63


class FieldRows:
    """A dictionary of fields for each packet; commas join several values of a field."""

    def __init__(self, tshark: Tshark, capture: Path, fields: Sequence[str], options: Sequence[str] = ()) -> None:
        self._tshark = tshark
        self._fields = fields
        self._arguments = ["-n", "-r", str(capture), *options, *rows.printing(fields, _JOINT)]
        self.warning = ""  # what tshark says about a capture that is cut off

    def __iter__(self) -> Iterator[dict[str, str]]:
        """Read the capture from its beginning. May raise TsharkError."""
        self.warning = ""
        try:
            for line in self._tshark.lines(self._arguments):
                yield rows.columns(self._fields, line)
        except TsharkError as error:
            if not is_cut(error):
                raise
            self.warning = last_words(error, "its end is missing: it").rstrip(".")


def protocols(tshark: Tshark, capture: Path) -> frozenset[str]:
    """Return the protocols of a capture's first packets; empty if it is not a capture. May raise TsharkError."""
    try:
        packets = list(FieldRows(tshark, capture, ["frame.protocols"], ["-c", "10"]))
    except TsharkError as error:
        if is_no_capture(error):
            return frozenset()
        raise
    return frozenset(name for row in packets for name in row["frame.protocols"].split(":"))


def nanoseconds(seconds: str) -> int:
    """Convert seconds, as tshark prints them, into ns. Clip times of a damaged capture to what a file can hold."""
    return min(max(int(Decimal(seconds) * 1_000_000_000), 0), _LATEST_NS)
