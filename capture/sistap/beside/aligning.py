# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds the telegrams that two captures have both, by what is in them.

A bus says the same again and again. So first the offset between the two clocks is found that most telegrams agree on,
then each telegram is looked for near where it has to be. An offset may drift.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from sistap.files.reading import NotCaptured, packets, record_of
from sistap.line.settings import Flag
from sistap.records.record import Record, Type

PROBES = 400  # telegrams, one after the other, by which the offset is found
MOST = 2000  # places of one telegram that are looked at
BIN_NS = 50_000_000
NEAR_NS = 250_000_000  # a telegram further off is another one
_SLOW = 16  # so many telegrams does it take for the offset to follow


class Frame(NamedTuple):
    """A telegram as one capture has it."""

    number: int  # of its packet, as Wireshark counts
    data: bytes
    times_ns: Sequence[int]  # as they are in the capture
    latest_ns: Sequence[int]  # at which each character can have come: of several in a read, the last came last
    uncertainty_ns: int

    @property
    def time_ns(self) -> int:
        """The time of its first character."""
        return self.times_ns[0]


Pair = tuple[Frame, Frame]


def frames(path: Path) -> list[Frame]:
    """Read the telegrams of a capture. OSError or NotCaptured."""
    records = []
    for number, packet in enumerate(packets(path), 1):
        try:
            if one := record_of(packet):
                records.append((number, one))
        except (ValueError, IndexError) as error:
            raise NotCaptured(f"{path} has a record that is damaged: {error}; leave it out in Wireshark") from error
    latest = _latest([one for _, one in records])
    return [
        Frame(number, one.data, _times(one), times, one.uncertainty_ns)
        for (number, one), times in zip(records, latest, strict=True)
        if one.type == Type.FRAME
    ]


def aligned(true: Sequence[Frame], other: Sequence[Frame]) -> list[Pair]:
    """Return the telegrams of both, in the order of `other`; none if the captures have not the same traffic."""
    places: dict[bytes, list[Frame]] = defaultdict(list)
    for frame in sorted(true, key=lambda frame: frame.time_ns):
        places[frame.data].append(frame)
    middle = max(0, (len(other) - PROBES) // 2)
    offset_ns = _offset_ns(places, other[middle : middle + PROBES])
    if offset_ns is None:
        return []
    taken: set[int] = set()
    before = list(_matched(places, reversed(other[:middle]), offset_ns, taken))
    return [*reversed(before), *_matched(places, other[middle:], offset_ns, taken)]


def _offset_ns(places: dict[bytes, list[Frame]], probes: Iterable[Frame]) -> float | None:
    """Return how much later than the true times those of the probes are, by the offset most of them have."""
    found = [probe.time_ns - one.time_ns for probe in probes for one in places.get(probe.data, [])[:MOST]]
    votes = Counter(offset // BIN_NS for offset in found)
    if not votes:
        return None
    best = max(votes, key=lambda bin_: (votes[bin_] + votes[bin_ + 1], -abs(bin_)))
    near = [offset for offset in found if best <= offset // BIN_NS <= best + 1]
    return sum(near) / len(near)


def _matched(
    places: dict[bytes, list[Frame]], other: Iterable[Frame], offset_ns: float, taken: set[int]
) -> Iterator[Pair]:
    for frame in other:
        if true := _nearest(places.get(frame.data, []), frame.time_ns - int(offset_ns), taken):
            taken.add(true.number)
            offset_ns += (frame.time_ns - true.time_ns - offset_ns) / _SLOW
            yield true, frame


def _nearest(places: Sequence[Frame], time_ns: int, taken: set[int]) -> Frame | None:
    begin = bisect_left(places, time_ns - NEAR_NS, key=lambda frame: frame.time_ns)
    end = bisect_left(places, time_ns + NEAR_NS, key=lambda frame: frame.time_ns)
    free = [frame for frame in places[begin:end] if frame.number not in taken]
    return min(free, key=lambda frame: abs(frame.time_ns - time_ns)) if free else None


def _times(record: Record) -> list[int]:
    times = [record.time_ns]
    for interval in record.intervals[1:]:
        times.append(times[-1] + interval)
    return times


def _latest(records: Sequence[Record]) -> list[list[int]]:
    """Return the latest times of each record: a read can go on in the next record of its line."""
    latest: list[list[int]] = [[]] * len(records)
    behind: Counter[int] = Counter()  # by line: characters of the same read that came later
    for index in reversed(range(len(records))):
        record = records[index]
        times = _times(record)
        for place in reversed(range(len(record.flags))):
            times[place] -= behind[record.line] * record.settings.character_ns
            same_read = record.flags[place] & Flag.SAME_READ
            behind[record.line] = behind[record.line] + 1 if same_read else 0
        latest[index] = times
    return latest
