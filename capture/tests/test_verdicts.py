# SPDX-License-Identifier: GPL-2.0-or-later
"""What is said of each thing that happened: whose it is, its words, from when to when. Worked out from what was played.

test_kinds has what provokes a kind at all; here is what a person then reads. Times are seconds since the first packet.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from operator import itemgetter
from operator import methodcaller as do
from typing import Any, NamedTuple

import pytest
from machines import (
    BEGIN_S,
    FAULT,
    LAPTOP,
    PANEL,
    PLC,
    RUNS,
    SPEED,
    STANDS,
    WARNING,
    Machine,
    access,
    diagnosis,
    judged,
    packet,
    telegram,
    undescribed,
)
from test_kinds import (
    BIT,
    IN_LIMITS,
    LIMIT,
    PART,
    RISES,
    TORQUE,
    Play,
    asked,
    behind,
    event,
    flips,
    limits,
    pause,
    phases,
    reaction,
    reads,
    refused,
    rests,
    run,
    stamped,
    talk,
    then,
    told,
    writes,
)

from sistap.dissected.accesses.access import Access, Parameter
from sistap.dissected.episodes.engine import Engine
from sistap.dissected.episodes.episode import Episode, Hit
from sistap.dissected.episodes.levels import Levels, goes_on
from sistap.dissected.episodes.lines import lines
from sistap.dissected.episodes.live import LiveEpisodes
from sistap.dissected.episodes.machine import Machine as Drives
from sistap.dissected.episodes.readings import RAW, ValueReading, reading
from sistap.dissected.episodes.rules import THRESHOLDS, Severity, Subject, changed
from sistap.dissected.episodes.silence import BusSilence, StationSilence
from sistap.dissected.episodes.trend import Slots, quartiles, trend
from sistap.dissected.episodes.values import unlike
from sistap.dissected.packets.dissection import EXCEEDED, UNRESOLVED
from sistap.dissected.wireshark.rows import EVENT, OTHER
from sistap.tap.line.settings import Flag
from sistap.tap.records.record import KEPT, Event
from sistap.tap.sis.faults import FAULTS


class Case(NamedTuple):
    """What happens, and the one episode of a kind that is told of it."""

    kind: str
    play: Play
    who: str
    detail: str
    from_s: float | None = None
    to_s: float | None = None
    worst: float | None = None


def is_late(kind: str, time_s: float, limit_s: float, verdict: int = EXCEEDED, **more: Any) -> Play:
    said: dict[str, Any] = {kind: judged(time_s, limit_s, verdict)}
    return reaction(is_doubtful=True, **said, **more)


def refuse(service: int, status: int = 0xF0) -> Play:
    return reaction(service=service, is_refusal=True, status=status)


def level(ident: str, middle: float, count: int, unit: str, *stations: int) -> Play:
    """Let a number be near a middle, and every second time there."""
    return told(ident, near(middle, count), *stations, unit=unit)


def near(middle: float, count: int) -> Sequence[float]:
    beside = [step / 10 * sign for step in range(1, 6) for sign in (0, 1, 0, -1)]
    return [middle + beside[number % 20] for number in range(count)]


def line(*ends: tuple[float, float]) -> Play:
    """Let numbers of stations 3, 4 and so on go from one to another within two hours; each second time a little beside,
    as a counter never does.
    """

    def play(machine: Machine) -> None:
        for minute in range(0, 121, 2):
            for station, (begin, end) in enumerate(ends, 3):
                number = begin + (end - begin) * (minute / 120 + minute // 2 % 2 / 25)
                machine.exchange(access(station, TORQUE, number, unit="%"))
            machine.pause(120 - 0.03 * len(ends))

    return play


def beside(*steps: tuple[float, float]) -> Play:
    """Let a number of stations 3, 4 and so on step for a minute, at once."""
    numbers = [[*near(usual, 99), *near(other, 30), *near(usual, 99)] for usual, other in steps]
    said = (
        [access(station, TORQUE, one, unit="%") for station, one in enumerate(row, 3)]
        for row in zip(*numbers, strict=True)
    )
    return then(*(then(reads(*row), pause(2)) for row in said))


def standing(play: Play) -> Play:
    """Let a machine stand from the beginning."""
    return then(lambda machine: machine.all(STANDS, 0.0), run(60), play)


def turns(rpm: float, count: int) -> Play:
    return level(SPEED, rpm, count, "rpm")


def command(rpm: float) -> Play:
    return do("write", 3, "S-0-0036", rpm)


NEXT_FILE = event(Event.CAPTURE_STARTED, f"tap{KEPT}late")
NOUGHT = do("exchange", access(0, SPEED, 1.0))
SILENT = "1.0 s, 3 commands without a reaction"
UNREFERENCED = "its position is no longer referenced (S-0-0403)"
cut = telegram(None, None, good=False)
mangled = do("put", telegram(3, PLC, is_reaction=True, good=False), after_s=0.2)
stretched = telegram(5, PLC, is_reaction=True, faults=[fault for fault in FAULTS if fault.name == "damaged"])
SLOW = [reaction(20, reaction=judged(time_s, 0.05, 0)) for time_s in [0.010] * 45 + [0.030] * 45]


TRS: list[dict[str, Any]] = [{"is_reaction": True, "reaction": judged(0.01, limit_s, 0)} for limit_s in (0.05, 0.04)]
NEXT_OF_RING = do("put", type=EVENT, event=int(Event.CAPTURE_STARTED), is_again=True)
NEXT_KEPT = do("put", type=EVENT, event=int(Event.CAPTURE_STARTED), text=f"a tap{KEPT}late", is_again=True)


def paces(*times_s: float, station: int = 5, every_s: float = 60.0) -> Play:
    """Let a station answer so late, each minute once; a packet has the command, too."""
    answers = (telegram(station, PLC, is_reaction=True, reaction=judged(time_s, 0.1, 0)) for time_s in times_s)
    return then(*(do("put", telegram(PLC, station), answer, after_s=every_s) for answer in answers))


RISING = [0.010 + 0.020 * minute / 59 for minute in range(60)]


CASES = (
    # silences
    Case("bus_silent", then(talk(60), pause(9), talk(2)), "", "10 s: cable or master off?", 60.8, 70.82),
    Case("bus_silent", then(talk(60), pause(8), talk(2)), "", "9.0 s: cable or master off?"),
    Case(
        "bus_silent",
        then(talk(60), pause(3), event(Event.MARKER, "a lorry"), pause(3), NEXT_OF_RING, pause(3), talk(2)),
        *("", "10 s: cable or master off?"),
    ),
    Case(
        "silent",
        then(run(30), do("silent", 4, 4, every_s=2), do("exchange", station=4)),
        *("station 4", "6.0 s, 4 commands without a reaction"),
    ),
    Case(
        "silent",
        then(run(30), do("silent", 4, 3)),
        "station 4",
        "1.0 s, 3 commands without a reaction; not heard again",
    ),
    Case("silent", do("silent", 9, 5), "station 9", "never answered 5 commands", 0.5, 2.5),
    Case(
        "silent",
        then(do("silent", 9, 5), do("exchange", station=9)),
        *("station 9", "2.0 s, 5 commands without a reaction", 0.5, 2.53),
    ),
    Case(
        "silent",  # between two captures nobody has listened
        then(run(30), do("silent", 4, 4), pause(3600), event(Event.CAPTURE_STARTED), run(30)),
        *("station 4", "1.0 s, 3 commands without a reaction", 30.5, 31.5),
    ),
    Case(
        "silent",  # it answers only in the second file
        then(do("silent", 9, 3, every_s=0.2), NEXT_KEPT, do("exchange", station=9), do("silent", 9, 3)),
        *("station 9", "1.0 s, 3 commands without a reaction; not heard again"),
    ),
    Case("unanswered", then(run(30), do("silent", 3)), "station 3", ""),
    Case(
        "unanswered",
        then(run(30), do("silent", 3), event(Event.MARKER, "a lorry"), do("exchange", station=3, service=0x03)),
        *("station 3", ""),
    ),
    Case(
        "repeated",
        then(run(30), do("silent", 3), do("ask", 3, is_repeat=True), do("answer", 3)),
        *("station 3", "a command without a reaction"),
    ),
    Case("silent", then(run(30), NOUGHT, do("silent", 0, 3), NOUGHT), "station 0", SILENT),
    # masters
    Case("master", asked(0, before_s=130), "", "master 0 asked station 3: 1 command, 0 values read, 0 written"),
    Case("master", asked(LAPTOP, before_s=130), "", "master 127 asked station 3: 1 command, 0 values read, 0 written"),
    Case(
        "master",
        then(run(130), do("exchange", access(4, SPEED, 1.0, master=LAPTOP), master=LAPTOP), do("ask", 3, LAPTOP)),
        *("", "master 127 asked stations 3, 4: 2 commands, 1 value read, 0 written", 130.02, 130.05),
    ),
    Case(
        "master",
        then(run(130), do("write", 0, "P-0-0123", 5.0, master=0)),
        *("", "master 0 asked station 0: 1 command, 0 values read, 1 written"),
    ),
    Case(
        "master",
        then(run(130), *[do("exchange", station=3, master=LAPTOP)] * 200),
        *("", "master 127 asked station 3: 200 commands, 0 values read, 0 written"),
    ),
    Case(
        "vanished",
        then(run(450), pause(300), run(80, has_panel=False)),
        *("", "master 2 asks nothing any more, others do (225 commands until then)", 750.02, 828.17),
    ),
    # single telegrams
    Case("late", is_late("reaction", 0.06, 0.05), "station 5", "60.000 ms, TrS 50 ms", 0.03, 0.03),
    Case("late", is_late("reaction", 0.06, 0.05, UNRESOLVED), "station 5", "perhaps: 60.000 ms, TrS 50 ms"),
    Case("late", is_late("reaction", 0.0, 0.05, UNRESOLVED), "station 5", "perhaps: not measured, TrS 50 ms"),
    Case(
        *("interval", is_late("pause", 0.003, 0.002, pause_position=7)),
        *("station 5", "3.000 ms before character 7, TzA 2 ms"),
    ),
    Case(
        "cycle",
        do("put", telegram(PLC, 4, is_doubtful=True, cycle=judged(0.2, 0.1, EXCEEDED))),
        *("station 4", "200.000 ms, Tmas 100 ms by master 1"),
    ),
    Case("damaged", then(run(5), do("damage", 4)), "station 4", "its checksum is wrong"),
    Case("damaged", then(run(5), do("ask", 4), do("put", type=OTHER)), "station 4", "its rest is not a telegram"),
    Case(
        *("line_error", then(run(5), do("damage", 4, errors=int(Flag.BREAK)))),
        *("station 4", "in a telegram that is damaged"),
    ),
    Case(
        *("lost", then(run(5), do("ask", 4), do("answer", 4), do("put", errors=int(Flag.LOST_BEFORE)))),
        *("", "in a telegram that is not damaged"),
    ),
    Case(
        *("line_error", then(run(5), do("ask", 4), do("put", type=OTHER, errors=int(Flag.BREAK)))),
        *("station 4", "in a telegram that is damaged"),
    ),
    Case(
        "damaged",
        then(NOUGHT, do("ask", 0), do("put", type=OTHER)),
        *("station 0", "its rest is not a telegram"),
    ),
    Case("damaged", then(run(5), do("ask", 9), do("put", type=OTHER)), "", "its rest is not a telegram"),  # who is 9?
    Case("damaged", do("put", telegram(None, None, good=False)), "", "its checksum is wrong"),
    Case("damaged", do("put", stretched, faults=stretched.faults), "station 5", ""),
    Case("lost", then(run(5), do("ask", 4), event(Event.CHARACTERS_LOST, "overrun")), "", "overrun"),
    Case(
        *(
            "line_error",
            then(run(5), do("ask", 4), do("put", telegram(4, PLC, is_reaction=True), errors=int(Flag.BREAK))),
        ),
        *("station 4", "in a telegram that is not damaged"),
    ),
    Case("error", refuse(0x03), "station 5", "Initialization of the SIS communication, status 0xf0"),
    Case("error", refuse(0x01), "station 5", "Cancel data transmission, status 0xf0"),
    Case("error", refuse(0x0F), "station 5", "Token passing, status 0xf0"),
    Case("never", refuse(0x00), "station 5", "Node identification, status 0xf0"),
    Case("never", refuse(0x11, 0x01), "station 5", "Read list segment, status 0x01"),
    Case("error", refuse(0x12, 0x02), "station 5", "Read phase, status 0x02"),
    Case("never", reaction(is_refusal=True, status=None), "station 5", "Read parameter, status 0x00"),
    Case("error", do("refuse", 5, LIMIT, "0x7009", is_write=True), f"station 5 {LIMIT}", "write: 0x7009"),
    Case("never", do("refuse", 5, LIMIT, "0x1001"), f"station 5 {LIMIT}", "0x1001"),
    Case(
        "early",
        do("ask", 3, is_repeat=True, signs=("early",)),
        *("station 3", "master 1 did not wait for TrS"),
    ),
    Case("warning_bit", reaction(signs=("warning_bit",)), "station 5", ""),
    Case("warning_bit", do("ask", 5, signs=("warning_bit",)), "station 1", ""),  # the sender has it
    # states
    Case("phase", phases("4", "2"), "station 5", "4 -> 2"),
    Case("rate", then(reaction(), *[do("put", baud=19200)] * 2), "", "9600 -> 19200 Bd"),
    Case("rate", then(reaction(), do("put", baud=None), do("put", baud=4800)), "", "9600 -> 4800 Bd"),
    Case(
        "limits",
        then(*(reaction(pause=judged(0.001, limit_s, 0)) for limit_s in (0.002, 0.003))),
        *("station 5", "TzA 2 -> 3 ms"),
    ),
    Case(
        "limits",
        then(*(do("put", telegram(PLC, 5), telegram(5, PLC, **said)) for said in TRS)),
        *("station 5", "TrS 50 -> 40 ms"),
    ),
    Case(
        "gap",
        then(run(30), event(Event.MARKER, "now"), pause(60), event(Event.CAPTURE_STARTED)),
        "",
        "62 s between two captures",
    ),
    Case("adapter", event(Event.ADAPTER_LOST, "unplugged"), "", "unplugged", 0, 0),
    Case(
        "gap",  # the two directions of a bus
        then(do("put", line=1), do("put", line=2, after_s=30), pause(60), *[event(Event.CAPTURE_STARTED)] * 2),
        *("", "60 s between two captures", 30, 90),
    ),
    Case(
        "gap",  # the second capture is the older one
        then(do("put", after_s=100), pause(-40), event(Event.CAPTURE_STARTED)),
        *("", "-40 s between two captures", 60, 60),
    ),
    Case("clock", stamped(37), "", "+37 s", 37.05, 37.05, 37),
    Case("clock", stamped(-37), "", "-37 s", -36.95, 0.05, -37),
    Case("clock", stamped(-37, None), "", "-37 s", -36.95, 0.03, -36.98),
    Case(
        "clock",
        then(reaction(), event(Event.MARKER, "system time jumped by -2.5 s")),
        *("", "-2.5 s; the times of the capture go on without the jump", 0.03, 0.03, -2.5),
    ),
    Case("unreadable", then(run(30), do("noise", 21, every_s=0.2), reaction(3)), "", "21 records are no telegrams"),
    Case("unreadable", then(do("noise", 21, every_s=0.2), reaction(3)), "", "21 records are no telegrams", 0.2, 4.2),
    Case(
        *("unreadable", then(*[then(do("noise"), reaction(3))] * 10, do("noise", 21, every_s=0.2), reaction(3))),
        *("", "21 records are no telegrams"),
    ),
    Case("unreadable", then(run(30), *[mangled] * 25, reaction(3)), "", "25 records are no telegrams"),
    Case("unreadable", then(*[then(do("noise", 3), reaction())] * 10), "", "30 records are no telegrams"),
    Case("foreign", do("noise", 7), "", "none of 7 records is a telegram: another protocol, rate or format?", 0.1, 0.7),
    Case(
        "foreign",
        then(*[do("put", *[cut] * 2)] * 5),
        "",
        "none of 5 records is a telegram: another protocol, rate or format?",
    ),
    Case("stopped", then(do("stop", 60), run(60)), "", "", 0.02, 60.03),
    Case("stopped", then(run(60), do("stop", 60)), "", "still so when last read", 60.15),
    # drives
    Case(
        "fault",
        then(run(10), lambda machine: machine.says.update({4: FAULT}), run(10)),
        *("station 4", "F2028 (S-0-0390, before A0101); still so when last read"),
    ),
    Case(
        "fault",
        reads(access(5, "S-0-0095", '"F228 Excessive deviation"')),
        "station 5",
        "F228 (S-0-0095); still so when last read",
    ),
    Case(
        *("fault", reads(access(5, "S-0-0011", "0b0000000000000100"))),
        *("station 5", "class 1 diagnostic 0b0000000000000100 (S-0-0011); still so when last read"),
    ),
    Case(
        *(
            "warning",
            reads(*(access(5, "S-0-0390", f"0x{code:08X}") for code in (WARNING, WARNING, 0xA0101)), every_s=4),
        ),
        "station 5",
        "E2051 (S-0-0390)",
        *(0.03, 8.09),
    ),
    Case("fault", reads(diagnosis(0, FAULT)), "station 0", "F2028 (S-0-0390); still so when last read"),
    Case(
        *("fault", reads(*(access(5, "S-0-0095", f'"{text}"') for text in ("A101 Halt", "F228 Excessive deviation")))),
        *("station 5", "F228 (S-0-0095, before A101); still so when last read"),
    ),
    Case(
        *("fault", reads(*(access(5, "S-0-0390", f"0x{code:X}") for code in (RUNS, WARNING, FAULT)))),
        *("station 5", "F2028 (S-0-0390, before E2051); still so when last read"),
    ),
    Case(
        *("fault", reads(access(5, "S-0-0135", "0x2000", number=8192.0))),
        *("station 5", "shut down by an error: drive status bit 13 (S-0-0135); still so when last read"),
    ),
    Case(
        *("warning", reads(access(5, "S-0-0012", "0b0100"))),
        *("station 5", "class 2 diagnostic 0b0100 (S-0-0012); still so when last read"),
    ),
    Case("homing", reads(*BIT), "station 5", f"{UNREFERENCED}; still so when last read", 0.06, 0.06),
    Case("homing", reads(*BIT, *BIT[:1]), "station 5", UNREFERENCED, 0.06, 0.09),
    Case("stuck", do("boot", stuck=4), "station 4", "stays in phase 2, others are in phase 4"),
    Case("boot", do("boot"), "", "stations 3, 4, 5, ready 5 s later"),
    Case("boot", then(do("boot", 3, 4), NEXT_OF_RING, do("boot", 5)), "", "stations 3, 4, 5, ready 5 s later"),
    Case("boot", do("boot", 0, 3), "", "stations 0, 3, ready 3 s later", 0.02, 3.24),
    Case(
        "restart",
        then(run(30), do("silent", 4, 4), do("boot", 4)),
        *("station 4", "silent for 2 s, identified, initialised again"),
    ),
    Case(
        "restart",
        then(
            run(30),
            do("silent", 4, 4),
            do("exchange", station=4, service=0x03),
            do("exchange", station=4, service=0x1D, phase="4"),
        ),
        *("station 4", "silent for 2 s, initialised again"),
    ),
    Case(
        "exchanged",
        then(*(reaction(service=0x00, columns={"sis.type_key": key}) for key in ("HCS01", "HCS02"))),
        *("station 5", "type key HCS01 -> HCS02"),
    ),
    # values
    Case("beyond", told(SPEED, [3001], **IN_LIMITS), f"station 3 {SPEED}", "3001 rpm, its maximum is 3000 rpm"),
    Case("beyond", told("P-0-0100", [-2], minimum="0 rpm"), "station 3 P-0-0100", "-2 rpm, its minimum is 0 rpm"),
    Case("beyond", told("P-0-0100", [12], maximum="9 rpm"), "station 3 P-0-0100", "12 rpm, its maximum is 9 rpm"),
    Case("beyond", told(SPEED, [-3002], **IN_LIMITS), f"station 3 {SPEED}", "-3002 rpm, its minimum is -3000 rpm"),
    Case("apart", behind(500, 30), f"station 3 {SPEED}", "50 % below S-0-0036", 60.06, 89.06),
    Case("apart", behind(1250, 30), f"station 3 {SPEED}", "25 % above S-0-0036"),
    Case("apart", behind(-500, 30, usual=-1000.0), f"station 3 {SPEED}", "50 % below S-0-0036"),
    Case("apart", behind(-1250, 30, usual=-1000.0), f"station 3 {SPEED}", "25 % above S-0-0036"),
    Case(
        *("beyond", told(SPEED, [3001, 3500, 3100], **IN_LIMITS)),
        *(f"station 3 {SPEED}", "3500 rpm, its maximum is 3000 rpm"),
        *(0.03, 4.09),
    ),
    Case(
        "beyond",
        told(SPEED, [-3001, -3500, -3100], **IN_LIMITS),
        *("station 3 S-0-0040", "-3500 rpm, its minimum is -3000 rpm"),
    ),
    Case("drift", line((30, 50)), f"station 3 {TORQUE}", "+10 %/h, 30 -> 50 % (not by chance)", 0.03, 7200.03),
    Case("drift", line((-30, -50)), f"station 3 {TORQUE}", "-10 %/h, -30 -> -50 % (not by chance)"),
    Case("drift", line((30, 54.68)), f"station 3 {TORQUE}", "+12.3 %/h, 30 -> 54.68 % (not by chance)"),
    Case("drift", line((1, 1.5)), f"station 3 {TORQUE}", "+0.25 %/h, 1 -> 1.5 % (not by chance)"),
    Case("drift", line((0, 20)), f"station 3 {TORQUE}", "+10 %/h, 0 -> 20 % (not by chance)"),
    Case("step", beside((0, 20)), f"station 3 {TORQUE}", "20 %, usually 0"),
    Case("drift", line((1.5, 1)), f"station 3 {TORQUE}", "-0.25 %/h, 1.5 -> 1 % (not by chance)"),
    Case("drift", line((30, 50), (60, 104)), f"stations 3, 4 {TORQUE}", "+22 %/h, 60 -> 104 % (not by chance)"),
    Case("chatter", flips(7), "station 5 P-0-0222", "7 changes between 0 and 1", 480.27, 540.45),
    Case(
        "changed",
        reads(
            *[access(5, "P-0-0222", "1")] * 20,
            *[access(5, "P-0-0222", "0")] * 3,
            *[access(5, "P-0-0222", "1")] * 2,
            every_s=10,
        ),
        *("station 5 P-0-0222", "1 -> 0", 200.63, 230.72),
    ),
    Case(
        "changed",
        reads(*[access(5, "P-0-0222", "1")] * 20, access(5, "P-0-0222", "0"), every_s=10),
        *("station 5 P-0-0222", "1 -> 0; still so when last read"),
    ),
    Case(
        "changed",
        reads(*(access(5, "P-0-0222", f"{one} rpm") for one in [1000] * 9 + [1010] * 9 + [900]), every_s=10),
        *("station 5 P-0-0222", "1010 rpm -> 900 rpm; still so when last read"),
    ),
    Case(
        "changed",
        reads(*[access(5, "P-0-0222", "0")] * 3, *[access(5, "P-0-0222", "1")] * 20, every_s=1),
        "station 5 P-0-0222",
        "0",
        *(0.03, 3.12),
    ),
    Case(
        "changed",
        reads(*(undescribed(5, "P-0-0222", one) for one in [b"\1\2\3"] * 9 + [b"\1\2"]), every_s=10),
        *("station 5 P-0-0222", "010203 -> 513 raw; still so when last read"),  # of another length
    ),
    Case(
        "changed",
        reads(*(access(5, "P-0-0222", letter * 50) for letter in "AAB")),
        *("station 5 P-0-0222", f"{'A' * 40} -> {'B' * 40}; still so when last read"),
    ),
    Case(
        "step",
        then(*(level(TORQUE, *part, "%") for part in ((50.25, 99), (70.25, 30), (50.25, 99)))),
        *(f"station 3 {TORQUE}", "70.25 %, usually 50.25", 201.0, 259.87),
    ),
    Case(
        "step",
        then(
            *(
                level("P-0-0300", middle, count, "Inc")
                for middle, count in ((-30_000, 99), (-60_000, 30), (-30_000, 99))
            )
        ),
        *("station 3 P-0-0300", "-60000 Inc, usually -30000"),
    ),
    Case(
        "step",
        then(*(level("P-0-0123", *part, "") for part in ((1050, 99), (1730, 30), (1050, 99)))),
        *("station 3 P-0-0123", "1730, usually 1050"),
    ),
    Case(
        "step",
        standing(then(*(level("P-0-0123", *part, "bar") for part in ((110.5, 99), (130.5, 30), (110.5, 99))))),
        *("station 3 P-0-0123", "130.5 bar, usually 110.5"),
    ),
    *(
        Case(
            "step",
            then(
                command(3),
                *(
                    told(SPEED, [at + one / 50 for one in near(0, count)], unit="m/s")
                    for at, count in ((3, 99), (by, 30), (3, 99))
                ),
            ),
            *(f"station 3 {SPEED}", f"0.5 m/s {where} S-0-0036"),
        )
        for by, where in ((2.5, "below"), (3.5, "above"))
    ),
    Case("step", beside((50, 20), (500, 700)), f"stations 3, 4 {TORQUE}", "20 %, usually 50"),  # by 60 and 40 %
    Case(
        *("step", then(command(-1000), turns(-1000, 99), turns(-900, 30), turns(-1000, 99))),
        *(f"station 3 {SPEED}", "100 rpm above S-0-0036"),
    ),
    Case(
        "step",
        then(
            turns(1000, 60),
            command(1000),
            turns(1000, 99),
            turns(900, 30),
            turns(1000, 99),
            command(1200),
            turns(1200, 60),
        ),
        *(f"station 3 {SPEED}", "100 rpm below S-0-0036"),
    ),
    Case(
        "step",
        then(
            command(1000), turns(1000, 60), NEXT_FILE, command(1000), turns(1000, 99), turns(900, 30), turns(1000, 99)
        ),
        *(f"station 3 {SPEED}", "100 rpm below S-0-0036"),
    ),
    Case(
        "step",
        then(
            reads(undescribed(3, "S-0-0036", bytes([128, 150, 152, 0]))),
            turns(1000, 99),
            turns(900, 30),
            turns(1000, 99),
        ),
        *(f"station 3 {SPEED}", "900 rpm, usually 1000"),  # nobody knows the scale of its command
    ),
    Case(
        "blip",
        then(
            level(TORQUE, 50.25, 60, "%", 3, 4, 5),
            *(do("exchange", access(station, TORQUE, by, unit="%")) for station, by in ((3, 80), (4, 90), (5, 85)) * 2),
            level(TORQUE, 50.25, 60, "%", 3, 4, 5),
        ),
        *(f"stations 3, 4, 5 {TORQUE}", "90 %, usually 50.25", 125.43, 125.58),
    ),
    Case(
        "step",
        then(command(1000), turns(1000, 400), command(1200), turns(1000, 30), turns(1200, 99)),
        *(f"station 3 {SPEED}", "200 rpm below S-0-0036; soon after the write of S-0-0036"),
    ),
    Case(
        "slower",
        then(paces(0.01, station=3), paces(*[0.009, 0.010, 0.011] * 10, *[0.029, 0.030, 0.031] * 10, station=0)),
        *("station 0", "reaction time 10.0 -> 30.0 ms", 32 * 60, 61 * 60, 0.02),
    ),
    Case(
        "slower",  # of an hour, sixteen minutes are known
        paces(*RISING[::4], RISING[-1], every_s=240),
        *("station 5", "reaction time 10.0 -> 30.0 ms", 240, 16 * 240, 0.02),
    ),
    # writes
    Case("write", writes("P-0-0123", (PLC, 12)), "station 5 P-0-0123", "12 rpm by master 1; still set at the end"),
    Case(
        "write",
        writes("P-0-0123", (LAPTOP, 12)),
        *("station 5 P-0-0123", "12 rpm by new master 127; still set at the end"),
    ),
    Case(
        "write",
        writes("P-0-0123", (0, 12)),
        *("station 5 P-0-0123", "12 rpm by new master 0; still set at the end"),
    ),
    Case(
        "write",
        then(run(150), do("put", accesses=[access(5, "P-0-0123", 12, master=None, is_write=True)])),
        *("station 5 P-0-0123", "12 rpm by ASCII; still set at the end"),
    ),
    Case(
        "write",
        then(run(150), do("write", 5, "S-0-0134", "0b1110000000000000", master=LAPTOP), run(60)),
        *("station 5 S-0-0134", "0b1110000000000000 by new master 127; still set at the end"),  # a control word
    ),
    Case(
        *("write", writes("P-0-0123", (0, 12))),
        *("station 5 P-0-0123", "12 rpm by new master 0; still set at the end"),
    ),
    Case("write", writes("P-0-0123", (None, 12)), "station 5 P-0-0123", "12 rpm by ASCII; still set at the end"),
    Case(  # a list of services
        "write",
        then(
            run(150),
            do("exchange", access(5, "S-0-4095", "", error="0x1001"), access(5, "P-0-0123", 12, is_write=True)),
        ),
        *("station 5 P-0-0123", "12 rpm by master 1; still set at the end"),
    ),
    Case(  # the same, whose attribute nobody had read until then
        "write",
        then(
            run(150),
            reads(undescribed(5, "P-0-0123", (120_000).to_bytes(4, "little"))),
            do("write", 5, "P-0-0123", 12, master=LAPTOP),
        ),
        *("station 5 P-0-0123", "12 rpm -> 12 rpm by new master 127; still set at the end"),
    ),
    Case(  # a segment of a list
        *("write", then(run(150), do("write", 5, "P-0-0123", "", text=None, master=LAPTOP))),
        *("station 5 P-0-0123", "another value by new master 127"),
    ),
    Case(  # beside what is written often
        "write",
        then(writes("P-0-0001", *[(PLC, one) for one in range(9)], every_s=2), do("write", 5, "P-0-0123", 12)),
        *("station 5 P-0-0123", "12 rpm by master 1; still set at the end"),
    ),
    Case(
        "conflict",
        writes("P-0-0123", (PLC, 12), (PANEL, 15), (PLC, 13), (PANEL, 16)),
        *("station 5 P-0-0123", "master 1 13 rpm, master 2 16 rpm; at the end 16 rpm"),
    ),
    Case(  # what is shown is cut off
        *(
            "conflict",
            then(*(do("write", 5, "P-0-0123", "1, ...", master=who, text=f"1, {who}") for who in (PLC, PANEL) * 2)),
        ),
        *("station 5 P-0-0123", "master 1 1, ..., master 2 1, ...; at the end 1, ..."),
    ),
    Case(
        "recipe",
        then(
            run(150), *(do("write", at, f"P-0-000{one}", 1.0) for at, one in ((4, 1), (4, 2), (5, 1), (5, 2), (5, 1)))
        ),
        *("", "master 1 wrote 4 parameters of stations 4, 5", 150.03, 150.15),
    ),
    Case(
        "recipe",
        then(run(150), *(then(do("write", 5, f"P-0-000{one}", 1.0), pause(9)) for one in range(4))),
        *("", "master 1 wrote 4 parameters of station 5"),
    ),
    Case(
        "limit_write",
        then(reads(access(5, LIMIT, 3000.0)), writes(LIMIT, (PLC, 500))),
        *(f"station 5 {LIMIT}", "3000.0 rpm -> 500 rpm by master 1; still set at the end"),
    ),
    Case(
        "other",
        then(writes("P-0-0123", (PLC, 12)), reads(*(access(5, "P-0-0123", value) for value in (12.0, 10.0)))),
        *("station 5 P-0-0123", "12 rpm -> 10.0 rpm, nobody on this bus wrote it"),
    ),
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.kind}-{case.detail[:20]}")
def test_what_is_said(case: Case) -> None:
    """There is a second port, whose bus is another one."""
    machine = Machine(interface="b")
    machine.engine.add(packet(BEGIN_S, interface="a"))
    case.play(machine)
    (found,) = machine.told().of(case.kind)
    assert (found.who, found.detail, found.hit.port) == (case.who, case.detail, "b")
    if case.kind in ("foreign", "drift", "slower", "stopped", "vanished"):
        assert found.packets == []  # it is of the whole capture
    elif case.kind not in ("bus_silent", "gap", "restart"):  # they begin with a silence
        assert machine.times_s[found.packets[0]] == pytest.approx(found.from_s, abs=0.006)
    if case.from_s is not None:
        assert found.from_s - BEGIN_S == pytest.approx(case.from_s, abs=0.006)
    if case.to_s is not None:
        assert found.to_s - BEGIN_S == pytest.approx(case.to_s, abs=0.006)
    if case.worst is not None:
        assert found.hit.worst == pytest.approx(case.worst, abs=0.006)


def turn(master: int, commands: int) -> Play:
    """Give another master a token; it asks so often, and gives it back."""
    give, take = (do("ask", listener, talker, service=0x0F) for talker, listener in ((PLC, master), (master, PLC)))
    return then(run(150), give, *[do("exchange", station=3, master=master)] * commands, take, run(60))


STATE = [access(5, "P-0-0222", str(value)) for value in [1] * 20 + [0] * 3 + [1] * 20 + [2]]

# Two commands without a reaction between two reactions: each direction has its own time.
DUPLEX = then(
    do("put", line=2, intervals_s=[0.01] * 100),  # it takes a second
    *[do("put", line=1, after_s=1.0)] * 3,
    do("put", line=2, after_s=0.01, since_s=2.01),
)

# What is no news, and of which kind it would be.
QUIET: Sequence[tuple[str, Play]] = (
    ("write", then(reads(access(5, "P-0-0123", 12.0)), writes("P-0-0123", (PLC, 12.0)))),  # it was so
    ("", writes("P-0-0123", (PLC, 12), (PLC, 12))),
    ("write", writes("P-0-0123", *[(PLC, 12)] * 10, (PLC, 13), every_s=2)),  # it is written again and again
    ("write", then(run(150), do("write", 5, "S-0-0134", "0b1110000000000000"), run(60))),  # by the usual master
    ("conflict", writes("P-0-0123", (PLC, 12), (PLC, 15), (PLC, 12), (PLC, 16))),  # one master
    ("conflict", writes("S-0-0134", *[(PLC, 1), (PANEL, 2)] * 3)),  # each value is obeyed, and over
    ("write", writes("S-0-0099", (PLC, 1))),
    ("recipe", then(run(150), *(then(do("write", 5, f"P-0-000{one}", 1.0), pause(10)) for one in range(4)))),
    ("recipe", then(run(150), *(do("write", 5, f"P-0-000{one}", 1.0, master=1 + one // 2) for one in range(4)))),
    ("fault", reads(undescribed(5, "S-0-0135", bytes(3)))),  # no word
    ("homing", reads(BIT[0], undescribed(5, "S-0-0403", bytes(3)))),
    ("interval", reaction(is_doubtful=True, reaction=judged(0.06, 0.05, EXCEEDED), pause=judged(0.001, 0.002, 0))),
    ("stopped", then(*[rests(7)] * 3)),  # an indexing axis
    ("unreadable", then(*[do("put", after_s=0.2)] * 40)),  # frames of another protocol
    ("drift", told("S-0-0051", RISES, every_s=30, unit="mm")),  # a position
    ("master", turn(9, 200)),  # a control that takes turns
    ("bus_silent", then(do("ask", 3), pause(5), talk(2))),  # nothing is known of it
    ("bus_silent", then(talk(60), pause(600), NEXT_KEPT, talk(60))),  # of a recorder
    ("bus_silent", then(talk(60), event(Event.ADAPTER_LOST, "unplugged"), pause(600), talk(60))),  # nobody listens
    ("stuck", then(run(4), do("boot", 4, 5), do("answer", 3, service=0x12, phase="2"))),  # nobody switched it
    ("stuck", then(*[do("exchange", station=station, service=0x1D, phase="2") for station in (4, 5)])),  # all are
    ("restart", then(run(30), do("silent", 4, 4), do("exchange", station=4, service=0x1D, phase="4"))),  # a switch
    ("stuck", then(do("boot", 4), do("ask", 3, service=0x1D, phase="4"), do("answer", 3, service=0x1D))),  # not said
    ("clock", DUPLEX),
    ("clock", then(reaction(), NEXT_KEPT, do("put", since_s=5.0, after_s=600))),  # its last character is in no file
    ("gap", then(run(30), pause(60), NEXT_OF_RING, run(30))),
    ("gap", then(run(30), pause(60), event(Event.MARKER, "a lorry"), run(30))),
    ("limits", then(limits(0.05), reaction(good=False, reaction=judged(0.01, 0.04, 0)), limits(0.05))),
    ("limits", limits(0.05, None, 0.05)),  # a second capture that has not told them yet
    ("slower", paces(*[0.0] * 30, *[0.030] * 30)),  # not measured
    ("slower", paces(*[0.010, 0.030] * 30, *[0.030, 0.010] * 29, 0.030, every_s=30)),  # in each minute the same
    ("slower", paces(*RISING[:45], *RISING[44::-3])),  # as quick again at the end
    ("slower", paces(*RISING[::4], every_s=240)),  # fifteen
    ("vanished", then(*[do("refuse", 5, LIMIT, "0x1001")] * 200, run(90))),  # a station is no master
    ("master", then(run(150), do("put", telegram(99, 3, good=False)), run(60))),  # its address may be damaged, too
    ("step", then(command(1000), turns(1000, 90), NEXT_FILE, turns(1200, 90))),
    ("error", refuse(0x10)),  # what is asked for is not known
    ("error", then(*[do("refuse", 5, LIMIT, "0x1001")] * 3)),
    ("changed", reads(*[access(5, "P-0-0222", one) for one in [1000] * 20 + [1010] * 5 + [1000] * 5], every_s=10)),
    *(("changed", reads(*[access(5, ident, one) for one in "AAAB"])) for ident in ("S-0-0390", "S-0-0095", "S-0-0135")),
    (
        "changed",
        then(reads(*[access(5, "P-0-0222", 1)] * 20), writes("P-0-0222", (PLC, 0)), reads(access(5, "P-0-0222", 0))),
    ),
    ("step", then(turns(1000, 60), command(1000), turns(1000, 60))),
    *(("step", then(command(rpm), *(turns(rpm * part, 99) for part in (1, 0.97, 1)))) for rpm in (1000, -1000)),
    ("step", then(do("write", 3, TORQUE, 50), told(TORQUE, PART, unit="%"))),  # somebody sets it
    ("drift", then(do("write", 3, TORQUE, 50), line((30, 50)))),
    ("beyond", do("write", 3, SPEED, 3001, **IN_LIMITS)),  # that tells nothing of what it is
    ("beyond", reads(access(3, SPEED, "fast", **IN_LIMITS))),
    ("unreadable", then(*[then(do("noise"), reaction())] * 25)),  # two of three are telegrams
)


@pytest.mark.parametrize(("kind", "play"), QUIET, ids=lambda one: str(one)[:10])
def test_what_is_not_told(kind: str, play: Play) -> None:
    machine = Machine()
    play(machine)
    assert machine.told().of(kind) == []


def test_a_visitor_with_a_token_is_told() -> None:
    machine = Machine()
    turn(9, 5)(machine)
    assert [one.detail for one in machine.told().of("master")] == [
        "master 9 asked stations 1, 3: 6 commands, 0 values read, 0 written"
    ]


def test_what_several_had_before_a_visitor_wrote_the_same_is_not_told() -> None:
    machine = Machine()
    before = reads(*(access(station, "P-0-0123", 10.0 * station) for station in (3, 4)))
    wrote = [do("write", station, "P-0-0123", 12, master=LAPTOP) for station in (3, 4)]
    then(run(150), before, *wrote)(machine)
    (found,) = machine.told().of("write")
    assert (found.who, found.hit.detail) == ("stations 3, 4 P-0-0123", "12 rpm by new master 127")


@pytest.mark.parametrize(
    ("masters", "said", "visits"),
    [
        (
            (103, 104),
            ["station 3 P-0-0123 12 rpm by new master 103", "station 4 P-0-0123 12 rpm by new master 104"],
            [[1051], [1053]],  # before it, 75 cycles of 14 packets
        ),
        ((103, 103), ["stations 3, 4 P-0-0123 12 rpm by new master 103"], [[1051]]),
    ],
)
def test_what_visitors_write_at_once_is_told_by_its_author(
    masters: tuple[int, int], said: Sequence[str], visits: Sequence[Sequence[int]]
) -> None:
    machine = Machine()
    stations = zip((3, 4), masters, strict=True)
    then(run(150), *(do("write", station, "P-0-0123", 12, master=master) for station, master in stations))(machine)
    told = machine.told()
    assert [f"{one.who} {one.detail.partition(';')[0]}" for one in told.of("write")] == said
    assert [one.packets for one in told.of("master")] == visits


@pytest.mark.parametrize(("falls", "count"), [(0, 0), (1, 0), (2, 1)])
def test_what_only_rises_is_a_counter_and_has_no_drift(falls: int, count: int) -> None:
    """It may fall once in a hundred times: somebody has reset it."""
    numbers = [float(number) for number in range(1, 121)]
    for place in range(falls):
        numbers.insert(60 + 20 * place, numbers[58 + 20 * place])
    machine = Machine()
    told("P-0-0300", numbers, every_s=30, unit="mm")(machine)
    assert len(machine.told().of("drift")) == count


@pytest.mark.parametrize(("since_s", "count"), [(0, 1), (1200, 1), (2400, 0)])
def test_a_drift_is_one_of_the_time_that_is_told(since_s: float, count: int) -> None:
    """It takes half an hour at least; this one is an hour long."""
    machine = Machine()
    machine.engine = Engine(since_s=BEGIN_S + since_s)
    told(TORQUE, RISES, every_s=30, unit="%")(machine)
    assert len(machine.told().of("drift")) == count


def test_four_warnings_are_told_one_by_one_and_four_faults_as_one() -> None:
    def drives(kind: str) -> str:
        found = [
            Episode.of(Hit(kind, n, 100.0 * n, 100.0 * n, 3, detail=f"number {n}", topic="F2028")) for n in range(1, 5)
        ]
        return lines(found, 0, 1000)[Subject.DRIVES].text

    assert drives("beyond").count("station 3 number ") == 4
    assert drives("fault").startswith("Drives: Fault F2028 4 times, station 3 (")


def test_what_a_good_capture_refused_too_is_no_fault() -> None:
    good = Machine(interface="COM3")
    refused(is_known=True)(good)
    assert good.told().kinds == ["error"]
    machine = Machine(before=good.engine, interface="COM4")
    refused(is_known=True)(machine)
    assert machine.told().kinds == ["never"]


def test_a_bus_that_is_unreadable_twice_is_told_twice() -> None:
    machine = Machine()
    for _ in range(2):
        then(run(60), do("noise", 21, every_s=0.2), reaction(3))(machine)
    found = machine.told().of("unreadable")
    assert [one.detail for one in found] == ["21 records are no telegrams"] * 2
    assert [one.from_s - BEGIN_S for one in found] == pytest.approx([60.2, 124.49])


def test_a_drift_that_chance_may_make_says_so() -> None:
    """Of 16 points, 8 pairs of neighbours fall: S = 120 - 16, and its deviation is sqrt(16*15*37/18) = 22.2."""
    numbers = [30 + 2 * (number ^ 1) for number in range(16)]
    machine, short = Machine(), Machine()
    told(TORQUE, numbers, every_s=300, unit="%")(machine)
    (drift,) = machine.told().of("drift")
    told(TORQUE, numbers[:12], every_s=400, unit="%")(short)
    assert short.told().of("drift") == []  # too few
    assert int(drift.detail.rpartition(" ")[2].rstrip(")")) == pytest.approx(352_000, rel=0.01)  # 4.68 deviations


def test_a_capture_in_which_nothing_was_heard_has_a_gap_before_and_after_it() -> None:
    machine = Machine()
    started = event(Event.CAPTURE_STARTED)
    then(run(30), pause(600), started, pause(7200), started, run(30))(machine)
    assert [one.detail for one in machine.told().of("gap")] == [
        "602 s between two captures",
        "7200 s between two captures",
    ]


def test_many_stops_are_one_phrase() -> None:
    machine = Machine()
    for _ in range(4):
        machine.run(300)
        machine.stop(60)
    machine.run(300)
    assert ". Machine stopped 4 times (" in machine.told().lines[0]


def test_a_drive_whose_torque_rises_much_more_is_told_apart() -> None:
    machine = Machine()
    line((30, 50), (30, 55))(machine)
    assert [one.who for one in machine.told().of("drift")] == [f"station {station} {TORQUE}" for station in (3, 4)]


def test_what_drifted_in_a_good_capture_is_usual_there() -> None:
    """Also if the tap was at another port."""
    good = Machine(interface="a")
    line((30, 50))(good)
    good.finish()
    machine = Machine(interface="b", before=good.engine)
    line((30, 50), (30, 50))(machine)
    assert [one.who for one in machine.told().of("drift")] == [f"station 4 {TORQUE}"]


def test_states_of_long_ago_are_forgotten() -> None:
    for memory_s, count in ((1000, 2), (100, 1)):
        machine = Machine()
        machine.engine = Engine(thresholds=THRESHOLDS._replace(memory_s=memory_s))
        reads(*STATE, every_s=10)(machine)
        assert sum(one.count for one in machine.told().of("changed")) == count


def test_what_begins_is_told_at_once() -> None:
    live = LiveEpisodes()
    said = [access(5, "S-0-0390", f"0x{code:08X}") for code in (0xA0101, FAULT, FAULT, 0xA0101)]
    found = [
        live.add(packet(BEGIN_S + n, telegram(5, PLC, is_reaction=True), accesses=[one])) for n, one in enumerate(said)
    ]
    assert [[hit.kind for hit in hits] for hits in found] == [[], ["fault"], [], ["fault"]]


def at_once(*accesses: Access, every_s: float = 10.0) -> list[tuple[int, str, float, str]]:
    """Return what is told of values, at once: with which of them, what, since when, its outcome."""
    live = LiveEpisodes(THRESHOLDS._replace(learning_s=0.0))
    found = []
    for number, one in enumerate(accesses):
        hits = live.add(packet(BEGIN_S + every_s * number, telegram(5, PLC, is_reaction=True), accesses=[one]))
        found += [(number, hit.detail, hit.from_s - BEGIN_S, hit.outcome) for hit in hits]
    return found


def test_a_state_is_told_at_once_each_time_it_begins() -> None:
    states = at_once(*(access(5, "P-0-0222", state) for state in "1111111110011101"))
    assert states == [(9, "1 -> 0", 90, ""), (14, "1 -> 0", 140, "")]
    numbers = at_once(*(access(5, "P-0-0222", number) for number in [1] * 9 + [0, 0, 1]))
    assert numbers == [(9, "1 rpm -> 0 rpm", 90, "")]


def test_a_level_is_told_when_it_lasts_and_once() -> None:
    """A drive may stand from its beginning: then it has levels, too."""
    torque = [access(5, TORQUE, number, unit="%") for number in (*near(50, 30), *near(70, 9))]
    assert at_once(*torque) == [(32, "70 %, usually 50", 300, "")]
    again = (access(5, TORQUE, number, unit="%") for middle in (50, 70, 50, 70) for number in near(middle, 40))
    assert at_once(*again) == [(42, "70 %, usually 50", 400, "")]  # the second time, it is known
    assert at_once(*torque, every_s=1) == [(35, "70 %, usually 50", 30, "")]  # after 5 s
    stands = access(5, "S-0-0390", "0xA0012")
    assert at_once(stands, *torque) == [(33, "70 %, usually 50", 310, "")]


@pytest.mark.parametrize(
    ("more", "count"),
    [
        ({"is_doubtful": True, "reaction": judged(0.06, 0.05, EXCEEDED)}, 1),
        ({"is_doubtful": True, "reaction": judged(0.06, 0.05, UNRESOLVED)}, 0),  # perhaps
        ({"signs": ("early",)}, 1),
        ({"signs": ("against",)}, 0),
        ({"is_refusal": True, "status": 2, "service": 0x12}, 1),
        ({"is_refusal": True, "status": 1, "service": 0x11}, 0),  # it never knew it
    ],
)
def test_what_is_only_a_note_is_not_told_at_once(more: dict[str, Any], count: int) -> None:
    assert len(LiveEpisodes().add(packet(BEGIN_S, telegram(5, PLC, is_reaction=True, **more)))) == count


def test_a_visitor_is_told_at_once_but_not_his_tokens() -> None:
    live = LiveEpisodes()
    for second in range(250):
        assert live.add(packet(BEGIN_S + second, telegram(PLC, 3))) == []
    assert live.add(packet(BEGIN_S + 250, telegram(LAPTOP, PLC, service=0x0F))) == []
    (hit,) = live.add(packet(BEGIN_S + 251, telegram(LAPTOP, 3)))
    assert (hit.kind, hit.station, hit.detail) == ("master", 3, "asked by new master 127")
    assert len(live.add(packet(BEGIN_S + 252, telegram(126, 3)))) == 1  # another one
    assert live.add(packet(BEGIN_S + 253, telegram(LAPTOP, 3))) == []


# -- While it happens ------------------------------------------------------------------------------------------------


def test_a_silence_of_three_seconds_is_one() -> None:
    for silence_s, count in ((2.99, 0), (3.0, 1)):
        silence = BusSilence()
        for second in range(60):
            silence.add(packet(second / 2, telegram(PLC, 3)))
        assert len([*silence.add(packet(29.5 + silence_s, telegram(PLC, 3)))]) == count


def test_a_silence_under_way_is_one_from_three_seconds_on() -> None:
    silence = BusSilence()
    for second in range(60):
        silence.add(packet(second / 2, telegram(PLC, 3)))
    assert silence.under_way(32.49) == () and len([*silence.under_way(32.5)]) == 1


def test_a_silence_that_lasts_is_told_once() -> None:
    silence = BusSilence()
    for second in range(30):
        silence.add(packet(float(second), telegram(PLC, 3)))
    assert silence.under_way(31.9) == () and silence.under_way(32) == ()  # 3 s; three times as long as usual
    (hit,) = silence.under_way(32.1)
    assert (hit.kind, hit.from_s, hit.to_s, hit.detail) == ("bus_silent", 29, 32.1, "3.1 s: cable or master off?")
    assert hit.worst == pytest.approx(3.1)
    assert silence.under_way(40) == ()
    silence.add(packet(40.5, type=EVENT, event=int(Event.MARKER)))
    assert silence.under_way(41) == ()
    assert [one.from_s for one in silence.add(packet(42.0, telegram(PLC, 3)))] == [29]
    assert len([*silence.under_way(60)]) == 1  # the next one


def test_a_bus_that_was_heard_for_a_quarter_of_an_hour_is_known() -> None:
    """Shorter: a silence of more than half of the time may be usual."""

    def severity(heard_s: int, silence_s: int) -> Severity | None:
        silence = BusSilence()
        for second in range(heard_s + 1):
            silence.add(packet(float(second), telegram(PLC, 3)))
        under_way = [*silence.under_way(float(heard_s + silence_s))]
        (hit,) = silence.add(packet(float(heard_s + silence_s), telegram(PLC, 3)))
        assert len(under_way) == (hit.severity is None)  # a note is told only afterwards
        return hit.severity

    assert severity(100, 50) is None and severity(100, 51) == Severity.NOTE
    assert severity(900, 5000) is None and severity(899, 5000) == Severity.NOTE
    assert severity(20, 5) is None and severity(19, 5) == Severity.NOTE  # twenty silences say what is usual


def test_a_rhythm_is_told_with_its_length() -> None:
    silence = BusSilence()
    found: list[Hit] = []
    for begin_s, talks_s in ((1000, 100), *((1139 + 99 * number, 60) for number in range(13))):
        for second in range(talks_s):
            found += silence.add(packet(float(begin_s + second), telegram(PLC, 3)))
    # The length of the first one's period is not known; ten others make a rhythm.
    assert [one.kind for one in found] == ["bus_silent"] * 11 + ["rhythm"] * 2
    assert found[-1].detail == "40 s each: a master that pauses, or a loose cable?"


def test_of_two_directions_the_shorter_silence_counts() -> None:
    silence = BusSilence()
    for second in range(30):
        silence.add(packet(float(second), telegram(PLC, 3)))
    assert silence.add(packet(39.0, telegram(PLC, 3), since_s=20.0))[0].from_s == 29  # type: ignore[index]
    assert silence.add(packet(49.0, telegram(PLC, 3), since_s=2.0)) == ()
    assert silence.add(packet(69.0, telegram(PLC, 3), since_s=7.0))[0].from_s == 62  # type: ignore[index]
    silence.add(packet(69.5, telegram(PLC, 3)))
    silence.add(packet(70.0, type=2, event=int(Event.CAPTURE_STARTED)))
    assert silence.under_way(90) == ()
    assert silence.add(packet(99.0, telegram(PLC, 3))) == ()  # between two captures nobody has listened


def ask(silence: StationSilence, second: float, *, unanswered: bool = True, **more: bool) -> Sequence[Hit]:
    return [*silence.add(packet(second, telegram(PLC, 0, unanswered=unanswered, **more), number=int(second)))]


def answer(silence: StationSilence, second: float) -> Sequence[Hit]:
    return [*silence.add(packet(second, telegram(0, PLC, is_reaction=True), number=int(second)))]


def test_a_station_that_is_silent_while_it_happens() -> None:
    """One that never answered is perhaps not there; what is damaged may have been the reaction."""
    silence = StationSilence()
    assert answer(silence, 1) == []
    for second in (2, 3, 4):
        ask(silence, second)
    (hit,) = silence.under_way("")  # the last command may still be answered
    assert (hit.kind, hit.from_s, hit.to_s, hit.worst) == ("unanswered", 2, 3, 2)
    assert silence.command(packet(4.5, telegram(PLC, 3))) == ()  # it was not
    (hit,) = silence.under_way("")
    assert (hit.kind, hit.to_s, hit.worst) == ("silent", 4, 3)
    assert [*silence.under_way("")] == []
    ask(silence, 5)
    assert (hit.packet, hit.severity) == (2, None)
    silence.add(packet(6, telegram(4, PLC, is_reaction=True, good=False)))
    (hit,) = answer(silence, 7)
    assert (hit.kind, hit.to_s, hit.worst) == ("silent", 7, 3)
    assert [*silence.finish("")] == []


def test_a_file_that_ends_forgets_who_was_asked() -> None:
    silence = StationSilence()
    answer(silence, 1)
    for second in (2, 3, 4, 5):
        ask(silence, second)
    seam = packet(6, type=2, event=int(Event.CAPTURE_STARTED), text=f"a tap{KEPT}late")
    (hit,) = silence.add(seam)
    assert (hit.kind, hit.worst) == ("silent", 3)  # the last reaction may be in no file
    for second in (7, 8, 9, 10):
        ask(silence, second)
    (hit,) = silence.finish("")
    assert (hit.kind, hit.worst, hit.outcome) == ("silent", 4, "not heard again")


# -- A machine runs or stands ----------------------------------------------------------------------------------------


def test_a_text_may_have_its_two_lengths_before_it() -> None:
    for data, text in (("02 00 3C 00 46 32", '"F2"'), ("00 00 3C 00", '""'), ("46 32 32 38", '"F228"')):
        found = reading(undescribed(3, "S-0-0095", bytes.fromhex(data)))
        assert found and found.text == text


def stops(*said: tuple[float, int, str, ValueReading], end_s: float = 100) -> list[tuple[float, float]]:
    """Return from when to when it stood within 100 s."""
    drives = Drives()
    for now_s, station, ident, tells in said:
        drives.add(now_s, Parameter("", str(station), 0, ident), tells)
    return drives.stops(0, end_s)


def word(bits: int) -> ValueReading:
    return ValueReading(None, "", "", bits)


def code(number: int) -> ValueReading:
    return ValueReading(None, f"0x{number:X}", "", number)


def speed(number: float) -> ValueReading:
    return ValueReading(number, "", "rpm")


def test_a_drive_stands_as_its_words_say() -> None:
    """S-0-0134: bits 15 to 13 enable. S-0-0135: bits 15 and 14 are 11 in operation, 10 free of torque."""
    on, off = (10.0, 3, "S-0-0134", word(0xE000)), (40.0, 3, "S-0-0134", word(0x6000))
    assert stops(on, off) == [(40, 100)]
    assert stops(on, off, (70.0, 3, "S-0-0134", word(0xE00F))) == [(40, 70)]
    assert stops(on, (40.0, 3, "S-0-0134", word(0xFFFF))) == []
    assert stops((10.0, 3, "S-0-0135", word(0xC000)), (40.0, 3, "S-0-0135", word(0x8000))) == [(40, 100)]
    assert stops((10.0, 3, "S-0-0135", word(0x4000)), (40.0, 3, "S-0-0135", word(0xC000))) == [(0, 40)]
    assert stops((10.0, 3, "S-0-0135", word(0x4000))) == []  # nobody knows whether it ever runs
    assert stops(on, off, (43.0, 3, "S-0-0134", word(0xE000))) == []  # too short
    ready = [(20.0, 3, "S-0-0135", word(0x8000)), (30.0, 3, "S-0-0134", word(0xE000))]
    assert stops(on, off, (60.0, 3, "S-0-0134", word(0xE000)), (63.0, 3, "S-0-0134", word(0))) == [(40, 100)]
    assert stops((10.0, 3, "S-0-0134", word(0)), (20.0, 3, "S-0-0134", word(0xE000)), off) == [(0, 20), (40, 100)]
    assert stops(on, *ready, (50.0, 3, "S-0-0135", word(0xC000))) == [(20, 50)]  # the drive itself says it best


@pytest.mark.parametrize(
    ("reads_s", "stood"),
    [
        ((110.3,), [(110.3, 172)]),  # a minute later it says nothing any more
        ((110.3, 410.3, 710.3), [(110.3, 172), (410.3, 910)]),  # it is read every five minutes
    ],
)
def test_a_drive_says_it_best_while_it_is_read(reads_s: Sequence[float], stood: Sequence[tuple[float, float]]) -> None:
    """A control enables it all the time, and it is not in operation."""
    enabled = [(10.0 + 2 * number, 3, "S-0-0134", word(0xE000)) for number in range(450)]
    status = [(at_s, 3, "S-0-0135", word(0x8000)) for at_s in reads_s]
    assert stops(*sorted([*enabled, *status], key=itemgetter(0)), end_s=910) == stood


def test_a_word_that_a_laptop_reads_once_stops_no_machine() -> None:
    """The drive is enabled by an input, and not by its control word."""
    turning = [(2.0 * number, 3, "S-0-0040", speed(1000)) for number in range(450)]
    once = [(110.1, 3, "S-0-0134", word(0)), (110.3, 3, "S-0-0135", word(0xC000))]
    assert stops(*sorted([*turning, *once], key=itemgetter(0)), end_s=900) == []


def test_a_drive_is_the_same_at_its_own_address_and_at_0() -> None:
    machine = Drives()
    for at_s, device, bits in ((10, 3, 0xE000), (20, 0, 0xE000), (30, 3, 0)):
        machine.add(at_s, Parameter("", "3", device, "S-0-0134"), word(bits))
    assert machine.stops(0, 100) == [(30, 100)]


def test_a_drive_with_a_warning_stands_as_it_said_before() -> None:
    codes = {10.0: 0xA0101, 20.0: 0xA0012, 85.0: WARNING}
    assert stops(*((at_s, 3, "S-0-0390", code(number)) for at_s, number in codes.items())) == [(20, 100)]


@pytest.mark.parametrize("drives", [(("3/8", 0), ("3/9", 0)), (("3", 1), ("3", 2))])
def test_of_two_drives_behind_a_station_each_says_whether_it_runs(drives: Sequence[tuple[str, int]]) -> None:
    """One of them runs all the time, and the other one stands."""
    machine = Drives()
    for number in range(10):
        machine.add(10.0 * number, Parameter("", *drives[number % 2], "S-0-0134"), word(0xE000 * (1 - number % 2)))
    assert machine.stops(0, 100) == []


def test_a_machine_runs_if_a_third_of_its_drives_do() -> None:
    on = [(10.0, station, "S-0-0134", word(0xE000)) for station in (3, 4, 5)]
    off = [(40.0 + station, station, "S-0-0134", word(0)) for station in (3, 4, 5)]
    assert stops(*on, *off[:2]) == []
    assert stops(*on, *off) == [(45, 100)]


def test_a_drive_stands_as_its_speed_says() -> None:
    """An index axis rests for a moment."""

    def every_second(*speeds: float) -> list[tuple[float, int, str, ValueReading]]:
        return [(float(second), 3, SPEED, speed(one)) for second, one in enumerate(speeds)]

    assert stops(*every_second(*[1000] * 20, *[0] * 20, *[-1000] * 20)) == [(20, 40)]
    assert stops(*every_second(1, *[1000] * 19, *[-9] * 20, *[11] * 20)) == [(20, 40)]  # 1 % of the fastest is at rest
    assert stops(*every_second(*[1000, 1000, 1000, 0, 0] * 20)) == []
    others = [(float(second), station, SPEED, speed(0)) for second in range(60) for station in (4, 5, 6)]
    assert stops(*every_second(*[1000] * 60), *others) == []  # nobody knows whether they ever turn
    assert stops(*every_second(*[1000] * 20, *[0] * 14, *[1000] * 20)) == []
    assert stops(*every_second(*[0] * 60)) == []
    assert stops((10.0, 3, SPEED, ValueReading(None, "010203"))) == []


@pytest.mark.parametrize(("code_s", "found"), [((0, 20), [(5, 100)]), ((0, 20, 70), [])])
def test_a_speed_says_more_than_an_old_diagnosis(code_s: Sequence[int], found: Sequence[tuple[float, float]]) -> None:
    """A panel reads diagnoses only now and then."""
    codes = [(float(second), 3, "S-0-0390", code(0xA0101)) for second in code_s]
    speeds = [(float(second), 3, SPEED, speed(1000.0 * (second < 5))) for second in range(100)]
    assert stops(*sorted((*codes, *speeds), key=lambda one: one[0])) == found


# -- Levels, lines, and their chance ---------------------------------------------------------------------------------


def levels(*parts: tuple[float, int], every_s: float = 2.0, by: float = 1.0, **thresholds: Any) -> Levels:
    made, number = Levels(THRESHOLDS._replace(**thresholds)), 0
    for middle, count in parts:
        for _ in range(count):
            made.add(every_s * number, middle + by * ((0, 1, 0, -1)[number % 4]), number)
            number += 1
    return made


def unusual(made: Levels) -> list[tuple[float, float, Severity]]:
    return [(level.from_s, level.value, severity) for level, severity in made.unusual()]


NOTE, LOOK = Severity.NOTE, Severity.WARNING


@pytest.mark.parametrize(
    ("parts", "found"),
    [
        (((100, 100), (120, 50), (100, 100)), [(200, 120, LOOK)]),
        (((100, 100), (104, 50), (100, 100)), []),  # less than 5 %
        (((100, 100), (120, 2), (100, 100)), []),  # two values are no level
        (((100, 100), (120, 3), (100, 100)), []),  # shorter than 5 s
        (((100, 100), (120, 4), (100, 100)), [(200, 120, LOOK)]),
        (((100, 100), (140, 90), (100, 100), (140, 90), (100, 100), (140, 30)), [(200, 140, NOTE)]),  # rarely
        (((100, 100), (140, 90)) * 4, []),
        ((*((100, 100), (120, 100)) * 4, (185, 50)), [(1600, 185, LOOK)]),  # by more than thrice the usual change
        ((*((100, 100), (120, 100)) * 4, (175, 50)), []),
        ((*((100, 100), (120, 100)) * 4, (35, 50)), [(1600, 35, LOOK)]),
        ((*((100, 100), (120, 100)) * 4, (45, 50)), []),
        (((100, 50), *((100, 4), (120, 4)) * 50, (200, 10), *((100, 4), (120, 4)) * 45), [(900, 200, LOOK)]),
        # what has more than 200 levels just moves
        (((100, 50), *((100, 4), (120, 4)) * 50, (200, 10), *((100, 4), (120, 4)) * 55), []),
    ],
)
def test_a_level_is_unusual(parts: Sequence[tuple[float, int]], found: Sequence[tuple[float, float, Severity]]) -> None:
    assert unusual(levels(*parts)) == pytest.approx(found) if not found else unusual(levels(*parts))[:1] == found


def test_noise_is_no_level() -> None:
    """Eight times the usual scatter: 1.48 median deviations, here of 1 and 0."""
    assert unusual(levels((100, 200), (110, 50), (100, 200), by=2.0)) == []
    assert len(unusual(levels((100, 200), (114, 50), (100, 200), by=2.0))) == 1


def test_the_last_digit_of_a_constant_makes_no_levels() -> None:
    """With many of them, none is rare."""
    flickers = levels(*((50, 20), (50.1, 20)) * 5, (54, 20), (50, 20), by=0.0)
    assert unusual(flickers) == [(400, 54, LOOK)]


def test_levels_of_long_ago_are_forgotten() -> None:
    for memory_s, found in ((1000, [2240]), (3000, [200, 2240])):
        made = levels((100, 100), (140, 20), (100, 1000), (160, 20), memory_s=memory_s)
        assert [from_s for from_s, *_ in unusual(made)] == found


@pytest.mark.parametrize(("every", "found"), [(40, [(1802, 150, LOOK)]), (26, [])])
def test_a_value_that_swings_farther_now_and_then_has_no_level_there(every: int, found: Sequence[Any]) -> None:
    """Now and then: every thirtieth time at least."""
    swings = [part for _ in range(900 // every) for part in ((100, every), (160, 1))]
    assert unusual(levels(*swings, (150, 30), (100, 50), by=0.5)) == found


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_level_between_two_that_swing_and_far_from_both_is_none(sign: int) -> None:
    """Levels of 0 and 20 make 60 more usual, and less."""
    swings = [part for middle in (0, 20) * 3 for part in ((sign * middle, 15), (sign * 60, 1)) * 4]
    assert unusual(levels(*swings, (sign * 70, 30), (0, 60), by=0.5)) == []


@pytest.mark.parametrize(("alike", "times", "count"), [(3, 38, 1), (3, 65, 0), (5, 65, 1)])
def test_what_mostly_moves_has_no_levels(alike: int, times: int, count: int) -> None:
    """For more than a quarter of the time, more than a fifth of its values are elsewhere."""
    moves = [part for _ in range(times) for part in ((140, alike), (170, 1))]
    assert len(unusual(levels((100, 300), *moves, (100, 300), (300, 10), by=0.5))) == count


@pytest.mark.parametrize(("every", "times", "count"), [(30, 1, 1), (20, 1, 0), (50, 2, 2), (25, 2, 0)])
def test_a_peak_is_one_of_a_value_that_hardly_ever_has_any(every: int, times: int, count: int) -> None:
    """In fifty values or more, one of fifty."""
    made = levels(*((100, every), (160, 1)) * times, (100, every), by=0.0)
    peaks = [(2.0 * every * number + 2 * (number - 1), 160) for number in range(1, times + 1)]
    assert [(blip.from_s, blip.value) for blip in made.blips()] == peaks[:count]
    assert levels((100, 90), (104.5, 2), (100, 90), by=0.0).blips() == []  # less than 5 %


@pytest.mark.parametrize(
    ("gaps_s", "found"), [((50, 70), [140, 160]), ((70, 50), [140, 160]), ((70, 70), [160]), ((50, 50), [140, 160])]
)
def test_a_level_is_one_if_it_was_read_shortly_before_or_after(gaps_s: Sequence[float], found: Sequence[float]) -> None:
    made, second = Levels(), 0.0
    parts = (100, gaps_s[0]), (140, gaps_s[1]), (100, 0), (160, 0), (100, 0)
    for middle, gap_s in parts:
        for value in near(middle, 60):
            second += 2
            made.add(second, value, 1)
        second += gap_s
    assert [value for _, value, _ in unusual(made)] == found


def test_a_step_is_small_beside_later_noise() -> None:
    """By 15; later, the median deviation is 2: eight times the scatter are 23.7."""
    made = levels((100, 100), (115, 20), (100, 50), by=0.5)
    assert [severity for _, _, severity in unusual(made)] == [LOOK]
    for number in range(170, 500):
        made.add(2.0 * number, 100 + (0, 4, 0, -4)[number % 4], number)
    assert [severity for _, _, severity in unusual(made)] == [NOTE]


def test_quartiles_have_weights() -> None:
    assert quartiles([(3.0, 1.0), (1.0, 1.0), (2.0, 1.0), (4.0, 1.0)]) == (1.0, 3.0)
    assert quartiles([(1.0, 1.0), (2.0, 9.0)]) == (2.0, 2.0)
    assert quartiles([(7.0, 1.0)]) == (7.0, 7.0)
    assert quartiles([(float(value), 1.0) for value in range(1, 6)]) == (2.0, 4.0)


def test_a_line_through_points() -> None:
    """Mann and Kendall: of 10 rising points, S = 45 and its deviation is sqrt(10*9*25/18) = 11.18."""
    found = trend([(float(x), 2.0 * x + 5) for x in range(10)])
    assert (found.slope, found.scatter) == (2.0, 0.0)
    assert found.chance == pytest.approx(5.7e-5, rel=0.01)  # 4.025 standard deviations, both sides
    bent = trend([(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (3.0, 9.0)])
    assert (bent.slope, bent.scatter) == (2.0, 1.4826)  # of 1, 1, 1, 3, 4, 7
    assert trend([(0.0, 1.0), (0.0, 2.0), (1.0, 3.0)]).slope == 1.5  # nothing rises at one time


def test_what_levels_out_does_not_go_on() -> None:
    def bent(slope: float) -> list[tuple[float, float]]:
        return [(float(x), 2.0 * min(x, 20) + slope * max(x - 20, 0)) for x in range(41)]

    assert goes_on(bent(0.6), trend(bent(0.6)))  # 0.6 of 1.3
    assert not goes_on(bent(0.4), trend(bent(0.4)))  # of 1.2


def test_slots_are_averages_in_bounded_memory() -> None:
    slots = Slots()
    for second in range(128):
        slots.add(second, float(second))
    assert slots.points() == [(second + 0.5, second + 0.5) for second in range(0, 128, 2)]
    slots.add(128, 1.0)
    assert slots.points()[0] == (1.5, 1.5) and len(slots.points()) == 33
    slots = Slots()
    for second in (200, 100):  # a clock that was set back
        slots.add(second, float(second))
    assert slots.points() == [(100, 100.0), (200, 200.0)]


# -- Beside a good capture -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("good", "bad", "said"),
    [
        (1000, 600, ["600 rpm, 1000 in the good capture"]),
        (1000, 1020, []),
        (600, 1000, ["1000 rpm, 600 in the good capture"]),
    ],
)
def test_a_level_that_a_good_capture_does_not_have(good: int, bad: int, said: Sequence[str]) -> None:
    before, now = Machine(interface="a"), Machine(interface="b")
    for machine, rpm in ((before, good), (now, bad)):
        level("P-0-0123", rpm, 100, "rpm")(machine)
    sides = [machine.engine._buses[name].values for machine, name in ((before, "a"), (now, "b"))]
    assert [hit.detail for hit in unlike(*sides)] == said


P123, P145 = "P-0-0123", "P-0-0145"
USUAL = then(level(P123, 1000, 99, "rpm", 3), level(P123, 600, 99, "rpm", 4), level(P145, 600, 99, "rpm", 3))


@pytest.mark.parametrize(
    ("good", "bad", "said"),
    [
        (USUAL, level(P123, 600, 99, "rpm"), [f"station 3 {P123} 600 rpm, 1000 in the good capture"]),
        *(
            (
                level(P123, 23450, 99, unit),
                level(P123, 12340, 99, unit),
                [f"station 3 {P123} {said} in the good capture"],
            )
            for unit, said in (("", "12340, 23450"), (RAW, "12340 raw, 23450"))
        ),
        (USUAL, level(P123, 600, 99, RAW), []),  # on another scale
        (USUAL, level("P-0-0124", 600, 99, "rpm"), []),
        (then(command(1000), turns(1000, 99)), turns(600, 99), []),  # only one side tells what it follows
        (turns(1000, 99), then(command(1000), turns(600, 99)), []),
        (level(TORQUE, 50, 99, "%"), line((80, 50)), []),  # a drift, that is told
        (
            level(P123, 1000, 99, "rpm"),
            then(level(P123, 1000, 99, "rpm"), level(P123, 600, 30, "rpm"), level(P123, 1000, 99, "rpm")),
            [f"station 3 {P123} 600 rpm, usually 1000"],  # once
        ),
        (then(level(P123, 1000, 99, "rpm"), level(P123, 600, 99, "rpm")), level(P123, 600, 99, "rpm"), []),
        (
            then(USUAL, level(TORQUE, 50, 99, "%")),
            then(level("P-0-0001", 9, 99, ""), level(P145, 9, 99, RAW), line((80, 50)), level(P123, 600, 99, "rpm")),
            [f"station 3 {P123} 600 rpm, 1000 in the good capture"],
        ),
    ],
)
def test_what_a_good_capture_tells_of_a_level(good: Play, bad: Play, said: Sequence[str]) -> None:
    before = Machine()
    good(before)
    before.finish()
    machine = Machine(before=before.engine)
    bad(machine)
    assert [f"{one.who} {one.detail.partition(';')[0]}" for one in machine.told().of("step")] == said


def test_a_level_is_far_from_a_good_one_beside_its_own_noise() -> None:
    good = levels((100, 99), by=0.1)
    assert [level.value for level in levels((112, 99), by=0.1).unlike(good)] == [112]
    assert [*levels((112, 99), by=2.0).unlike(good)] == []  # eight times the scatter are 11.9, and 5 % of the good one
    assert [level.value for level in levels((88, 99), by=0.1).unlike(good)] == [88]
    assert [*levels((88, 99), by=2.0).unlike(good)] == []


def test_what_follows_a_command_is_compared_beside_it() -> None:
    machines = Machine(), Machine()
    for machine, rpm in zip(machines, (1000, 900), strict=True):
        then(command(1000), turns(rpm, 100))(machine)
    sides = [machine.engine._buses[""].values for machine in machines]
    (hit,) = unlike(*sides)
    assert (hit.detail, hit.severity) == ("-100 rpm beside S-0-0036, 0 in the good capture", NOTE)
    for one in (followed for side in sides for _, followed in side.followed()):
        was, one.is_written = one.is_written, True  # what somebody writes is as it was told
        assert [*unlike(*sides)] == ([] if not was else [hit])
        one.is_written = was


# -- Thresholds ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("silence=3", "'silence=3' is not NAME=VALUE with a NAME of: bus_silent_s, "),
        ("again=1.5", "again takes a whole number from 0 on, not '1.5'"),
        ("again=-1", "again takes a whole number from 0 on, not '-1'"),
        ("silent_s=inf", "silent_s takes a number from 0 on, not 'inf'"),
        ("silent_s=nan", "silent_s takes a number from 0 on, not 'nan'"),
        ("silent_s", "silent_s takes a number from 0 on, not ''"),
    ],
)
def test_a_threshold_that_is_none_says_why(text: str, said: str) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(said)}"):
        changed(THRESHOLDS, text)


def test_one_threshold_is_changed() -> None:
    assert changed(THRESHOLDS, "again=0") == THRESHOLDS._replace(again=0)
    assert changed(THRESHOLDS, "silent_s=1e3") == THRESHOLDS._replace(silent_s=1000.0)


# -- An episode ------------------------------------------------------------------------------------------------------


def test_an_episode_keeps_ten_packets_and_its_worst() -> None:
    made = Episode.of(Hit("late", 1, 10.0, 10.0, 3, worst=0.2))
    for number in range(2, 14):
        made.join(Episode.of(Hit("late", number, 9.0 + number, 9.5 + number, 4, worst=0.1 * (number == 5) + 0.15)))
    assert made.packets == [1, 2, 3, 4, 5, 6, 7, 8, 9, 13]
    assert (made.count, made.from_s, made.to_s, made.hit.packet, made.stations) == (13, 10, 22.5, 5, {3, 4})
    assert (made.station, made.who) == (None, "stations 3, 4")
    assert made.filter.startswith("frame.number >= 1 && frame.number <= 13 && (")
    assert made.text.endswith(" (13 times)")
    few = Episode.of(Hit("late", 1, 10.0, 10.0, 3))
    few.join(Episode.of(Hit("late", 3, 10.0, 10.0, 3, severity=NOTE)))
    assert (few.filter, few.station, few.severity) == ("frame.number in {1, 3}", 3, Severity.ERROR)
    before = Episode.of(Hit("late", 1000, 10.0, 10.0, 3, worst=0.3, severity=NOTE))
    before.join(Episode.of(Hit("late", 7, 10.0, 10.0, 3, worst=0.2)))
    assert (before.packets, before.hit.packet, before.severity) == ([7, 1000], 7, Severity.ERROR)


def test_an_episode_of_a_whole_capture_is_found_by_its_values() -> None:
    drift = Episode.of(Hit("drift", 0, 10.0, 20.0, 3, TORQUE))
    assert drift.filter == f'sis.parameter == "{TORQUE}" && (sis.talker == 3) && sis.value'
    drift.join(Episode.of(Hit("drift", 0, 10.0, 20.0, 8, TORQUE)))
    assert drift.filter == f'sis.parameter == "{TORQUE}" && (sis.talker == 3 || sis.talker == 8) && sis.value'
    assert drift.who == f"stations 3, 8 {TORQUE}"
    assert Episode.of(Hit("slower", 0, 10.0, 20.0, 3)).filter.startswith("frame.time_epoch >= 9.999998 && ")


def test_an_episode_for_programs() -> None:
    said = Episode.of(Hit("silent", 7, 0.0, 1e18, 4, "", "6 s")).as_json()
    assert (said["from"], said["to"]) == ("1970-01-01T00:00:00.000Z", None)  # no calendar has it
    assert (said["severity"], said["station"], said["stations"], said["packets"]) == ("error", 4, [4], [7])
    assert (said["parameter"], said["text"]) == (None, "Station silent, station 4: 6 s")
    assert said["do"] == "Check supply, address, baud rate and cable of this station."
    two = Episode.of(Hit("step", 9, 1.5, 2.25, 8, TORQUE, "70 %, usually 50", 20.0, LOOK))
    two.join(Episode.of(two.hit._replace(station=3, packet=8)))
    two.cause, two.outcome = "soon after the write of S-0-0080", "still so when last read"
    said = two.as_json()
    assert (said["kind"], said["severity"], said["station"], said["stations"]) == ("step", "warning", None, [3, 8])
    assert (said["from"], said["to"]) == ("1970-01-01T00:00:01.500Z", "1970-01-01T00:00:02.250Z")
    assert (said["count"], said["worst"], said["packets"], said["parameter"]) == (2, 20.0, [8, 9], TORQUE)
    about = "70 %, usually 50; soon after the write of S-0-0080; still so when last read"
    assert said["text"] == f"Step, stations 3, 8 {TORQUE}: {about} (2 times)"
    assert Episode.of(Hit("bus_silent", 7, 0.0, 1.0)).text == "Bus silent"
