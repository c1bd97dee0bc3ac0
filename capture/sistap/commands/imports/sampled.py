# SPDX-License-Identifier: GPL-2.0-or-later
"""Characters that the UART decoder of a logic analyser found."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from sistap.commands.imports.source import NS, RECEIVED, SENT, Stated, numbered
from sistap.tap.line.settings import Flag, LineSettings, Read
from sistap.tap.terminal.exits import Refusal

HEXADECIMAL = "let the decoder show hexadecimal values, and export again"

DECODER = "set the decoder to the format of the line, mostly 8E1; or export the levels, then sistap finds the settings"

# Saleae's decoder needs at least this many samples a bit; an edge is seen at most one sample late.
_SAMPLES_A_BIT = 4
_LONGEST_S = 1 << 32  # 136 years; twice of it, in ns, fits into a file


class Row(NamedTuple):
    """A character in the file."""

    channel: str  # the name of its decoder, or its direction
    time_s: Fraction  # of the middle of its stop bit, where a UART samples it
    value: int
    flags: Flag = Flag(0)


class UnreadableRow(NamedTuple):
    """A line of a file that has a character but cannot be read."""

    number: int  # from 1
    why: str


class SampledLine:
    """A Source: the characters of one or two channels."""

    def __init__(self, path: Path, rows: Iterable[Row | UnreadableRow], stated: Stated, cure: str = DECODER) -> None:
        """Read all characters: a table may have one channel after the other. May raise Refusal.

        `cure` is what to do if most of them are faulty.
        """
        self.settings = stated.settings
        self.settings_from = "as given"
        self.warning = ""
        self._rows = sorted(self._readable(rows), key=lambda row: row.time_s)
        if not self._rows:
            raise Refusal(f"{path} has no characters that can be read: {self.warning or HEXADECIMAL}")
        if 2 * sum(bool(row.flags & ~Flag.LOST_BEFORE) for row in self._rows) > len(self._rows):
            self.warning = self.warning or f"most characters are faulty: {cure}"
        channels = sorted({row.channel for row in self._rows})
        if len(channels) > 2:
            listed = ", ".join(channels)
            raise Refusal(
                f"{path} has {len(channels)} decoders ({listed}): export one, or the two directions of one bus"
            )
        self._lines = dict(zip(channels, (RECEIVED, SENT), strict=False))
        self.lines = numbered(channels[0], channels[-1], has_sent=len(channels) > 1)
        self._period_ns = (
            math.ceil(NS / stated.samplerate)
            if stated.samplerate
            else math.ceil(NS / (self.settings.baud * _SAMPLES_A_BIT))
        )
        self.timing = "times of a logic analyser, to a sample" + (
            f" ({stated.samplerate} Hz)" if stated.samplerate else ", which is at most a quarter of a bit"
        )

    def reads(self) -> Iterator[Read]:
        """Yield each character as a read of its own. Times that count from a trigger begin at 0."""
        origin_s = min(self._rows[0].time_s, Fraction(0))
        for row in self._rows:
            time_ns = round((row.time_s - origin_s) * NS)
            line = self._lines[row.channel]
            yield Read(line, time_ns, bytes([row.value]), bytes([row.flags]), self._period_ns, self.settings)

    def _readable(self, rows: Iterable[Row | UnreadableRow]) -> Iterator[Row]:
        """Skip what cannot be read, and mark that something is missing."""
        missing = Flag(0)
        for row in rows:
            if isinstance(row, UnreadableRow):
                missing = Flag.LOST_BEFORE
                self.warning = self.warning or f"line {row.number} cannot be read ({row.why})"
            elif abs(row.time_s) > _LONGEST_S:
                missing = Flag.LOST_BEFORE
                self.warning = self.warning or f"a character at {float(row.time_s):.3g} s is left out: it does not fit"
            else:
                yield row._replace(flags=row.flags | missing)
                missing = Flag(0)


def bits_to_stop(settings: LineSettings, *, after_start: bool) -> Fraction:
    """Return the bits of a character up to the middle of its stop bit: after its data, or from its start on."""
    after_data = (settings.parity != "N") + Fraction(1, 2)
    return 1 + settings.data_bits + after_data if after_start else after_data
