# SPDX-License-Identifier: GPL-2.0-or-later
"""The line between an S5 and a PPC: when each character arrives, and what a tap hears."""

from __future__ import annotations

import heapq
import itertools
import random
from collections.abc import Iterator
from typing import NamedTuple

from sisbus.playing.characters import Branch, Faults, Played, SentCharacter, Slot
from sisbus.procedure3964.controls import S5, Ppc
from sisbus.procedure3964.partner import MS, Saying
from sistap.tap.line.settings import LineSettings

BOTH = "both"  # marks a request at the same time as one of the S5
_S5, _PPC = 0, 1  # the sides; on a full-duplex tap their lines are 1 and 2


class _Arrival(NamedTuple):
    """A character that reaches a side."""

    time_ns: int
    number: int  # characters of one time arrive in this order
    side: int
    value: int


class Link:
    """A simulated line. Times are ns since it was switched on."""

    def __init__(  # noqa: PLR0913 - the line, its sides, and the tap
        self, settings: LineSettings, duplex: bool, s5: S5, ppc: Ppc, faults: Faults, seed: int
    ) -> None:
        """Connect them: with a line each (`duplex`), or so that a tap hears both on one."""
        self._settings = settings
        self._duplex = duplex
        self._sides: tuple[S5 | Ppc, S5 | Ppc] = (s5, ppc)
        self._s5 = s5
        self._branch = Branch(faults, seed)
        self._timing = random.Random(f"{seed} timing")
        self._number = itertools.count()
        self._arrivals: list[_Arrival] = []
        self._said: list[tuple[int, int, Played]] = []  # sent but not yet yielded
        self._free_ns = [0, 0]  # when a side has finished sending
        self._deaf_ns = [0, 0]  # when a side begins to hear again

    def play(self, end_ns: float) -> Iterator[Played]:
        """Yield all that is sent, in order, until the S5 has nothing more to send."""
        while (now_ns := self._next_ns()) is not None and now_ns < end_ns:
            while self._said and self._said[0][0] <= now_ns:
                yield heapq.heappop(self._said)[2]
            if self._arrivals and self._arrivals[0].time_ns <= now_ns:
                self._hear(heapq.heappop(self._arrivals))
            for side, station in enumerate(self._sides):
                station.look(now_ns)
                self._say(side, station.partner.look(now_ns), now_ns)
        while self._said and self._said[0][0] < end_ns:
            yield heapq.heappop(self._said)[2]

    def _next_ns(self) -> int | None:
        times = [arrival.time_ns for arrival in self._arrivals[:1]]
        for side, station in enumerate(self._sides):
            if (due_ns := station.due_ns) is not None:
                times.append(max(due_ns, self._free_ns[side]))
        return min(times, default=None)

    def _hear(self, arrival: _Arrival) -> None:
        """Deliver a character to a side, after what that side is sending."""
        now_ns, _, side, value = arrival
        if now_ns < self._deaf_ns[side]:
            return
        if now_ns < self._free_ns[side]:
            heapq.heappush(self._arrivals, arrival._replace(time_ns=self._free_ns[side]))
            return
        self._say(side, self._sides[side].partner.hear(value, now_ns), now_ns)

    def _say(self, side: int, saying: Saying | None, now_ns: int) -> None:
        """Let a side send, a moment later."""
        if saying is None:
            return
        begin_ns = now_ns + self._timing.randrange(2 * MS, 8 * MS) + saying.delay_ns
        if not self._duplex:
            begin_ns = max(begin_ns, *self._free_ns)
        end_ns = self._put(side, saying, begin_ns) if saying.said else begin_ns
        self._free_ns[side] = end_ns
        self._deaf_ns[side] = end_ns if saying.delay_ns else 0
        self._sides[side].partner.said(end_ns)
        if BOTH in saying.marks:
            self._s5.repeat(now_ns)
            self._say(_S5, self._s5.partner.look(now_ns), now_ns)

    def _put(self, side: int, saying: Saying, begin_ns: int) -> int:
        """Send characters; return when the last one has arrived."""
        character_ns = self._settings.character_ns
        marks = list(saying.marks)
        heard: list[SentCharacter] = []
        times: list[int] = []
        time_ns = begin_ns
        for index, value in enumerate(saying.said):
            time_ns += character_ns + int(character_ns * 0.2 * self._timing.random() ** 4)
            times.append(time_ns)
            heapq.heappush(self._arrivals, _Arrival(time_ns, next(self._number), 1 - side, value))
            if (character := self._branch.arrived(index, Slot(value), time_ns, marks)) is not None:
                heard.append(character)
        line = side + 1 if self._duplex else 0
        played = Played(times[0], saying.said, heard, marks, self._settings, line)
        heapq.heappush(self._said, (times[0], next(self._number), played))
        return time_ns
