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
from sistap.dissected.episodes.lines import lines
from sistap.dissected.episodes.rules import RULES, THRESHOLDS, Severity

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
