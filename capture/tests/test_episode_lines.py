# SPDX-License-Identifier: GPL-2.0-or-later
"""The five lines: short, with times, what belongs together in one phrase."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from typing import Any

import pytest

from sistap.dissected.episodes.episode import Episode, Hit
from sistap.dissected.episodes.folding import fold
from sistap.dissected.episodes.lines import clock_of, lines, verdict
from sistap.dissected.episodes.rules import RULES, SUBJECTS, THRESHOLDS, Severity

EVENING = datetime(2026, 11, 21, 22)  # noqa: DTZ001 - local time, as it is shown


def at(clock: str) -> float:
    """Return the time of the night at which a clock shows this."""
    hour, minute, second = map(int, clock.split(":"))
    return EVENING.timestamp() + ((hour - 22) % 24) * 3600 + minute * 60 + second


def episode(kind: str, begin: str, end: str = "", station: int | None = None, **more: Any) -> Episode:
    return Episode.of(Hit(kind, 1, at(begin), at(end or begin), station, **more))


def told(*episodes: Episode, begin: str = "22:00:00", end: str = "06:00:00") -> Sequence[str]:
    found = sorted(episodes, key=lambda one: one.from_s)
    return [line.text for line in lines(found, at(begin), at(end))]


LINES = {
    "Bus": "foreign bus_silent unreadable adapter gap estop rhythm off boot stopped",
    "Silent": "silent vanished restart",
    "Drives": "fault homing system_error warning warning_bit stuck beyond apart chatter error never busy slower drift"
    " step blip changed",
    "Changed": "conflict limit_write exchanged other write master phase rate limits recipe",
    "Limits": "again late interval cycle unexpected early damaged line_error lost repeated unanswered clock against",
}


@pytest.mark.parametrize("line", LINES)
def test_each_kind_stands_in_its_line(line: str) -> None:
    for kind in LINES[line].split():
        said = told(episode(kind, "23:10:00", station=4, detail="1 -> 2", worst=1.0))
        found = [one.partition(":")[0] for one in said[1:] if not one.endswith(": nothing.")]
        assert found == ([] if line == "Bus" else [line]), kind  # the bus is told in the first one


def test_no_kind_is_without_a_line() -> None:
    assert {kind for kinds in LINES.values() for kind in kinds.split()} == {*RULES}


# What is said of one episode of each kind, from 23:10:00 on; of those with a *, until 23:11:00.
SAID = {
    "foreign": ("none of 9 records is a telegram: another rate?", "none of 9 records is a telegram: another rate?"),
    "bus_silent*": ("60 s: cable or master off?", "Bus silent {}, all stations: cable or master off?"),
    "unreadable*": ("40 records are no telegrams", "bus unreadable {}: wrong rate, or a short circuit?"),
    "rhythm*": (
        "40 s each: a master that pauses?",
        "Bus silent 1 times in a rhythm {}, 40 s each: a master that pauses?",
    ),
    "adapter": ("gone", "adapter lost {}"),
    "gap*": ("60 s between two captures", "nothing was captured {}"),
    "estop*": ("F4034", "emergency stop, fault F4034 of station 4 {}, still so"),
    "off*": ("stations 3, 4, ready 5 s later", "machine off and on again {}: stations 3, 4, ready 5 s later"),
    "boot*": ("stations 3, 4, ready 5 s later", "initialised at 23:10:00: stations 3, 4, ready 5 s later"),
    "stopped*": ("", "machine stopped {}"),
    "silent*": ("60 s, 31 commands without a reaction", "station 4 from 23:10:00 (60 s), still so"),
    "vanished*": ("master 2 asks nothing any more (9 commands)", "master 2 asks nothing any more, since 23:10:00"),
    "restart*": (
        "silent for 2 s, initialised again",
        "station 4 restarted at 23:10:00: silent for 2 s, initialised again",
    ),
    "fault*": ("F2028 (S-0-0390, before A0101)", "station 4 fault F2028 {}, still so"),
    "homing": ("its position is no longer referenced (S-0-0403)", "station 4 not referenced any more {}, still so"),
    "warning*": ("E2051 (S-0-0390)", "station 4 warning E2051 {}, still so"),
    "stuck*": (
        "stays in phase 2, others are in phase 4",
        "station 4 stays in phase 2, others are in phase 4 since 23:10:00",
    ),
    "beyond": ("31 rpm, its maximum is 30 rpm", "station 4 P-0-0123 31 rpm, its maximum is 30 rpm {}"),
    "apart*": ("50 % below S-0-0036", "station 4 P-0-0123 50 % below S-0-0036 {}, still so"),
    "chatter*": ("7 changes between 0 and 1", "station 4 P-0-0123 7 changes between 0 and 1 {}"),
    "slower*": ("reaction time 10.0 -> 30.0 ms", "station 4 answers slower, reaction time 10.0 -> 30.0 ms"),
    "changed*": ("1 -> 0", "station 4 P-0-0123 1 -> 0 {}, still so"),
    "blip": ("90 %, usually 50", "station 4 P-0-0123 90 %, usually 50 {}"),
    "step*": ("70 %, usually 50", "station 4 P-0-0123 70 %, usually 50 {}, still so"),
    "drift*": ("+5 %/h (not by chance)", "station 4 P-0-0123 +5 %/h"),
    "conflict*": (
        *("master 1 9 rpm, master 2 8 rpm", "station 4 P-0-0123 is written by two masters {}: "),
        "master 1 9 rpm, master 2 8 rpm (2 times), still so",
    ),
    "limit_write": (
        "9.50 rpm -> 5.00 rpm by master 1",
        "master 1 wrote the limit station 4 P-0-0123 9.5 -> 5 rpm at 23:10:00, still so",
    ),
    "exchanged": ("firmware A -> B", "station 4 is another device since 23:10:00: firmware A -> B"),
    "other": (
        "9.50 rpm -> 5.00 rpm, nobody on this bus wrote it",
        "station 4 P-0-0123 9.5 -> 5 rpm at 23:10:00, nobody on this bus wrote it",
    ),
    "write": ("5.00 rpm by new master 17", "new master 17 wrote station 4 P-0-0123 5 rpm at 23:10:00, still so"),
    "master*": ("master 17 asked station 3: 2 commands", "new master 17 asked station 3: 2 commands {}"),
    "phase": ("4 -> 2", "station 4 phase 4 -> 2 {}"),
    "rate": ("9600 -> 19200 Bd", "9600 -> 19200 Bd {}"),
    "limits": ("TzA 2 -> 3 ms", "station 4 TzA 2 -> 3 ms {}"),
    "recipe*": ("master 1 wrote 4 parameters of station 5", "master 1 wrote 4 parameters of station 5 at 23:10:00"),
    "clock": ("-2.5 s; the times go on", "clock -2.5 s at 23:10:00"),
    "late": ("60 ms, TrS 50 ms", "1 reaction later than TrS (60 ms, TrS 50 ms, station 4, {})"),
    "interval": ("3 ms, TzA 2 ms", "1 interval longer than TzA (3 ms, TzA 2 ms, station 4, {})"),
    "cycle": ("9 ms by master 1", "1 master control word later than Tmas (9 ms by master 1, station 4, {})"),
    "system_error": ("", "1 telegram of a station with an error (station 4, {})"),
    "warning_bit": ("", "1 telegram with a warning bit (station 4, {})"),
    "error": ("0x8004", "1 error code (P-0-0123 0x8004, station 4, {})"),
    "never": ("0x1001", "1 request for what a station does not know (P-0-0123 0x1001, station 4, {})"),
    "busy": ("0x8001", "1 reaction of a busy station (P-0-0123 0x8001, station 4, {})"),
    "again": ("", "1 second answer: two stations at one address? (station 4, {})"),
    "unexpected": ("", "1 answer to a broadcast (station 4, {})"),
    "early": ("", "1 command sent again before TrS was over (station 4, {})"),
    "damaged": ("its checksum is wrong", "1 damaged telegram (its checksum is wrong, station 4, {})"),
    "line_error": ("in a telegram", "1 line error (in a telegram, station 4, {})"),
    "lost": ("in a telegram", "1 loss of characters (in a telegram, station 4, {})"),
    "repeated": ("", "1 command sent again (station 4, {})"),
    "unanswered": ("", "1 command without a reaction (station 4, {})"),
    "against": ("", "1 telegram against the rules (station 4, {})"),
}
OF_PARAMETERS = set(
    "beyond apart chatter changed blip step drift conflict limit_write other write error never busy".split()
)


@pytest.mark.parametrize("name", SAID)
def test_what_is_said_of_one_episode(name: str) -> None:
    kind, detail, said = name.rstrip("*"), SAID[name][0], "".join(SAID[name][1:])
    end = "23:11:00" if kind != name else ""
    parameter = "P-0-0123" if kind in OF_PARAMETERS else ""
    made = episode(kind, "23:10:00", end, 4, detail=detail, parameter=parameter, topic=detail[:5], worst=1.0)
    made.outcome, made.count = "still so", 2 if kind == "conflict" else 1
    (phrase,) = (phrase.text for line in lines([made], at("22:00:00"), at("23:59:00")) for phrase in line.phrases)
    assert phrase == said.format(f"23:10:00 to {end}" if end else "23:10:00")


def test_each_kind_is_said_once() -> None:
    assert {name.rstrip("*") for name in SAID} == set(RULES)


FAULT, WARNING = "F2028 (S-0-0390)", "E2051 (S-0-0390)"


def drive(kind: str, station: int, *, still: str = "", begin: str = "23:10:00", detail: str = "") -> Episode:
    detail = detail or {"fault": FAULT, "warning": WARNING}.get(kind, "")
    return Episode.of(episode(kind, begin, "", station, detail=detail, topic=detail[:5], outcome=still).hit)


@pytest.mark.parametrize(
    ("episodes", "said"),
    [
        ([], "OK, {}."),
        ([drive("warning", 3), drive("warning", 4)], "OK, 2 things to look at, {}."),
        (
            [drive("late", 3), drive("early", 3), drive("early", 4)],
            "NOT OK, {}: reaction later than TrS (station 3), 1 thing to look at.",
        ),
        ([drive("warning", 4, still="still so")], "OK, 1 thing to look at, {}: now warning E2051 (station 4)."),
        ([drive("write", 4, still="still set at the end")], "OK, 1 thing to look at, {}."),
        ([drive("fault", 4, still="still so")], "NOT OK, {}: now fault F2028 (station 4)."),
        ([drive("silent", 4, still="not heard again")], "NOT OK, {}: now station silent (station 4)."),
        (
            [drive("fault", 3), drive("fault", 4), drive("fault", 5, detail="F2029")],
            "NOT OK, {}: fault F2028 (stations 3, 4), fault F2029 (station 5).",
        ),
        (
            [drive("fault", 3, still="still so"), drive("fault", 4), drive("stuck", 4), drive("stuck", 5)],
            "NOT OK, {}: now fault F2028 (station 3); fault F2028 (station 4), 2 things to look at.",
        ),
        (
            [drive("fault", 3, still="still so"), drive("stuck", 4)],
            "NOT OK, {}: now fault F2028 (station 3); 1 thing to look at.",
        ),
    ],
)
def test_the_first_line_says_what_is_wrong_and_what_still_is(episodes: Sequence[Episode], said: str) -> None:
    first, *others = told(*episodes)
    assert first == said.format("2026-11-21 22:00:00 to 2026-11-22 06:00:00")
    if not episodes:
        assert others == [f"{subject}: nothing." for subject in SUBJECTS[1:]]


def test_what_was_not_judged_or_described_is_said() -> None:
    made = [line.text for line in lines([drive("fault", 3)], at("22:00:00"), at("23:00:00"), ["TrS", "TzA"], 2)]
    assert made[2].endswith("; parameters without a description: 2; sistap parameters --from FILE.par names them.")
    assert made[4] == "Limits: not judged: TrS, TzA."
    assert verdict([drive("stuck", 3)], is_judged=False) == "OK as far as it was judged, 1 thing to look at"


def test_a_line_has_ten_phrases_and_three_of_them_are_notes() -> None:
    steps = [drive("step", station, detail="70 %, usually 50") for station in range(3, 8)]
    looks = [drive("beyond", station, detail="31 rpm, its maximum is 30 rpm") for station in range(3, 15)]
    few, many = told(*steps, *looks[:2])[2], told(*steps, *looks)[2]
    assert (few.count("its maximum"), few.count("usually"), few.count("more")) == (2, 3, 0)
    assert (many.count("its maximum"), many.count("usually"), many.endswith("; and 2 more.")) == (10, 0, True)
    assert few.index("its maximum") < few.index("usually")


@pytest.mark.parametrize(("kind", "code"), [("fault", "F2028"), ("warning", "E2051")])
def test_many_faults_are_told_by_station_and_code(kind: str, code: str) -> None:
    times = [f"23:{minute}:00" for minute in range(10, 14)]
    faults = [drive(kind, station, begin=time) for time in times for station in (3, 4)]
    other = drive(kind, 3, detail="X2029")
    often = "; ".join(f"{kind.title()} {code} 4 times, station {station} ({', '.join(times)})" for station in (3, 4))
    assert told(*faults, other)[2] == f"Drives: {often}; station 3 {kind} X2029 23:10:00."


def test_three_are_told_one_by_one_and_more_lead_to_the_first() -> None:
    faults = [drive("fault", 3, begin=f"23:1{minute}:00") for minute in range(7)]
    assert told(*faults[:3])[2].count("station 3 fault F2028 23:1") == 3
    assert "more" not in told(*faults[:6])[2] and "and 1 more" in told(*faults)[2]
    (phrase,) = lines(faults, at("22:00:00"), at("23:59:00"))[2].phrases
    assert (phrase.episode, phrase.others) == (faults[0], faults)


def test_of_many_the_longest_is_named() -> None:
    lengths = zip(range(10, 14), (5, 20, 50, 20), strict=True)
    silent = [episode("silent", f"23:{minute}:00", f"23:{minute}:{length}", 4) for minute, length in lengths]
    times = "23:10:00, 23:11:00, 23:12:00, 23:13:00"
    assert told(*silent)[1] == f"Silent: Station silent 4 times, station 4 (longest 50 s at 23:12:00; {times})."
    stops = [Episode.of(one.hit._replace(kind="stopped", station=None)) for one in silent]
    first = "; ".join(told(*stops)[0].split(". ")[1:])
    assert first.startswith("Machine stopped 4 times (23:10:00 to 23:10:05, 23:11:00 to 23:11:20, ")


@pytest.mark.parametrize(
    ("kind", "order"),
    [("step", ["20", "70", "30"]), ("drift", ["20", "70", "30"]), ("apart", ["20", "5", "70", "30"])],
)
def test_what_is_still_so_comes_first_and_then_what_moved_farthest(kind: str, order: Sequence[str]) -> None:
    """Other things are in the order of their beginning."""
    made = [drive(kind, 3 + place, detail=f"{far} % off") for place, far in enumerate((5, 70, 20, 30))]
    for one, far in zip(made, (5.0, 70.0, 20.0, 30.0), strict=True):
        one.hit = one.hit._replace(worst=far)
    made[2].outcome = "still so"
    assert [one.split()[2] for one in told(*made)[2].split(": ")[1].split("; ")] == order
    few = [one.split()[2] for one in told(*made[:3])[2].split(": ")[1].split("; ")]
    assert few == [far for far in order if far != "30"] + ["5"] * (kind != "apart")


@pytest.mark.parametrize("kind", ["step", "drift", "blip", "changed"])
def test_values_that_moved_are_told_one_by_one(kind: str) -> None:
    made = [episode(kind, "23:10:00", station=3, parameter=f"P-0-000{one}", detail="5 rpm") for one in range(4)]
    (line,) = (line for line in lines(made, at("22:00:00"), at("23:59:00")) if line.phrases)
    assert [phrase.episode for phrase in line.phrases] == made[:3]


def test_writes_of_a_visitor_are_counted_apart_from_those_of_a_usual_master() -> None:
    made = [
        episode("write", f"23:1{one}:00", station=3, parameter="P-0-0123", detail="5 rpm by master 1")
        for one in range(4)
    ]
    for one in made[2:]:
        one.severity = Severity.NOTE
    assert told(*made)[3].count("master 1 wrote") == 4


def test_cause_and_outcome_are_said_in_this_order() -> None:
    step = drive("step", 3, detail="200 rpm below S-0-0036")
    step.cause, step.outcome = "soon after the write of S-0-0036", "still so when last read"
    assert told(step)[2].endswith(", soon after the write of S-0-0036, still so when last read.")


def test_days_are_named_where_a_capture_has_several() -> None:
    fault = Episode.of(drive("fault", 3).hit._replace(to_s=at("23:11:00")))
    line = lines([fault], at("22:00:00"), at("22:00:00") + 2 * 86_400)[2]
    assert line.text == "Drives: station 3 fault F2028 2026-11-21 23:10:00 to 2026-11-21 23:11:00."


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            [(6, "4 -> 2"), (6, "2 -> 4"), (6, "4 -> 3")],
            "station 6 phase 4 -> 2 -> 4 {0} to {1}; station 6 phase 4 -> 3 {2}",
        ),
        (
            [(6, "4 -> 2"), (6, "3 -> 4"), (6, "4 -> 2")],
            "station 6 phase 4 -> 2 {0}; station 6 phase 3 -> 4 -> 2 {1} to {2}",
        ),
        (
            [(6, "4 -> 2"), (5, "2 -> 4"), (5, "4 -> 2")],
            "station 5 phase 2 -> 4 -> 2 {1} to {2}; station 6 phase 4 -> 2 {0}",
        ),
        ([(None, "9600 -> 19200 Bd"), (None, "19200 -> 38400 Bd")], "9600 -> 19200 -> 38400 {0} to {1}"),
    ],
)
def test_what_goes_on_where_the_last_one_ended_is_one_phrase(changes: Sequence[tuple[int, str]], said: str) -> None:
    times = "01:30:00", "01:31:00", "01:32:00"
    kind = "rate" if "Bd" in changes[0][1] else "phase"
    made = [
        episode(kind, time, station=station, detail=what) for time, (station, what) in zip(times, changes, strict=False)
    ]
    assert told(*made)[3] == f"Changed: {said.format(*times)}."
    assert all(phrase.episode in made for phrase in lines(made, at("01:00:00"), at("02:00:00"))[3].phrases)
    assert lines(made[:2], at("01:00:00"), at("02:00:00"))[3].phrases[0].episode is made[0]


@pytest.mark.parametrize(
    ("certain", "perhaps", "said"),
    [
        (2, 0, "2 intervals longer than TzA (worst 9 ms at 23:10:00, station 6, 23:10:00, 23:11:00)"),
        (1, 2, "1 interval longer than TzA, perhaps 2 more (9 ms, TzA 2 ms, station 6, 23:10:00)"),
        (0, 2, "perhaps 2 intervals longer than TzA (worst 9 ms at 23:10:00, station 7, 23:10:00, 23:11:00)"),
    ],
)
def test_what_is_certain_is_counted_apart(certain: int, perhaps: int, said: str) -> None:
    def hits(count: int, before: str, **more: Any) -> list[Episode]:
        detail = f"{before}9 ms, TzA 2 ms"
        station = 7 if before else 6
        return [
            episode("interval", f"23:1{one}:00", "", station, detail=detail, worst=0.009, **more)
            for one in range(count)
        ]

    unsure = hits(perhaps, "perhaps: ", severity=Severity.NOTE)
    assert told(*hits(certain, ""), *unsure)[4] == f"Limits: {said}."
    for one in unsure:
        one.count = 4
    assert told(*hits(certain, ""), *unsure)[4] == f"Limits: {said.replace('perhaps 2', 'perhaps 8')}."


def test_times_that_nobody_measured_have_no_worst() -> None:
    made = [
        episode("late", "23:10:00", "", station, detail="perhaps: not measured", severity=Severity.NOTE)
        for station in (3, 4)
    ]
    assert told(*made)[4] == "Limits: perhaps 2 reactions later than TrS (not measured, stations 3, 4, 23:10:00)."
    made.append(episode("late", "23:10:00", "", 3, worst=0.06, severity=Severity.NOTE))
    said = "perhaps 3 reactions later than TrS (worst 60 ms at 23:10:00, stations 3, 4, 23:10:00)"
    assert told(*made)[4] == f"Limits: {said}."


def test_of_many_codes_the_most_frequent_come_first() -> None:
    errors = [episode("error", "23:10:00", station=3 + place, detail=f"0x700{place}") for place in range(5)]
    errors[4].count, errors[3].count = 9, 4
    assert told(*errors, *errors)[2] == (
        "Drives: 32 error codes (0x7004, 0x7003, 0x7000 and 2 more, stations 3, 4, 5, 6, 7, 23:10:00)."
    )
    assert told(*errors[:3])[2] == "Drives: 3 error codes (0x7000, 0x7001, 0x7002, stations 3, 4, 5, 23:10:00)."


def test_more_than_three_times_are_from_the_first_to_the_last() -> None:
    lost = [episode("lost", f"23:1{minute}:00", station=3) for minute in range(4)]
    assert told(*lost)[4] == "Limits: 4 losses of characters (station 3, 23:10:00 to 23:13:00)."
    assert told(*lost[:3])[4] == "Limits: 3 losses of characters (station 3, 23:10:00, 23:11:00, 23:12:00)."


def test_more_than_eight_stations_are_counted() -> None:
    lost = [episode("lost", "23:10:00", "23:20:00", station) for station in range(3, 12)]
    assert "9 losses of characters (9 stations, 23:10:00 to 23:20:00)" in told(*lost)[4]
    lost[0].to_s = lost[0].from_s
    assert "(stations 3, 4, 5, 6, 7, 8, 9, 10, 23:10:00 to 23:20:00)" in told(*lost[:8])[4]


MANY = {
    "system_error": "telegrams of stations with an error",
    "warning_bit": "telegrams with a warning bit",
    "error": "error codes",
    "busy": "reactions of busy stations",
    "never": "requests for what a station does not know",
    "again": "second answers: two stations at one address?",
    "late": "reactions later than TrS",
    "interval": "intervals longer than TzA",
    "cycle": "master control words later than Tmas",
    "unexpected": "answers to broadcasts",
    "early": "commands sent again before TrS was over",
    "damaged": "damaged telegrams",
    "line_error": "line errors",
    "lost": "losses of characters",
    "repeated": "commands sent again",
    "unanswered": "commands without a reaction",
    "against": "telegrams against the rules",
}


@pytest.mark.parametrize("kind", MANY)
def test_what_is_only_counted(kind: str) -> None:
    """It is one thing to look at, however often it is."""
    more: dict[str, Any] = {"severity": Severity.WARNING, "detail": "0x7009", "worst": 2.0}
    made = [episode(kind, clock, station=station, **more) for station, clock in ((3, "23:10:00"), (4, "23:40:00"))]
    made[1].count = 8
    first, *others = told(*made)
    assert first.startswith("OK, 1 thing to look at, ")
    (line,) = (line for line in others if not line.endswith(": nothing."))
    assert f": 9 {MANY[kind]} (" in line
    assert ("0x7009" in line) == (kind in ("error", "never"))
    is_timed = kind in ("late", "interval", "cycle")
    assert ("station 3 up to 2000 ms, station 4 up to 2000 ms" if is_timed else "stations 3, 4") in line


def test_a_time_in_no_calendar_is_said() -> None:
    assert clock_of(1e18, 2e18)(1e18) == clock_of(0, 1e18)(1e18) == "a time in no calendar"
    assert clock_of(0, 1e18)(at("22:00:00")) == "22:00:00"
    assert clock_of(1e18, 0)(at("22:00:00")) == "22:00:00"


def test_a_number_of_a_diagnosis_is_shown_as_a_drive_does() -> None:
    changed = episode("changed", "23:10:00", station=3, parameter="S-0-0390", detail="0x000A0101 -> 0x000A0012")
    assert told(changed)[2] == "Drives: station 3 S-0-0390 A0101 -> A0012 23:10:00."


def test_a_night_in_five_lines() -> None:
    late = [
        episode("late", clock, station=3, detail=f"{worst_s * 1e3:.3f} ms, TrS 40 ms", worst=worst_s)
        for clock, worst_s in (("22:17:00", 0.0406), ("05:12:00", 0.201), ("05:12:50", 0.09))
    ]
    first, silent, drives, changed, limits = told(
        episode("bus_silent", "04:30:00", "04:35:00", detail="300 s: cable or master off?", worst=300.0),
        episode("silent", "00:40:12", "00:41:42", 4, detail="90 s, 501 commands without a reaction"),
        episode("silent", "04:50:31", "04:52:01", 6, detail="90 s, 501 commands without a reaction"),
        episode("fault", "02:20:00", "02:23:00", 4, detail="F2028 (S-0-0390, before A0101)", topic="F2028"),
        episode("drift", "22:00:00", "06:00:00", 5, parameter="S-0-0084", detail="+5 %/h (not by chance)"),
        episode("error", "22:33:00", station=3, detail="0x8001"),
        episode("error", "01:17:00", station=4, detail="0x8002"),
        episode(
            *("write", "03:12:07", "", 4),
            parameter="S-0-0091",
            detail="3000.0000 rpm -> 500.0000 rpm by new master 17",
            worst=500.0,
        ),
        *late,
        episode("interval", "05:40:00", station=6, detail="30.000 ms", worst=0.03),
        episode("interval", "03:03:00", station=6, detail="perhaps", worst=0.06, severity=Severity.NOTE),
        episode("damaged", "00:03:00", station=6, detail="its checksum is wrong"),
        episode("damaged", "02:12:00", station=3, detail="its checksum is wrong"),
        episode("lost", "05:05:00", station=3, detail="in a telegram that is damaged"),
        episode("clock", "05:50:00", "05:50:25", detail="-25 s", worst=-25.0),
    )
    assert first == (
        "NOT OK, 2026-11-21 22:00:00 to 2026-11-22 06:00:00: reaction later than TrS (station 3), station silent "
        "(stations 4, 6), fault F2028 (station 4), bus silent, interval longer than TzA (station 6), "
        "3 things to look at. Bus silent 04:30:00 to 04:35:00, all stations: cable or master off?"
    )
    assert silent == "Silent: station 4 from 00:40:12 (90 s); station 6 from 04:50:31 (90 s)."
    assert drives == (
        "Drives: station 4 fault F2028 02:20:00 to 02:23:00; "
        "2 error codes (0x8001, 0x8002, stations 3, 4, 22:33:00, 01:17:00); station 5 S-0-0084 +5 %/h."
    )
    assert changed == "Changed: new master 17 wrote station 4 S-0-0091 3000 -> 500 rpm at 03:12:07."
    assert limits == (
        "Limits: 3 reactions later than TrS (worst 201 ms at 05:12:00, station 3, 22:17:00, 05:12:00, 05:12:50); "
        "1 interval longer than TzA, perhaps 1 more (30.000 ms, station 6, 05:40:00); "
        "clock -25 s at 05:50:00; "
        "2 damaged telegrams (stations 3, 6, 00:03:00, 02:12:00); "
        "1 loss of characters (in a telegram that is damaged, station 3, 05:05:00)."
    )


@pytest.mark.parametrize(
    ("outcome", "said"),
    [
        ("", ""),
        ("still set at the end", ", still set at the end"),
        ("at the end 480.5000 rpm", ", at the end 480.5 rpm"),
    ],
)
def test_what_became_of_a_write(outcome: str, said: str) -> None:
    written = episode("write", "03:12:07", station=4, parameter="S-0-0091", detail="3000 rpm -> 500 rpm by master 17")
    assert told(replace(written, outcome=outcome))[3] == (
        f"Changed: master 17 wrote station 4 S-0-0091 3000 rpm -> 500 rpm at 03:12:07{said}."
    )


def test_what_follows_a_write_and_what_lasts_is_said() -> None:
    """A write to another station, or an earlier or a later one, is not the cause."""
    writes = [("01:50:00", 3, "S-0-0036"), ("01:50:01", 4, "S-0-0091"), ("01:40:00", 3, "S-0-0100")]
    stepped = episode("step", "01:50:07", "01:54:59", 3, parameter="S-0-0040", detail="200 rpm below S-0-0036")
    lasting = Episode.of(stepped.hit._replace(from_s=at("02:30:00"), to_s=at("05:59:58"), outcome="still so"))
    before = Episode.of(stepped.hit._replace(from_s=at("01:48:00"), to_s=at("01:49:00")))
    written = [episode("write", clock, "", station, parameter=parameter) for clock, station, parameter in writes]
    assert told(*fold([before, stepped, lasting, *written], 1000, THRESHOLDS))[2] == (
        "Drives: station 3 S-0-0040 200 rpm below S-0-0036 02:30:00 to 05:59:58, still so; "
        "station 3 S-0-0040 200 rpm below S-0-0036 01:48:00 to 01:49:00; "
        "station 3 S-0-0040 200 rpm below S-0-0036 01:50:07 to 01:54:59, soon after the write of S-0-0036."
    )


def test_there_and_back_is_one_phrase() -> None:
    switched = [("01:30:00", 6, "4 -> 2"), ("01:30:40", 6, "2 -> 4"), ("01:30:20", 3, "4 -> 3")]
    assert told(
        *(episode("phase", clock, station=station, detail=detail) for clock, station, detail in switched),
        episode("rate", "02:45:00", detail="9600 -> 19200 Bd"),
        episode("rate", "02:55:00", detail="19200 -> 9600 Bd"),
    )[3] == (
        "Changed: station 6 phase 4 -> 2 -> 4 01:30:00 to 01:30:40; station 3 phase 4 -> 3 01:30:20; "
        "19200 Bd 02:45:00 to 02:55:00."
    )


def test_what_perhaps_is_none_comes_last() -> None:
    perhaps = episode("interval", "01:00:00", station=6, detail="perhaps: 6.000 ms", severity=Severity.NOTE)
    jumped = episode("clock", "03:07:04", detail="+3600 s; the times go on without the jump", severity=Severity.NOTE)
    assert told(perhaps, jumped)[4] == (
        "Limits: clock +3600 s at 03:07:04; perhaps 1 interval longer than TzA (6.000 ms, station 6, 01:00:00)."
    )


def test_a_cable_that_is_off_ten_times_is_one_phrase() -> None:
    flaps = [
        episode("bus_silent", f"22:{minute}:00", f"22:{minute}:{seconds}", worst=float(seconds))
        for minute, seconds in zip(range(10, 20), [10] * 9 + [50], strict=True)
    ]
    assert told(*flaps)[0].endswith(
        ". Bus silent 10 times (longest 50 s at 22:19:00; 22:10:00, 22:11:00, 22:12:00, 22:13:00, 22:14:00, 22:15:00 "
        "and 4 more)."
    )


@pytest.mark.parametrize(
    ("begin", "end", "said"),
    [("22:00:00", "23:00:00", "22:00:00 to 23:00:00"), ("23:00:00", "01:00:00", "2026-11-22 ")],
)
def test_the_date_is_said_where_it_changes(begin: str, end: str, said: str) -> None:
    assert said in told(begin=begin, end=end)[0]
