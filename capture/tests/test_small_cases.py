# SPDX-License-Identifier: GPL-2.0-or-later
"""Small cases of a machine, and what a person reads about them: never a false OK, never a false alarm."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime

import pytest
from machines import (
    FAULT,
    LAPTOP,
    PANEL,
    PLC,
    RUNS,
    SPEED,
    WARNING,
    Machine,
    access,
    telegram,
    undescribed,
)
from portable import posix, zone

from sistap.dissected.episodes.engine import Engine
from sistap.dissected.episodes.lines import clock_of
from sistap.dissected.wireshark.rows import OTHER
from sistap.tap.line.settings import Flag
from sistap.tap.records.record import Event


@pytest.fixture(autouse=True)
def _in_utc(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Write all times in UTC."""
    yield from zone(monkeypatch, "UTC")


def at(machine: Machine) -> str:
    """Return what the clock shows."""
    return datetime.fromtimestamp(machine.now_s, UTC).strftime("%H:%M:%S")


@pytest.mark.parametrize("is_described", [True, False])
@pytest.mark.parametrize(("code", "shown"), [(FAULT, "F2028"), (0xF228, "F228"), (0x050F0200, "50F0200")])
def test_a_fault_is_one_whether_or_not_anybody_describes_it(code: int, shown: str, *, is_described: bool) -> None:
    """Codes of IndraDrive, of ECODRIVE, and of SERCOS III."""
    machine = Machine(is_described=is_described)
    machine.run(300)
    begun = at(machine)
    machine.says[4] = code
    machine.run(240)
    ended = at(machine)
    machine.says[4] = RUNS
    machine.run(300)
    told = machine.told()
    assert told.lines[0].startswith("NOT OK, ")
    assert told.lines[2].startswith(f"Drives: station 4 fault {shown} {begun} to {ended}")
    assert told.kinds == ["fault"]


def test_a_fault_that_is_still_there_says_so() -> None:
    machine = Machine()
    machine.run(300)
    machine.says[4] = FAULT
    machine.run(60)
    assert machine.told().lines[2].endswith(", still so when last read.")


def test_two_masters_that_write_against_each_other_are_told_with_both_values() -> None:
    machine = Machine()
    machine.run(150)
    for _ in range(5):
        machine.write(5, "P-0-0123", 1200.0)
        machine.run(60)
        machine.write(5, "P-0-0123", 1500.0, master=PANEL)
        machine.run(60)
    machine.write(5, "P-0-0123", 1200.0)
    told = machine.told()
    assert told.verdict == "OK, 1 thing to look at"
    (conflict,) = told.of("conflict")
    assert conflict.who == "station 5 P-0-0123" and conflict.count == 8  # the first three begin it
    assert told.lines[3].startswith("Changed: station 5 P-0-0123 is written by two masters ")
    assert told.lines[3].endswith("master 1 1200.0 rpm, master 2 1500.0 rpm (8 times), at the end 1200 rpm.")


def test_a_master_that_repeats_too_early() -> None:
    machine = Machine()
    machine.run(150)
    for _ in range(30):
        machine.silent(3, 1, every_s=2)
        machine.ask(3, is_repeat=True, signs=("early",))
        machine.answer(3)
    machine.run(60)
    told = machine.told()
    assert told.verdict == "OK, 1 thing to look at"
    assert told.lines[4].startswith("Limits: 30 commands sent again before TrS was over (station 3, ")
    assert told.kinds == ["early"]  # and not that there were repeats, too


def test_two_stations_at_one_address() -> None:
    machine = Machine()
    machine.run(150)
    for _ in range(20):
        machine.exchange(station=4)
        machine.answer(4, signs=("again",))
    told = machine.told()
    assert told.verdict == "NOT OK"
    assert told.lines[4].startswith("Limits: 20 second answers: two stations at one address? (station 4, ")


def test_a_break_is_no_news() -> None:
    machine = Machine()
    machine.run(400)
    begun = at(machine)
    machine.stop(180)
    ended = at(machine)
    machine.run(300)
    told = machine.told()
    assert told.verdict == "OK" and told.kinds == ["stopped"]
    assert told.lines[0].endswith(f". machine stopped {begun} to {ended}.")


def test_a_broadcast_that_is_answered() -> None:
    machine = Machine()
    machine.run(150)
    for _ in range(3):
        machine.ask(255, service=0x03)
        machine.answer(4, signs=("unexpected",))
        machine.run(60)
    told = machine.told()
    assert told.verdict == "OK, 1 thing to look at"
    assert told.lines[4].startswith("Limits: 3 answers to broadcasts (station 4, ")


def test_a_panel_that_crashes() -> None:
    machine = Machine()
    machine.run(420)
    gone = machine.now_s
    machine.has_panel = False
    machine.run(300)
    told = machine.told()
    assert told.verdict == "OK, 1 thing to look at"
    (vanished,) = told.of("vanished")
    assert vanished.from_s == pytest.approx(gone, abs=3)
    assert told.lines[1].startswith("Silent: master 2 asks nothing any more, others do")


def test_damage_of_two_telegrams_with_line_errors_is_two_notes() -> None:
    """What is left of them is no telegram: the station that was asked is known, no other one."""
    machine = Machine()
    machine.run(150)
    for _ in range(2):
        machine.put(type=OTHER, errors=int(Flag.CHARACTER_ERROR), after_s=0.02)
        machine.run(60)
    told = machine.told()
    assert told.verdict == "OK"
    assert told.lines[4].startswith("Limits: 2 line errors (")
    assert "not damaged" not in told.text and not told.episodes[0].stations


def test_a_lunch_without_power() -> None:
    machine = Machine()
    machine.boot()
    machine.run(300)
    off = machine.now_s
    machine.pause(300)
    machine.boot()
    machine.run(300)
    told = machine.told()
    assert told.verdict == "OK" and told.kinds == ["boot", "off"]
    assert told.of("off")[0].from_s == pytest.approx(off, abs=3)
    assert "machine off and on again" in told.lines[0] and "stations 3, 4, 5, ready 5 s later" in told.lines[0]


def test_a_warning_beside_three_breaks() -> None:
    machine = Machine()
    for _ in range(3):
        machine.run(280)
        machine.stop(120)
    machine.run(200)
    begun = at(machine)
    machine.says[3] = WARNING
    machine.run(300)
    ended = at(machine)
    machine.says[3] = RUNS
    machine.run(100)
    told = machine.told()
    assert told.verdict == "OK, 1 thing to look at"
    assert told.lines[2] == f"Drives: station 3 warning E2051 {begun} to {ended}."
    assert told.kinds == ["stopped"] * 3 + ["warning"]


def test_another_firmware_after_a_restart() -> None:
    machine = Machine()
    machine.exchange(station=5, service=0x00, columns={"sis.firmware": "FWA-ECODR3-SMT-02VRS-MS"})
    machine.run(300)
    machine.exchange(station=5, service=0x00, columns={"sis.firmware": "FWA-ECODR3-SMT-03VRS-MS"})
    machine.run(60)
    told = machine.told()
    assert told.verdict == "OK, 1 thing to look at"
    assert told.lines[3].startswith("Changed: station 5 is another device since ")
    assert "firmware FWA-ECODR3-SMT-02VRS-MS -> FWA-ECODR3-SMT-03VRS-MS" in told.lines[3]


def test_damaged_reactions_are_no_error_reactions() -> None:
    """Of 30, the status byte is hit: no station has refused anything, and no other station is there."""
    machine = Machine()
    machine.run(150)
    for _ in range(30):
        machine.ask(4)
        hit = telegram(88, PLC, is_reaction=True, good=False, is_refusal=True, status=0x80, has_system_error=True)
        machine.put(hit, after_s=0.01)
        machine.run(40)
    told = machine.told()
    assert set(told.kinds) == {"damaged"}
    assert {station for one in told.episodes for station in one.stations} == {4}
    assert "30 damaged telegrams (station 4" in told.lines[4]


def test_never_ok_beside_a_station_that_never_answered() -> None:
    machine = Machine()
    for _ in range(33):
        machine.silent(9, 3)
        machine.run(10)
    told = machine.told()
    assert told.verdict == "OK, 1 thing to look at"
    assert told.lines[1] == "Silent: station 9 never answered 99 commands."


@pytest.fixture
def _in_zone(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> Iterator[None]:
    """Write all times as in Berlin, or in another zone."""
    yield from zone(monkeypatch, getattr(request, "param", "Europe/Berlin"))


def utc(text: str) -> float:
    return datetime.fromisoformat(f"{text}+00:00").timestamp()


@posix("it knows no zones by name")
@pytest.mark.usefixtures("_in_zone")
def test_the_end_of_summer_time_does_not_look_backwards() -> None:
    machine = Machine()
    machine.now_s = machine.begin_s = utc("2026-10-25T00:55:00")
    machine.run(600)
    machine.silent(4, 10)
    machine.run(289)
    told = machine.told()
    assert told.lines[0].startswith("NOT OK, 02:55:00 UTC+2 to 02:09:")
    assert told.lines[0].partition(": ")[0].endswith(" UTC+1")
    assert told.lines[1].startswith("Silent: station 4 from 02:05:00 UTC+1 (")


@posix("it knows no zones by name")
@pytest.mark.parametrize(
    ("begin", "end", "said"),
    [
        ("2026-10-25T00:30:00", "2026-10-25T00:59:59", "02:30:00 to 02:59:59"),
        ("2026-10-25T00:30:00", "2026-10-25T01:30:00", "02:30:00 UTC+2 to 02:30:00 UTC+1"),
        ("2026-03-29T00:30:00", "2026-03-29T01:30:00", "01:30:00 UTC+1 to 03:30:00 UTC+2"),
        ("2026-11-24T22:30:00", "2026-11-24T23:30:00", "2026-11-24 23:30:00 to 2026-11-25 00:30:00"),
    ],
)
@pytest.mark.usefixtures("_in_zone")
def test_the_zone_is_said_where_it_changes(begin: str, end: str, said: str) -> None:
    begin_s, end_s = utc(begin), utc(end)
    clock = clock_of(begin_s, end_s)
    assert f"{clock(begin_s)} to {clock(end_s)}" == said


@posix("it knows no zones by name")
@pytest.mark.parametrize(
    ("_in_zone", "begin", "said"),
    [
        ("Europe/London", "2026-10-25T00:30:00", "01:30:00 UTC+1 to 01:30:00 UTC+0"),
        ("America/St_Johns", "2026-11-01T04:00:00", "01:30:00 UTC-2:30 to 01:30:00 UTC-3:30"),
    ],
    indirect=["_in_zone"],
)
@pytest.mark.usefixtures("_in_zone")
def test_each_zone_is_said_as_it_differs(begin: str, said: str) -> None:
    begin_s = utc(begin)
    clock = clock_of(begin_s, begin_s + 3600)
    assert f"{clock(begin_s)} to {clock(begin_s + 3600)}" == said


def test_a_gap_over_midnight_has_dates() -> None:
    machine = Machine()
    machine.now_s = machine.begin_s = datetime(2026, 11, 24, 23, 0, tzinfo=UTC).timestamp()
    machine.run(3000)
    machine.pause(1200)
    machine.event(Event.CAPTURE_STARTED)
    machine.run(300)
    (line, *_) = machine.told().lines
    assert "nothing was captured 2026-11-24 23:49:58 to 2026-11-25 00:10:00" in line


# Several buses and ports.


class Duplex(Machine):
    """A tap that hears the two directions at an interface each."""

    def put(self, *telegrams: object, **more: object) -> None:
        is_reaction = any(one.is_reaction for one in telegrams)  # type: ignore[attr-defined]
        more |= {"interface": "RX", "line": 2} if is_reaction else {"interface": "TX", "line": 1}
        super().put(*telegrams, **more)  # type: ignore[arg-type]


def test_two_directions_are_one_bus() -> None:
    """Two lines of a log, one write: it was said to be by a new master."""
    machine = Duplex()
    machine.write(5, "P-0-0123", 12.0)
    told = machine.told()
    assert told.worse == [] and "new" not in told.text
    machine = Duplex()
    machine.run(150)
    for ident in ("P-0-0123", "P-0-0145", "P-0-0083", "S-0-0258"):
        machine.write(5, ident, 12.0)
    machine.run(60)
    machine.write(5, "P-0-0123", 13.0, master=LAPTOP)
    told = machine.told()
    assert told.kinds == ["recipe", "master", "write"]
    assert told.lines[3].startswith("Changed: new master 127 wrote station 5 P-0-0123 12 -> 13 rpm at ")


def test_a_silence_of_two_directions_has_its_station() -> None:
    machine = Duplex()
    machine.run(60)
    machine.silent(4, 4)
    machine.run(60)
    (silent,) = machine.told().episodes
    assert (silent.kind, silent.stations) == ("silent", {4})


def test_a_command_that_perhaps_nobody_took_is_lost_in_two_directions_too() -> None:
    machine = Duplex()
    machine.write(3, "S-0-0036", 1000.0, port="RX")
    for rpm in [1000.0] * 60 + [500.0] * 30:
        if rpm < 1000:
            machine.silent(3, columns={"sis.parameter": "S-0-0036", "sis.service": "0x1f"})
        machine.exchange(access(3, SPEED, rpm, port="RX"))
        machine.pause(1)
    assert machine.told().of("apart") == []


def test_each_port_is_a_bus_of_its_own() -> None:
    engine = Engine()
    first, second = (Machine(3, 4, 5, interface=name) for name in "ab")
    first.engine = second.engine = engine
    for machine in (first, second):
        machine.run(150)
    first.exchange(station=3, master=LAPTOP)
    second.says[3] = FAULT
    second.run(20)
    found = {(one.kind, one.hit.port) for one in engine.finish()}
    assert found == {("master", "a"), ("fault", "b")}


def test_limits_and_states_of_one_port_explain_nothing_of_another() -> None:
    engine = Engine()
    stopping, damaged = (Machine(3, 4, 5, interface=name) for name in "ab")
    stopping.engine = damaged.engine = engine
    for machine in (stopping, damaged):
        machine.run(120)
    stopping.noise(40, every_s=0.2)
    damaged.damage(3)
    for machine in (stopping, damaged):
        machine.run(60)
    assert sorted((one.kind, one.hit.port) for one in engine.finish()) == [("damaged", "b"), ("unreadable", "a")]


def test_what_nobody_describes_is_compared_and_counted() -> None:
    machine = Machine(is_described=False)
    for value in (3000, 3000, 3000, 500, 3000):
        machine.run(60, *(undescribed(5, "P-0-4095", value.to_bytes(2, "little")) for _ in range(2)))
    told = machine.told()
    assert "station 5 P-0-4095 3000 -> 500 raw" in told.lines[2]
    assert machine.engine.undescribed == 1 + 3  # and the speeds
    machine.run(60, access(5, "P-0-4095", 3000), access(5, "P-0-4096", 1))
    assert machine.engine.undescribed == 3
