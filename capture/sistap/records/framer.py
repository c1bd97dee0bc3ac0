# SPDX-License-Identifier: GPL-2.0-or-later
"""Cuts the characters of one line into records; every character received is in exactly one of them.

SIS telegrams are cut by content (IF02 chapter 2.2), never by time: the longest pause inside a telegram, TzA, is agreed
on the bus and nobody knows it while capturing. Only a second of silence, or the end, writes out what is unfinished.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from itertools import pairwise

from sistap.line.settings import UNCERTAINTY_UNKNOWN, Flag, LineSettings, Read
from sistap.records.record import INTERVAL_MAX, Framing, Record, Type
from sistap.sis.telegram import START, STATIC_LENGTH, checksum_good

SILENCE_NS = 1_000_000_000  # after this nothing more of a telegram comes
# Characters that are no telegram are collected up to this many: enough for a page of text, and far below the 43,000
# (6 bytes a character) at which Wireshark refuses a packet.
RUN_LIMIT = 4096

_LENGTHS_END = 4  # start, checksum, both lengths
_WITH_SAME_READ = bytes(flag | Flag.SAME_READ for flag in range(256))


class Framer(ABC):
    """What came on one line and is not yet in a record; a way of framing says where to cut it."""

    framing: Framing

    def __init__(self, line: int, settings: LineSettings, silence_ns: int) -> None:
        """Start with an empty line; `silence_ns` without a character ends whatever there is."""
        self.line = line
        self.settings = settings
        self.silence_ns = silence_ns
        self._data = bytearray()
        self._flags = bytearray()
        self._uncertainties: list[int] = []
        # One longer than the data: data[i] came at times[i + 1], the character before it at times[i].
        self._times: list[int] = []
        # Below this many characters nothing can be decided: so a character in mid-telegram costs next to nothing.
        self._needed = 1

    def feed(self, read: Read) -> list[Record]:
        """Take what was read; give the records that are complete by it."""
        _, time_ns, data, flags, uncertainty_ns, _, _ = read
        times = self._times
        count = len(data)
        records: list[Record] = []
        if not count:
            return self.idle(time_ns - times[-1]) if times else records
        if not times:
            times.append(time_ns)
            flags = bytes([flags[0] | Flag.INTERVAL_UNKNOWN]) + flags[1:]
        last_ns = times[-1]
        time_ns = max(time_ns, last_ns)  # a clock that goes back (another machine's) must not end the capture
        pause_ns = time_ns - last_ns
        if following := flags[1:]:
            # The first of k characters came at least k - 1 character times before the last.
            pause_ns -= len(following) * self.settings.character_ns
            flags = flags[:1] + following.translate(_WITH_SAME_READ)
        if self._silent(pause_ns, uncertainty_ns):
            records = self.flush()
        self._data += data
        self._flags += flags
        times.extend([time_ns] * count)
        self._uncertainties.extend([uncertainty_ns] * count)
        if len(self._data) >= self._needed:
            self._cut(records, final=False)
        return records

    def idle(self, idle_ns: int) -> list[Record]:
        """Tell that nothing was read for so long, by the caller's clock; give the records that this completes."""
        return self.flush() if idle_ns >= self.silence_ns else []

    def settle(self) -> list[Record]:
        """Return what is certainly no part of a frame, without collecting more of it."""
        return []

    def flush(self) -> list[Record]:
        """Return all that is left: the line is silent, or the capture ends."""
        records: list[Record] = []
        if self._data:
            self._cut(records, final=True)
        return records

    def restart(self) -> list[Record]:
        """Return all that is left; what comes next is by another clock, so that the interval before it is not known."""
        records = self.flush()
        self._times.clear()
        return records

    def _silent(self, pause_ns: int, uncertainty_ns: int) -> bool:
        """Tell whether a pause, by times as uncertain as this, ends what came before it."""
        return pause_ns >= self.silence_ns

    @property
    def empty(self) -> bool:
        """Whether all characters are in records."""
        return not self._data

    @property
    def oldest_ns(self) -> int | None:
        """When the first character that is not in a record came, None if all are."""
        return self._times[1] if self._data else None

    @abstractmethod
    def _cut(self, records: list[Record], *, final: bool) -> None:
        """Append what is decided to the records and drop it; everything, if nothing more comes (`final`)."""

    def _record(self, kind: Type, start: int, end: int, *, checksum_bad: bool = False) -> Record:
        times = self._times
        intervals = [later - earlier for earlier, later in pairwise(times[start : end + 1])]
        flags = self._flags[start:end]
        for i, interval in enumerate(intervals):
            if interval > INTERVAL_MAX:
                intervals[i] = INTERVAL_MAX
                flags[i] |= Flag.INTERVAL_SATURATED
        return Record(
            times[start + 1],
            kind,
            self.line,
            self.settings,
            bytes(self._data[start:end]),
            intervals,
            bytes(flags),
            max(self._uncertainties[start:end]),
            self.framing,
            checksum_bad=checksum_bad,
        )

    def _drop(self, count: int) -> None:
        del self._data[:count], self._flags[:count], self._times[:count], self._uncertainties[:count]


class SilenceFramer(Framer):
    """Whatever comes without a pause is a frame: for protocols other than SIS."""

    framing = Framing.SILENCE

    def _cut(self, records: list[Record], *, final: bool) -> None:
        size = len(self._data)
        start = 0
        while size - start >= RUN_LIMIT or (final and start < size):
            end = min(start + RUN_LIMIT, size)
            records.append(self._record(Type.FRAME, start, end))
            start = end
        self._drop(start)


class ContentFramer(Framer):
    """A way of framing by what comes, whenever it comes: the base of SIS and of 3964R."""

    def __init__(self, line: int, settings: LineSettings, silence_ns: int = SILENCE_NS) -> None:
        super().__init__(line, settings, silence_ns)
        self._done = 0  # position in the data: what is before is in records

    def idle(self, idle_ns: int) -> list[Record]:
        """Give, too, what is decided and has waited for so long: other traffic may never pause."""
        records = super().idle(idle_ns)
        if self._data and self._times[-1] - self._times[1] + idle_ns >= self.silence_ns:
            records += self.settle()
        return records

    def settle(self) -> list[Record]:
        """Return what is certainly no part of a frame, without collecting more of it."""
        records: list[Record] = []
        self._emit_others(records, self._certain)
        self._forget_done()
        return records

    def _silent(self, pause_ns: int, uncertainty_ns: int) -> bool:
        """Believe only what is certain: what waited while this process was stopped came without a pause.

        Where nothing is known of the times, idle() alone tells of silence.
        """
        return uncertainty_ns != UNCERTAINTY_UNKNOWN and pause_ns - uncertainty_ns >= self.silence_ns

    @property
    @abstractmethod
    def _certain(self) -> int:
        """Before this, what is not in records is no part of a frame."""

    def _emit_frame(self, records: list[Record], start: int, end: int, *, checksum_bad: bool) -> None:
        self._emit_others(records, start)
        records.append(self._record(Type.FRAME, start, end, checksum_bad=checksum_bad))
        self._done = end

    def _emit_others(self, records: list[Record], end: int) -> None:
        while self._done < end:
            start = self._done
            self._done = min(start + RUN_LIMIT, end)
            records.append(self._record(Type.OTHER, start, self._done))

    def _forget_done(self) -> None:
        self._drop(self._done)
        self._done = 0


class SisFramer(ContentFramer):
    """Cuts SIS telegrams: start character, equal lengths, complete length, checksum zero.

    Where that does not hold it goes on from the next character, and what is skipped becomes records of other
    characters; but a telegram that is wrong only in its checksum is a frame too (Record.checksum_bad), if no good one
    starts inside it. What may still become a telegram holds back everything after it, so the result does not depend
    on how the characters were read.
    """

    framing = Framing.SIS

    def __init__(self, line: int, settings: LineSettings, silence_ns: int = SILENCE_NS) -> None:
        super().__init__(line, settings, silence_ns)
        # Positions in the data, too:
        self._at = 0  # before this no good telegram starts ...
        self._damaged: list[tuple[int, int]] = []  # ... but these do (start, end), wrong only in their checksum

    def _cut(self, records: list[Record], *, final: bool) -> None:
        data = self._data
        size = len(data)
        while True:
            at = data.find(START, self._at)
            self._at = at = at if at >= 0 else size
            if self._damaged:
                self._emit_damaged(records)
            needed = at + _LENGTHS_END if at < size else size + 1
            if needed <= size:
                if data[at + 2] != data[at + 3]:
                    self._at += 1
                    continue
                needed = at + STATIC_LENGTH + data[at + 2]
            if needed <= size:
                self._judge(records, at, needed)
            elif final and at < size:
                self._at += 1
            else:
                break
        certain = self._certain
        self._emit_others(records, certain if final else certain - (certain - self._done) % RUN_LIMIT)
        self._needed = needed
        if self._done:
            self._forget_done()

    @property
    def _certain(self) -> int:
        """Before this, what is not in records is no part of a telegram."""
        return self._damaged[0][0] if self._damaged else self._at

    def _judge(self, records: list[Record], start: int, end: int) -> None:
        """Decide about a telegram whose lengths agree and that is there to its end."""
        if checksum_good(self._data[start:end]):
            # What is damaged and reaches into the good telegram is no telegram.
            self._damaged = [span for span in self._damaged if span[1] <= start]
            self._emit_damaged(records)
            self._emit_frame(records, start, end, checksum_bad=False)
            self._at = end
        else:
            self._damaged.append((start, end))
            self._at = start + 1

    def _emit_damaged(self, records: list[Record]) -> None:
        """Emit the damaged telegrams inside which nothing is undecided; of those that overlap, the first."""
        while self._damaged and self._damaged[0][1] <= self._at:
            start, end = self._damaged[0]
            self._emit_frame(records, start, end, checksum_bad=True)
            self._damaged = [span for span in self._damaged if span[0] >= end]

    def _forget_done(self) -> None:
        done = self._done
        super()._forget_done()
        self._at -= done
        self._needed -= done
        self._damaged = [(start - done, end - done) for start, end in self._damaged]
