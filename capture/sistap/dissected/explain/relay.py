# SPDX-License-Identifier: GPL-2.0-or-later
"""Explains records for months, with one tshark after the other, before its memory grows too large.

tshark keeps data about every telegram. So after a while a new one takes over. First it receives what the bus has told
so far (records/before.py), and the records of the last two minutes. So it knows what is under way: commands without
their reactions, transfers. Exactly one of the two judges each record: the old one up to the seam, the new one
from there on. If a tshark ends by itself, the next one gets what was not judged. If a tshark falls too far behind, it
is replaced, and what it had not judged stays unjudged.
"""

from __future__ import annotations

import queue
import secrets
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from sistap.dissected.explain.running import Running
from sistap.tap.files import pcapng
from sistap.tap.files.writer import Blocks
from sistap.tap.records.before import Before, Heard
from sistap.tap.records.record import Record
from sistap.tap.terminal.console import visible

Start = Callable[[bytes | None], Running]  # called with the data of a mark, if the filter must let marks pass
Columns = dict[str, str]

_MARK_S = 1.0  # how often a tshark that prints only matches is asked how far it is
_DIGITS = 10  # of the number of a packet
_SHOWN = 80  # characters of a line that nobody understands
_PAUSES_S = (0.0, 1.0, 10.0, 60.0)  # before the next tshark, after that many ended without having judged anything


class Seams(NamedTuple):
    """When the next tshark takes over; one needs about 250 bytes of memory for each packet."""

    packets: int = 300_000  # for one tshark, besides its context
    context_ns: int = 120_000_000_000  # its context: a long transfer takes a minute
    context: int = 8_000_000  # bytes, at most
    behind: int = 32_000_000  # bytes of records that may wait to be judged


class Entry(NamedTuple):
    """A block of a capture on its way."""

    time_ns: int
    block: bytes
    heard: Heard | None = None
    is_packet: bool = True
    line: str = ""  # for a reader


class Judged(NamedTuple):
    """A block, and what tshark said about it."""

    entry: Entry
    columns: Columns | None  # None: the filter does not match, or it was not judged
    is_unjudged: bool = False


@dataclass
class _Post:
    """One tshark, and the records that it receives."""

    running: Running
    first: int  # number of the first live record
    foreign: int  # packets that are no live records: its context, then marks
    until: int | None = None  # number of the first record that it no longer receives
    packets: int = 0


class Relay:
    """Takes blocks, returns them in order with what tshark says. Never blocks."""

    def __init__(  # noqa: PLR0913 - each comes from another part
        self,
        start: Start,
        columns: Callable[[str], Columns],
        say: Callable[[str], None],
        *,
        finds: bool,
        seams: Seams = Seams(),  # noqa: B008 - the default is frozen
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        """`start` starts a tshark; `columns` parses its lines, which have frame.number and data.data.

        `finds`: it prints only matches of a filter, and marks; else each packet.
        """
        self._start = start
        self._columns = columns
        self._say = say
        self._token = secrets.token_bytes(16) if finds else None
        self._seams = seams
        self._clock_s = clock_s
        self._before = Before()
        self._last_ns = 0  # time of the last record
        self._blocks: Blocks | None = None
        self._heading = b""  # section and interfaces
        self._started: list[bytes] = []  # the events at the beginning of the capture
        self._posts: deque[_Post] = deque()  # the first one judges now
        self._unsent: list[bytes] = []  # sent to tshark in one piece at the next look
        self._pending: deque[Entry] = deque()
        self._pending_bytes = 0
        self._recent: deque[Entry] = deque()  # judged, and still context for what comes
        self._recent_bytes = 0
        self._judged = 0  # number of the first pending record
        self._number = 0  # of the next record
        self._marked_s = 0.0
        self._marked = 0  # number of the record after the last mark
        self._failures = 0  # posts in a row that judged nothing
        self._next_s = 0.0  # earliest start of the next one
        self.unjudged = 0  # records, in total
        self.successions = 0

    def begin(self, blocks: Blocks, heading: bytes, started: Sequence[Record]) -> None:
        """Begin with a section, its interfaces, and the first events of a capture. May raise OSError."""
        self._blocks, self._heading = blocks, heading
        self._started = list(map(blocks.packet, started))
        self._appoint(0, ())

    def put(self, entry: Entry) -> None:
        """Add the next block."""
        if not entry.is_packet:
            self._heading += entry.block
        self._pending.append(entry)
        self._pending_bytes += len(entry.block)
        self._unsent.append(entry.block)
        for post in self._on_duty():
            post.packets += entry.is_packet
        self._number += entry.is_packet
        if entry.heard:
            self._last_ns = entry.time_ns
            self._before.take(entry.heard)
        self._succeed()

    def look(self) -> Iterator[Judged]:
        """Yield what is judged by now. Call it regularly, also while nothing comes."""
        self._mark()
        self._send()
        yield from self._judged_by_now()
        if self._failures > 1 and self._number > self._judged:  # a pending record may be the cause
            yield from self._give_up("tshark ends again and again")
        elif self._pending_bytes > self._seams.behind:
            yield from self._give_up("tshark is too slow for this bus")
        if not self._posts and self._clock_s() >= self._next_s:
            self._replace()

    @property
    def empty(self) -> bool:
        """Tell whether everything was judged."""
        return not self._pending

    def finish(self, patience_s: float) -> Iterator[Judged]:
        """Yield the rest when tshark has judged it, or unjudged after a time-out."""
        self._send()
        for post in self._on_duty():
            post.running.end()
        end_s = self._clock_s() + patience_s
        while self._posts and (left_s := end_s - self._clock_s()) > 0:
            post = self._posts[0]
            try:
                line = post.running.lines.get(timeout=left_s)
            except queue.Empty:
                break
            if line is None and post.running.ended_well:
                yield from self._up_to(post.until if post.until is not None else self._number)
                self._posts.popleft()
                continue
            yield from self._told(post, line)
            if not self._posts and self._failures == 1:
                self._replace()
                for post in self._posts:
                    post.running.end()
        if self._number > self._judged:
            yield from self._give_up("tshark has not finished")
        yield from self._up_to(self._number)

    def close(self) -> None:
        """End all running tsharks."""
        while self._posts:
            self._posts.popleft().running.kill()

    def _send(self) -> None:
        if self._unsent:
            data = b"".join(self._unsent)
            self._unsent = []
            for post in self._on_duty():
                post.running.put(data)

    def _on_duty(self) -> Iterator[_Post]:
        return (post for post in self._posts if post.until is None)

    # -- One after the other

    def _appoint(self, first: int, context: Iterable[Entry]) -> _Post:
        """Start a tshark that judges from a record on, and send it its context. May raise OSError."""
        running = self._start(self._token)
        assert self._blocks
        told = map(self._blocks.packet, self._before.records(self._last_ns))
        known = [*self._started, *told, *(entry.block for entry in context if entry.is_packet)]
        running.put(self._heading + b"".join(known))
        self._posts.append(_Post(running, first, len(known)))
        return self._posts[-1]

    def _succeed(self) -> None:
        """Let another one take over when it is time."""
        if len(self._posts) != 1 or self._posts[0].packets < self._seams.packets:
            return
        post = self._posts[0]
        self._send()
        try:
            self._appoint(self._number, [*self._recent, *self._pending])
        except OSError:  # the old one continues, and the next record tries again
            return
        post.until = self._number
        post.running.end()
        self.successions += 1

    def _lose(self, post: _Post, why: str) -> None:
        """Continue without one that does not do its work."""
        self._failures = 1 if self._judged > post.first else self._failures + 1
        self._say(f"{why}; another one goes on")
        self._dismiss()

    def _dismiss(self) -> None:
        """End all; the pause before the next grows while nothing is judged."""
        self.close()
        self._next_s = self._clock_s() + _PAUSES_S[min(self._failures, len(_PAUSES_S)) - 1]

    def _replace(self) -> None:
        """Send everything that is not judged to another tshark."""
        self._unsent = []
        try:
            post = self._appoint(self._judged, self._recent)
        except OSError as error:
            self._failures += 1
            self._say(f"tshark cannot be started: {error.strerror}")
            self._dismiss()
            return
        post.running.put(b"".join(entry.block for entry in self._pending if entry.is_packet))
        post.packets = self._number - self._judged
        self._marked = self._judged

    def _give_up(self, why: str) -> Iterator[Judged]:
        """Leave pending records unjudged."""
        count = self._number - self._judged
        self.unjudged += count
        self._say(f"{why}: {count} records were not tested with the filter")
        self._failures = max(1, self._failures)
        self._dismiss()
        while self._pending:
            yield self._taken(None, is_unjudged=True)

    # -- What they say

    def _mark(self) -> None:
        """Ask how far they are, with a packet that the filter lets pass."""
        now_s = self._clock_s()
        is_due = self._marked != self._number != self._judged and now_s - self._marked_s >= _MARK_S
        if self._token is None or not is_due:
            return
        self._marked_s, self._marked = now_s, self._number
        # With the time of the packet before it: then no measured time changes.
        mark = pcapng.enhanced_packet(0, self._pending[-1].time_ns, pcapng.upper_pdu("data", self._token))
        self._unsent.append(mark)

    def _judged_by_now(self) -> Iterator[Judged]:
        while self._posts:
            post = self._posts[0]
            try:
                line = post.running.lines.get_nowait()
            except queue.Empty:
                return
            if line is None and post.until is not None and post.running.ended_well:
                yield from self._up_to(post.until)
                self._posts.popleft()
            else:
                yield from self._told(post, line)

    def _told(self, post: _Post, line: str | None) -> Iterator[Judged]:
        """Take a line of one, None: it has ended by itself."""
        if line is None:
            self._lose(post, f"tshark has ended: {post.running.failure()}")
            return
        columns = self._columns(line)
        packet = _number(columns) - 1
        number = post.first + packet - post.foreign
        if packet < 0 or number >= self._number + (self._token is not None):  # a mark follows the last record
            self._lose(post, f"tshark has printed what was not asked for: {visible(line[:_SHOWN])}")
        elif self._token is not None and columns.get("data.data", "").replace(":", "") == self._token.hex():
            post.foreign += 1
            yield from self._up_to(number)
        elif packet >= post.foreign and self._judged <= number < (self._number if post.until is None else post.until):
            yield from self._up_to(number)
            yield self._taken(columns)

    def _up_to(self, number: int) -> Iterator[Judged]:
        """Yield what comes before this record: the filter does not match it."""
        while self._pending and (self._judged < number or not self._pending[0].is_packet):
            yield self._taken(None)

    def _taken(self, columns: Columns | None, *, is_unjudged: bool = False) -> Judged:
        entry = self._pending.popleft()
        self._pending_bytes -= len(entry.block)
        self._judged += entry.is_packet
        self._recent.append(entry)
        self._recent_bytes += len(entry.block)
        while self._recent and (
            self._recent_bytes > self._seams.context
            or abs(entry.time_ns - self._recent[0].time_ns) > self._seams.context_ns  # a clock can be set back
        ):
            self._recent_bytes -= len(self._recent.popleft().block)
        return Judged(entry, columns, is_unjudged)


def _number(columns: Columns) -> int:
    """Return the number of the packet, 0 if the line has none."""
    text = columns.get("frame.number", "")
    return int(text) if text.isdecimal() and len(text) <= _DIGITS else 0
