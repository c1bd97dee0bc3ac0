# SPDX-License-Identifier: GPL-2.0-or-later
"""Each kind of episode: what provokes it, and what nearly does."""

from __future__ import annotations

import random
import tomllib
from collections.abc import Callable, Sequence
from operator import methodcaller as do
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from machines import (
    BEGIN_S,
    FAULT,
    LAPTOP,
    PANEL,
    PLC,
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

from sistap.dissected.accesses.access import Access
from sistap.dissected.episodes.masters import Masters
from sistap.dissected.episodes.rules import RULES, Severity
from sistap.dissected.packets.dissection import EXCEEDED, UNRESOLVED
from sistap.dissected.wireshark.rows import EVENT
from sistap.tap.line.settings import Flag
from sistap.tap.records.record import CLOCK_MOVED, KEPT, Event

Play = Callable[[Machine], object]

NOTE, LOOK, ERROR = Severity.NOTE, Severity.WARNING, Severity.ERROR
ESTOP, COMMAND_ACTIVE = 0xF4034, 0xC0300
TORQUE = "S-0-0084"
LIMIT = "S-0-0091"


class Case(NamedTuple):
    """What makes an episode of a kind that bad, and what does not."""

    kind: str
    severity: Severity
    happens: Play
    nearly: Play


def then(*steps: Play) -> Play:
    """Do one after the other."""
    return lambda machine: [step(machine) for step in steps]


def run(seconds: float, every_s: float = 2.0, *, has_panel: bool = True) -> Play:
    """Let the machine go on as usual."""

    def play(machine: Machine) -> None:
        machine.has_panel = has_panel
        machine.run(seconds, every_s=every_s)

    return play


def pause(seconds: float) -> Play:
    return do("pause", seconds)


def event(code: Event, text: str = "") -> Play:
    return do("event", code, text)


FURTHER = do("put", type=EVENT, event=int(Event.CAPTURE_STARTED), is_again=True)
APART = event(Event.CAPTURE_STARTED, f"a tap{KEPT}late")


def say(code: int, *stations: int) -> Play:
    """Let stations say a diagnosis for a minute."""

    def play(machine: Machine) -> None:
        before = machine.says.copy()
        machine.says |= dict.fromkeys(stations, code)
        machine.run(60)
        machine.says = before

    return then(run(60), play, run(60))


def told(ident: str, numbers: Sequence[float], *stations: int, every_s: float = 2.0, **more: Any) -> Play:
    """Let stations tell a number again and again."""

    def play(machine: Machine) -> None:
        for number in numbers:
            for station in stations or (3,):
                machine.exchange(access(station, ident, number, **more))
            machine.pause(every_s)

    return play


def about(middle: float, count: int, *, seed: int = 1, by: float = 1.0) -> list[float]:
    """Return numbers near one."""
    chance = random.Random(seed)
    return [chance.gauss(middle, by) for _ in range(count)]


def reaction(count: int = 1, **more: Any) -> Play:
    """Let station 5 answer so."""
    return then(*[do("exchange", station=5, **more)] * count)


def reads(*accesses: Access, every_s: float = 0.0) -> Play:
    return then(*(then(do("exchange", one), pause(every_s)) for one in accesses))


def writes(ident: str, *by: tuple[int | None, float], every_s: float = 60.0) -> Play:
    """Let masters write a parameter of station 5, one after the other."""
    return then(run(150), *(then(do("write", 5, ident, value, master=who), run(every_s)) for who, value in by))


def late(to_s: float, from_s: float = 0.010) -> Play:
    """Let a station answer slower and slower for an hour and a half."""
    times_s = [from_s + (to_s - from_s) * minute / 89 for minute in range(90)]
    return then(*(then(reaction(20, reaction=judged(time_s, 0.05, 0)), pause(59.4)) for time_s in times_s))


def behind(rpm: float, seconds: int, *, is_named: bool = False, usual: float = 1000.0) -> Play:
    """Let a speed be near its command for long, and then be another for a while. Nobody knows their scale; or somebody
    reads it between the two.
    """
    speeds = [usual] * 60 + [rpm] * seconds + [usual] * 10
    said = [undescribed(3, SPEED, round(one * 10_000).to_bytes(4, "little", signed=True)) for one in speeds]
    if is_named:
        said[60:] = [access(3, SPEED, one) for one in speeds[60:]]
    return then(do("write", 3, "S-0-0036", usual), reads(*said, every_s=0.97))


def flips(count: int, every_s: float = 10.0, rests: int = 8) -> Play:
    """Let a switch change so often; before and after, it rests for so many minutes."""
    states = [0] * rests, [number % 2 for number in range(1, count + 1)], [count % 2] * rests
    still, changing, last = ([access(5, "P-0-0222", str(one)) for one in part] for part in states)
    return then(reads(*still, every_s=60), reads(*changing, every_s=every_s), reads(*last, every_s=60))


def stamped(jump_s: float, since_s: float | None = 0.02) -> Play:
    """Let a time stamp be so far beside the measured interval."""
    return then(reaction(), do("put", since_s=since_s, after_s=0.02 + jump_s))


def talk(count: int) -> Play:
    return then(*[then(do("exchange", station=3), pause(1))] * count)


def panel_alone(count: int) -> Play:
    return then(*[then(do("exchange", station=3, master=PANEL), pause(1.5))] * count)


def silences(count: int, longer_s: float = 0.0, less: int = 0) -> Play:
    """Let the bus be silent in a rhythm; every second time for a little longer, after talking less."""
    odds = [number % 2 for number in range(count)]
    talks = (then(talk(60 - less * odd), pause(30 + longer_s * odd)) for odd in odds)
    return then(talk(90), *talks, talk(60))


def asked(master: int, *, before_s: float) -> Play:
    return then(run(before_s), do("exchange", station=3, master=master), run(60))


def bursts(count: int, **more: int) -> Play:
    """Let so many telegrams in a row be damaged."""
    return then(run(30), *[then(do("damage", **more), pause(1))] * count, run(30))


def damaged(count: int, telegrams: int) -> Play:
    """Let so many telegrams be damaged, each alone, among good ones."""
    good = then(*[do("exchange", station=3)] * (telegrams // count // 2 - 1))
    return then(*[then(do("damage"), good, pause(40))] * count)


def flagged(count: int, errors: Flag) -> Play:
    """Let so many telegrams have line errors."""
    one = then(do("ask", 3), do("put", type=1, errors=int(errors), after_s=0.01))
    return then(run(30), *[then(one, pause(1))] * count, run(30))


def unanswered(count: int, **more: Any) -> Play:
    """Let so many commands have no reaction, each answered when it is sent again."""
    return then(run(30), *[then(do("silent", 3, 1, **more), do("exchange", station=3))] * count, run(30))


BUSY = "0x8001 Service channel busy"
REFUSED = access(3, "S-0-4095", "", error="0x1001")
PAUSES = [then(run(30, has_panel=False), run(10))] * 3
KNOWN = access(5, LIMIT, 3000.0)
BIT = access(5, "S-0-0403", "0b0000000000000001"), access(5, "S-0-0403", "0b0000000000000000")
IN_LIMITS: dict[str, Any] = {"minimum": "-3000 rpm", "maximum": "3000 rpm"}
RISES = [35 + 22 * number / 120 + one for number, one in enumerate(about(0, 120, by=0.3))]
SLIGHT, CLEAR = (  # by 17 and 22 %
    [50 + by * number / 120 + one for number, one in enumerate(about(0, 120, by=0.3))] for by in (9.5, 12.5)
)
LEVELS_OUT = [57 - 22 * 0.9**number + one for number, one in enumerate(about(0, 120, by=0.3))]
RECIPE = ("P-0-0123", "P-0-0145", "P-0-0083", "S-0-0258")
PARTS = about(50, 100), about(70, 30, seed=2), about(50, 100, seed=3)
PART = [one for part in PARTS for one in part]
SMALL = [*about(50, 100, by=0.05), *about(52, 30, seed=2, by=0.05), *about(50, 100, seed=3, by=0.05)]
PEAK = [*about(50, 60), 90.0, *about(50, 60, seed=2)]


def firmware(*texts: str, **more: Any) -> Play:
    return then(*(reaction(service=0x00, columns={"sis.firmware": text}, **more) for text in texts))


def phases(*names: str) -> Play:
    return then(*(then(reaction(service=0x1D, phase=name), run(70)) for name in names))


def served(*services: int) -> Play:
    """Let two stations of three answer services."""
    return then(*(do("exchange", station=station, service=service) for station in (4, 5) for service in services))


def phase_after(seconds: float) -> Play:
    """Let a station be in another phase, so long after it was told to go on in its own."""
    return then(reaction(service=0x1D, phase="2"), pause(seconds - 0.03), reaction(service=0x12, phase="1"))


def limits(*limits_s: float | None) -> Play:
    return then(*(reaction(reaction=judged(0.01, limit_s, 0)) for limit_s in limits_s))


def sign(name: str, *, good: bool = True, count: int = 1) -> Play:
    """Let telegrams have what an expert item alone tells."""
    return reaction(count, signs=(name,), good=good)


def recipe(count: int) -> Play:
    known = reads(*(access(5, ident, 1.0, unit="mm") for ident in RECIPE))
    return then(run(150), known, *(do("write", 5, ident, 2.0, unit="mm") for ident in RECIPE[:count]), run(10))


def refused(*, is_known: bool, is_write: bool = False, code: str = "0x8004") -> Play:
    known = reads(access(5, "S-0-0383", 40.0, unit="degC")) if is_known else run(1)
    return then(known, do("refuse", 5, "S-0-0383", code, is_write=is_write))


def staircase(count: int) -> Play:
    """Let a number have so many levels; each is a little farther than the one before."""
    levels = (about(50 + 4 * number, 60 if number else 200, seed=number, by=0.1) for number in range(count))
    return told(TORQUE, [one for level in levels for one in level], unit="%")


def rising(count: int, unit: str) -> Play:
    """Let a number rise so often, each time after five minutes."""
    return told("P-0-0300", [20.0 + number // 10 for number in range(10 * count + 10)], every_s=30, unit=unit)


def falling_back(low: int) -> Play:
    """Let a number rise from 0 to 30, and again from another one on."""
    return told("P-0-0300", [float(one) for one in (*range(31), *range(low, low + 30)) for _ in range(4)], every_s=30)


def besides(count: int) -> Play:
    """Let a switch be beside its usual state so often, each time for one read; the last time, to the end."""
    return reads(*[access(5, "P-0-0222", one) for one in (["1"] * 9 + ["0"]) * count], every_s=20)


def rests(reads: int) -> Play:
    """Let the speeds be 0 for so many reads, 2 s apart; nothing else tells whether the machine runs."""
    runs = told(SPEED, about(1000, 30), 3, 4, 5)
    return then(runs, told(SPEED, [0.0] * reads, 3, 4, 5), runs)


def judging(kind: str, verdict: int) -> Play:
    said: dict[str, Any] = {kind: OVER._replace(verdict=verdict)}
    return reaction(is_doubtful=True, **said)


OVER = judged(0.06, 0.05, EXCEEDED)


CASES = (
    Case("foreign", ERROR, do("noise", 5), do("noise", 4)),
    Case("foreign", ERROR, do("noise", 50), then(do("noise", 50), reaction())),
    Case(
        *("bus_silent", ERROR),
        then(run(60, 0.5), pause(2.75), run(60, 0.5)),
        # run() ends 0.31 s after its last telegram
        then(run(60, 0.5), pause(2.65), run(60, 0.5)),
    ),
    Case(
        *("bus_silent", ERROR),
        then(talk(700), pause(340), talk(60)),
        then(talk(700), pause(370), talk(60)),  # the bus was heard for less than twice as long
    ),
    Case(
        *("bus_silent", ERROR),
        then(run(60), pause(3.8), run(60)),
        then(run(60), pause(3.4), run(60)),  # the usual silences last 1.81 s: this one, not thrice as long
    ),
    Case(
        "bus_silent", ERROR, then(talk(12), pause(2.5), talk(2)), then(talk(10), pause(2.5), talk(2))
    ),  # heard too little
    Case(
        *("bus_silent", ERROR),
        then(run(60, 0.5), pause(10), do("put")),
        then(run(60, 0.5), do("put", since_s=10.0)),  # of its line; the other one was heard
    ),
    Case(
        *("bus_silent", ERROR),
        then(talk(30), pause(2.5), talk(2)),
        then(talk(9), pause(2.5), talk(18), pause(2.5), talk(2)),  # it was so at the beginning
    ),
    Case("rhythm", NOTE, silences(12), silences(11)),
    Case(
        *("bus_silent", ERROR),
        then(talk(100), pause(40), talk(2)),
        then(talk(100), pause(600), event(Event.CAPTURE_STARTED), talk(10), pause(40), talk(2)),  # another bus, perhaps
    ),
    Case("rhythm", NOTE, silences(12, 2.5), silences(12, 4)),  # 8 and 13 % longer than the one before
    Case("rhythm", NOTE, silences(12), silences(12, 0, 12)),  # as long, but not as far apart
    Case("rhythm", NOTE, silences(12), silences(12, 4.12, 4)),  # as far apart, but not as long
    Case(
        *("unreadable", ERROR),
        then(run(30), do("noise", 20, every_s=0.2), run(30)),
        then(run(30), do("noise", 19, every_s=0.2), run(30)),
    ),
    Case(
        *("unreadable", ERROR),
        then(run(30), do("noise", 40, every_s=0.1), run(30)),
        then(run(30), do("noise", 29, every_s=0.1), run(30)),  # shorter than 3 s
    ),
    Case(
        *("adapter", ERROR),
        then(run(30), event(Event.ADAPTER_LOST, "gone"), pause(300), run(30)),
        then(run(30), event(Event.MARKER, "gone"), run(30)),
    ),
    Case(
        *("gap", LOOK),
        then(run(30), pause(60), event(Event.CAPTURE_STARTED), run(30)),
        then(run(30), pause(60), APART, run(30)),
    ),
    Case("estop", LOOK, say(ESTOP, 3, 4), say(ESTOP, 3)),
    Case("estop", LOOK, say(0xF434, 3, 4), say(FAULT, 3, 4)),
    Case(
        *("off", NOTE),
        then(run(120), pause(60), do("boot"), run(60)),
        then(run(120), pause(60), run(60)),
    ),
    Case(
        *("off", NOTE),
        then(run(120), do("exchange", station=3, service=0x00), pause(40), do("boot"), run(60)),
        then(run(120), do("boot"), run(30), pause(40), run(60)),
    ),
    Case("boot", NOTE, do("boot"), then(run(30), do("boot", 5), run(60))),
    Case("boot", NOTE, then(run(30), do("boot", 4, 5)), reaction(service=0x00)),
    Case("boot", NOTE, *(do("ask", station, service=0x1D, phase="2") for station in (199, 200))),  # one; a group
    # 0xCD switches a phase only if the user has set CLC's services: then it has one
    Case("boot", NOTE, then(run(30), do("boot", 4, 5, switch=0xCD)), then(run(30), served(0xCD))),
    Case("boot", NOTE, then(run(30), served(0x00, 0x03)), then(run(30), served(0x00))),  # somebody looks who is there
    Case("boot", NOTE, *(do("ask", 5, service=0x1D, phase="2", good=is_good) for is_good in (True, False))),
    # In a further file of a ring, and in one of the recorder, nobody knows who answered before
    Case("boot", NOTE, then(FURTHER, do("boot", 4, 5)), then(FURTHER, do("boot", 5))),
    Case("boot", NOTE, then(FURTHER, event(Event.CAPTURE_STARTED), do("boot", 5)), then(APART, do("boot", 5))),
    Case("boot", NOTE, then(do("boot", 5), run(2), APART), then(APART, event(Event.MARKER), do("boot", 5))),
    Case("stopped", NOTE, then(run(60), do("stop", 30), run(60)), say(STANDS, 3)),
    Case("stopped", NOTE, then(run(60), do("stop", 8), run(60)), then(run(60), do("stop", 4), run(60))),
    Case("stopped", NOTE, rests(9), rests(7)),  # an indexing axis rests for less than 15 s
    Case("silent", ERROR, then(run(30), do("silent", 4, 3)), then(run(30), do("silent", 4, 2, every_s=2))),
    Case("silent", ERROR, then(run(30), do("silent", 4, 3)), then(run(30), do("silent", 4, 3, every_s=0.49))),
    Case("silent", ERROR, then(run(30), do("silent", 4, 9)), do("silent", 9, 9)),  # it never answered
    Case("silent", LOOK, do("silent", 9, 3), do("silent", 9, 2)),
    Case("vanished", LOOK, then(run(420), run(70, has_panel=False)), then(run(420), run(50, has_panel=False))),
    Case("vanished", LOOK, then(run(420), run(80, has_panel=False)), then(run(380), run(80, has_panel=False))),
    Case(
        *("vanished", LOOK),
        then(run(420), *PAUSES, run(180, has_panel=False)),
        then(run(420), *PAUSES, run(140, has_panel=False)),  # it pauses for 32 s
    ),
    Case("vanished", LOOK, *(then(run(420), panel_alone(count)) for count in (55, 45))),  # others ask fifty times
    Case(
        *("vanished", LOOK),
        then(run(420), pause(300), run(60), run(80, has_panel=False)),
        then(run(420), pause(300), run(2, has_panel=False), pause(300), run(20, has_panel=False)),  # nobody can ask
    ),
    Case(
        *("restart", LOOK),
        then(run(30), do("silent", 4, 4), do("boot", 4), run(90)),
        then(run(30), do("boot", 4), run(90)),
    ),
    Case("fault", ERROR, say(FAULT, 3), say(COMMAND_ACTIVE, 3)),
    Case("fault", ERROR, say(0xF228, 3), say(0xA228, 3)),
    Case(
        *("fault", ERROR),
        reads(access(5, "S-0-0135", "0x2000", number=8192.0)),
        reads(access(5, "S-0-0135", "0xDFFF", number=57343.0)),
    ),
    Case(
        *("fault", ERROR),
        reads(access(5, "S-0-0011", "0b0000000000000100")),
        reads(access(5, "S-0-0011", "0b0000000000000000"), access(5, "S-0-0013", "0b0000000000000100")),
    ),
    Case("fault", ERROR, do("exchange", REFUSED, diagnosis(3, FAULT)), do("exchange", REFUSED)),  # a list of services
    Case("homing", ERROR, reads(*BIT), reads(BIT[1], BIT[1])),  # it was never referenced
    Case("system_error", ERROR, reaction(has_system_error=True), reaction(has_system_error=True, good=False)),
    Case("warning", LOOK, say(WARNING, 3), say(STANDS, 3)),
    Case("warning", LOOK, reads(access(5, "S-0-0012", "0b0100")), reads(access(5, "S-0-0012", "0b0000"))),
    Case("warning_bit", LOOK, sign("warning_bit"), sign("warning_bit", good=False)),
    Case("beyond", LOOK, told(SPEED, [3001], **IN_LIMITS), told(SPEED, [3000], **IN_LIMITS)),
    Case("beyond", LOOK, told(SPEED, [-3001], **IN_LIMITS), told(SPEED, [-3000], **IN_LIMITS)),
    Case("beyond", LOOK, told(SPEED, [3001], maximum="3000 rpm"), told(SPEED, [3001], minimum="3000 rpm")),
    Case("beyond", LOOK, told(SPEED, [3001], **IN_LIMITS), told(SPEED, [3001], minimum="9 %", maximum="-9 %")),
    Case("beyond", LOOK, told(SPEED, [3001], maximum="3e+03 rpm"), told(SPEED, [3001], maximum="3.402823e+38 rpm")),
    Case("apart", LOOK, behind(899, 65), behind(900, 65)),
    Case("apart", LOOK, behind(500, 23), behind(500, 20)),
    Case("apart", LOOK, behind(500, 65, is_named=True), behind(950, 65, is_named=True)),  # meanwhile somebody names it
    Case("chatter", LOOK, flips(6), flips(5)),
    Case("chatter", LOOK, flips(6, every_s=50), flips(6, every_s=70)),
    Case("chatter", LOOK, flips(6, every_s=50, rests=3), flips(6, every_s=50, rests=2)),  # it hardly rests
    Case("chatter", LOOK, *(then(reads(*[access(5, "P-0-0222", "1")] * 8, every_s=60), flips(one)) for one in (10, 7))),
    Case("error", LOOK, refused(is_known=True), refused(is_known=False)),
    Case("error", LOOK, refused(is_known=False, is_write=True), refused(is_known=False)),
    Case("busy", NOTE, refused(is_known=True, code=BUSY), refused(is_known=True)),
    Case("busy", LOOK, *(then(*[refused(is_known=True, code=BUSY)] * count) for count in (20, 19))),
    Case("stuck", LOOK, do("boot", stuck=4), do("boot")),
    Case("never", NOTE, refused(is_known=False), refused(is_known=True)),
    Case("slower", LOOK, late(0.030), late(0.014)),
    Case("slower", LOOK, late(0.0075, 0.002), late(0.006, 0.002)),  # less than 5 ms
    Case("slower", LOOK, late(0.069, 0.040), late(0.058, 0.040)),  # less than by half
    Case("drift", NOTE, told(TORQUE, RISES, every_s=30, unit="%"), told(TORQUE, LEVELS_OUT, every_s=30, unit="%")),
    Case("drift", NOTE, told(TORQUE, RISES, every_s=17, unit="%"), told(TORQUE, RISES, every_s=14, unit="%")),
    Case("drift", NOTE, told(TORQUE, CLEAR, every_s=30, unit="%"), told(TORQUE, SLIGHT, every_s=30, unit="%")),
    Case("drift", NOTE, rising(14, "h"), rising(21, "h")),  # a counter
    Case("drift", NOTE, rising(8, "h"), rising(7, "h")),  # a state
    Case("drift", NOTE, falling_back(12), falling_back(6)),  # a counter that begins anew
    *(Case("drift", NOTE, rising(30, unit), rising(30, "l")) for unit in ("°C", "°F", "degC", "deg F", "K")),
    Case("step", NOTE, told(TORQUE, PART, unit="%"), told(TORQUE, SMALL, unit="%")),  # 40 %; less than 5 %
    Case("step", NOTE, *(then(*(then(told(TORQUE, one, unit="%"), run(gap)) for one in PARTS)) for gap in (50, 90))),
    Case("step", NOTE, staircase(6), staircase(7)),  # what has many levels, changes
    Case("blip", NOTE, told(TORQUE, PEAK, 3, 4, 5, unit="%"), told(TORQUE, PEAK, 3, 4, unit="%")),
    Case(
        *("changed", NOTE),
        reads(*[access(5, "P-0-0222", "1")] * 20, access(5, "P-0-0222", "0"), every_s=10),
        reads(*[access(5, "P-0-0222", "1")] * 21, every_s=10),
    ),
    Case("changed", NOTE, told("P-0-0222", [1] * 7 + [0]), told("P-0-0222", [1] * 6 + [0])),  # a few numbers
    Case("changed", NOTE, reads(*(access(5, "P-0-0222", one) for one in "AB")), told("P-0-0222", [0, 1])),
    Case("changed", NOTE, *(told("P-0-0222", [0] * 40 + [*range(1, count)], every_s=60) for count in (8, 9))),
    Case("changed", NOTE, besides(12), besides(13)),  # that is usual
    Case(
        *("conflict", LOOK),
        writes("P-0-0123", (PLC, 12), (PANEL, 15), (PLC, 12), (PANEL, 15)),
        writes("P-0-0123", (PLC, 12), (PANEL, 15), (PLC, 12)),  # a recipe between two settings at the panel
    ),
    Case(
        *("conflict", LOOK),
        writes("P-0-0123", (PLC, 12), (PANEL, 15), (PLC, 12), (PANEL, 15)),
        writes("P-0-0123", (PLC, 12), (PANEL, 12), (PLC, 12), (PANEL, 12)),  # they agree
    ),
    Case(
        *("limit_write", LOOK),
        then(reads(KNOWN), writes(LIMIT, (PLC, 500))),
        then(reads(KNOWN), writes(LIMIT, (PLC, 3000))),
    ),
    Case("exchanged", LOOK, firmware("FWA-1", "FWA-2"), firmware("FWA-1", "FWA-1")),
    Case("exchanged", LOOK, firmware("FWA-1", "FWA-2"), then(firmware("FWA-1"), firmware("FWA-2", good=False))),
    Case(
        *("other", LOOK),
        then(writes("P-0-0123", (PLC, 12)), reads(*(access(5, "P-0-0123", value) for value in (12.0, 10.0)))),
        then(writes("P-0-0123", (PLC, 12)), reads(access(5, "P-0-0123", 11.9))),  # the drive rounds
    ),
    Case("write", LOOK, writes("P-0-0123", (LAPTOP, 12)), writes("P-0-0123", (PLC, 12))),
    Case("write", NOTE, writes("P-0-0123", (PLC, 12), (PLC, 13)), writes("P-0-0123", (PLC, 1), (PLC, 2), (PLC, 3))),
    Case("write", NOTE, writes("P-0-0123", (PLC, 12)), writes("S-0-0134", (PLC, 12))),  # the master control word
    Case("master", NOTE, asked(LAPTOP, before_s=122), asked(LAPTOP, before_s=100)),
    Case("master", NOTE, asked(LAPTOP, before_s=122), then(run(122), do("ask", PLC, LAPTOP), run(60))),  # a token
    Case("master", NOTE, *(then(talk(count), do("exchange", station=3, master=LAPTOP)) for count in (200, 199))),
    Case("phase", LOOK, phases("4", "2"), phases("4", "4")),
    Case("phase", LOOK, then(phases("2"), phase_after(11)), then(phases("2"), phase_after(9))),
    Case(
        *("rate", LOOK),
        then(reaction(), do("put", baud=19200)),
        then(reaction(), do("put", baud=19200, type=2, event=int(Event.CAPTURE_STARTED), is_again=True)),
    ),
    Case("limits", LOOK, limits(0.05, 0.04), limits(0.05, 0.05)),
    Case("recipe", NOTE, recipe(4), recipe(3)),
    Case("again", ERROR, sign("again", count=3), sign("again", count=2)),
    Case("again", ERROR, *(then(*[then(sign("again"), pause(120))] * count) for count in (3, 2))),
    Case("again", NOTE, sign("again"), then(do("damage"), do("answer", 3, signs=("again",)))),
    Case("late", ERROR, judging("reaction", EXCEEDED), judging("reaction", UNRESOLVED)),
    Case("interval", ERROR, judging("pause", EXCEEDED), judging("pause", UNRESOLVED)),
    Case(
        *("interval", ERROR),
        judging("pause", EXCEEDED),
        then(do("ask", 3), do("put", telegram(3, PLC, is_doubtful=True, pause=OVER), errors=int(Flag.LOST_BEFORE))),
    ),
    Case("cycle", ERROR, judging("cycle", EXCEEDED), judging("cycle", UNRESOLVED)),
    Case("unexpected", LOOK, sign("unexpected"), sign("unexpected", good=False)),
    Case("early", LOOK, sign("early"), sign("early", good=False)),
    Case("damaged", LOOK, bursts(5), bursts(4)),
    Case("damaged", LOOK, damaged(20, 20_000), damaged(20, 21_000)),  # 0.1 % of all
    Case("damaged", LOOK, damaged(20, 4000), damaged(19, 3800)),
    Case("damaged", ERROR, damaged(20, 1900), damaged(20, 2200)),  # 1 % of all
    Case("line_error", LOOK, flagged(5, Flag.CHARACTER_ERROR), flagged(4, Flag.CHARACTER_ERROR)),
    Case("lost", LOOK, flagged(5, Flag.LOST_BEFORE), flagged(4, Flag.LOST_BEFORE)),
    Case("unanswered", LOOK, unanswered(5), unanswered(4)),
    Case(
        *("unanswered", NOTE),
        then(run(30), do("silent", 3), run(30)),
        then(run(30), do("silent", 3), APART, run(30)),  # it is elsewhere
    ),
    Case("repeated", LOOK, unanswered(5, is_repeat=True), unanswered(4, is_repeat=True)),
    Case("clock", LOOK, stamped(0.6), stamped(0.4)),
    Case("clock", LOOK, stamped(-0.6), stamped(-0.4)),
    Case("clock", LOOK, stamped(-0.6, None), stamped(-0.4, None)),
    Case("clock", NOTE, event(Event.MARKER, CLOCK_MOVED.format(-37)), event(Event.MARKER, "a lorry passed")),
    Case("against", NOTE, sign("against"), sign("against", good=False)),
)


def of(play: Play, kind: str) -> list[Severity]:
    """Return how bad the episodes of a kind are that a machine has."""
    machine = Machine()
    play(machine)
    return [one.severity for one in machine.finish() if one.kind == kind]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.kind}-{case.severity.name}")
def test_what_is_an_episode_and_what_nearly_is(case: Case) -> None:
    assert max(of(case.happens, case.kind), default=None) == case.severity
    assert max(of(case.nearly, case.kind), default=0) < case.severity


FIRST = {case.kind: case for case in reversed(CASES)}
WHOLE = {"foreign", "vanished", "stopped", "slower", "drift"}  # no packet begins them


@pytest.mark.parametrize("kind", RULES)
def test_an_episode_leads_to_packets_within_it(kind: str) -> None:
    machine = Machine()
    FIRST[kind].happens(machine)
    for one in machine.finish():
        times_s = [machine.times_s[number] for number in one.packets]
        assert all(one.from_s - 0.001 <= time_s <= one.to_s + 0.001 for time_s in times_s), one
        assert bool(times_s) != (one.kind in WHOLE)


def test_a_write_is_refused_where_a_good_capture_refused_a_read() -> None:
    good = Machine()
    good.refuse(5, LIMIT, "0x1001")
    for is_write, kind in ((False, "never"), (True, "error")):
        machine = Machine(before=good.engine)
        machine.refuse(5, LIMIT, "0x1001", is_write=is_write)
        assert machine.told().kinds == [kind]


def test_what_only_a_recorder_asks_for_is_not_kept() -> None:
    """Memory is bounded, and a visitor may ask for hours."""
    masters = Masters()
    for number in range(400):
        masters.add(packet(BEGIN_S + number, telegram(LAPTOP if number > 250 else PLC, 3)))
    assert len(masters.begun()) == 1
    assert masters.begun() == []


def test_each_kind_has_a_case() -> None:
    assert {case.kind for case in CASES} == set(RULES)


def test_each_warning_and_error_of_the_dissector_has_its_kind_or_a_reason() -> None:
    file = Path(__file__).parents[2] / "plugin/protocol/experts.toml"
    items = tomllib.loads(file.read_text("utf-8"))
    bad = {name: one for name, one in items.items() if one["severity"] in ("warn", "error")}
    assert len(bad) > 30
    assert {
        name for name, one in bad.items() if one.get("episode", "") not in RULES and not one.get("no_episode")
    } == set()
