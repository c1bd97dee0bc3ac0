# SPDX-License-Identifier: GPL-2.0-or-later
"""Captures that are too large to be read together: in portions, each of which knows what those before it were told.

Portions overlap: a command and its reaction, a command and its repeat, and the pieces of long data are together in one,
wherever it is cut. What is in two of them belongs to one.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import chain, groupby, islice
from pathlib import Path
from typing import NamedTuple

from sistap.dissected.captures import joining, reading
from sistap.dissected.captures.joining import CapturedPacket, Joining, in_order, is_foreign, unjoinable
from sistap.tap.common import temporary
from sistap.tap.files import pcapng
from sistap.tap.records.before import Before, heard
from sistap.tap.records.record import Type
from sistap.tap.terminal.exits import NotCaptured

# Bytes of captures that are read at once: tshark needs up to three times as much memory. So it needs about 1 GB.
TOGETHER = 400_000_000

_AROUND = 1000  # packets on either side of a seam that are in both portions: long data come in many pieces
_AROUND_BYTES = 1 << 25  # of these packets, at most: one of another program may have 16 MB
_PACKED_TIMES = 12  # as large is a capture that was compressed
_NANOSECONDS = bytes((9, 0, 1, 0, 9))  # the option of an interface with such times, as sistap writes them
_FIRST = 100  # packets among which is what was told before


class Begin(NamedTuple):
    """Where packets of a capture begin in a portion."""

    at: int  # number of the packet in the portion
    capture: Path
    number: int  # in the capture


class Portion(NamedTuple):
    """A file with the packets of captures that are read together, and with others that explain them."""

    path: Path
    told: int = 0  # packets at its beginning that are not its own: told before, and the last of the portion before
    own: int | None = None  # packets then; what follows belongs to the next portion. None: all
    begins: Sequence[Begin] = ()

    def owns(self, number: int) -> bool:
        """Tell whether this packet is its own."""
        return self.told < number and (self.own is None or number <= self.told + self.own)

    def place(self, number: int) -> tuple[Path, int]:
        """Return the capture of a packet that is its own, and its number there."""
        begin = self.begins[bisect_right(self.begins, number, key=lambda begin: begin.at) - 1]
        return begin.capture, number - begin.at + begin.number


def in_turn(captures: Sequence[Path], most: int, say: Callable[[str], None]) -> Generator[Portion, None, None]:
    """Yield captures in the order of their time, one portion of up to so many bytes after the other.
    A single one that is small, or foreign, stays as it is.

    Report damage. Raise NotCaptured for a foreign one among several, before anything else.
    """
    if len(captures) == 1 and (_size(captures[0]) <= most or is_foreign(captures[0])):
        yield Portion(captures[0], begins=[Begin(1, captures[0], 1)])
        return
    for capture in filter(is_foreign, captures):
        raise NotCaptured(unjoinable(capture))
    cutting = _Cutting(in_order(captures), most, say)
    while not cutting.is_over:
        with temporary.folder() as folder:
            portion = cutting.write(folder / "portion.pcapng")
            if portion.own:  # not if all are deleted by now
                yield portion


def as_one(captures: Iterable[Path]) -> Iterator[list[Path]]:
    """Yield captures that can be read as one, in the order of their time. A foreign one is alone."""
    for is_alone, several in groupby(in_order(captures), is_foreign):
        if is_alone:
            yield from ([capture] for capture in several)
        else:
            yield [*several]


def _size(capture: Path) -> int:
    """Return how many bytes it has, if it is still there: unpacked, about."""
    try:
        return capture.stat().st_size * (_PACKED_TIMES if capture.suffix == ".gz" else 1)
    except OSError:
        return 0


class _Cutting:
    """Captures that are cut into portions."""

    def __init__(self, captures: Sequence[Path], most: int, say: Callable[[str], None]) -> None:
        self._most = most
        self._sizes = {capture: _size(capture) for capture in captures}
        # What a portion needs to know of those before it is worked out only where there are some, and where no file
        # says it by itself. Then no file is cut. How large a compressed one is, nobody knows before.
        sizes = self._sizes.values()
        self._is_one = sum(sizes) <= most and all(capture.suffix != ".gz" for capture in captures)
        is_told = max(sizes) <= most and all(map(_is_told, captures[1:]))
        self._facts = None if self._is_one or is_told else _Facts()
        self._source: Iterator[CapturedPacket] = chain.from_iterable(
            joining.packets(capture, say) for capture in captures
        )
        self._behind: deque[CapturedPacket] = deque()
        self._behind_bytes = 0
        self._ahead: deque[CapturedPacket] = deque()
        self.is_over = False

    def write(self, path: Path) -> Portion:
        """Write the next portion."""
        begins: list[Begin] = []
        with temporary.keeping("a part of the capture"), path.open("wb") as file:
            joined = Joining(file)
            for packet in (*self._told(), *self._behind):
                joined.put(packet)
            told = joined.packets
            for packet in self._own():
                joined.put(packet)
                if not begins or packet.number == 1:
                    begins.append(Begin(joined.packets, packet.capture, packet.number))
            own = joined.packets - told
            self._look_ahead()
            for packet in self._ahead:
                joined.put(packet)
        self.is_over = not self._ahead
        return Portion(path, told, own, begins)

    def _told(self) -> Iterator[CapturedPacket]:
        """Yield what was told before the next packet."""
        first = next(filter(_counts_ns, self._behind), None)
        if self._facts and first:
            yield from self._facts.packets(first)

    def _own(self) -> Iterator[CapturedPacket]:
        """Yield the packets of a portion."""
        size = 0
        while packet := self._next():
            if self._is_full(size, packet):
                self._ahead.appendleft(packet)
                return
            if not self._is_one:
                size += len(packet.body)
                self._remember(packet)
            yield packet

    def _next(self) -> CapturedPacket | None:
        if self._ahead:
            return self._ahead.popleft()
        return next(self._source, None)

    def _look_ahead(self) -> None:
        size = sum(len(packet.body) for packet in self._ahead)
        while len(self._ahead) < _AROUND and size < _AROUND_BYTES and (packet := next(self._source, None)):
            self._ahead.append(packet)
            size += len(packet.body)

    def _is_full(self, size: int, packet: CapturedPacket) -> bool:
        """Tell whether a packet belongs to the next portion. A file that knows what was told before it is not cut."""
        if self._facts:
            return size > self._most
        return packet.number == 1 and 0 < size > self._most - self._sizes[packet.capture]

    def _remember(self, packet: CapturedPacket) -> None:
        if packet.is_apart:
            self._behind.clear()
            self._behind_bytes = 0
        self._behind.append(packet)
        self._behind_bytes += len(packet.body)
        while len(self._behind) > _AROUND or self._behind_bytes > _AROUND_BYTES:
            self._behind_bytes -= len(self._behind.popleft().body)
        if self._facts:
            self._facts.take(packet)


def _counts_ns(packet: CapturedPacket) -> bool:
    """Tell whether the time of a packet is in nanoseconds."""
    return _NANOSECONDS in packet.description


def _is_told(capture: Path) -> bool:
    """Tell whether what was told before is at its beginning."""
    try:
        first = map(reading.record_of, islice(reading.packets(capture), _FIRST))
        return any(record.type == Type.BEFORE for record in first if record)
    except (OSError, NotCaptured):
        return False


class _Facts:
    """What captures were told, by the description of their interface."""

    def __init__(self) -> None:
        self._before: dict[bytes, Before] = {}

    def take(self, packet: CapturedPacket) -> None:
        """Take what a packet tells."""
        if not _counts_ns(packet):
            return
        with suppress(ValueError, IndexError):  # a damaged record
            if record := reading.record_of(packet.raw):
                self._before.setdefault(packet.description, Before()).take(heard(record))

    def packets(self, first: CapturedPacket) -> Iterator[CapturedPacket]:
        """Yield packets that tell it, before the first of a portion."""
        time_ns = first.raw.time_ns or 0
        for description, before in self._before.items():
            for record in before.records(time_ns):
                block = pcapng.enhanced_packet(0, time_ns, pcapng.upper_pdu("sertap", record.pack()))
                yield CapturedPacket(first.capture, 0, description, block[8:-4])
