# SPDX-License-Identifier: GPL-2.0-or-later
"""Marks and counters of real drivers: their behaviour in captures, and the resulting flags."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from real_captures import truth, unpacked

from sistap.files.reading import records
from sistap.line.reader.errors import HOLD_NS, Counts, Errors
from sistap.line.settings import ERROR_FLAGS, Flag, Read

BAD, BREAK = int(Flag.CHARACTER_ERROR), int(Flag.BREAK)
SOMEWHERE, LOST = int(Flag.UNLOCATED_ERROR), int(Flag.LOST_BEFORE)
MS = 1_000_000


class Line:
    """A driver that counts, and its reads; every read comes 1 ms after the one before."""

    def __init__(self, *, by_packet: bool = False, counts: bool = True) -> None:
        self.counters: Counter[str] = Counter()
        self.errors = Errors(lambda: self._asked() if counts else None, by_packet=by_packet)
        self.now = 0
        self.flags: list[list[int]] = []

    def _asked(self) -> Counts:
        return Counts(*(self.counters[name] for name in Counts._fields))

    def read(self, marks: list[int], **counted: int) -> None:
        self.now += MS
        self.counters.update(counted)
        read = Read(0, self.now, bytes(range(len(marks))), bytes(marks))
        self._settle(self.errors.take(read, self.now))

    def silence(self, ns: int) -> None:
        self.now += ns
        self._settle(self.errors.due(self.now))

    def _settle(self, reads: list[Read]) -> None:
        self.flags += [list(read.flags) for read in reads]


def test_a_break_that_was_counted_a_read_too_early() -> None:
    line = Line()
    line.read([0, 0], breaks=1)
    assert line.flags == []
    line.read([0, BREAK, 0])
    line.read([0])
    assert line.flags == [[0, 0], [0, BREAK, 0], [0]]


def test_a_break_that_was_counted_two_reads_too_early() -> None:
    line = Line()
    line.read([0], breaks=1)
    line.read([0])
    line.read([BREAK])
    assert line.flags == [[0], [0], [BREAK]]


def test_a_driver_that_only_counts() -> None:
    line = Line()
    line.read([0, 0], parity=1)
    line.read([0])
    line.silence(HOLD_NS - MS - 1)
    assert line.flags == []
    line.silence(1)
    assert line.flags == [[SOMEWHERE, SOMEWHERE], [0]]
    line.silence(HOLD_NS)
    assert len(line.flags) == 2


def test_a_driver_that_only_counts_and_counts_on_holds_nothing_for_long() -> None:
    line = Line()
    for _ in range(100):
        line.read([0], frame=1)
    assert len(line.flags) >= 80
    assert set(map(tuple, line.flags)) == {(SOMEWHERE,)}


def test_what_waits_is_given_out_at_the_end() -> None:
    line = Line()
    line.read([0], frame=1)
    assert [list(read.flags) for read in line.errors.all()] == [[SOMEWHERE]]
    assert line.errors.all() == []


def test_a_damaged_00_is_no_break() -> None:
    line = Line()
    line.read([0, BREAK], parity=1)
    line.read([BREAK], breaks=1)
    line.read([BREAK, BREAK], breaks=1, parity=1)  # which of them, nobody knows: a break is a framing error, too
    assert line.flags == [[0, BAD], [BREAK], [BAD, BAD]]


@pytest.mark.parametrize("counts", [True, False])
def test_a_driver_that_does_not_count_is_believed(counts: bool) -> None:
    line = Line(counts=counts)
    line.read([BREAK, 0, BAD])
    assert line.flags == [[BREAK, 0, BAD]]


def test_one_flag_for_a_packet() -> None:
    line = Line(by_packet=True)
    line.read([0, BAD, BAD, BREAK, BAD], parity=1)
    line.read([BAD], frame=1)  # a packet of its own
    line.read([0, BREAK, 0], parity=1)
    assert line.flags == [[0, SOMEWHERE, SOMEWHERE, SOMEWHERE, SOMEWHERE], [BAD], [0, BAD, 0]]


def test_the_break_of_a_packet_is_its_last_character() -> None:
    line = Line(by_packet=True)
    line.read([BAD, BREAK, BAD, BREAK], breaks=1, frame=1)
    line.read([BREAK, BAD], parity=1)
    assert line.flags == [[SOMEWHERE, SOMEWHERE, SOMEWHERE, BREAK], [SOMEWHERE, SOMEWHERE]]


def test_a_loss_is_somewhere_in_its_read() -> None:
    line = Line()
    line.read([0, 0], overrun=1)
    line.read([0], buffer_overrun=1)
    line.read([BAD, 0], overrun=1, parity=1)
    assert line.flags == [[SOMEWHERE | LOST, SOMEWHERE], [LOST], [BAD | SOMEWHERE | LOST, SOMEWHERE]]


# -- What drivers did --------------------------------------------------------------------------------------------------


def reads(file: Path) -> Iterator[list[int]]:
    """Yield the flags of each read in a capture of sistap."""
    flags: list[int] = []
    for record in records(file):
        for flag in record.flags:
            if flags and not flag & Flag.SAME_READ:
                yield flags
                flags = []
            flags.append(flag & ERROR_FLAGS)
    yield flags


def test_forty_breaks_of_a_16550(tmp_path: Path) -> None:
    """12 of them were counted with the read before: in the capture, that is marked as damaged somewhere."""
    line = Line()
    early = ahead = 0
    for flags in reads(unpacked("sistap-16550-breaks.pcapng", tmp_path)):
        counted = SOMEWHERE in flags
        early += counted
        marks = [flag & BREAK for flag in flags]
        line.read(marks, breaks=counted or marks.count(BREAK) - ahead)
        ahead = counted
    assert early == 12
    together = [flag for flags in line.flags for flag in flags]
    assert Counter(together) == {0: len(together) - 40, BREAK: 40}


def test_line_errors_of_a_ft232r(tmp_path: Path) -> None:
    """The driver has marked whole packets, and each 00 in them like a break."""
    parity, framing, overrun, broken = 0x04, 0x08, 0x02, 0x10
    played = truth("usbmon-ft232r-errors")
    packets = iter(played.packets)
    line = Line(by_packet=True)
    place = 0
    for flags in reads(unpacked("sistap-ft232r-errors.pcapng", tmp_path)):
        counted: Counter[str] = Counter()
        end = place + len(flags)
        while place < end:
            size, status = next(packets)
            place += size
            is_last_00 = status & broken and played.received[place - 1] == 0
            counted["breaks"] += bool(is_last_00)
            counted["parity"] += bool(status & parity)
            counted["frame"] += bool(status & framing)
            counted["overrun"] += bool(status & overrun)
        assert place == end, "a packet is in one read"
        line.read([flag & (BAD | BREAK) for flag in flags], **counted)
    line.silence(HOLD_NS)
    together = [flag for flags in line.flags for flag in flags]
    assert len(together) == len(played.received)
    assert together.count(BREAK) == 1
    assert together[478] == BREAK  # alone in its packet; all others are in packets of several
    assert BAD not in together
    for damaged, status in played.errors.items():
        if damaged != 478:
            assert together[damaged] & SOMEWHERE
        if status == overrun:
            assert any(flag & LOST for flag in together[damaged - 17 : damaged + 1])
    packet_of = [status for size, status in played.packets for _ in range(size)]
    assert all(bool(flag) == (status != 0x60) for flag, status in zip(together, packet_of, strict=True))
