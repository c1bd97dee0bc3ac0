# SPDX-License-Identifier: GPL-2.0-or-later
"""What is nearly something else: each border that decides what a person reads of a machine, from both sides."""

from __future__ import annotations

from operator import methodcaller as do

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
from test_kinds import LIMIT, TORQUE, Play, about, event, firmware, pause, reaction, reads, run, then, told, writes

from sistap.dissected.episodes.episode import Episode, Hit
from sistap.dissected.episodes.lines import lines
from sistap.dissected.packets.dissection import EXCEEDED
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
    slow = telegram(5, PLC, is_reaction=True, is_doubtful=True, pause=judged(0.003, 0.002, EXCEEDED))
    assert len(details(do("put", slow, errors=int(flag)), "interval")) == (flag == 0)


def test_a_station_that_only_refuses_is_known_when_it_is_damaged() -> None:
    refusing = do("exchange", station=9, is_refusal=True, status=1)
    assert details(then(refusing, do("damage", 9)), "damaged") == ["station 9: its checksum is wrong"]


def test_noise_is_damage_only_while_a_reaction_is_due() -> None:
    assert details(then(run(5), do("noise"), run(5)), "damaged") == []
    assert len(details(then(run(5), do("ask", 4), do("noise"), run(5)), "damaged")) == 1


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


def test_an_initialisation_to_another_phase_is_one_too() -> None:
    stations = (then(do("exchange", station=station, service=0x1D, phase="2"), run(50)) for station in (3, 4, 5))
    assert details(then(run(4), *stations), "boot") == [": stations 3, 4, 5"]


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
    bad = then(*[then(do("noise", 10, every_s=0.2), reaction())] * 4)
    assert details(then(run(60), bad, reaction(3)), "unreadable") == [": 40 records are no telegrams"]


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


@pytest.mark.parametrize(("ident", "count"), [("P-0-0123", 1), ("S-0-0036", 0)])
def test_only_its_own_command_that_perhaps_nobody_took_is_lost(ident: str, count: int) -> None:
    lost = do("silent", 3, columns={"sis.parameter": ident, "sis.service": "0x1f"})
    speeds = told(SPEED, [1000.0] * 60), lost, told(SPEED, [500.0] * 30)
    assert len(details(then(do("write", 3, "S-0-0036", 1000.0), *speeds), "apart")) == count


@pytest.mark.parametrize(("scatter", "count"), [(0.3, 1), (4.0, 0)])
def test_what_moved_less_than_its_noise_has_not_drifted(scatter: float, count: int) -> None:
    moving = [50 + 16 * number / 120 + one for number, one in enumerate(about(0, 120, by=scatter))]
    assert len(details(told(TORQUE, moving, every_s=30, unit="%"), "drift")) == count


def test_a_drive_stands_by_the_scale_of_its_speed() -> None:
    """Its bytes were larger numbers than its revolutions, once somebody has read its attribute."""
    raw = undescribed(3, SPEED, (10_000_000).to_bytes(4, "little"))
    found = of(then(reads(*[raw] * 60, every_s=1), reads(*[access(3, SPEED, 1000.0)] * 60, every_s=1)))
    assert found.of("stopped") == []


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


def test_what_a_good_capture_writes_and_says_is_known() -> None:
    good = Machine()
    then(reads(access(5, LIMIT, 3000.0)), writes("P-0-0123", (PLC, 12)))(good)
    good.finish()
    machine = Machine(before=good.engine)
    writes("P-0-0123", (PLC, 12))(machine)
    assert machine.told().of("write") == []
    machine = Machine(before=good.engine)
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
