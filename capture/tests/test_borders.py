# SPDX-License-Identifier: GPL-2.0-or-later
"""What is nearly something else: each border that decides what a person reads of a machine, from both sides."""

from __future__ import annotations

from operator import methodcaller as do
from typing import Any

import pytest
from machines import (
    BEGIN_S,
    FAULT,
    LAPTOP,
    PLC,
    RUNS,
    SPEED,
    STANDS,
    Machine,
    Told,
    access,
    diagnosis,
    judged,
    telegram,
    undescribed,
)
from test_kinds import (
    LIMIT,
    RISES,
    TORQUE,
    Play,
    about,
    event,
    firmware,
    limits,
    pause,
    reaction,
    reads,
    run,
    then,
    told,
    writes,
)

from sistap.dissected.episodes.engine import Engine
from sistap.dissected.episodes.episode import Episode, Hit
from sistap.dissected.episodes.lines import lines
from sistap.dissected.packets.dissection import EXCEEDED, UNRESOLVED
from sistap.dissected.wireshark.rows import EVENT
from sistap.tap.line.settings import Flag
from sistap.tap.records.record import KEPT, Event
from sistap.tap.sis.faults import FAULTS

NEXT_FILE = event(Event.CAPTURE_STARTED, f"a tap{KEPT}late")


def of(play: Play, *drives: int) -> Told:
    machine = Machine(*drives)
    play(machine)
    return machine.told()


def details(play: Play, kind: str) -> list[str]:
    """Return what is said of a kind: at whom, and what."""
    return [f"{one.who}: {one.detail}" for one in of(play).of(kind)]


def test_a_device_is_exchanged_once() -> None:
    assert details(firmware("FWA-1", "FWA-2", "FWA-2"), "exchanged") == ["station 5: firmware FWA-1 -> FWA-2"]


def test_a_pause_in_a_command_is_one_of_the_master() -> None:
    """TzA is between the characters of whoever talks."""
    slow = telegram(PLC, 4, is_doubtful=True, pause=judged(0.003, 0.002, EXCEEDED), pause_position=7)
    assert details(do("put", slow), "interval") == ["station 1: 3.000 ms before character 7, TzA 2 ms"]


@pytest.mark.parametrize("flag", [0, Flag.LOST_BEFORE])
def test_a_pause_in_which_characters_were_lost_is_none(flag: int) -> None:
    times = {"pause": judged(0.003, 0.002, EXCEEDED), "reaction": judged(0.06, 0.05, EXCEEDED)}
    found = of(do("put", telegram(5, PLC, is_reaction=True, is_doubtful=True, **times), errors=int(flag)))
    assert (len(found.of("interval")), len(found.of("late"))) == (flag == 0, 1)


def test_refusals_are_told_by_code_service_and_access() -> None:
    known = reads(access(5, LIMIT, 3000.0))
    codes = [
        do("refuse", 5, LIMIT, code, is_write=is_write)
        for code, is_write in (("0x8004", False), ("0x8004", True), ("0x7009", True))
    ]
    services = [reaction(service=service, is_refusal=True, status=0xF0) for service in (0x03, 0x0F)]
    assert details(then(known, *codes, *services), "error") == [
        f"station 5 {LIMIT}: 0x8004",
        f"station 5 {LIMIT}: write: 0x8004",
        f"station 5 {LIMIT}: write: 0x7009",
        "station 5: Initialization of the SIS communication, status 0xf0",
        "station 5: Token passing, status 0xf0",
    ]


def test_what_perhaps_was_late_is_counted_beside_what_was() -> None:
    late = [reaction(is_doubtful=True, reaction=judged(0.06, 0.05, verdict)) for verdict in (EXCEEDED, UNRESOLVED)]
    assert "1 reaction later than TrS, perhaps 1 more (" in of(then(*late)).lines[4]


def test_a_station_that_only_refuses_is_known_when_it_is_damaged() -> None:
    refusing = do("exchange", station=9, is_refusal=True, status=1)
    assert details(then(refusing, do("damage", 9)), "damaged") == ["station 9: its checksum is wrong"]


def test_noise_is_damage_only_while_a_reaction_is_due() -> None:
    assert details(then(run(5), do("noise"), run(5)), "damaged") == []
    assert details(then(run(5), reaction(has_system_error=True), do("noise"), run(5)), "damaged") == []
    (damaged,) = of(then(run(5), do("ask", 4), do("noise"), run(5))).of("damaged")
    assert damaged.count == 1


def test_two_damaged_telegrams_in_a_packet_are_two() -> None:
    bad = telegram(4, PLC, is_reaction=True, good=False)
    (damaged,) = of(then(run(5), do("put", bad, bad, faults=[one for one in FAULTS if one.name == "damaged"] * 2))).of(
        "damaged"
    )
    assert damaged.count == 2


@pytest.mark.parametrize(("stations", "is_boot"), [((4, 5), False), ((4, 9), False), ((4, 5, 6), True)])
def test_half_of_all_stations_are_a_machine_that_starts(stations: tuple[int, ...], *, is_boot: bool) -> None:
    found = of(then(run(30), do("boot", *stations)), 3, 4, 5, 6, 7, 8)
    assert [one.detail.partition(",")[0] for one in found.of("boot")] == ["stations 4"] * is_boot


def test_a_long_initialisation_is_one() -> None:
    """Its steps are within a minute of one another; all of it takes longer."""
    marker = event(Event.MARKER, "a lorry")
    (boot,) = of(then(do("boot", 3), run(50), do("boot", 4), marker, run(50), do("boot", 5))).of("boot")
    assert boot.detail.startswith("stations 3, 4, 5, ready 1")
    assert boot.to_s - boot.from_s == pytest.approx(105, abs=2)


def of_itself(station: int, phase: str, times_s: tuple[float, float], firmware: str, key: str) -> Play:
    """Let a station say its phase, its limits TrS and TzA, and which device it is. Masters keep its TzA, too."""
    limits = {"reaction": judged(0.01, times_s[0], 0), "pause": judged(0.001, times_s[1], 0)}
    return then(
        do("ask", station, is_doubtful=True, pause=limits["pause"]),
        do("answer", station, service=0x12, phase=phase, **limits),
        do("answer", station, service=0x00, columns={"sis.firmware": firmware}),
        do("answer", station, service=0x00, columns={"sis.type_key": key}),
    )


def test_what_a_station_says_of_itself_is_no_change_of_another() -> None:
    """Nor is it one where a good capture says the same."""
    before = of_itself(0, "2", (0.05, 0.002), "FWA-1", "HCS01"), of_itself(5, "3", (0.04, 0.003), "FWA-2", "HCS02")
    switched = then(do("ask", 4, service=0x1D, phase="4"), do("answer", 4, service=0x1D))
    after = of_itself(0, "3", (0.06, 0.001), "FWA-3", "HCS03"), of_itself(5, "3", (0.06, 0.003), "FWA-2", "HCS02")
    machine = Machine()
    then(do("answer", 4), *before, *before)(machine)
    assert machine.finish() == []
    another = Machine(before=machine.engine, baud=19200)
    changes = [
        "station 0: 2 -> 3",
        "station 0: TrS 50 -> 60 ms",
        "station 0: TzA 2 -> 1 ms",
        "station 0: firmware FWA-1 -> FWA-3",
        "station 0: type key HCS01 -> HCS03",
        "station 4: unknown -> 4",
        "station 5: TrS 40 -> 60 ms",
    ]
    for one, more in ((another, [": 9600 -> 19200 Bd"]), (machine, [])):
        then(do("answer", 4), switched, *after)(one)
        assert sorted(f"{found.who}: {found.detail}" for found in one.finish()) == more + changes


def test_an_initialisation_to_another_phase_is_one_only_if_nobody_had_answered() -> None:
    """Drives that run are switched to a phase."""
    switched = [then(do("exchange", station=station, service=0x1D, phase="2"), run(50)) for station in (3, 4, 5)]
    assert details(then(*switched), "boot") == [": stations 3, 4, 5"]
    found = of(then(run(4), *switched))
    assert not found.of("boot")
    assert [one.who for one in found.of("phase")] == ["station 3", "station 4", "station 5"]


def test_two_captures_have_two_initialisations() -> None:
    assert len(details(then(do("boot"), event(Event.CAPTURE_STARTED), do("boot")), "boot")) == 2


@pytest.mark.parametrize("drives", [(3,), (3, 4)])
def test_the_restart_of_one_station_of_few_is_no_initialisation_of_the_machine(drives: tuple[int, ...]) -> None:
    kinds = of(then(run(30), do("silent", 3, 4), do("boot", 3), run(90)), *drives).kinds
    assert "restart" in kinds and "boot" not in kinds


def test_two_stations_that_restart_are_told_one_by_one() -> None:
    silent = then(do("silent", 3, 4), do("silent", 4, 4))
    found = of(then(run(30), silent, do("boot", 3, 4), run(90)), 3, 4, 5, 6, 7).of("restart")
    assert [one.who for one in found] == ["station 3", "station 4"]


@pytest.mark.parametrize(("name", "kind"), [("error_reaction", "error"), ("damaged", "damaged")])
def test_a_fault_of_another_protocol_has_no_station(name: str, kind: str) -> None:
    """Of ECODRIVE's ASCII protocol, say: the packet has no telegram."""
    faults = tuple(fault for fault in FAULTS if fault.name == name)
    assert details(do("put", faults=faults), kind) == [": "]


def test_a_boot_lasts_until_its_stations_are_ready() -> None:
    machine = Machine()
    machine.boot(stuck=5)
    machine.pause(1)
    machine.answer(5, service=0x12, phase="4")
    (boot,) = machine.told().of("boot")
    assert boot.to_s == pytest.approx(machine.now_s, abs=0.02)


def test_a_bus_with_a_good_telegram_now_and_then_is_unreadable_once() -> None:
    """It is readable again after five in a row."""
    bad = then(*[then(do("noise", 10, every_s=0.2), reaction(2))] * 4)
    assert details(then(run(60), bad, reaction(3)), "unreadable") == [": 40 records are no telegrams"]
    five = then(do("noise", 20, every_s=0.2), reaction(2), do("ask", 3))
    (twice,) = of(then(run(60), five, five)).of("unreadable")
    assert (twice.count, twice.detail) == (2, "20 records are no telegrams")


# -- Values and their commands ---------------------------------------------------------------------------------------


def test_a_command_that_is_a_text_is_none() -> None:
    assert details(then(do("write", 3, "S-0-0036", "stop"), told(SPEED, [1000.0] * 90)), "step") == []


def test_after_the_next_command_of_another_file_values_are_compared_again() -> None:
    """What was commanded between the two files, nobody has heard."""
    first = then(do("write", 3, "S-0-0036", 1000.0), told(SPEED, about(1000, 60)), NEXT_FILE)
    again = then(do("write", 3, "S-0-0036", 1000.0), told(SPEED, [500.0] * 60))
    assert details(then(first, again), "apart") == ["station 3 S-0-0040: 50 % below S-0-0036"]


def test_a_value_that_is_apart_for_minutes_is_told_once() -> None:
    moves = then(do("write", 3, "S-0-0036", 1000.0), told(SPEED, [1000.0] * 60 + [500.0] * 300))
    (apart,) = of(moves).of("apart")
    assert apart.to_s - apart.from_s == pytest.approx(600, abs=10)


def test_a_value_is_apart_since_it_left_its_command_for_the_last_time() -> None:
    speeds = [1000.0] * 60 + [500.0] * 3 + [1000.0] * 60 + [500.0] * 30
    (apart,) = of(then(do("write", 3, "S-0-0036", 1000.0), told(SPEED, speeds))).of("apart")
    assert apart.from_s - BEGIN_S == pytest.approx(2.03 * 123, abs=3)


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_value_that_swings_as_far_in_each_cycle_has_no_level_there(sign: int) -> None:
    def cycles(count: int) -> list[float]:
        swings = {0: 60, 5: -60}
        return [100 + swings.get(number % 10, 0) + one for number, one in enumerate(about(0, count))]

    swinging = [*cycles(200), *about(100 + sign * 50, 30, seed=2), *cycles(200)]
    assert details(told(TORQUE, swinging, unit="%"), "step") == []
    resting = [*about(100, 200), *about(100 + sign * 50, 30, seed=2), *about(100, 200, seed=3)]
    assert len(details(told(TORQUE, resting, unit="%"), "step")) == 1


def test_a_value_that_drifts_in_steps_has_a_drift_and_no_steps() -> None:
    stairs = [30 + 3 * (number // 12) + one for number, one in enumerate(about(0, 120, by=0.1))]
    found = of(told(TORQUE, stairs, every_s=30, unit="%"))
    assert "drift" in found.kinds and "step" not in found.kinds
    stairs[60:72] = [one + 15 for one in stairs[60:72]]
    assert len(details(told(TORQUE, stairs, every_s=30, unit="%"), "step")) == 1


@pytest.mark.parametrize("sign", [-1, 1])
def test_what_falls_drifts_as_what_rises(sign: int) -> None:
    moving = [50 + sign * 16 * number / 120 + one for number, one in enumerate(about(0, 120, by=0.3))]
    assert len(details(told(TORQUE, moving, every_s=30, unit="%"), "drift")) == 1


@pytest.mark.parametrize(
    ("station", "ident", "service", "more", "count"),
    [
        (3, "S-0-0036", "0x1f", {}, 0),
        (4, "S-0-0036", "0x1f", {}, 1),
        (3, "P-0-0123", "0x1f", {}, 1),
        (3, "S-0-0036", "0x10", {}, 1),  # a read
        (3, "S-0-0036", "0x1f", {"unanswered": False, "is_repeat": True}, 1),
        (3, "S-0-0036", "0x1f", {"good": False}, 1),  # it was damaged
    ],
)
def test_only_its_own_command_that_perhaps_nobody_took_is_lost(
    station: int, ident: str, service: str, more: dict[str, bool], count: int
) -> None:
    columns = {"sis.parameter": ident, "sis.service": service}
    lost = do("put", telegram(PLC, station, columns=columns, **{"unanswered": True} | more))
    assert len(details(then(follows((1000, 60)), lost, told(SPEED, [500.0] * 30)), "apart")) == count


def follows(*parts: tuple[float, int], every_s: float = 2.0) -> Play:
    """Let a speed be so fast for so many reads, after a command of 1000."""
    speeds = (told(SPEED, [rpm] * count, every_s=every_s) for rpm, count in parts)
    return then(do("write", 3, "S-0-0036", 1000.0), *speeds)


@pytest.mark.parametrize(
    ("play", "count"),
    [
        (follows((1000, 55), (500, 30)), 1),
        (follows((1000, 45), (500, 30)), 0),  # nobody knows yet that it follows
        (follows(*[(1000, 10), (500, 1)] * 10, (500, 30)), 1),
        (follows(*[(1000, 8), (500, 1)] * 13, (500, 30)), 0),  # near its command less often than nine times of ten
        (follows((1000, 60), (500, 8), every_s=10), 1),
        (follows((1000, 60), (500, 7), every_s=10), 0),  # too few reads
        (then(follows((1000, 60)), *[follows((500, 1))] * 15), 1),  # commanded again and again
        (then(told(SPEED, [1000] * 60), do("write", 4, "S-0-0036", 1000.0), told(SPEED, [500] * 30)), 0),  # another one
        (then(told(SPEED, [1000] * 60), do("write", 3, "S-0-0080", 1000.0), told(SPEED, [500] * 30)), 0),
        (then(do("exchange", access(3, "S-0-0036", 1000.0)), told(SPEED, [1000] * 60 + [500] * 30)), 1),  # it is read
    ],
)
def test_a_value_is_apart_from_a_command_that_it_followed_until_then(play: Play, count: int) -> None:
    assert details(play, "apart") == ["station 3 S-0-0040: 50 % below S-0-0036"] * count


def test_a_drive_that_still_speeds_up_to_each_next_command_is_not_apart() -> None:
    faster = (then(do("write", 3, "S-0-0036", rpm), told(SPEED, [rpm - 500] * 8)) for rpm in (2000.0, 3000.0, 4000.0))
    assert details(then(follows((1000, 60)), *faster), "apart") == []


@pytest.mark.parametrize(("scatter", "count"), [(3.2, 1), (4.0, 0)])
def test_what_moved_less_than_its_noise_has_not_drifted(scatter: float, count: int) -> None:
    moving = [50 + 16 * number / 120 + one for number, one in enumerate(about(0, 120, by=scatter))]
    assert len(details(told(TORQUE, moving, every_s=30, unit="%"), "drift")) == count


def test_a_drive_stands_by_the_scale_of_its_speed() -> None:
    """Its bytes were larger numbers than its revolutions, once somebody has read its attribute."""
    raw = undescribed(3, SPEED, (10_000_000).to_bytes(4, "little"))
    found = of(then(reads(*[raw] * 60, every_s=1), reads(*[access(3, SPEED, 1000.0)] * 60, every_s=1)))
    assert found.of("stopped") == []


@pytest.mark.parametrize(
    ("usual", "other", "count"),
    [
        ("0b0000000000000001", "0b0000000000000101", 1),
        ("0x0010", "0x0011", 1),
        ("0, 0, 1", "0, 0, 2", 1),
        ("Auto", "1", 1),
        ("1", "Auto", 1),
        ("100 rpm", "104 rpm", 0),  # less than 5 %
        ("100 rpm", "106 rpm", 1),
        ("-100 rpm", "-104 rpm", 0),
        ("-100 rpm", "-93.5 rpm", 1),
        ("1e-05 A", "1.04e-05 A", 0),
        ("500.0", "500.0 mm", 0),  # somebody has read its unit
        ("500.0", "600.0 mm", 1),
        ("500.0 mm", "500.0 rpm", 1),
        ("1, 5", "1", 1),
    ],
)
def test_bits_and_lists_are_alike_only_if_they_are_the_same(usual: str, other: str, count: int) -> None:
    said = reads(*[access(5, "P-0-0222", text) for text in [usual] * 20 + [other] * 5 + [usual] * 5], every_s=10)
    assert details(said, "changed") == [f"station 5 P-0-0222: {usual} -> {other}"] * count


@pytest.mark.parametrize(("command", "rpm", "count"), [(1000.0, 8.0, 0), (-1000.0, 8.0, 0), (1000.0, 15.0, 1)])
def test_a_drive_that_holds_its_place_while_others_run_moves_a_little(command: float, rpm: float, count: int) -> None:
    """By less than a hundredth of its greatest command."""
    machine = Machine()
    for said, turns in ((command, command), (0.0, rpm)):
        machine.write(3, "S-0-0036", said)
        machine.turns[3] = turns
        machine.run(150)
    assert [one.detail for one in machine.told().of("apart")] == ["above S-0-0036"] * count


@pytest.mark.parametrize("seam", [NEXT_FILE, event(Event.CAPTURE_STARTED), event(Event.ADAPTER_LOST)])
def test_what_nobody_describes_is_not_apart_from_a_command_of_another_file(seam: Play) -> None:
    def bytes_of(ident: str, *numbers: int) -> Play:
        return reads(*(undescribed(3, ident, number.to_bytes(4, "little")) for number in numbers), every_s=1)

    moves = then(bytes_of("S-0-0036", 1000), bytes_of(SPEED, *[1000] * 60), seam, bytes_of(SPEED, *[500] * 30))
    assert details(moves, "apart") == []


@pytest.mark.parametrize("where", [{"station": 3, "device": 5}, {"station": "3/2/8"}])
def test_each_device_of_a_station_has_its_own_state(where: dict[str, Any]) -> None:
    """A control tells what its drives say, in turn; behind a router there are several."""
    fault = reads(*[diagnosis(3, FAULT), diagnosis(code=RUNS, **where)] * 30, every_s=1)
    (found,) = of(fault).of("fault")
    assert found.detail == "F2028 (S-0-0390); still so when last read"
    assert found.to_s - found.from_s == pytest.approx(60, abs=2.5)
    one, other = (
        access(ident="S-0-0135", value=f"0x{word:X}", number=float(word), **more)
        for word, more in ((0xC000, {"station": 3}), (0x8000, where))
    )
    assert details(reads(*[one, other] * 10, every_s=8), "stopped") == []


def test_what_one_drive_still_has_is_told_beside_what_is_over_at_another() -> None:
    machine = Machine()
    machine.says[3] = FAULT
    machine.run(10)
    machine.says[4] = FAULT
    machine.run(20)
    machine.says |= {4: RUNS, 5: 0xF2029}
    machine.run(10)
    said = machine.told()
    assert "now fault F2028 (station 3), fault F2029 (station 5); fault F2028 (station 4)." in said.lines[0]
    assert said.lines[2].count("still so") == 2


@pytest.mark.parametrize("last", [3, 4])
def test_an_emergency_stop_lasts_as_long_as_one_drive_says_so(last: int) -> None:
    machine = Machine()
    machine.run(60)
    machine.says |= {3: 0xF4034, 4: 0xF4034}
    machine.run(60)
    machine.says[7 - last] = RUNS
    machine.run(10)
    assert [one.detail for one in machine.told().of("estop")] == ["F4034; still so when last read"]


def test_a_value_of_a_standing_machine_is_no_usual_one_of_a_running_machine() -> None:
    def say(code: int, rpm: float) -> Play:
        return then(do("all", code, rpm), run(10))

    high, low = (told("P-0-0300", about(middle, 60), unit="bar") for middle in (50, 5))
    day = then(run(10), *[then(high, say(STANDS, 0.0), low, say(RUNS, 1000.0))] * 4, high)
    assert details(day, "step") == []
    assert len(details(then(day, low, high), "step")) == 1


# -- Masters and writes ----------------------------------------------------------------------------------------------


def test_a_drive_that_rounds_one_value_and_takes_another_as_it_is() -> None:
    written = writes("P-0-0123", (PLC, 12.0))
    as_written = reads(access(5, "P-0-0123", 12.0))
    rounded = then(do("write", 5, "P-0-0123", 12.34), reads(access(5, "P-0-0123", 12.3)))
    assert details(then(written, as_written, rounded), "other") == []


def test_what_moves_by_itself_is_other_once() -> None:
    """And again, when it has come back to what it was."""
    moves = reads(*(access(5, "P-0-0123", value) for value in (12.0, 10.0, 9.0, 8.0, 10.0, 7.0)))
    said = "station 5 P-0-0123: {} rpm -> {} rpm, nobody on this bus wrote it"
    found = of(then(writes("P-0-0123", (PLC, 12)), moves))
    assert [f"{one.who}: {one.detail}" for one in found.of("other")] == [said.format(12, 10.0), said.format(10.0, 7.0)]
    assert "station 5 P-0-0123 10 -> 7 rpm at 06:03:30, nobody on this bus wrote it" in found.lines[3]


@pytest.mark.parametrize(
    ("between", "count"),
    [
        (run(9), 1),
        (NEXT_FILE, 0),
        (do("put", type=EVENT, event=int(Event.CAPTURE_STARTED), text=KEPT, is_again=True), 0),
        (event(Event.CAPTURE_STARTED), 0),
        (event(Event.ADAPTER_LOST), 0),
        (do("put", type=EVENT, event=int(Event.CAPTURE_STARTED), is_again=True), 1),  # the next file of a ring
        (do("silent", 5, columns={"sis.parameter": "P-0-0123", "sis.service": "0x1f"}), 0),
        (do("silent", 5, columns={"sis.parameter": "P-0-0123", "sis.service": "0x10"}), 1),
        (do("silent", 5, columns={"sis.parameter": "P-0-0145", "sis.service": "0x1f"}), 1),
        (do("silent", 4, columns={"sis.parameter": "P-0-0123", "sis.service": "0x1f"}), 1),
    ],
)
def test_nobody_wrote_only_what_somebody_would_have_heard(between: Play, count: int) -> None:
    before, after = (reads(access(5, "P-0-0123", value)) for value in (12.0, 10.0))
    assert len(details(then(writes("P-0-0123", (PLC, 12)), before, between, after), "other")) == count


def test_each_visitor_has_written_each_parameter() -> None:
    written = ("P-0-0123", 12, 127), ("P-0-0145", 13, 127), ("P-0-0123", 14, 126)
    visits = (do("write", 5, ident, value, master=master) for ident, value, master in written)
    assert details(then(run(150), *visits), "write") == [
        "station 5 P-0-0123: 12 rpm by new master 127; at the end 14 rpm",
        "station 5 P-0-0145: 13 rpm by new master 127; still set at the end",
        "station 5 P-0-0123: 12 rpm -> 14 rpm by new master 126; still set at the end",
    ]


@pytest.mark.parametrize(("value", "said"), [(12, "stations 3, 4: 12 rpm"), (9, "station 3: 12 rpm")])
def test_what_a_visitor_writes_to_several_is_one_if_it_is_the_same_at_the_end(value: float, said: str) -> None:
    written = [do("write", station, "P-0-0123", 12, master=LAPTOP) for station in (3, 4)]
    back = then(run(1000), do("write", 4, "P-0-0123", value))
    found = of(then(run(150), *written, back)).of("write")[0]
    assert f"{found.who.removesuffix(' P-0-0123')}: {found.detail}" == f"{said} by new master 127; still set at the end"


def test_a_limit_that_is_set_again_and_again_is_told_when_it_is_another() -> None:
    assert details(writes(LIMIT, *[(PLC, 3000)] * 5, (PLC, 500)), "limit_write") == [
        f"station 5 {LIMIT}: 3000 rpm by master 1; at the end 500 rpm",
        f"station 5 {LIMIT}: 3000 rpm -> 500 rpm by master 1; still set at the end",
    ]


def test_what_is_written_a_minute_beside_a_recipe_is_none_of_it() -> None:
    beside = [then(do("write", 5, ident, 7.0), run(60)) for ident in ("P-0-0200", "P-0-0201")]
    recipe = then(*(do("write", 5, f"P-0-000{one}", 1.0) for one in range(4)), run(60))
    found = of(then(run(150), beside[0], recipe, beside[1])).of("write")
    assert [one.hit.parameter for one in found] == ["P-0-0200", "P-0-0201"]


def test_more_parameters_than_are_remembered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sistap.dissected.episodes.writes.MOST", 1)
    said = details(then(run(150), *(do("write", 5, f"P-0-000{one}", 1.0, master=LAPTOP) for one in range(3))), "write")
    assert [one.partition(";")[0] for one in said] == [
        f"station 5 P-0-000{one}: 1.0 rpm by new master 127" for one in range(3)
    ]


def test_of_two_buses_each_knows_what_is_set_at_its_end() -> None:
    engine = Engine()
    first, second = (Machine(interface=name) for name in "ab")
    first.engine = second.engine = engine
    for machine in (first, second):
        machine.run(150)
    first.write(5, "P-0-0123", 12, master=LAPTOP)
    assert [one.outcome for one in engine.finish() if one.kind == "write"] == ["still set at the end"]


@pytest.mark.parametrize(
    ("kind", "good", "now"),
    [
        ("phase", reaction(service=0x12, phase="4"), reaction(service=0x12, phase="2")),
        ("rate", reaction(), do("put", baud=19200)),
        ("limits", limits(0.05), limits(0.04)),
        ("exchanged", firmware("FWA-1"), firmware("FWA-2")),
        ("step", told("P-0-0123", about(50, 60)), told("P-0-0123", about(70, 60))),
    ],
)
def test_what_is_other_than_in_a_good_capture(kind: str, good: Play, now: Play) -> None:
    before = Machine()
    good(before)
    before.finish()
    for engine, count in ((None, 0), (before.engine, 1)):
        machine = Machine(before=engine)
        now(machine)
        assert len(machine.told().of(kind)) == count


def test_what_drifts_in_a_good_capture_too_is_usual() -> None:
    good = Machine()
    told(TORQUE, RISES, every_s=30, unit="%")(good)
    good.finish()
    machine = Machine(before=good.engine)
    told(TORQUE, RISES, every_s=30, unit="%")(machine)
    assert machine.told().of("drift") == []


def test_each_bus_is_compared_with_the_good_one_of_its_name() -> None:
    def asks(master: int, name: str, engine: Engine) -> None:
        machine = Machine(interface=name)
        machine.engine = engine
        visit = do("exchange", station=3, master=master)
        then(run(130), visit, told("P-0-0123", about(50 + master / 5, 60)))(machine)

    good = Engine()
    asks(LAPTOP, "a", good)
    asks(PLC, "b", good)
    now = Engine(good)
    asks(LAPTOP, "a", now)
    asks(LAPTOP, "b", now)
    other = Machine(interface="c", baud=19200)
    other.engine = now
    other.run(10)
    assert sorted((one.kind, one.hit.port) for one in now.finish()) == [("master", "b"), ("step", "b")]


def test_what_nobody_describes_is_counted_of_all_buses() -> None:
    engine = Engine()
    for name in "ab":
        machine = Machine(3, interface=name, is_described=False)
        machine.engine = engine
        machine.run(60)
    assert engine.undescribed == 2  # the speeds


def test_what_a_good_capture_writes_and_says_is_known() -> None:
    """The tap was at another port."""
    good = Machine(interface="COM3")
    then(reads(access(5, LIMIT, 3000.0)), writes("P-0-0123", (PLC, 12)))(good)
    good.finish()
    machine = Machine(before=good.engine, interface="COM4")
    writes("P-0-0123", (PLC, 12))(machine)
    assert machine.told().of("write") == []
    machine = Machine(before=good.engine, interface="COM4")
    do("write", 5, LIMIT, 500.0)(machine)
    (said,) = machine.told().of("limit_write")
    assert said.detail == "3000.0 rpm -> 500.0 rpm by master 1; still set at the end"


def test_a_damaged_telegram_has_no_phase() -> None:
    damaged = telegram(5, PLC, is_reaction=True, service=0x12, phase="2", good=False)
    assert details(then(reaction(service=0x12, phase="4"), pause(70), do("put", damaged)), "phase") == []


def test_what_is_written_to_the_control_word_switches_a_machine_off() -> None:
    """Nobody reads how fast it turns."""

    def word(bits: int) -> Play:
        return do("write", 5, "S-0-0134", f"0b{bits:016b}", number=float(bits), data=bits.to_bytes(2, "little").hex())

    off = then(word(0xE000), pause(60), word(0x8000), pause(60), word(0xE000), pause(60), reaction())
    assert len(details(off, "stopped")) == 1


def test_a_machine_stands_as_the_status_word_says_whatever_its_other_bits_are() -> None:
    def word(bits: int) -> Play:
        said = access(5, "S-0-0135", f"0b{bits:016b}", number=float(bits), data=bits.to_bytes(2, "little").hex())
        return reads(*[said] * 30, every_s=2)

    assert len(details(then(word(0xC0FF), word(0x80FF), word(0xC0FF)), "stopped")) == 1


def test_a_level_that_lasts_to_the_end_says_so_and_no_other_does() -> None:
    above = [*about(50, 99), *about(70, 30, seed=2)]
    for numbers, lasts in (([*above, *about(50, 99, seed=3)], False), (above, True)):
        (step,) = details(told(TORQUE, numbers, unit="%"), "step")
        assert step.endswith("; still so when last read") is lasts


def test_one_fault_after_another_is_two() -> None:
    codes = 0xA0101, 0xF2028, 0xF2028, 0xF4034, 0xF4034
    found = details(reads(*(diagnosis(5, code) for code in codes), every_s=4), "fault")
    assert [detail.split()[2] for detail in found] == ["F2028", "F4034"]


def test_a_second_answer_is_told_also_after_damage() -> None:
    """What was damaged before the last command is no explanation."""
    again = do("answer", 4, signs=("again",))
    assert len(details(then(run(5), do("damage", 3), do("exchange", station=4), again), "again")) == 1
    assert details(then(run(5), do("exchange", station=4), do("damage", 4), again), "again") == []
    half = do("put", telegram(3, PLC, is_reaction=True), telegram(4, PLC, is_reaction=True, good=False))
    assert len(details(then(run(5), half, do("exchange", station=4), again), "again")) == 1
    assert len(details(then(run(5), do("damage", 4), do("answer", 4, signs=("warning_bit",))), "warning_bit")) == 1


def test_after_a_silence_of_the_bus_no_master_is_gone() -> None:
    """Nobody asked; a panel that asks now and then is not missing for so long."""
    seldom = then(*[then(run(20, has_panel=False), run(2))] * 5, run(20, has_panel=False))
    assert details(then(run(450), pause(300), seldom), "vanished") == []


def test_a_visitor_hides_no_master_that_is_gone() -> None:
    """He asks first; who usually asks is known from a good capture."""
    good = Machine()
    good.run(10)
    machine = Machine(before=good.engine)
    then(do("exchange", station=3, master=LAPTOP), run(420), run(80, has_panel=False))(machine)
    assert machine.told().kinds == ["master", "vanished"]


@pytest.mark.parametrize(
    ("fast", "slow", "count"), [(14, 14, 0), (17, 17, 1), (50, 8, 1), (50, 7, 0), (8, 50, 1), (7, 50, 0)]
)
def test_a_slow_drive_is_told_after_eight_minutes_of_half_an_hour(fast: int, slow: int, count: int) -> None:
    """Nobody judges a shorter time."""
    times_s = [0.010] * fast + [0.030] * slow
    minutes = (then(reaction(20, reaction=judged(time_s, 0.05, 0)), pause(59.4)) for time_s in times_s)
    assert len(details(then(*minutes), "slower")) == count


def test_two_stations_that_answer_slower_are_told_one_by_one() -> None:
    slow = [
        do("exchange", station=station, reaction=judged(time_s, 0.05, 0))
        for time_s in [0.010] * 17 + [0.030] * 17
        for station in (3, 4)
    ]
    found = of(then(*(then(one, pause(30)) for one in slow))).of("slower")
    assert [one.who for one in found] == ["station 3", "station 4"]


@pytest.mark.parametrize(("scatter_s", "count"), [(0.0002, 1), (0.006, 0)])
def test_reaction_times_that_scatter_more_than_they_rise_are_not_slower(scatter_s: float, count: int) -> None:
    noise = about(0, 90, by=scatter_s)
    times_s = [0.020 + 0.025 * minute / 89 + one for minute, one in enumerate(noise)]
    rises = then(*(then(reaction(20, reaction=judged(time_s, 0.1, 0)), pause(59.4)) for time_s in times_s))
    assert len(details(rises, "slower")) == count


def test_a_repeat_of_long_ago_is_none_of_a_command_without_a_reaction() -> None:
    """Its reaction was damaged, so the master asked again."""
    again = then(do("damage", 3), do("ask", 3, is_repeat=True), do("answer", 3))
    found = of(then(run(30), again, run(60), do("silent", 3), do("exchange", station=3)))
    assert "unanswered" in found.kinds and "repeated" not in found.kinds


def test_the_worst_of_two_is_told_with_its_time() -> None:
    first, second = (
        reaction(is_doubtful=True, reaction=judged(time_s, 0.05, EXCEEDED), status=0) for time_s in (0.06, 0.09)
    )
    said = "2 reactions later than TrS (worst 90 ms at 06:01:00, station 5, 06:00:00 to 06:01:00)"
    assert said in of(then(first, pause(60), second)).text


def test_what_is_counted_ends_with_the_last_end() -> None:
    ends_s = {3: 100, 4: 60}
    hits = [Hit("late", one, BEGIN_S + one, BEGIN_S + end_s, one, worst=0.06) for one, end_s in ends_s.items()]
    said = "\n".join(line.text for line in lines([*map(Episode.of, hits)], BEGIN_S, BEGIN_S + 200))
    assert "06:00:03 to 06:01:40" in said


def test_of_several_stations_each_has_its_worst() -> None:
    late = [
        do("exchange", station=station, is_doubtful=True, reaction=judged(time_s, 0.05, EXCEEDED))
        for station, time_s in ((4, 0.06), (5, 0.09), (4, 0.07))
    ]
    assert "station 4 up to 70 ms, station 5 up to 90 ms" in of(then(*late)).text


def test_a_fault_of_a_drive_ends_when_it_says_so() -> None:
    machine = Machine()
    machine.run(60)
    machine.says[4] = FAULT
    machine.run(60)
    machine.says[4] = 0xA0101
    machine.run(60)
    (found,) = machine.told().of("fault")
    assert found.to_s - found.from_s == pytest.approx(60, abs=2.5)


def test_what_is_to_be_looked_at_is_counted_beside_a_fault_that_lasts() -> None:
    def breaks(machine: Machine) -> None:
        machine.says[4] = FAULT

    said = of(then(run(60), firmware("FWA-1", "FWA-2"), breaks, run(60)))
    assert said.lines[0].partition(": ")[2].partition(".")[0] == "now fault F2028 (station 4); 1 thing to look at"
