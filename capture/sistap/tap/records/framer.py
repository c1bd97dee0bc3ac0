# SPDX-License-Identifier: GPL-2.0-or-later
"""Cuts the characters of one line into records. Every received character is in exactly one record.

SIS telegrams are cut by content (IF02 chapter 2.2), never by time. TzA, the longest interval inside a telegram, is
agreed on the bus, and a capture does not know it. Only a second of silence, or the end, writes out what is unfinished.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from itertools import pairwise

from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag, LineSettings, Read
from sistap.tap.records.record import INTERVAL_MAX, Framing, Record, Type
from sistap.tap.sis.telegram import START, STATIC_LENGTH, checksum_good

SILENCE_NS = 1_000_000_000  # a telegram does not continue after such a pause
# Characters outside telegrams are collected up to this many: enough for a page of text, and far below the 43,000 (6
# bytes for each) at which Wireshark refuses a packet.
RUN_LIMIT = 4096
# Longest frame between silences. Half a second later it is on the disk, so a power cut costs a second.
FRAME_NS = 500_000_000

_LENGTHS_END = 4  # start, checksum, both lengths
_WITH_SAME_READ = bytes(flag | Flag.SAME_READ for flag in range(256))


class Framer(ABC):
    """The characters of one line that are not in a record yet; a subclass decides where to cut."""

    framing: Framing

    def __init__(self, line: int, settings: LineSettings, silence_ns: int) -> None:
        """Start with an empty line; `silence_ns` without a character ends everything."""
        self.line = line
        self.settings = settings
        self.silence_ns = silence_ns
        self._data = bytearray()
        self._flags = bytearray()
        self._uncertainties: list[int] = []
        # One longer than the data: data[i] came at times[i + 1], the character before it at times[i].
        self._times: list[int] = []
        # Below this number of characters nothing can be decided. This makes a character within a telegram very cheap.
        self._needed = 1

    def feed(self, read: Read) -> list[Record]:
        """Take what was read; return the records that it completes."""
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
        pause_ns = time_ns - last_ns
        if pause_ns < 0:  # a clock that goes back (another computer's) must not end the capture
            time_ns, pause_ns = last_ns, 0
        if count > 1:  # the first of k characters came at least k - 1 character times before the last
            pause_ns -= (count - 1) * self.settings.character_ns
            flags = flags[:1] + flags[1:].translate(_WITH_SAME_READ)
        if self._silent(pause_ns, uncertainty_ns):
            records = self.flush()
        self._data += data
        self._flags += flags
        times += [time_ns] * count
        self._uncertainties += [uncertainty_ns] * count
        if len(self._data) >= self._needed:
            self._cut(records, final=False)
        return records

    def beside(self, read: Read) -> list[Record]:  # noqa: ARG002
        """Take what came on the other line of a full-duplex tap; return the records that this completes."""
        return []

    def idle(self, idle_ns: int) -> list[Record]:
        """Note that nothing was read for that long, by the caller's clock; return the records that this completes."""
        return self.flush() if idle_ns >= self.silence_ns else []

    def settle(self) -> list[Record]:
        """Return what is certainly not part of a frame, without collecting more of it."""
        return []

    def flush(self) -> list[Record]:
        """Return all that is left: the line is silent, or the capture ends."""
        records: list[Record] = []
        if self._data:
            self._cut(records, final=True)
        return records

    def restart(self) -> list[Record]:
        """Return all that is left. The next characters have another clock, so the interval before them is unknown."""
        records = self.flush()
        self._times.clear()
        return records

    def _silent(self, pause_ns: int, uncertainty_ns: int) -> bool:
        """Tell whether a pause ends what came before it, given the uncertainty of the times."""
        return pause_ns >= self.silence_ns

    @property
    def empty(self) -> bool:
        """Tell whether all characters are in records."""
        return not self._data

    @property
    def oldest_ns(self) -> int | None:
        """Return the time of the first character that is not in a record, None if all are."""
        return self._times[1] if self._data else None

    @abstractmethod
    def _cut(self, records: list[Record], *, final: bool) -> None:
        """Append decided characters to the records and drop them; everything if nothing more comes (`final`)."""

    def _record(self, kind: Type, start: int, end: int, *, checksum_bad: bool = False) -> Record:
        times = self._times
        intervals = [later - earlier for earlier, later in pairwise(times[start : end + 1])]
        flags = self._flags[start:end]
        for i in [i for i, interval in enumerate(intervals) if interval > INTERVAL_MAX]:
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
    """Characters without a pause between them form a frame: for protocols other than SIS.

    A long frame is cut. The interval before the rest is shorter than the silence.
    """

    framing = Framing.SILENCE

    def __init__(self, line: int, settings: LineSettings, silence_ns: int) -> None:
        super().__init__(line, settings, silence_ns)
        self._longest_ns = max(FRAME_NS, silence_ns)

    def _cut(self, records: list[Record], *, final: bool) -> None:
        final = final or self._times[-1] - self._times[1] >= self._longest_ns
        size = len(self._data)
        start = 0
        while size - start >= RUN_LIMIT or (final and start < size):
            end = min(start + RUN_LIMIT, size)
            records.append(self._record(Type.FRAME, start, end))
            start = end
        self._drop(start)


class ContentFramer(Framer):
    """The base of framers that cut by content, never by time: SIS and 3964R."""

    def __init__(self, line: int, settings: LineSettings, silence_ns: int = SILENCE_NS) -> None:
        super().__init__(line, settings, silence_ns)
        self._done = 0  # position in the data: everything before is in records

    def idle(self, idle_ns: int) -> list[Record]:
        """Also return what is decided and has waited for that long: other traffic may never pause."""
        records = super().idle(idle_ns)
        if self._data and self._times[-1] - self._times[1] + idle_ns >= self.silence_ns:
            records += self.settle()
        return records

    def settle(self) -> list[Record]:
        """Return what is certainly not part of a frame, without collecting more of it."""
        records: list[Record] = []
        self._emit_others(records, self._certain)
        self._forget_done()
        return records

    def _silent(self, pause_ns: int, uncertainty_ns: int) -> bool:
        """Accept only certain pauses: characters that waited while this process was suspended came without one.

        If the times are unknown, only idle() reports silence.
        """
        return uncertainty_ns != UNCERTAINTY_UNKNOWN and pause_ns - uncertainty_ns >= self.silence_ns

    @property
    @abstractmethod
    def _certain(self) -> int:
        """Return the position before which nothing is part of a frame."""

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

    If one of these does not hold, it goes on from the next character. What is skipped becomes records of other
    characters. But a telegram with only a wrong checksum is a frame, too (Record.checksum_bad), if no good one starts
    inside it. A possible telegram holds back everything after it, so the result does not depend on how the characters
    were read.
    """

    framing = Framing.SIS

    def __init__(self, line: int, settings: LineSettings, silence_ns: int = SILENCE_NS) -> None:
        super().__init__(line, settings, silence_ns)
        # Also positions in the data:
        self._at = 0  # no good telegram starts before this ...
        # ... but these damaged ones do (start, end): only their checksum is wrong
        self._damaged: list[tuple[int, int]] = []

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
        self._emit_certain(records, final=final)
        self._needed = needed
        if self._done:
            self._forget_done()

    @property
    def _certain(self) -> int:
        """Return the position before which nothing is part of a telegram."""
        return self._damaged[0][0] if self._damaged else self._at

    def _emit_certain(self, records: list[Record], *, final: bool) -> None:
        """Emit what is certainly not part of a telegram; only long runs of it if more may come."""
        certain = self._certain
        self._emit_others(records, certain if final else certain - (certain - self._done) % RUN_LIMIT)

    def _judge(self, records: list[Record], start: int, end: int) -> None:
        """Decide about a complete telegram with equal lengths."""
        if checksum_good(self._data[start:end]):
            # A damaged candidate that overlaps a good telegram is dropped.
            self._damaged = [span for span in self._damaged if span[1] <= start]
            self._emit_damaged(records)
            self._emit_frame(records, start, end, checksum_bad=False)
            self._at = end
        else:
            self._damaged.append((start, end))
            self._at = start + 1

    def _emit_damaged(self, records: list[Record]) -> None:
        """Emit the damaged telegrams with nothing undecided inside; of overlapping ones, the first."""
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


# Latin-1, as drives write "°C". A prompt; a line with its end. After CR at the end of the data, LF may still come.
_TEXT = rb"[ -~\t\xa0-\xff]"
_PROMPT = re.compile(rb"E\d{1,3}:>|\?")
_LINE = re.compile(_TEXT + rb"{0,%d}(\r\n|\r|\n)" % (RUN_LIMIT - 2))
_ANY_TEXT = re.compile(_TEXT)
# Words that only the ASCII protocol has: BCD:21 and its end, E21:>, S-0-0051,7,R.
ASCII_WORD = re.compile(rb"BCD:\d{1,3}[\r\n]|E\d{1,3}:>|[SP]-[0-7]-\d{4}(?:\.\d{1,3}\.\d{1,3})?,[1-7],[RWrw]")
_NOISE = re.compile(_TEXT + rb"*[^ -~\t\xa0-\xff\r\n]*")  # with the text before it, which has no end


class AsciiFramer(SisFramer):
    """Cuts SIS telegrams, and what is between them into lines of the ASCII protocol: both may be on one bus.

    A line ends with CR, CR LF or LF. A prompt is complete without an end: E21:> of a drive, "?" where it asks for the
    next element of a list. What follows it is the next command. A line of characters that are no text is no frame.
    """

    framing = Framing.ASCII

    def settle(self) -> list[Record]:
        """Return what is certain, but not the beginning of a line: its end may still come."""
        records: list[Record] = []
        super()._emit_others(records, self._emit_lines(records, self._certain, final=False))
        self._forget_done()
        return records

    def _emit_frame(self, records: list[Record], start: int, end: int, *, checksum_bad: bool) -> None:
        super()._emit_frame(records, start, end, checksum_bad=checksum_bad)
        records[-1] = records[-1]._replace(framing=Framing.SIS)

    def _emit_certain(self, records: list[Record], *, final: bool) -> None:
        self._emit_lines(records, self._certain, final=final)

    def _emit_others(self, records: list[Record], end: int) -> None:
        self._emit_lines(records, end, final=True)

    def _emit_lines(self, records: list[Record], end: int, *, final: bool) -> int:
        """Emit lines, and the characters before each that are none; all of them if nothing more comes (`final`).

        Return the position before which no line is.
        """
        at = self._done
        while at < end:
            if line_end := self._line_end(at, end, final=final):
                super()._emit_others(records, at)
                records.append(self._record(Type.FRAME, at, line_end))
                self._done = at = line_end
                continue
            limit = self._done + RUN_LIMIT
            noise_end = _end_of_noise(self._data, at, min(end, limit))
            is_open = noise_end == at or _ANY_TEXT.match(self._data, noise_end - 1)
            if is_open and not final and noise_end < limit:
                return at
            at = noise_end
            if at == limit:
                super()._emit_others(records, at)
        if final:
            super()._emit_others(records, end)
        return at

    def _line_end(self, at: int, end: int, *, final: bool) -> int:
        """Return the end of the line that begins here; 0: none, or not all of it has come."""
        prompt = _PROMPT.match(self._data, at, end)
        if prompt:
            return prompt.end()
        line = _LINE.match(self._data, at, end)
        if not line or (line[1] == b"\r" and line.end() == end and not final):
            return 0
        return line.end()


def _end_of_noise(data: bytearray, at: int, end: int) -> int:
    found = _NOISE.match(data, at, end)
    return found.end() if found else end
