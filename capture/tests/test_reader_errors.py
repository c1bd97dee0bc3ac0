# SPDX-License-Identifier: GPL-2.0-or-later
"""Marks and counters of real drivers: their behaviour in captures, and the resulting flags."""

from __future__ import annotations

import functools
import operator
import random
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest
from real_captures import truth, unpacked

from sistap.dissected.captures.reading import records
from sistap.tap.line import drivers
from sistap.tap.line.drivers import ErrorPlace
from sistap.tap.line.reader.device import MarkDecoder
from sistap.tap.line.reader.errors import MOST_READS, SILENCE_NS, Counts, Errors
from sistap.tap.line.settings import ERROR_FLAGS, Flag, Read

pytestmark = pytest.mark.tap

BAD, BREAK = int(Flag.CHARACTER_ERROR), int(Flag.BREAK)
SOMEWHERE, LOST = int(Flag.UNLOCATED_ERROR), int(Flag.LOST_BEFORE)
MS = 1_000_000
UNCERTAINTY = 1000


class Line:
    """A driver that counts, and its reads; every read comes 1 ms after the one before."""

    def __init__(self, driver: str = "8250", *, counts: bool = True) -> None:
        self.counters: Counter[str] = Counter()
        self.errors = Errors(
            lambda: self._asked() if counts else None, drivers.driver(driver, is_uart=driver == "8250")
        )
        self.now = 0
        self.reads: list[Read] = []

    def _asked(self) -> Counts:
        return Counts(*(self.counters[name] for name in Counts._fields))

    def read(self, marks: list[int], *, slept: bool = True, **counted: int) -> None:
        self.now += MS
        self.counters.update(counted)
        read = Read(0, self.now, bytes(range(len(marks))), bytes(marks), UNCERTAINTY)
        self.reads += self.errors.take(read, slept=slept)

    def silence(self, ns: int) -> None:
        self.now += ns
        self.reads += self.errors.silent(ns)

    @property
    def flags(self) -> list[list[int]]:
        return [list(read.flags) for read in self.reads]


def test_a_driver_that_never_counts_is_asked_once() -> None:
    asked: list[int] = []
    errors = Errors(lambda: asked.append(1), drivers.driver(""))
    read = Read(0, 0, b"@", bytes(1), UNCERTAINTY)
    assert errors.take(read, slept=True) == [read]
    assert len(asked) == 1


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
    line.silence(SILENCE_NS - 1)
    assert line.flags == []
    line.silence(1)
    assert line.flags == [[SOMEWHERE, SOMEWHERE], [0]]
    line.silence(SILENCE_NS)
    assert len(line.flags) == 2


def test_a_driver_that_only_counts_and_counts_on_holds_nothing_for_long() -> None:
    line = Line()
    for _ in range(100):
        line.read([0], frame=1)
    assert len(line.flags) == 98
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
    line.read([BREAK, BREAK], breaks=1, parity=1)
    assert line.flags == [[0, BAD], [BREAK], [BAD | SOMEWHERE] * 2]  # one is a break: nobody knows which


def test_a_break_that_was_not_counted_is_a_damaged_00() -> None:
    line = Line()
    line.read([BAD], parity=1)
    line.read([BREAK])
    assert line.flags == [[BAD], [BAD]]


def test_marks_come_in_the_order_of_the_counts() -> None:
    """A damaged 00, and a break that is counted already: the first mark is not the break."""
    line = Line()
    line.read([0], parity=1)
    line.read([BREAK], breaks=1)
    line.read([BREAK])
    assert line.flags == [[0], [BAD], [BREAK]]


def test_what_was_counted_and_never_marked_makes_no_break_and_no_innocent() -> None:
    line = Line()
    line.read([BREAK, 0], breaks=1, parity=1)
    line.silence(SILENCE_NS)
    line.read([BAD, 0, BAD, 0], breaks=1, parity=1)  # a break has no mark; the second one was not counted
    assert line.flags == [[BAD | SOMEWHERE, SOMEWHERE], [BAD | SOMEWHERE, SOMEWHERE, BAD | SOMEWHERE, SOMEWHERE]]


def test_what_was_counted_and_never_marked_is_forgotten() -> None:
    line = Line()
    line.read([0], breaks=1)
    line.silence(SILENCE_NS)
    line.read([BREAK], parity=1)
    assert line.flags == [[SOMEWHERE], [BAD]]


@pytest.mark.parametrize("counts", [True, False])
def test_a_driver_that_does_not_count_is_believed(counts: bool) -> None:
    line = Line("?", counts=counts)
    line.read([BREAK, 0, BAD])
    assert line.flags == [[BREAK, 0, BAD]]


def test_one_flag_for_a_packet() -> None:
    line = Line("ftdi_sio")
    line.read([0, BAD, BAD, BREAK, BAD], parity=1)
    line.silence(SILENCE_NS)
    line.read([BAD], frame=1)  # a packet of its own
    line.read([0, BREAK, 0], parity=1)
    assert line.flags == [[0, SOMEWHERE, SOMEWHERE, SOMEWHERE, SOMEWHERE], [BAD], [0, BAD, 0]]


def test_the_break_of_a_packet_is_its_last_character() -> None:
    line = Line("ftdi_sio")
    line.read([BAD, BREAK, BAD, BREAK], breaks=1, frame=1)
    line.silence(SILENCE_NS)
    line.read([BREAK, BAD], parity=1)
    line.silence(SILENCE_NS)
    assert line.flags == [[SOMEWHERE, SOMEWHERE, SOMEWHERE, BREAK], [SOMEWHERE, SOMEWHERE]]


def test_a_break_in_a_row_of_packets_has_no_place() -> None:
    """A packet that ends with a break, and one with a parity error that ends with 00: five marks in a row."""
    line = Line("ftdi_sio")
    line.read([BAD, BREAK, BAD, BAD, BREAK], breaks=1, frame=1, parity=1)
    line.silence(SILENCE_NS)
    assert line.flags == [[SOMEWHERE] * 5]


@pytest.mark.parametrize(("mark", "alone"), [(BAD, BAD), (BREAK, BREAK)])
def test_a_packet_with_a_break_may_come_in_two_reads(mark: int, alone: int) -> None:
    """Then its first character looks like a packet of its own, and its first 00 like the break."""
    cut, whole, silent = Line("ftdi_sio"), Line("ftdi_sio"), Line("ftdi_sio")
    for line in (cut, whole, silent):
        line.read([mark], breaks=1, frame=1)
        assert line.flags == []
    cut.read([BAD, BREAK])
    cut.silence(SILENCE_NS)
    whole.read([0])
    silent.silence(SILENCE_NS)
    assert cut.flags == [[SOMEWHERE], [SOMEWHERE] * 2]
    assert whole.flags == [[alone], [0]]
    assert silent.flags == [[alone]]


def test_the_packet_after_a_break_may_say_so_again() -> None:
    """Its 00 at the end is a good one: ftdi_sio cannot tell."""
    line = Line("ftdi_sio")
    line.read([BREAK], breaks=1, frame=1)
    line.read([0, 0, BREAK], breaks=1)
    line.silence(SILENCE_NS)
    line.read([BREAK], breaks=1, frame=1)
    line.silence(SILENCE_NS)
    assert line.flags == [[BREAK], [0, 0, SOMEWHERE], [BREAK]]


def test_two_reads_after_a_break_the_next_one_is_certain() -> None:
    line = Line("ftdi_sio")
    line.read([BREAK], breaks=1, frame=1)
    line.read([0])
    line.read([0])
    line.read([BREAK], slept=False, breaks=1, frame=1)
    line.silence(SILENCE_NS)
    assert line.flags == [[BREAK], [0], [0], [BREAK]]


def test_only_the_first_row_of_a_read_is_the_rest_of_a_packet() -> None:
    line = Line("ftdi_sio")
    line.read([BAD], parity=1)
    line.read([BAD, 0, BAD, 0], parity=1)
    assert line.flags == [[SOMEWHERE], [SOMEWHERE, 0, BAD, 0]]


def test_the_first_00_of_a_cp210x_is_doubtful() -> None:
    """On a busy line it may come from the moment when the chip begins to report errors."""
    first, later, other = Line("cp210x"), Line("cp210x"), Line("ftdi_sio")
    for line in (first, other):
        line.read([0])  # the value is 00
        line.read([0])
    later.reads += later.errors.take(Read(0, 0, b"\x02\0", b"\0\0"), slept=True)
    assert [first.flags, other.flags, later.flags] == [[[SOMEWHERE], [0]], [[0], [0]], [[0, 0]]]


def test_a_mark_that_is_not_in_its_packet() -> None:
    """pl2303: the same mark for all, and nothing is counted."""
    line = Line("pl2303", counts=False)
    line.read([BREAK, BREAK, BREAK])
    line.read([BAD])
    assert line.flags == [[SOMEWHERE] * 3, [SOMEWHERE]]


def test_an_error_that_comes_another_way_than_its_character() -> None:
    """cdc_acm: in this read or the next; a break is a 00 of its own."""
    line = Line("cdc_acm")
    line.read([0, BREAK], breaks=1, parity=1)
    for _ in range(3):
        line.read([0])
    assert line.flags == [[SOMEWHERE, BREAK | SOMEWHERE], [SOMEWHERE], [SOMEWHERE], [0]]
    line.read([0], parity=1)
    line.silence(SILENCE_NS)
    line.read([0])
    assert line.flags[4:] == [[SOMEWHERE], [0]]
    line.read([BREAK], breaks=1)  # it is nothing else
    line.read([0])
    assert line.flags[6:] == [[BREAK], [0]]


def test_a_process_that_never_sleeps_holds_nothing_for_long() -> None:
    """The break has no mark: Linux takes it from a console."""
    line = Line()
    line.read([0], breaks=1)
    for _ in range(MOST_READS):
        line.read([0], slept=False)
    assert line.flags == [[SOMEWHERE]] + [[0]] * MOST_READS


def test_losses_without_end_hold_nothing_for_long() -> None:
    line = Line()
    for _ in range(3 * MOST_READS):
        line.read([0], overrun=1)
    assert [len(flags) for flags in line.flags] == [MOST_READS + 1] * 2
    assert {flags[0] for flags in line.flags} == {SOMEWHERE | LOST}


@pytest.mark.parametrize(("driver", "flag", "mark"), [("8250", 0, BREAK), ("cdc_acm", SOMEWHERE, 0)])
def test_a_late_process_waits_for_what_is_on_its_way(driver: str, flag: int, mark: int) -> None:
    """What it reads without a sleep has come before the counters moved."""
    line = Line(driver)
    line.counters["breaks" if driver == "8250" else "parity"] += 1
    line.read([0])
    for _ in range(5):
        line.read([0], slept=False)
    line.silence(SILENCE_NS // 2)
    line.read([mark])
    assert line.flags == [[flag]] * 6 + [[mark or flag]]


def test_a_loss_is_somewhere_in_its_read() -> None:
    line = Line()
    for marks, counted in (([0, 0], "overrun"), ([0], "buffer_overrun")):
        line.counters[counted] += 1
        line.read(marks)
        line.silence(SILENCE_NS)
    line.read([BAD, 0], overrun=1, parity=1)
    line.silence(SILENCE_NS)
    assert line.flags == [[SOMEWHERE | LOST, SOMEWHERE], [LOST], [BAD | SOMEWHERE | LOST, SOMEWHERE]]


def test_a_loss_may_be_in_two_more_reads() -> None:
    """They become one read, whose times have both bounds."""
    line = Line()
    line.read([0], overrun=1)
    line.read([0])
    assert line.flags == []
    line.read([0])
    line.read([0])
    assert line.flags == [[SOMEWHERE | LOST, SOMEWHERE, SOMEWHERE], [0]]
    joined = line.reads[0]
    assert (joined.time_ns, joined.uncertainty_ns) == (3 * MS, 2 * MS + UNCERTAINTY)
    line.read([0], overrun=1)
    line.silence(SILENCE_NS)
    line.read([0])
    assert line.flags[2:] == [[LOST], [0]]


# -- What drivers do: a simulated kernel between the line and the reader -----------------------------------------------

PARITY, FRAMING, BROKEN, OVERRUN = 0x04, 0x08, 0x10, 0x02  # line status of a UART
CHARACTER_NS = 95_486  # 115200 Bd 8E1
ROOM = 1364  # of the terminal, in characters; with PARMRK a third of 4096
BUFFER = 64  # of the kernel, in characters; really 256
GOOD = 1000  # characters without an error at the end of a line


class Sent(NamedTuple):
    """A character on the line, its damage, and whether one was lost before it."""

    value: int
    status: int
    lost_before: bool


def traffic(seed: int, count: int) -> list[Sent]:
    """Characters with many errors, many zeros, and breaks beside all else."""
    chance = random.Random(seed)
    line: list[Sent] = []
    for _ in range(count):
        value = chance.choice((0, 0, 0xFF, chance.randrange(256))) if line else 2
        status = chance.choices((0, PARITY, FRAMING, PARITY | FRAMING, BROKEN | FRAMING), (92, 4, 1, 1, 2))[0]
        lost = bool(line) and chance.random() < 0.01
        line.append(Sent(0 if status & BROKEN else value, status, lost))
    return line


class Kernel:
    """Counts and marks as a driver does; what it has passed on is not yet what a program can read."""

    def __init__(self) -> None:
        self.counters: Counter[str] = Counter()
        self._flip: list[list[bytes]] = [[]]  # on its way to the program; a character each, with its mark
        self._inserted = 0
        self._readable: list[bytes] = []
        self._passed_on = 0  # how often since the last read

    @property
    def has_more(self) -> bool:
        return bool(self._readable)

    @property
    def is_awaited(self) -> bool:
        """Tell whether the program slept until the last of it came."""
        return self._passed_on <= 1

    def count(self, name: str) -> None:
        self.counters[name] += 1

    def insert(self, value: int, status: int) -> None:
        """n_tty: any break is FF 00 00, whatever the character is."""
        good = b"\xff\xff" if value == 0xFF else bytes([value])
        self._flip[-1].append(bytes((0xFF, 0, 0 if status & BROKEN else value)) if status else good)
        self._inserted += 1

    def insert_alone(self, value: int, status: int) -> None:
        """tty_insert_flip_char: if a buffer is full, what comes next is in another one."""
        if not self._inserted % BUFFER:
            self._flip.append([])
        self.insert(value, status)

    def flush(self) -> bool:
        """Pass on the first buffer; tell whether there are more. The program may read before the next one."""
        first = self._flip.pop(0)
        self._passed_on += bool(first)
        self._readable += first
        self._flip = self._flip or [[]]
        return any(self._flip)

    def read(self) -> bytes:
        data = b"".join(self._readable[:ROOM])
        del self._readable[:ROOM]
        self._passed_on = 2 if self._readable else 0
        return data


Passing = Callable[[Kernel, list[Sent]], None]


def first(status: int) -> str:
    """Break goes before parity, which goes before framing."""
    return "breaks" if status & BROKEN else "parity" if status & PARITY else "frame" if status & FRAMING else ""


def by_character(kernel: Kernel, packet: list[Sent]) -> None:
    """8250_port.c: serial8250_read_char; cp210x.c: cp210x_process_lsr."""
    for sent in packet:
        if kind := first(sent.status):
            kernel.count(kind)
        kernel.insert(sent.value, sent.status)


def ftdi(kernel: Kernel, packet: list[Sent], *, sticky: bool = False) -> None:
    """ftdi_sio.c: ftdi_process_packet. A packet ends with a break; `sticky`: the next one still says so.

    A packet with a break is passed on character by character.
    """
    start = was_broken = 0
    for end in range(1, len(packet) + 1):
        if end < len(packet) and not packet[end - 1].status & BROKEN:
            continue
        part = packet[start:end]
        start = end
        status = functools.reduce(operator.or_, (sent.status for sent in part)) | (was_broken if sticky else 0)
        was_broken = part[-1].status & BROKEN
        is_break = bool(status & BROKEN) and part[-1].value == 0
        if is_break:
            kernel.count("breaks")
        kind = first(status & ~BROKEN)
        if kind:
            kernel.count(kind)
        insert = kernel.insert_alone if is_break else kernel.insert
        for sent in part[:-1]:
            insert(sent.value, status & ~BROKEN)
        insert(part[-1].value, BROKEN if is_break else status & ~BROKEN)


def pl2303(kernel: Kernel, packet: list[Sent]) -> None:
    """pl2303.c: pl2303_process_read_urb. The same flag for all, and no counter."""
    status = functools.reduce(operator.or_, (sent.status for sent in packet))
    for sent in packet:
        kernel.insert(sent.value, status)


def cdc(kernel: Kernel, packet: list[Sent]) -> None:
    """cdc-acm.c: acm_process_notification, before the packet. A break is a 00 of its own."""
    for sent in packet:
        if sent.status & BROKEN:
            kernel.count("breaks")
            kernel.insert(0, BROKEN)
        elif sent.status:
            kernel.count(first(sent.status))


def cdc_characters(kernel: Kernel, packet: list[Sent]) -> None:
    for sent in packet:
        if not sent.status & BROKEN:
            kernel.insert(sent.value, 0)


def nothing(kernel: Kernel, packet: list[Sent]) -> None:
    """ch341.c and the like."""
    for sent in packet:
        kernel.insert(sent.value, 0)


class Simulated(NamedTuple):
    """A driver by its name in sysfs; `ahead`, what it does before a read returns that has nothing of the packet yet."""

    name: str
    ahead: Passing
    later: Passing | None = None
    largest: int = 62
    loses_values: bool = False

    @property
    def says(self) -> drivers.Driver:
        return drivers.driver(self.name, is_uart=self.name == "8250")


DRIVERS = [
    Simulated("8250", by_character, largest=3),
    Simulated("cp210x", by_character),
    Simulated("ftdi_sio", ftdi),
    Simulated("ftdi_sio", functools.partial(ftdi, sticky=True)),
    Simulated("pl2303", pl2303, loses_values=True),
    Simulated("cdc_acm", cdc, cdc_characters),
    Simulated("ch341-uart", nothing),
]


def received(driver: Simulated, line: list[Sent], chance: random.Random) -> list[Read]:
    """Play a line to a driver. The program reads between any two steps of the kernel, and may be very late."""
    kernel, decoder = Kernel(), MarkDecoder()
    errors = Errors(
        lambda: Counts(*(kernel.counters[name] for name in Counts._fields)) if driver.says.counts else None, driver.says
    )
    reads: list[Read] = []
    now = late = 0

    def read() -> None:
        is_first = True
        while is_first or kernel.has_more:
            slept = kernel.is_awaited
            values, flags = decoder.feed(kernel.read())
            if values:
                reads.extend(errors.take(Read(0, now, values, flags, 1000), slept=slept))
            else:
                reads.extend(errors.silent(0))
            is_first = False

    rest = list(line)
    while rest:
        size = chance.randint(1, driver.largest)
        if driver.later and (broken := [at for at, sent in enumerate(rest[:size]) if sent.status & BROKEN]):
            size = broken[0] or 1
        packet, rest = rest[:size], rest[size:]
        now += CHARACTER_NS * size
        # What was lost after the packet is reported with it.
        if any(sent.lost_before for sent in [*packet[1:], *rest[:1]]):
            kernel.count("overrun")
        driver.ahead(kernel, packet)
        if chance.random() < 0.1:
            now += 2 * SILENCE_NS  # another program has the processor
        late = 100 if chance.random() < 0.005 else max(late - 1, 0)
        late *= len(rest) > GOOD  # whoever is late doubts more
        if chance.random() < 0.3 and not late:
            read()
        if driver.later:
            driver.later(kernel, packet)
        while kernel.flush():
            if chance.random() < 0.5 and not late:
                read()
        if chance.random() < 0.8 and not late:
            read()
        if chance.random() < 0.05 and not late and not any(sent.lost_before for sent in rest[:1]):
            read()
            now += 2 * SILENCE_NS
            reads.extend(errors.silent(2 * SILENCE_NS))
    kernel.flush()
    read()
    return reads + errors.all()


@pytest.mark.parametrize("driver", DRIVERS, ids=lambda driver: f"{driver.name} {getattr(driver.ahead, 'keywords', '')}")
@pytest.mark.parametrize("seed", range(5))
def test_what_a_driver_says_is_told_and_nothing_else(driver: Simulated, seed: int) -> None:
    line = traffic(seed, 1500) + [Sent(0x55, 0, False)] * GOOD
    reads = received(driver, line, random.Random(seed))
    told = [(value, flag, read) for read in reads for value, flag in zip(read.data, read.flags, strict=True)]
    says = driver.says
    assert len(told) == len(line)
    assert not any(flag for _, flag, _ in told[-GOOD // 2 :]), "a doubt without a reason"
    for sent, (value, flag, read) in zip(line, told, strict=True):
        lost = read.flags[0] & LOST
        assert value == sent.value or (driver.loses_values and flag == SOMEWHERE and value == 0), "a wrong value"
        assert sent.status or not flag & (BAD | BREAK), "an innocent"
        assert sent.status & BROKEN or not flag & BREAK, "a false break"
        assert lost or not sent.lost_before or not says.counts, "a loss outside its read"
        if says.place == ErrorPlace.CHARACTER:
            assert bool(flag & (BAD | BREAK)) == bool(sent.status), "an error without its place"
            assert lost or sent.status or not flag, "a doubt without a reason"
        elif says.place == ErrorPlace.NOWHERE:
            assert not flag
        else:
            assert flag or not sent.status, "a missing error"


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
    line = Line("ftdi_sio")
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
        line.silence(SILENCE_NS)
        line.read([flag & (BAD | BREAK) for flag in flags], **counted)
    line.silence(SILENCE_NS)
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
