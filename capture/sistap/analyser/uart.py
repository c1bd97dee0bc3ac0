# SPDX-License-Identifier: GPL-2.0-or-later
"""A UART in software: converts samples of a line into characters.

A character begins at a falling edge. Each of its bits is sampled once, in the middle. A low shorter than half a bit is
not a start bit. After a break or a missing stop bit, nothing begins until the line is high.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction
from itertools import product
from operator import itemgetter
from typing import NamedTuple

from sistap.line.settings import Flag, LineSettings

HIGH, LOW = b"1", b"0"  # a sample, as sigrok writes it
FEWEST_SAMPLES = 5  # for a bit; with fewer, the middle of the last bit is missed
ENOUGH_SAMPLES = 20  # for a bit

_PULSES = 3  # pulses of one width that are no accident
_ALIKE = Fraction(11, 10)
_RUN = re.compile(rb"(?<=1)0+(?=1)|(?<=0)1+(?=0)")


class Sampled(NamedTuple):
    """A character."""

    start: int  # the first sample of its start bit, counted from the very first sample
    value: int
    flag: Flag


class Uart:
    """The UART of one line. `samplerate` is in Hz."""

    def __init__(self, samplerate: int, settings: LineSettings) -> None:
        """Begin with an unknown line: it may be within a character."""
        self._samplerate = samplerate
        self._rest = b""  # samples that are not processed yet
        self._base = 0  # the number of the first of them
        self._is_high = False  # level before them: if high, they can begin with a start bit
        self.set(settings)

    def set(self, settings: LineSettings) -> None:
        """Use other settings from the next character on."""
        bit = Fraction(self._samplerate, settings.baud)
        bits = settings.data_bits + (settings.parity != "N") + 1  # the first stop bit is the last bit that is sampled
        self._middle = int(bit / 2)  # the middle of the start bit
        looks = [int(bit * (place + Fraction(1, 2))) for place in range(1, bits + 1)]
        self._to_stop = looks[-1]
        self._take = itemgetter(*looks)
        self._meanings = _meanings(settings)
        self.stop_ns = round((bits + Fraction(1, 2)) * 1_000_000_000 / settings.baud)  # from start to middle of stop

    def feed(self, samples: bytes) -> Iterator[Sampled]:
        """Take samples, one in each byte; yield the characters that they complete."""
        data = self._rest + samples if self._rest else samples
        at, size = 0, len(data)
        while True:
            if not self._is_high:
                at = data.find(HIGH, at)
                if at < 0:
                    at = size
                    break
                self._is_high = True
            start = data.find(LOW, at)
            at = start if start >= 0 else size
            if at + self._to_stop >= size:
                break
            frame = data[at : at + self._to_stop + 1]
            self._is_high = False
            if frame[self._middle] == HIGH[0]:  # a glitch
                continue
            value, flag = self._meanings[bytes(self._take(frame))]
            yield Sampled(self._base + at, value, flag)
            at += self._to_stop
        self._rest = data[at:]
        self._base += at

    @property
    def now(self) -> int:
        """Return the number of the next sample."""
        return self._base + len(self._rest)


def _meanings(settings: LineSettings) -> dict[bytes, tuple[int, Flag]]:
    """Return value and flag of a character, given its bits from the lowest to the stop bit."""
    count = settings.data_bits
    meanings = {}
    for bits in product((0, 1), repeat=count + (settings.parity != "N") + 1):
        value = sum(bit << place for place, bit in enumerate(bits[:count]))
        wanted = {"E": value.bit_count() % 2, "O": 1 - value.bit_count() % 2, "M": 1, "S": 0, "N": bits[count]}
        is_wrong = bits[count] != wanted[settings.parity] or not bits[-1]
        flag = Flag.BREAK if not any(bits) else Flag.CHARACTER_ERROR if is_wrong else Flag(0)
        meanings[bytes(HIGH[0] if bit else LOW[0] for bit in bits)] = value, flag
    return meanings


def rate_of(samples: bytes, samplerate: int) -> Fraction | None:
    """Return the rate in Bd that the shortest pulse of these samples means; None: too few pulses.

    A width counts only if it occurs several times: a glitch comes alone.
    """
    widths = sorted(match.end() - match.start() for match in _RUN.finditer(samples))
    for first, last in zip(widths, widths[_PULSES - 1 :], strict=False):
        if last <= first * _ALIKE + 1 and first > 1:
            of_a_bit = [width for width in widths if first <= width <= first * _ALIKE + 1]
            return Fraction(samplerate * len(of_a_bit), sum(of_a_bit))
    return None
