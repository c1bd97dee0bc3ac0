# SPDX-License-Identifier: GPL-2.0-or-later
"""What no state hides: the trouble of a drive beside it, before it or after it; and what is no trouble on any day."""

from __future__ import annotations

from operator import methodcaller as do
from typing import NamedTuple

import pytest
from machines import FAULT, LAPTOP, PANEL, RUNS, STANDS, Machine, access, diagnosis
from test_kinds import ESTOP, FURTHER, Play, event, pause, run, then

from sistap.dissected.episodes.rules import Severity
from sistap.tap.records.record import Event

STATUS = access(5, "S-0-0135", "0x2000", number=8192.0)  # shut down by an error
HOMED, NOT_HOMED = (access(3, "S-0-0403", f"0b{bit}", number=float(bit)) for bit in (1, 0))
SET = access(5, "S-0-0036", 1000.0)
TEXT = access(4, "S-0-0095", '"F2028 Excessive deviation"', master=PANEL)


def says(code: int, *stations: int, turns: float = 1000.0) -> Play:
    """Let stations say a diagnosis from now on."""

    def play(machine: Machine) -> None:
        machine.says |= dict.fromkeys(stations, code)
        machine.turns |= dict.fromkeys(stations, turns)

    return play


def dead(station: int, rounds: int, every_s: float = 2.0) -> Play:
    """Let one station be silent while the others answer."""

    def play(machine: Machine) -> None:
        before = machine.drives
        machine.drives = tuple(one for one in before if one != station)
        for _ in range(rounds):
            machine.run(every_s)
            machine.silent(station)
        machine.drives = before

    return play


def switched(phase: str, **more: int) -> Play:
    """Let somebody switch all drives to a phase."""
    return then(*(do("exchange", station=one, service=0x1D, phase=phase, **more) for one in (3, 4, 5)))


def without_supply(*stations: int) -> Play:
    """Let stations be silent for 10 s, while another one answers."""
    return then(*[then(*(do("silent", one, every_s=0.2) for one in stations), do("exchange", diagnosis(6, RUNS)))] * 20)


def not_on(rounds: int) -> Play:
    """Let a master ask three drives that are not on yet."""
    return then(*[then(*(do("silent", one, every_s=0.3) for one in (3, 4, 5)))] * rounds)


MORNING = then(not_on(20), do("boot"), run(300))  # the drives come on after the control


class Case(NamedTuple):
    """What happens to a machine of drives 3, 4, 5, and what is said of it."""

    name: str
    play: Play
    verdict: str
    said: str
    of: tuple[int, ...] = (3, 4, 5)


CASES = (
    Case(
        "a supply fails for seconds",
        then(run(300), without_supply(3, 4), do("boot", 3, 4), run(300)),
        *("NOT OK", "station silent (stations 3, 4)", (3, 4, 5, 6)),
    ),
    Case("a morning", MORNING, "OK", "Silent: nothing"),
    Case(
        "a panel is on long before the drives",
        then(not_on(100), do("boot"), run(300)),
        *("OK", "Silent: nothing"),
    ),
    Case(
        "parameter mode for some minutes",
        then(run(300), switched("2"), run(180), switched("4"), run(300)),
        *("OK", "Changed: nothing"),
    ),
    Case(
        "each phase of an initialisation lasts for minutes",
        then(run(300), switched("0"), run(90), switched("2"), run(180), switched("3"), run(90), switched("4"), run(60)),
        *("OK", "Changed: nothing"),
    ),
    Case(
        "a laptop leaves phase 2, and the machine is switched off and on",
        then(run(300), switched("2", master=LAPTOP), run(300), pause(600), do("boot"), run(300)),
        *("OK, 3 things to look at", "station 5 phase unknown -> 2"),
    ),
    Case(
        "a laptop switches all drives to phase 2",
        then(run(300), switched("2", master=LAPTOP)),
        *("OK, 3 things to look at", "station 5 phase unknown -> 2"),
    ),
    Case(
        "a drive is initialised for the first time, another one is silent",
        then(run(20), do("boot", 5), dead(4, 8, 1), run(60)),
        *("NOT OK", "station silent (station 4)", (3, 4)),
    ),
    Case(
        "one drive stays shut down after an emergency stop of two others",
        then(run(300), says(ESTOP, 3, 4), run(30), says(RUNS, 3, 4), do("run", 100, STATUS)),
        *("NOT OK", "now fault shut down by an error: drive status bit 13 (station 5)"),
    ),
    Case(
        "one drive stays in the fault of an emergency stop that is over",
        then(run(300), says(ESTOP, 3, 4, 5), run(30), says(RUNS, 3, 4), run(300)),
        *("NOT OK", "now fault F4034 (station 5)"),
    ),
    Case(
        "another drive is silent while two are initialised for the first time",
        then(run(100), do("boot", 5, 6), dead(4, 8, 1), run(60)),
        *("NOT OK", "station silent (station 4)", (3, 4)),
    ),
    Case(
        "a drive comes up by itself after two are initialised for the first time",
        then(run(60), do("boot", 4, 5), do("silent", 6, 10, every_s=1.5), do("exchange", station=6, service=0x00)),
        *("OK", "Silent: nothing", (3,)),
    ),
    Case(
        "a drive is silent from the beginning until somebody switches off and on",
        then(dead(5, 100), pause(30), do("boot"), run(300)),
        *("NOT OK", "station silent (station 5)"),
    ),
    Case(
        "a drive is silent from the beginning until it alone is initialised",
        then(dead(5, 100), do("boot", 5), run(300)),
        *("NOT OK", "station silent (station 5)"),
    ),
    Case(
        "a drive comes on later than the others",
        then(dead(5, 10), pause(20), do("boot"), run(300)),
        *("OK", "Silent: nothing"),
    ),
    Case(
        "a station that is not there, before a start",
        then(*[then(do("run", 2), do("silent", 9))] * 100, pause(300), do("boot"), run(30)),
        *("OK, 1 thing to look at", "station 9 never answered 100 commands"),
    ),
    Case(
        "a station that is not there, during a start",
        then(do("silent", 9, 30, every_s=1.0), do("boot"), run(30)),
        *("OK", "Silent: nothing"),
    ),
    Case(
        "a capture ends just after a pause of the bus",
        then(do("run", 10, every_s=1), pause(20), *(do("silent", 5, 4) for _ in range(3))),
        *("OK", "Silent: nothing"),
    ),
    Case(
        "a capture ends while a drive is not up yet",
        then(run(300), pause(300), do("boot", 3, 4), dead(5, 5)),
        *("OK", "Silent: nothing"),
    ),
    Case(
        "one drive is always on, another one is initialised first",
        then(run(120), pause(30), do("boot", 4), run(120)),
        *("OK", "machine off and on again", (3,)),
    ),
    Case(
        "a night is quiet, and the capture began before it",
        then(FURTHER, pause(7200), do("boot"), run(120)),
        *("OK", "initialised at 08:00:00: stations 3, 4, 5"),
    ),
    Case(
        "one drive does not come back after the machine was off",
        then(run(300), pause(300), do("boot", 3, 4), dead(5, 20)),
        *("NOT OK", "now station silent (station 5)"),
    ),
    Case(
        "one drive falls silent after a pause of the bus",
        then(do("run", 10, every_s=1), pause(20), dead(5, 20)),
        *("NOT OK", "now station silent (station 5)"),
    ),
    Case(
        "a second drive behind a station stays shut down",
        then(
            do("run", 20, diagnosis("5/1", FAULT)),
            do("run", 50, diagnosis("5/1", RUNS), access("5/2", "S-0-0135", "0x2000", number=8192.0)),
        ),
        *("NOT OK", "now fault shut down by an error"),
    ),
    Case(
        "somebody switches off because a drive was silent",
        then(run(300), dead(4, 10, 1.5), run(20), pause(30), do("boot"), run(300)),
        *("NOT OK", "station silent (station 4)"),
    ),
    Case(
        "somebody switches off while a drive is silent",
        then(run(300), dead(4, 20), pause(30), do("boot"), run(300)),
        *("NOT OK", "station silent (station 4)"),
    ),
    Case(
        "somebody switches off while a drive is silent and the others have a fault",
        then(run(300), says(FAULT, 3, 5), dead(4, 20), pause(30), says(RUNS, 3, 5), do("boot"), run(300)),
        *("NOT OK", "station silent (station 4)"),
    ),
    Case(
        "somebody switches off for the second time while a drive is silent",
        then(run(300), pause(300), do("boot"), run(300), dead(4, 20), pause(30), do("boot"), run(300)),
        *("NOT OK", "station silent (station 4)"),
    ),
    Case(
        "the drives are off before the control",  # every evening
        then(run(300), *(do("silent", one, 5, every_s=0.3) for one in (3, 4, 5)), pause(3600), do("boot"), run(300)),
        *("OK", "Silent: nothing"),
    ),
    Case(
        "a drive turns too slowly until the machine stops",
        then(
            do("run", 120, SET),
            says(RUNS, 5, turns=500),
            do("run", 40, SET),
            says(STANDS, 3, 4, 5, turns=0),
            run(600),
        ),
        *("OK, 1 thing to look at", "station 5 S-0-0040 50 % below S-0-0036"),
    ),
    Case(
        "a heavy axis coasts",
        then(
            *(
                then(
                    says(RUNS, 5, turns=1000 * (1 - part / 23)),
                    do("run", 2, access(5, "S-0-0036", 0.0 if part else 1000.0)),
                )
                for part in [*[0] * 150, *range(1, 23)]
            ),
            says(STANDS, 3, 4, 5, turns=0),
            do("run", 600, access(5, "S-0-0036", 0.0)),
        ),
        *("OK", "Drives: nothing"),
    ),
    Case(
        "an axis runs for an hour without a reference",
        then(do("run", 60, HOMED), do("run", 3600, NOT_HOMED), pause(1800), do("boot"), do("run", 300, HOMED)),
        *("NOT OK", "position not referenced (station 3)"),
    ),
    Case(
        "an axis is homed after the machine was off",
        then(do("run", 300, HOMED), pause(1800), do("boot"), do("run", 60, NOT_HOMED), do("run", 300, HOMED)),
        *("OK", "Drives: nothing"),
    ),
    Case(
        "an axis is not homed after the machine was off",
        then(do("run", 300, HOMED), pause(1800), do("boot"), do("run", 300, NOT_HOMED)),
        *("NOT OK", "now position not referenced (station 3)"),
    ),
    Case(
        "a fault that a panel read as text, and the control sees go",
        then(run(300), says(FAULT, 4), run(10), do("exchange", TEXT, master=PANEL), says(RUNS, 4), run(300)),
        *("NOT OK", "NOT OK, 06:00:00 to 06:10:10: fault F2028 (station 4)."),
    ),
    Case(
        "a fault beside a text without a code",
        then(run(300), says(FAULT, 4), run(10), do("exchange", access(4, "S-0-0095", '"Drive not ready"'))),
        *("NOT OK", "now fault F2028 (station 4)"),
    ),
    Case(
        "a fault in number and text that lasts",
        then(run(300), says(FAULT, 4), run(10), do("exchange", TEXT, master=PANEL), run(60)),
        *("NOT OK", "now fault F2028 (station 4)"),
    ),
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name.replace(" ", "_"))
def test_what_is_said(case: Case) -> None:
    machine = Machine(*case.of)
    case.play(machine)
    told = machine.told()
    assert (told.verdict, case.said in told.text) == (case.verdict, True), told.text


@pytest.fixture(scope="module")
def good() -> Machine:
    machine = Machine()
    machine.run(600)
    machine.finish()
    return machine


@pytest.mark.parametrize(
    ("play", "verdict", "said"),
    [
        (dead(5, 100), "NOT OK", "now station silent (station 5)"),
        (MORNING, "OK", "Silent: nothing"),
        (do("run", 600, every_s=2.0), "OK", "Silent: nothing"),
    ],
)
def test_who_answered_in_a_good_capture_is_there(good: Machine, play: Play, verdict: str, said: str) -> None:
    machine = Machine(before=good.engine)
    play(machine)
    told = machine.told()
    assert (told.verdict, said in told.text) == (verdict, True), told.text


@pytest.mark.parametrize(("seconds", "count"), [(70, 1), (50, 0)])
def test_a_master_that_asked_in_a_good_capture_is_missed(good: Machine, seconds: float, count: int) -> None:
    machine = Machine(before=good.engine)
    run(seconds, has_panel=False)(machine)
    gone = machine.told().of("vanished")
    assert all(one.from_s == machine.begin_s + 0.02 for one in gone)
    assert [one.detail for one in gone] == ["master 2 asks nothing, but did in the good capture"] * count


def test_a_visitor_of_a_good_capture_is_not_missed() -> None:
    """Who left before its end, or asked little."""
    good = Machine()
    then(run(420), run(100, has_panel=False), *[do("exchange", station=3, master=LAPTOP)] * 50)(good)
    good.finish()
    machine = Machine(before=good.engine)
    run(600, has_panel=False)(machine)
    assert not machine.told().of("vanished")


def test_a_second_bus_is_not_that_of_the_good_capture(good: Machine) -> None:
    """Nobody knows what is usual there, also where a capture ends."""
    one, other = Machine(before=good.engine, interface="a"), Machine(3, 4, interface="b")
    other.engine = one.engine
    run(300)(one)
    then(run(300, has_panel=False), dead(5, 100), event(Event.CAPTURE_STARTED))(other)
    told = other.told()
    assert not told.of("vanished")
    assert [one.severity for one in told.of("silent")] == [Severity.WARNING]
