# SPDX-License-Identifier: GPL-2.0-or-later
"""A tap in software: the records that it makes of the true arrival times, and what these records prove.

The truth is known here, so a verdict can be wrong in two ways: it contradicts the truth, or it claims more, or less,
than the record proves. A record guarantees three things. No character arrived after its read. None arrived earlier than
the uncertainty before it. Characters of a line are at least a character time apart.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from random import Random
from typing import NamedTuple

from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag, LineSettings
from sistap.tap.records.record import Record, Type

OK, EXCEEDED, UNRESOLVED = range(3)
TOLERANCE = 0.02  # how much faster than its nominal rate a sender may be


@dataclass(frozen=True)
class Adapter:
    """The largest delays of a tap, in ns: its latency timer and the computer's own delay."""

    timer_ns: int = 0  # 0: every character is reported at once
    delay_ns: int = 0
    stall_ns: int = 0  # occasional sleep of the reader
    stall_every: int = 40  # reports, on average
    says: bool = True  # False: its uncertainty is unknown


class Seen(NamedTuple):
    """A character as a tap records it; those of one read have its time."""

    time_ns: int
    uncertainty_ns: int


def seen(arrivals: Sequence[int], adapter: Adapter, random: Random) -> list[Seen]:
    """Deliver characters, by their arrival times in ns, as the adapter does."""
    found: list[Seen] = []
    phase_ns = random.randrange(adapter.timer_ns or 1)
    reported_ns = had_ns = awake_ns = -1
    for arrived_ns in arrivals:
        next_ns = _next_report(arrived_ns, adapter.timer_ns, phase_ns)
        if next_ns != reported_ns:
            reported_ns, had_ns = next_ns, next_ns + random.randint(0, adapter.delay_ns)
            if adapter.stall_ns and had_ns > awake_ns and random.randrange(adapter.stall_every) == 0:
                awake_ns = had_ns + adapter.stall_ns
        time_ns = max(had_ns, awake_ns)
        uncertainty_ns = adapter.timer_ns + adapter.delay_ns + adapter.stall_ns * (time_ns == awake_ns)
        found.append(Seen(time_ns, uncertainty_ns if adapter.says else UNCERTAINTY_UNKNOWN))
    return found


def _next_report(arrived_ns: int, timer_ns: int, phase_ns: int) -> int:
    """Return when a free-running timer next reports what has arrived; at once without a timer."""
    return arrived_ns if not timer_ns else -(-(arrived_ns - phase_ns) // timer_ns) * timer_ns + phase_ns


def records(telegrams: Sequence[bytes], characters: Sequence[Seen], settings: LineSettings) -> list[Record]:
    """Put the characters, in order, into one record for each telegram."""
    made: list[Record] = []
    before: Seen | None = None
    rest = iter(characters)
    for telegram in telegrams:
        own = list(itertools.islice(rest, len(telegram)))
        times = [character.time_ns for character in ([before, *own] if before else own)]
        intervals = [later - earlier for earlier, later in itertools.pairwise(times)]
        flags = [0 if interval else int(Flag.SAME_READ) for interval in intervals]
        if before is None:
            intervals, flags = [0, *intervals], [int(Flag.INTERVAL_UNKNOWN), *flags]
        uncertainty_ns = max(character.uncertainty_ns for character in own)
        made.append(Record(own[0].time_ns, Type.FRAME, 0, settings, telegram, intervals, bytes(flags), uncertainty_ns))
        before = own[-1]
    return made


class Window(NamedTuple):
    """Earliest and latest arrival, in ns."""

    earliest: int
    latest: int


def windows(record: Record, character_ns: int) -> list[Window]:
    """Return when each character can have arrived. The record's uncertainty is known."""
    times = list(itertools.accumulate(record.intervals[1:], initial=record.time_ns))
    firsts = [i for i, flag in enumerate(record.flags) if i == 0 or not flag & Flag.SAME_READ]
    found = []
    for first, end in itertools.pairwise([*firsts, len(times)]):
        for i in range(first, end):
            earliest = times[i] - record.uncertainty_ns + (i - first) * character_ns
            found.append(Window(earliest, times[i] - (end - 1 - i) * character_ns))
    return found


def in_order(line: Sequence[Window], character_ns: int) -> list[Window]:
    """Narrow the windows: no character arrived less than a character time after the one before it."""
    earliests = itertools.accumulate((w.earliest for w in line), lambda a, b: max(a + character_ns, b))
    latests = list(itertools.accumulate((w.latest for w in line[::-1]), lambda a, b: min(a - character_ns, b)))
    return [Window(*both) for both in zip(earliests, latests[::-1], strict=True)]


def surely(line: Sequence[Window], limit_ns: int, ending_ns: int) -> int:
    """Judge the intervals between neighbours, each by its own two windows.

    Nobody knows whether the character that ends an interval counts, `ending_ns`: exceeded without it, or kept with it.
    """
    spans = [
        (later.earliest - earlier.latest, later.latest - earlier.earliest)
        for earlier, later in itertools.pairwise(line)
    ]
    if any(least - ending_ns > limit_ns for least, _ in spans):
        return EXCEEDED
    return OK if all(most <= limit_ns for _, most in spans) else UNRESOLVED


def provably(line: Sequence[Window], limit_ns: int, character_ns: int, ending_ns: int) -> int:
    """Judge them together: a verdict is not proved if any arrivals inside the windows contradict it."""
    reach = line[0]  # the possible positions of a character if no interval before it exceeds the limit
    for window in line[1:]:
        earliest = max(window.earliest, reach.earliest + character_ns)
        reach = Window(earliest, min(window.latest, reach.latest + limit_ns + ending_ns))
        if reach.latest < reach.earliest:
            return EXCEEDED
    return surely(line, limit_ns, ending_ns)


def admissible(record: Record, limit_ns: int, before: Record | None = None) -> set[int]:
    """Return the right verdicts on the intervals inside a record, or on the one between two records.

    The verdict must say what the windows of neighbours decide; inside a record, where they are narrowed by the order of
    the characters. It may say what only all windows together prove.
    """
    parts = [before, record] if before else [record]
    if any(part.uncertainty_ns == UNCERTAINTY_UNKNOWN for part in parts):
        return {UNRESOLVED}
    # As fast as the sender can be: its true rate is unknown.
    character_ns = int(record.settings.character_ns * (1 - TOLERANCE))
    line = [window for part in parts for window in windows(part, character_ns)]
    line = line[len(before.data) - 1 :][:2] if before else in_order(line, character_ns)
    ending_ns = record.settings.character_ns
    must = surely(line, limit_ns, ending_ns)
    return {must} if must != UNRESOLVED else {UNRESOLVED, provably(line, limit_ns, character_ns, ending_ns)}
