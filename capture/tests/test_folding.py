# SPDX-License-Identifier: GPL-2.0-or-later
"""What a state explains is told once, with the state."""

from __future__ import annotations

from typing import Any, NamedTuple

import pytest

from sistap.dissected.episodes.episode import ARROW, Episode, Hit
from sistap.dissected.episodes.folding import EXPLAINS, fold
from sistap.dissected.episodes.rules import RULES, THRESHOLDS, Severity

FROM_S, TO_S = 10_000.0, 10_100.0


def episode(kind: str, from_s: float, to_s: float, station: int | None = None, **more: Any) -> Episode:
    return Episode.of(Hit(kind, 1, from_s, to_s, station, **more))


def kinds(*episodes: Episode) -> list[str]:
    return [one.kind for one in fold(episodes, 100_000, THRESHOLDS)]


class Explained(NamedTuple):
    """An episode that a state explains, if it is within these seconds of it."""

    state: str
    kind: str
    before_s: float
    after_s: float
    is_of_one_station: bool = False


MINUTE = 60.0
TABLE = (
    Explained("foreign", "damaged", 5, MINUTE),
    Explained("off", "vanished", MINUTE, MINUTE),
    Explained("boot", "phase", MINUTE, MINUTE),
    Explained("restart", "limits", MINUTE, MINUTE, is_of_one_station=True),
    Explained("estop", "system_error", MINUTE, 2 * MINUTE),
    Explained("stopped", "apart", MINUTE, MINUTE),
    Explained("unreadable", "lost", 5, 5),
    Explained("rate", "unreadable", 30, 5),
    Explained("adapter", "gap", 5, 5),
    Explained("bus_silent", "silent", 5, MINUTE),
    Explained("fault", "system_error", MINUTE, MINUTE, is_of_one_station=True),
    Explained("warning", "warning_bit", 2 * MINUTE, 2 * MINUTE, is_of_one_station=True),
    Explained("recipe", "step", 5, MINUTE),
    Explained("again", "unanswered", 5, MINUTE, is_of_one_station=True),
    Explained("early", "repeated", 5, MINUTE, is_of_one_station=True),
)


def state(kind: str, station: int | None) -> list[Episode]:
    """Return a state; a restart is one only with a silence."""
    more = [episode("silent", FROM_S, TO_S, station)] if kind == "restart" else []
    return [episode(kind, FROM_S, TO_S, station, topic="F2028" if kind == "fault" else ""), *more]


@pytest.mark.parametrize("row", TABLE, ids=lambda row: row.state)
def test_what_is_within_a_state_is_told_with_it(row: Explained) -> None:
    station = 4 if row.is_of_one_station else None
    within = FROM_S - row.before_s, TO_S + row.after_s
    assert kinds(*state(row.state, station), episode(row.kind, *within, 4)) == [row.state]
    other = episode(row.kind, *within, 5)
    assert kinds(*state(row.state, station), other).count(row.kind) == row.is_of_one_station
    long = [episode(row.kind, FROM_S - row.before_s - 100, TO_S + row.after_s + 100, 4)]
    if row.kind != "step":
        long += [episode(row.kind, within[0] - 1, within[1], 4), episode(row.kind, within[0], within[1] + 1, 4)]
    for one in long:
        assert sorted(kinds(*state(row.state, station), one)) == sorted([row.state, row.kind])


def test_what_is_written_to_a_station_that_restarts_is_told_with_it() -> None:
    """A recipe names no single station."""
    assert kinds(*state("restart", 4), episode("recipe", FROM_S, TO_S)) == ["restart"]


def test_each_state_has_its_row() -> None:
    assert {row.state for row in TABLE} == set(EXPLAINS)


@pytest.mark.parametrize(("from_s", "to_s"), [(FROM_S + 10, TO_S + 9000), (FROM_S - 9000, TO_S - 10)])
def test_a_level_that_begins_or_ends_with_a_state_is_one_with_it(from_s: float, to_s: float) -> None:
    assert kinds(episode("stopped", FROM_S, TO_S), episode("step", from_s, to_s, 4)) == ["stopped"]


@pytest.mark.parametrize(
    ("hit", "is_told"),
    [
        (Hit("write", 1, FROM_S, FROM_S, 4, severity=Severity.NOTE), False),
        (Hit("write", 1, FROM_S, FROM_S, 4), True),  # by a visitor
        (Hit("limit_write", 1, FROM_S, FROM_S, 4, detail="500 rpm by master 1"), False),
        (Hit("limit_write", 1, FROM_S, FROM_S, 4, detail=f"3000 rpm{ARROW}500 rpm by master 1"), True),
    ],
)
def test_what_somebody_sets_at_a_boot_is_told(hit: Hit, *, is_told: bool) -> None:
    assert kinds(episode("boot", FROM_S, TO_S), Episode.of(hit)).count(hit.kind) == is_told


@pytest.mark.parametrize(
    ("first", "second", "count"),
    [
        (("fault", 0, 100, 3, "F2028"), ("fault", 60, 160, 4, "F2028"), 1),
        (("fault", 0, 100, 3, "F2028"), ("fault", 61, 160, 4, "F2028"), 2),
        (("fault", 0, 100, 3, "F2028"), ("fault", 0, 100, 4, "F2029"), 2),
        (("fault", 0, 100, 3, "F2028"), ("fault", 0, 160, 4, "F2028"), 1),
        (("fault", 0, 100, 3, "F2028"), ("fault", 0, 161, 4, "F2028"), 2),
        (("silent", 0, 100, 3, ""), ("silent", 10, 110, 4, ""), 1),
        (("silent", 0, 100, 3, ""), ("silent", 11, 110, 4, ""), 2),
        (("silent", 0, 100, 3, ""), ("silent", 0, 100, 3, ""), 2),
        (("homing", 0, 100, 3, ""), ("homing", 60, 100, 4, ""), 1),
        (("never", 0, 100, 3, "0x1001"), ("never", 9000, 9100, 4, "0x1001"), 1),
        (("never", 0, 100, 3, "0x1001"), ("never", 9000, 9100, 4, "0x1002"), 2),
        (("error", 0, 100, 3, "0x8004"), ("error", 0, 100, 4, "0x8004"), 2),
    ],
)
def test_what_several_stations_have_at_once_is_one(
    first: tuple[str, float, float, int, str], second: tuple[str, float, float, int, str], count: int
) -> None:
    episodes = (episode(kind, *times, topic=topic) for kind, *times, topic in (first, second))  # type: ignore[arg-type]
    assert len(kinds(*episodes)) == count


def test_which_kinds_several_stations_have_as_one() -> None:
    said: dict[str, Any] = {"worst": 1.0, "topic": "F2028", "parameter": "S-0-0040", "detail": "5 rpm by master 1"}
    one = {
        kind for kind in RULES if len(kinds(*(episode(kind, 0, 100, station, **said) for station in (3, 4, 5)))) == 1
    }
    alone = "silent cycle fault warning homing limits write step blip changed drift never"
    assert one == set(f"{alone} damaged line_error lost repeated unanswered".split())


@pytest.mark.parametrize("kind", ["fault", "warning", "limits", "never", "silent", "step", "write"])
def test_what_differs_is_told_of_each_station(kind: str) -> None:
    said: dict[str, Any] = {"topic": "F2028", "parameter": "S-0-0040", "detail": "5 rpm by master 1"}
    others: list[dict[str, Any]] = [{"parameter": "S-0-0084"}, {"severity": Severity.NOTE}, {"outcome": "still so"}]
    others += [{"topic": "F2029"}] if kind in ("fault", "warning", "limits", "never") else []
    others += [{"detail": "5 rpm by master 2"}, {"detail": "6 rpm by master 1"}] if kind == "write" else []
    for other in others:
        severity = {"severity": Severity.ERROR}
        both = episode(kind, 0, 100, 3, **severity | said), episode(kind, 0, 100, 4, **severity | said | other)
        assert len(kinds(*both)) == 2, other


@pytest.mark.parametrize(("later_s", "count"), [(60, 1), (61, 2)])
def test_what_two_parameters_of_a_drive_tell_is_one(later_s: float, count: int) -> None:
    told = [episode("fault", begin, end, 3, topic="F2028") for begin, end in ((0, 100), (100 + later_s, 300))]
    found = fold(told, 1000, THRESHOLDS)
    assert [one.count for one in found] == [1] * count
    assert found[-1].to_s == 300


def test_a_drift_that_is_far_more_than_that_of_others_is_told_apart() -> None:
    def drifts(*far: float) -> int:
        return len(kinds(*(episode("drift", 0, 9000, 3 + place, worst=one) for place, one in enumerate(far))))

    assert (drifts(0.5, 0.6), drifts(0.5, 0.61), drifts(0.5, 0.55, 0.6)) == (1, 2, 1)


@pytest.mark.parametrize(("later_s", "is_off"), [(180, True), (181, False)])
def test_a_silence_and_a_boot_soon_after_it_are_a_machine_that_was_off(later_s: float, *, is_off: bool) -> None:
    silent = episode("bus_silent", FROM_S, TO_S)
    boot = episode("boot", TO_S + later_s, TO_S + later_s + 20)
    assert kinds(silent, boot) == (["off"] if is_off else ["bus_silent", "boot"])


def test_a_machine_was_off_since_the_last_silence_before_its_boot() -> None:
    silences = [episode("bus_silent", begin_s, begin_s + 20) for begin_s in (900, 950)]
    (off,) = (one for one in fold([*silences, episode("boot", 1000, 1020)], 1000, THRESHOLDS) if one.kind == "off")
    assert off.from_s == 950


def test_after_the_fault_of_one_drive_an_emergency_stop_is_still_one() -> None:
    alone = episode("fault", 0, 100, 3, topic="F4034")
    both = [episode("fault", 1000, 1100, station, topic="F4034") for station in (3, 4)]
    assert kinds(alone, *both) == ["fault", "estop"]


@pytest.mark.parametrize(
    ("later_s", "station", "parameter", "is_cause"),
    [
        (0, 3, "S-0-0036", True),
        (59, 3, "S-0-0036", True),
        (60, 3, "S-0-0036", False),
        (-1, 3, "S-0-0036", False),
        (10, 4, "S-0-0036", False),
        (10, 3, "S-0-0091", False),
    ],
)
def test_a_cause_writes_what_the_effect_reads(later_s: float, station: int, parameter: str, *, is_cause: bool) -> None:
    write = episode("write", 1000, 1000, station, parameter=parameter)
    step = episode("step", 1000 + later_s, 2000, 3, parameter="S-0-0040")
    found = fold([write, step], 1000, THRESHOLDS)
    assert [bool(one.cause) for one in found if one.kind == "step"] == [is_cause]


@pytest.mark.parametrize("kind", ["write", "limit_write", "conflict"])
def test_which_kinds_have_a_cause(kind: str) -> None:
    write = episode(kind, 1000, 1000, 3, parameter="S-0-0036", topic=kind)
    effects = [episode(one, 1000, 2000, 3, parameter="S-0-0040") for one in ("step", "apart", "drift", "changed")]
    said = {one.kind: one.cause for one in fold([write, *effects], 1000, THRESHOLDS) if one.kind != kind}
    assert said == {**dict.fromkeys(("step", "apart"), "soon after the write of S-0-0036"), "drift": "", "changed": ""}


BOOT = "step changed unanswered repeated silent phase write limit_write limits recipe error early cycle"
ELSEWHERE = {"restart", "blip"}  # no state explains them; they have tests of their own
WITHIN = {
    "foreign": "damaged line_error lost unreadable bus_silent",
    "off": f"{BOOT} boot bus_silent stopped apart vanished damaged line_error homing",
    "boot": f"{BOOT} stopped bus_silent",  # the last one together with it: off
    "restart": BOOT,
    "estop": "step changed stopped fault system_error write recipe",
    "stopped": "step changed apart",
    "unreadable": "unanswered repeated damaged line_error lost silent bus_silent",
    "rate": "unanswered repeated damaged line_error silent unreadable",
    "adapter": "gap bus_silent",
    "bus_silent": "unanswered repeated step changed silent boot",
    "fault": "step changed system_error apart",
    "warning": "warning_bit",
    "recipe": "step changed",
    "again": "unanswered repeated",
    "early": "unanswered repeated",
}


@pytest.mark.parametrize("name", EXPLAINS)
def test_all_that_a_state_tells(name: str) -> None:
    """And nothing else."""
    for kind in RULES.keys() - ELSEWHERE - {name}:
        one = episode(kind, FROM_S, TO_S, 4, severity=Severity.NOTE if kind == "write" else None)
        found = kinds(*state(name, 4), one)
        assert found.count(kind) == (kind not in WITHIN[name].split()), kind


@pytest.mark.parametrize(
    ("state_kind", "state_topic", "topic", "is_told"),
    [
        ("estop", "F434", "F434", False),
        ("estop", "F434", "class 1 diagnostic 0x8000", False),
        ("estop", "F434", "F2028", True),
        ("fault", "F2028", "class 1 diagnostic 0x8000", False),
        ("fault", "F2028", "F2029", True),
        ("fault", "class 1 diagnostic 0x8000", "shut down by an error: drive status bit 13", True),
    ],
)
def test_a_code_is_never_hidden_by_another_one(state_kind: str, state_topic: str, topic: str, *, is_told: bool) -> None:
    first = episode(state_kind, FROM_S, TO_S, 4, topic=state_topic)
    second = episode("fault", FROM_S, TO_S, 4, topic=topic, detail=topic)
    assert any(one.hit.detail == topic for one in fold([first, second], 1000, THRESHOLDS)) == is_told


def test_an_emergency_stop_begins_with_the_first_drive_and_ends_with_the_last() -> None:
    ends = 2000, 2200, 2100
    stops = [episode("fault", 1000 + 20 * one, ends[one], 3 + one, topic="F434") for one in range(3)]
    late = [episode("fault", 1090, 1200, 9, topic="F434"), episode("fault", 5000, 5100, 4, topic="F434")]
    stop, *others = fold([*stops, *late], 1000, THRESHOLDS)
    assert (stop.kind, stop.stations, stop.from_s, stop.to_s) == ("estop", {3, 4, 5}, 1000, 2200)
    assert [(one.kind, one.from_s) for one in others] == [("fault", 5000)]  # alone; that at 1090 is told with them
    assert kinds(*stops) == ["estop"]  # nothing has to come after it


@pytest.mark.parametrize(
    ("silence", "is_restart"),
    [((900, 990), True), ((900, 940), True), ((900, 939), False), ((1011, 1100), False), ((990, 1071), False)],
)
def test_a_restart_begins_with_its_silence(silence: tuple[float, float], *, is_restart: bool) -> None:
    found = fold(
        [episode("silent", *silence, 4), episode("restart", 1000, 1010, 4, detail="initialised again")], 9, THRESHOLDS
    )
    restarts = [one for one in found if one.kind == "restart"]
    assert bool(restarts) == is_restart
    for one in restarts:
        assert one.from_s == 900
        assert one.hit.detail == f"silent for {silence[1] - silence[0]} s, initialised again"


@pytest.mark.parametrize("kind", ["silent", "unanswered", "repeated"])
def test_a_restart_begins_with_the_longest_of_what_nobody_answered(kind: str) -> None:
    times = (960, 961), (965, 985), (990, 991)
    silences = [episode(kind, *one, 4) for one in times]
    (restart,) = fold([*silences, episode("restart", 1000, 1010, 4, detail="initialised again")], 9, THRESHOLDS)
    assert (restart.from_s, restart.hit.detail) == (965, "silent for 20 s, initialised again")


def test_a_restart_with_a_silence_in_it_begins_before_it() -> None:
    (restart,) = fold([episode("restart", 1000, 1010, 4), episode("silent", 1004, 1008, 4)], 9, THRESHOLDS)
    assert restart.from_s == 1000


def test_the_silence_of_another_station_is_not_that_of_a_restart() -> None:
    assert kinds(episode("silent", 900, 990, 5), episode("restart", 1000, 1010, 4)) == ["silent"]


@pytest.mark.parametrize(("to_s", "left"), [(TO_S + 60, []), (TO_S + 61, [TO_S])])
def test_a_stop_after_a_boot_begins_where_that_ends(to_s: float, left: list[float]) -> None:
    for from_s in (FROM_S - 60, TO_S):
        found = fold([episode("boot", FROM_S, TO_S), episode("stopped", from_s, to_s)], 1000, THRESHOLDS)
        assert [one.from_s for one in found if one.kind == "stopped"] == left
    far = fold([episode("boot", FROM_S, TO_S), episode("stopped", TO_S + 1, TO_S + 500)], 1000, THRESHOLDS)
    assert [one.from_s for one in far if one.kind == "stopped"] == [TO_S + 1]
    assert kinds(episode("stopped", FROM_S, FROM_S + 10)) == ["stopped"]
    stops = fold([episode("estop", FROM_S, TO_S), episode("stopped", FROM_S + 5, TO_S + 500)], 1000, THRESHOLDS)
    assert [one.from_s for one in stops] == [FROM_S, TO_S]
    was_off = episode("bus_silent", FROM_S, TO_S), episode("boot", TO_S + 70, TO_S + 90)
    found = fold([was_off[0], episode("stopped", FROM_S + 5, TO_S + 500), was_off[1]], 1000, THRESHOLDS)
    assert [(one.kind, one.from_s) for one in found] == [("off", FROM_S), ("stopped", TO_S + 90)]


@pytest.mark.parametrize(("later_s", "count"), [(30, 1), (31, 2)])
def test_damage_of_several_stations_is_one(later_s: float, count: int) -> None:
    assert len(kinds(episode("damaged", 0, 100, 3), episode("damaged", 100 + later_s, 200, 4))) == count
    assert len(kinds(episode("damaged", 0, 100, 3), episode("lost", 100, 200, 4))) == 2


@pytest.mark.parametrize(
    ("count", "telegrams", "severity"),
    [
        (4, 100, Severity.NOTE),
        (5, 100_000, Severity.WARNING),
        (19, 19, Severity.WARNING),
        (20, 2000, Severity.ERROR),
        (20, 2001, Severity.WARNING),
        (20, 0, Severity.ERROR),
    ],
)
def test_damage_weighs_by_its_part_of_all(count: int, telegrams: int, severity: Severity) -> None:
    one = episode("damaged", 0, 100, 3)
    one.count = count
    (found,) = fold([one], telegrams, THRESHOLDS)
    assert found.severity == severity


@pytest.mark.parametrize(("telegrams", "rows"), [(20_000, 1), (20_001, 20)])
def test_damage_that_is_there_all_the_time_is_one(telegrams: int, rows: int) -> None:
    found = fold([episode("damaged", 100.0 * one, 100.0 * one, 3) for one in range(20)], telegrams, THRESHOLDS)
    assert len(found) == rows


def test_each_kind_that_is_there_all_the_time_is_told_by_itself() -> None:
    """A busy station is no damage: never an error."""
    often = [episode(kind, 0, 100, 3) for kind in ("damaged", "lost", "busy")]
    for one in often:
        one.count = 20
    found = fold(often, 1000, THRESHOLDS)
    assert {one.kind: one.severity.name for one in found} == {"damaged": "ERROR", "lost": "ERROR", "busy": "WARNING"}


@pytest.mark.parametrize(("count", "severity"), [(2, Severity.NOTE), (3, Severity.ERROR)])
def test_a_second_answer_may_be_chance(count: int, severity: Severity) -> None:
    one = episode("again", 0, 100, 3)
    one.count = count
    assert [found.severity for found in fold([one], 1000, THRESHOLDS)] == [severity]
