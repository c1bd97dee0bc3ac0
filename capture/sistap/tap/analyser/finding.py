# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds rate, format and polarity of a line by its edges: with the right ones, the characters have no errors.

Slow receivers delay the edges of one direction, so pulses are longer or shorter than their bits. That does not matter
here: characters are judged, not pulses.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from heapq import nlargest
from itertools import pairwise
from operator import attrgetter
from typing import NamedTuple

from sistap.tap.analyser.uart import FEWEST_SAMPLES, Sampled, Uart
from sistap.tap.line.settings import LineSettings
from sistap.tap.sis.telegram import START, STATIC_LENGTH, is_whole

BAUDS = (
    *(300, 600, 1200, 2400, 4800, 9600, 14400, 19200, 28800, 38400, 57600, 76800, 115200),
    *(187500, 230400, 250000, 460800, 500000, 921600),
)
FORMATS = ("8E1", "8N1", "8O1")  # in doubt, the first

_LIKELY = 5  # rates to try
_ENOUGH = 8  # characters without an error, not all alike: a short pulse looks like one
_FAULTS = 8  # one character in this many may be faulty, by noise
_FEWEST = 4  # steps of a clock


class Trace(NamedTuple):
    """A piece of a line: the times of its edges."""

    edges: Sequence[int]
    is_high: bool  # before the first edge
    end: int

    @property
    def is_clock(self) -> bool:
        """Tell whether the edges of one direction come at equal distances: a clock, or pulse width modulation."""
        for edges in (self.edges[::2], self.edges[1::2]):
            steps = sorted(after - before for before, after in pairwise(edges))
            usual = steps[len(steps) // 2] if len(steps) >= _FEWEST else 0
            if usual and 4 * sum(abs(step - usual) <= 1 + usual // 16 for step in steps) >= 3 * len(steps):
                return True
        return False


class Reading(NamedTuple):
    """A line read with settings, right or wrong."""

    settings: LineSettings
    is_inverted: bool
    characters: list[Sampled]
    good: int  # characters without an error
    in_telegrams: int  # of these, those in telegrams with a right checksum

    @property
    def score(self) -> int:
        """Return a number that is the higher, the more evidence there is for these settings."""
        return 2 * self.good - len(self.characters) + self.in_telegrams

    @property
    def is_clean(self) -> bool:
        """Tell whether there are characters, most of them without an error."""
        return 0 < len(self.characters) * (_FAULTS - 1) <= self.good * _FAULTS

    @property
    def is_sound(self) -> bool:
        """Tell whether these are characters. No checksum is right by accident."""
        values = {character.value for character in self.characters}
        return self.in_telegrams > 0 or self.is_clean and self.good >= _ENOUGH and len(values) > 1


def read_as(line: Trace, rate: int, settings: LineSettings) -> Reading:
    """Read a line by the polarity that makes the better characters; its times are counts, `rate` of them in a second.

    In doubt, the level of the idle line is the more frequent one.
    """
    steps = [after - before for before, after in pairwise((*line.edges, line.end))]
    mostly_low = 2 * sum(steps[0 if line.is_high else 1 :: 2]) > sum(steps)
    return max((_read(line, rate, settings, one) for one in (mostly_low, not mostly_low)), key=_SCORE)


def find(line: Trace, rate: int, bauds: Sequence[int] = BAUDS, formats: Sequence[str] = FORMATS) -> Reading | None:
    """Return the reading of a line for which there is most evidence; None if there is none."""
    widths = sorted(after - before for before, after in pairwise(line.edges))

    def single(baud: int) -> int:
        """Count the pulses that are as wide as a bit."""
        return bisect_right(widths, 5 * rate / (4 * baud)) - bisect_left(widths, 3 * rate / (4 * baud))

    likely = nlargest(_LIKELY, (baud for baud in bauds if baud * FEWEST_SAMPLES <= rate), key=single)
    readings = (read_as(line, rate, LineSettings.parse(baud, text)) for baud in likely for text in formats)
    best = max(readings, key=_SCORE, default=None)
    return best if best and best.is_sound and (best.in_telegrams or not line.is_clock) else None


_SCORE = attrgetter("score")


def _read(line: Trace, rate: int, settings: LineSettings, is_inverted: bool) -> Reading:
    uart = Uart(rate, settings, is_high=line.is_high ^ is_inverted)
    characters = list(uart.feed(line.edges, line.end))
    good = sum(not character.flag for character in characters)
    return Reading(settings, is_inverted, characters, good, _in_telegrams(characters))


def _in_telegrams(characters: Sequence[Sampled]) -> int:
    """Count the characters in telegrams that have no error."""
    data = bytes(character.value for character in characters)
    count = at = 0
    while (at := data.find(START, at)) >= 0 and at + STATIC_LENGTH <= len(data):
        end = at + STATIC_LENGTH + data[at + 2]
        if is_whole(data[at:end]) and not any(character.flag for character in characters[at:end]):
            count += end - at
            at = end
        else:
            at += 1
    return count
