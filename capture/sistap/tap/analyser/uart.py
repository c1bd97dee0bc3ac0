# SPDX-License-Identifier: GPL-2.0-or-later
"""A UART in software: converts the edges of a line into characters.

A character begins at a falling edge. Each of its bits is looked at once, in the middle, so edges may be late by nearly
half a bit. A low shorter than half a bit is not a start bit. After a break or a missing stop bit, nothing begins until
the line is high.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from sistap.tap.line.settings import Flag, LineSettings

HIGH, LOW = b"1", b"0"  # a sample, as sigrok writes it
FEWEST_SAMPLES = 5  # for a bit; with fewer, the middle of the last bit is missed
ENOUGH_SAMPLES = 20  # for a bit


class Sampled(NamedTuple):
    """A character."""

    start: int  # time of the edge that begins it
    value: int
    flag: Flag


class Edges:
    """Finds the edges in samples of a line. Before the first sample, the line counts as low."""

    def __init__(self) -> None:
        self.now = 0  # the number of the next sample
        self.is_high = False

    def feed(self, samples: bytes) -> list[int]:
        """Take samples, one in each byte; return the numbers of those that differ from the one before."""
        found = []
        at = -1
        while (at := samples.find(LOW if self.is_high else HIGH, at + 1)) >= 0:
            found.append(self.now + at)
            self.is_high = not self.is_high
        self.now += len(samples)
        return found


class Uart:
    """The UART of one line. Its times are counts, `rate` of them in a second: samples, or units of a clock."""

    def __init__(self, rate: int, settings: LineSettings, *, is_high: bool = False) -> None:
        """Begin with the level before the first edge."""
        self._rate = rate
        self._edges: list[int] = []  # not processed yet; the first one falls
        self._skip = 0 if is_high else 1  # edges before these: one that rises
        self.set(settings)

    def set(self, settings: LineSettings) -> None:
        """Use other settings from the next character on."""
        self._two_bauds = 2 * settings.baud
        self._bits = settings.data_bits + (settings.parity != "N") + 1  # after the start bit, with one stop bit
        self._to_start = self._rate // self._two_bauds  # from the edge to the middle of the start bit
        self._to_stop = (2 * self._bits + 1) * self._rate // self._two_bauds
        self._meanings = _meanings(settings)
        self.stop_ns = round((2 * self._bits + 1) * 1_000_000_000 / self._two_bauds)  # from start to middle of stop

    def feed(self, edges: Iterable[int], now: int) -> Iterator[Sampled]:
        """Take the edges until `now`; yield the characters that are complete."""
        held = [*self._edges, *edges]
        at = self._skip
        while at < len(held):
            start = held[at]
            middle = bisect(held, start + self._to_start, at)
            is_past = middle < len(held) or now - start > self._to_start
            if is_past and (middle - at) % 2 == 0:  # high again: a glitch
                at += 2
                continue
            end = bisect(held, start + self._to_stop, at)
            if end == len(held) and now - start <= self._to_stop:
                break
            yield self._character(start, held[at + 1 : end])
            at = end + (end - at) % 2  # if it is low, it has to rise first
        self._edges, self._skip = held[at:], max(0, at - len(held))

    def _character(self, start: int, edges: Iterable[int]) -> Sampled:
        ones = 0
        for time in edges:
            # Invert the bits from the first one on whose middle is not before the edge; 0 is the start bit.
            ones ^= -1 << ((time - start) * self._two_bauds + self._rate - 1) // (2 * self._rate)
        return Sampled(start, *self._meanings[ones >> 1 & (1 << self._bits) - 1])


def _meanings(settings: LineSettings) -> list[tuple[int, Flag]]:
    """Return value and flag of each character: its index has its bits, from the lowest to the stop bit."""
    count = settings.data_bits
    bits = count + (settings.parity != "N") + 1
    meanings = []
    for character in range(1 << bits):
        value = character & (1 << count) - 1
        wanted = {"E": value.bit_count() % 2, "O": 1 - value.bit_count() % 2, "M": 1, "S": 0}
        parity = character >> count & 1
        is_wrong = parity != wanted.get(settings.parity, parity) or not character >> bits - 1
        flag = Flag.CHARACTER_ERROR if is_wrong else Flag(0)
        meanings.append((value, flag if character else Flag.BREAK))
    return meanings
