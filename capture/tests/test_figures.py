# SPDX-License-Identifier: GPL-2.0-or-later
"""What a report says of telegrams whose times are known to the microsecond: each figure worked out by hand.

A character at 9600 Bd 8E1 has eleven bits: 1.146 ms. A verdict with the interval I, the limit L and the uncertainty u:
kept if I + u <= L; and whether I or I less a character counts, no document says.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest
from machines import BEGIN_S, LAPTOP, PLC, access, judged, packet, telegram
from no_tap import Printing
from portable import BERLIN, WINDOWS, posix, zone

from sistap.commands.report import plots, tables, windows
from sistap.commands.report.figures import Figures
from sistap.commands.report.gather import Report, gather, learned
from sistap.commands.report.unjudged import unjudged
from sistap.commands.report.windows import ReportWindow
from sistap.dissected.captures.portions import Portion
from sistap.dissected.draw.panel import Area, Strokes
from sistap.dissected.episodes.engine import Engine
from sistap.dissected.episodes.episode import Episode, Hit
from sistap.dissected.episodes.rules import RULES, THRESHOLDS
from sistap.dissected.packets.dissection import EXCEEDED, OK, UNRESOLVED, Dissection, Judged, Packet, Telegram
from sistap.dissected.packets.distribution import Distribution, Slices
from sistap.dissected.wireshark.rows import EVENT, FRAME, OTHER
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.line.settings import Flag
from sistap.tap.records.record import KEPT, Event, Framing
from sistap.tap.sis.faults import FAULTS

MS = 1e-3
U_S = 0.3 * MS


def report(*packets: Packet, episodes: Sequence[Episode] = (), **more: Any) -> Report:
    figures = Figures()
    for one in packets:
        figures.add(one)
    figures.finish()
    return Report(figures, [*episodes], [], [], "", {}, **more)


def at(second: float, *telegrams: Telegram, **more: Any) -> Packet:
    """Return a record so long after the first."""
    more = {"uncertainty_s": U_S, "number": int(second * 10) + 1, "time_s": second} | more
    return packet(BEGIN_S + second, *telegrams, **more)


def row(table: tables.ReportTable, head: str, number: int = 0) -> str:
    return table.rows[number][table.heads.index(head)]


def cells(table: tables.ReportTable, number: int = 0) -> dict[str, str]:
    return dict(zip(table.heads, table.rows[number], strict=True))


def said(table: tables.ReportTable) -> dict[str, str]:
    return {name: text for name, text, *_ in table.rows}


def answered(reaction: Judged | None = None, **more: Any) -> Telegram:
    return telegram(3, PLC, is_reaction=True, reaction=reaction, **more)


def paused(time_ms: float, limit_ms: float | None = 2.0, verdict: int | None = OK, place: int = 5) -> Telegram:
    """Return a reaction with this longest interval before a character."""
    limit_s = None if limit_ms is None else limit_ms * MS
    return answered(pause=judged(time_ms * MS, limit_s, verdict), pause_position=place)  # type: ignore[arg-type]


@pytest.fixture(autouse=True)
def _in_berlin(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    yield from zone(monkeypatch, BERLIN)


# -- TzA: intervals by talker ----------------------------------------------------------------------------------------


def pauses(*telegrams: Telegram, **more: Any) -> tables.ReportTable:
    return tables.pauses(report(*(at(second, one, **more) for second, one in enumerate(telegrams))))


def test_the_smallest_safe_tza_is_the_longest_interval_with_its_uncertainty() -> None:
    table = pauses(paused(1.2), paused(1.5, place=7), paused(1.5, place=9))
    assert table.rows == [
        ("3", "9600 Bd", "3", "1.500 ms", "7", "1.800 ms", "90%", "2 ms", "1 ms", "", ""),
    ]  # of equal ones the first; 1.8 ms less a character are 0.654 ms


def test_each_interval_is_a_share_of_the_limit_that_held() -> None:
    """TzA was lowered in between: 3 ms of 4, then 0.7 of 2."""
    assert row(pauses(paused(2.7, 4.0), paused(0.7, 2.0)), "Share of TzA") == "75%"


def test_of_equal_ones_the_first_counts_also_where_packets_are_counted_together() -> None:
    for second_ms, expected in ((1.5, "7"), (1.4, "9")):
        alike, times = object(), ((0.0001, 1.2, 5), (0.0002, second_ms, 7), (0.0003, 1.5, 9))  # all in one slice
        packets = [at(second, paused(time_ms, place=place), number=place) for second, time_ms, place in times]
        packets[0].alike = packets[2].alike = alike
        assert row(tables.pauses(report(*packets)), "Before character") == expected


@pytest.mark.parametrize(
    ("longest_ms", "safe", "alone"),
    [(1.7, "2 ms", "1 ms"), (1.701, "3 ms", "1 ms"), (1.845, "3 ms", "1 ms"), (1.846, "3 ms", "2 ms")],
)
def test_it_is_whole_ms(longest_ms: float, safe: str, alone: str) -> None:
    table = pauses(paused(longest_ms, None, None))
    assert (row(table, "Smallest safe TzA"), row(table, "If only the pause counts")) == (safe, alone)
    assert row(table, "Share of TzA") == ""


def test_without_an_uncertainty_nobody_knows_what_is_safe() -> None:
    known, unknown = [at(0, paused(1.2))] * 6, at(1, paused(1.5), uncertainty_s=None)
    for records in ([*known, unknown], [unknown, *known]):
        table = tables.pauses(report(*records))
        assert table.rows == [("3", "9600 Bd", "7", "1.500 ms", "5", "", "", "not known", "not known", "", "")]


def test_each_interval_has_the_uncertainty_of_its_own_record() -> None:
    """1.2 ms may be 2.2 ms, 1.5 ms at most 1.8 ms."""
    table = tables.pauses(report(at(0, paused(1.2), uncertainty_s=MS), at(1, paused(1.5))))
    assert (row(table, "Longest interval"), row(table, "With its uncertainty")) == ("1.500 ms", "2.200 ms")


def test_no_tza_is_below_a_millisecond() -> None:
    """The times of a logic analyser are as good as exact, and there was no pause between the characters."""
    table = pauses(paused(1.145), uncertainty_s=0.0)
    assert (row(table, "Smallest safe TzA"), row(table, "If only the pause counts")) == ("2 ms", "1 ms")


def test_of_a_talker_without_an_interval_nothing_is_known() -> None:
    """Its records are cut, say. Where only the place is not known, the interval is told."""
    nothing, old = pauses(telegram(0, PLC)), pauses(answered(pause=judged(1.2 * MS, 2 * MS, OK)))
    assert nothing.rows == [("0", "9600 Bd", "0", "not measured", "", "", "", "not known", "not known", "", "")]
    assert (row(old, "Longest interval"), row(old, "Before character")) == ("1.200 ms", "")


@pytest.mark.parametrize(("count", "text"), [(5, ""), (6, "fewer than 1 in 2"), (3000, "fewer than 1 in 1000")])
def test_how_rare_longer_ones_are(count: int, text: str) -> None:
    """Of n without a single one: with 95 % confidence less than 3 of n."""
    assert row(pauses(*[paused(1.2)] * count), "Longer ones (95 % sure)") == text


@pytest.mark.parametrize(
    ("times_ms", "text"),
    [
        ([1.9], "1; an uncertainty below 0.100 ms decides them"),
        ([1.9, 1.8], "2; an uncertainty below 0.100 ms decides them"),
        ([2.0], "1; exactly the limit"),
        ([2.5], "1; 1 depends on where TzA begins to count"),  # without a character 1.354 ms
        ([2.5, 2.6, 1.9], "3; an uncertainty below 0.100 ms decides 1, 2 depend on where TzA begins to count"),
        ([3.2], "1; an uncertainty below 0.054 ms decides them"),  # without a character 2.054 ms
    ],
)
def test_what_would_decide_the_unresolved(times_ms: Sequence[float], text: str) -> None:
    assert row(pauses(*(paused(time_ms, 2.0, UNRESOLVED) for time_ms in times_ms)), "Unresolved") == text


def test_a_rate_that_nobody_knows() -> None:
    """Then no character time is known: what only the pause could decide depends on what counts."""
    table = tables.pauses(report(at(0, paused(1.2)), at(1, paused(3.2, 2.0, UNRESOLVED), baud=None)))
    assert [one[1] for one in table.rows] == ["", "9600 Bd"]
    assert row(table, "Unresolved") == "1; 1 depends on where TzA begins to count"
    assert row(table, "Smallest safe TzA") == row(table, "If only the pause counts") == "4 ms"


def test_talkers_and_rates_are_told_apart_and_lost_or_damaged_telegrams_are_not_counted() -> None:
    table = tables.pauses(
        report(
            at(0, paused(1.2), intervals_s=[1.2 * MS]),
            at(1, paused(1.3), baud=19200, intervals_s=[1.3 * MS]),
            at(2, telegram(PLC, 3, pause=judged(1.4 * MS, 2 * MS, OK)), intervals_s=[1.4 * MS]),
            at(3, paused(9.0), errors=int(Flag.LOST_BEFORE), intervals_s=[9 * MS]),
            at(4, paused(9.0), intervals_s=[9 * MS], same_read=1),  # all came in one read
            at(5, answered(good=False, pause=judged(9 * MS, 2 * MS, OK)), intervals_s=[9 * MS]),
            at(7, paused(1.25), intervals_s=[1.25 * MS], errors=int(Flag.CHARACTER_ERROR)),  # its times are right
            at(6, paused(9.0), paused(9.0), intervals_s=[9 * MS]),  # two in a record: nobody knows whose it is
        )
    )
    assert [one[:4] for one in table.rows] == [
        ("1", "9600 Bd", "1", "1.400 ms"),
        ("3", "9600 Bd", "2", "1.250 ms"),
        ("3", "19200 Bd", "1", "1.300 ms"),
    ]


def test_places_in_a_telegram() -> None:
    """From the 24th character on, places are counted together."""
    long = [1 * MS] * 22 + [3 * MS, 5 * MS]  # before characters 2 to 25
    made = report(at(0, paused(5), intervals_s=long), at(1, paused(2), intervals_s=[2 * MS]))
    table = tables.places(made)
    assert cells(table) == {
        **{"Before character": "2", "Intervals": "2"},
        **{"Average": "1.500 ms", "99 % within": "2.000 ms", "Longest": "2.000 ms"},
    }
    assert table.rows[1] == ("3", "1", "1.000 ms", "1.000 ms", "1.000 ms")
    assert table.rows[-1] == ("24 and later", "2", "4.000 ms", "5.000 ms", "5.000 ms")
    assert len(table.rows) == 23 and made.figures.pauses.intervals.count == 25  # each once, however often it is asked


def test_all_intervals_of_telegrams_together() -> None:
    """Also of damaged ones, and where two are in a record; not of what came in one read."""
    records = [paused(1), answered(good=False), paused(1)]
    made = report(
        *(at(n, one, intervals_s=[n * MS, 2 * MS], same_read=n) for n, one in enumerate(records)),
        at(4, paused(1), paused(1), intervals_s=[4 * MS, 6 * MS]),
    )
    intervals = made.figures.pauses.intervals
    assert (intervals.count, intervals.longest_s) == (6, 6 * MS)
    assert intervals.average_s == pytest.approx(2.5 * MS)


def test_a_lane_of_a_talker_has_the_limits_that_held() -> None:
    drawing = plots.pauses_by_talker(report(at(0, paused(1.2, 4.0)), at(1, paused(1.2, 2.0)), at(2, paused(1.2, None))))
    assert drawing
    ((panel,),) = drawing.draw()
    (red,) = (mark for mark in panel.marks if isinstance(mark, Strokes))
    assert sorted(red.at) == [2 * MS, 4 * MS]


def test_what_waits_to_be_counted_is_bounded() -> None:
    figures, alike = Figures(), cast(Any, object())
    for number in range(2048):
        assert figures.telegrams == number // 256 * 256
        figures.add(at(number, paused(1), intervals_s=[1 * MS], alike=alike))
    assert not figures.pauses._waiting


# -- Stations, services, verdicts ------------------------------------------------------------------------------------


def exchanges() -> list[Packet]:
    """Station 3 answers twice, once with an error, and not once; 4 never; master 1 sends again."""
    return [
        at(0, telegram(PLC, 3)),
        at(0.1, answered(judged(10 * MS, 50 * MS, OK))),
        at(1, telegram(PLC, 3)),
        at(1.1, answered(judged(60 * MS, 50 * MS, EXCEEDED), is_refusal=True, is_doubtful=True)),
        at(2, telegram(PLC, 3, unanswered=True)),
        at(3, telegram(PLC, 3, is_repeat=True)),
        at(3.1, answered(judged(0.0, 50 * MS, UNRESOLVED))),  # in one read with its command
        at(4, telegram(PLC, 4, unanswered=True)),
        at(5, answered(good=False)),
    ]


def test_stations() -> None:
    table = tables.stations(report(*exchanges()))
    assert table.rows == [
        ("1", "5", "0", "0", "1", "0", "", "", "", "0", "0"),
        ("3", "0", "3", "1", "0", "1", "10.000 ms", "60.000 ms", "", "1", "0"),
        ("4", "0", "0", "0", "0", "1", "", "", "", "0", "0"),
    ]


def test_each_station_has_its_own_longest_interval() -> None:
    """Station 5 never pauses as long as 3, and 3 exceeds TzA at three rates."""
    slow = zip((5, 20, 9), (9600, 19200, 38400), strict=True)
    made = report(
        *(at(n, paused(ms, 2.0, EXCEEDED), baud=baud) for n, (ms, baud) in enumerate(slow)),
        at(3, telegram(5, PLC, is_reaction=True, pause=judged(1.2 * MS, 2 * MS, OK))),
        at(4, telegram(PLC, 5)),
    )
    table = tables.stations(made)
    heads = "Station", "Longest interval in a telegram", "TzA exceeded"
    assert [[row(table, head, number) for head in heads] for number in range(3)] == [
        ["1", "", "0"],
        ["3", "20.000 ms", "3"],
        ["5", "1.200 ms", "0"],
    ]


def test_station_0_and_service_0_are_like_others() -> None:
    """Service 0x00 is the identification."""
    asked, unanswered = telegram(PLC, 0, service=0), telegram(PLC, 0, service=0, unanswered=True)
    reaction = telegram(0, PLC, is_reaction=True, service=0, reaction=judged(10 * MS, 50 * MS, OK))
    made = report(at(0, asked), at(0.1, reaction), at(1, unanswered))
    assert tables.stations(made).rows[0][:8] == ("0", "0", "1", "0", "0", "1", "10.000 ms", "10.000 ms")
    assert [(one[0][:5], one[1]) for one in tables.services(made).rows] == [("0x00 ", "1")]


def test_all_telegrams_of_a_packet_count() -> None:
    """Two commands and two reactions in two packets, as TCP packs them: the second station refuses."""
    asked = at(0, telegram(PLC, 3), telegram(PLC, 4))
    refusal = telegram(4, PLC, is_reaction=True, is_refusal=True, reaction=judged(30 * MS, 50 * MS, OK))
    made = report(asked, at(0.1, answered(judged(10 * MS, 50 * MS, OK)), refusal))
    assert said(tables.summary(made))["Telegrams"] == "4, 0 of them with a wrong checksum or none"
    assert [one[:8] for one in tables.stations(made).rows] == [
        ("1", "2", "0", "0", "0", "0", "", ""),
        ("3", "0", "1", "0", "0", "0", "10.000 ms", "10.000 ms"),
        ("4", "0", "1", "1", "0", "0", "30.000 ms", "30.000 ms"),
    ]


def test_a_reaction_without_a_service_is_in_no_row_of_services() -> None:
    made = report(at(0, answered(judged(10 * MS, 50 * MS, OK), service=None)))
    assert tables.services(made).rows == []


def test_reactions_that_could_not_be_measured_are_said_to_be() -> None:
    """All of them came in one read with their command, say."""
    table = tables.stations(report(at(0, answered(judged(0, 50 * MS, UNRESOLVED))), at(1, telegram(PLC, 3))))
    shown = {table.rows[number][0]: row(table, "Slowest reaction", number) for number in range(len(table.rows))}
    assert shown == {"1": "", "3": "not measured"}


def test_telegrams_that_are_alike_count_each() -> None:
    """As packets have it that say the same."""
    commands, reactions = object(), object()
    late = tuple(fault for fault in FAULTS if fault.name == "trs_exceeded")
    refusal = answered(judged(60 * MS, 50 * MS, EXCEEDED), is_refusal=True, status=1)
    made = report(
        *(at(n, telegram(PLC, 3, is_repeat=True, unanswered=True), alike=commands) for n in range(3)),
        *(at(n + 0.5, refusal, alike=reactions, faults=late) for n in range(3)),
    )
    master, station = (cells(tables.stations(made), number) for number in (0, 1))
    counts = {name: count for name, count in master.items() if count not in ("0", "")}
    assert counts == {"Station": "1", "Commands": "3", "Sent again": "3"}
    assert {name: count for name, count in station.items() if count not in ("0", "")} == {
        **{"Station": "3", "Reactions": "3", "With an error": "3", "Not answered": "3", "TrS exceeded": "3"},
        **{"Half of its reactions within": "60.000 ms", "Slowest reaction": "60.000 ms"},
    }
    found = [cells(tables.faults(made), number) for number in range(len(FAULTS))]
    assert {one["What"]: one["How often"] for one in found if one["What to do"]} == {"Reaction later than TrS": "3"}


def test_reaction_times_by_service_and_verdicts() -> None:
    made = report(*exchanges())
    (service,) = tables.services(made).rows
    times = "10.000 ms", "35.000 ms", "10.000 ms", "60.000 ms", "60.000 ms"
    assert service == ("0x10 Read parameter", "2", *times, "50 ms", "1", "1")
    assert [one[1:6] for one in tables.verdicts(made).rows] == [
        ("not known", "0", "0", "0", "0"),
        ("50 ms", "1", "1", "1", "0"),
        ("not known", "0", "0", "0", "0"),
    ]
    assert tables.verdicts(made).note.startswith("1 unresolved: the times are uncertain by 0.300 ms. ")
    assert said(tables.summary(made))["Telegrams"] == "9, 1 of them with a wrong checksum or none"


def test_verdicts_on_each_limit() -> None:
    """TzA and Tmas; each in a column of its own, and all that are unresolved in the sum above."""
    verdicts = (OK, 1), (EXCEEDED, 2), (UNRESOLVED, 3), (None, 4)
    pauses = [paused(1, None if one is None else 4.0, one) for one, count in verdicts for _ in range(count)]
    limits = 0.5, 0.1, 0.25, 0.3
    cycles = [telegram(PLC, 3, cycle=judged(0.6, limit_s, EXCEEDED)) for limit_s in limits]
    unresolved = telegram(PLC, 3, cycle=judged(0.6, 0.5, UNRESOLVED))
    made = report(*(at(n, one) for n, one in enumerate([*pauses, *cycles, unresolved])))
    table = tables.verdicts(made)
    tza, _, tmas = ([*cells(table, number).values()][1:6] for number in range(3))
    shown = [(one[0].partition(",")[0], one[-1]) for one in table.rows]
    assert shown == [(name, f"sis.{name.lower()}.verdict == 1") for name in ("TzA", "TrS", "Tmas")]
    assert table.heads[1:6] == ("Value", "Kept", "Exceeded", "Unresolved", "No limit known")
    assert (tza, tmas) == (["4 ms", "1", "2", "3", "4"], ["100 ms, 250 ms, 300 ms, 500 ms", "0", "4", "1", "0"])
    assert table.note.startswith("4 unresolved: ")


def test_filters_stand_in_a_column_of_their_own() -> None:
    made = report(*exchanges())
    shown = tables.verdicts(made), tables.faults(made), tables.episodes(made)
    assert [table.heads[table.code or 0].partition(" for")[0] for table in shown] == [
        *("Filter", "Display filter", "Display filter")
    ]


def test_half_and_nearly_all_of_a_hundred_reactions() -> None:
    """They take 1 to 100 ms."""
    made = report(*(at(n, answered(judged(n * MS, 200 * MS, OK))) for n in range(1, 101)))
    assert cells(tables.services(made)) == {
        **{"Service": "0x10 Read parameter", "Reactions": "100", "Shortest": "1.000 ms", "Average": "50.500 ms"},
        **{"Half within": "50.000 ms", "99 % within": "99.000 ms", "Longest": "100.000 ms"},
        **{"TrS": "200 ms", "Exceeded": "0", "Unresolved": "0"},
    }
    assert tables.stations(made).rows[0][6:8] == ("50.000 ms", "100.000 ms")


def test_why_verdicts_are_unresolved() -> None:
    marker = at(0, type=EVENT, event=int(Event.MARKER), text="latency timer 255 ms")
    taps = started("FT232R (ftdi_sio, latency timer 1 ms)"), started("FT232R (ftdi_sio, latency timer 16 ms)")
    late = answered(judged(50 * MS, 50 * MS, UNRESOLVED))
    notes = [tables.verdicts(report(marker, *taps, at(1, late, uncertainty_s=one))).note for one in (0.016, None)]
    assert notes[0].startswith(
        "1 unresolved: the times are uncertain by 16.000 ms. The latency timer of the adapter was 16 ms. "
    )
    assert notes[1].startswith("1 unresolved: nobody knows how exact the times are. The latency")
    assert tables.verdicts(report(marker, *taps)).note == ""


def test_where_no_limit_is_known_nothing_is_said_to_be_kept() -> None:
    made = report(at(0, telegram(PLC, 3)), at(0.1, answered(judged(10 * MS, None, None))))  # type: ignore[arg-type]
    assert tables.verdicts(made).rows[1][1:6] == ("not known", "not judged", "not judged", "not judged", "1")
    assert tables.stations(made).rows[1][-2:] == ("not judged", "0")
    assert unjudged(made.figures) == ["reaction times (no TrS)"]
    assert unjudged(report(at(0, paused(1, None, None))).figures) == ["intervals in telegrams (no TzA)"]
    assert made.answer[0].text.startswith("OK as far as it was judged, ")


def test_of_which_stations_a_limit_is_missing() -> None:
    known = [at(0, answered(judged(10 * MS, 50 * MS, OK)))]
    for count, who in ((0, []), (1, ["station 5"]), (2, ["stations 5, 6"])):
        others = [
            at(5 + n, telegram(4 + count - n, PLC, is_reaction=True, reaction=Judged(0.01, None, None)))
            for n in range(count)
        ]
        assert unjudged(report(*known, *others).figures) == [f"reaction times of {one} (no TrS)" for one in who]


def test_a_master_that_is_unanswered_or_a_packet_without_address_has_no_station() -> None:
    made = report(at(0, telegram(None, None)), at(1, telegram(PLC, None, unanswered=True)))
    assert [one[:6] for one in tables.stations(made).rows] == [("1", "1", "0", "0", "0", "0")]


# -- What was captured -----------------------------------------------------------------------------------------------


def test_how_exact_the_times_are() -> None:
    def exact(*uncertain_s: float | None) -> str:
        records = [at(n, telegram(PLC, 3), uncertainty_s=one) for n, one in enumerate(uncertain_s)]
        return said(tables.summary(report(*records)))["Uncertainty of the times"]

    assert exact(0.0003, 0.0003) == "0.300 ms"
    assert exact(0.002, 0.0003, 0.001) == "0.300 ms to 2.000 ms"
    assert exact(0.0003, None, None) == "0.300 ms; unknown in 2 records"
    assert exact(None) == "unknown"
    assert exact() == "there are no times of characters"
    beside = report(at(0, telegram(PLC, 3)), at(1, type=OTHER))
    assert said(tables.summary(beside))["Uncertainty of the times"] == "0.300 ms"


def test_records_of_all_kinds() -> None:
    error = {"errors": int(Flag.CHARACTER_ERROR)}
    blocks = [at(n, framing=int(Framing.PROCEDURE_3964R), intervals_s=[n * MS], **error) for n in (1, 2, 3)]
    blocks[0].alike = blocks[2].alike = object()
    other = at(7, type=OTHER, intervals_s=[0.5], framing=int(Framing.PROCEDURE_3964R))
    lost = at(8, framing=int(Framing.PROCEDURE_3964R), intervals_s=[9 * MS], errors=int(Flag.LOST_BEFORE))
    said_ = said(
        tables.summary(report(*[at(0, telegram(PLC, 3))] * 2, *blocks, other, lost, at(8, type=EVENT, event=1)))
    )
    assert said_["Packets"] == "8: 2 telegrams, 1 other characters, 1 events, 4 handshakes and blocks of 3964R"
    between = "half within 2.000 ms, the longest 3.000 ms"
    assert said_["Intervals in other frames"] == f"3, from character to character: {between}"
    assert (said_["Duration"], said_["Line"]) == ("8.009 s", "9600 Bd 8E1")
    noise = said(tables.summary(report(at(0, type=OTHER))))
    assert (noise["Line"], noise["Uncertainty of the times"]) == ("9600 Bd 8E1", "0.300 ms")
    foreign = said(tables.summary(report(at(0, type=None), at(0, framing=int(Framing.SILENCE)), at(1, framing=99))))
    assert foreign["Packets"] == "3: 1 no records of the tap, 1 frames of framing 99, 1 frames cut by silence"


def test_ports_have_their_names() -> None:
    assert said(tables.summary(report(at(0, interface="COM3"), at(1, interface="COM4"))))["Ports"] == "COM3, COM4"
    nothing = said(tables.summary(report(at(0, baud=None))))
    assert (nothing["Ports"], nothing["Line"]) == ("not named", "not known")


def test_when_it_began() -> None:
    """In Berlin. Who has no clock writes any number for the time."""
    assert said(tables.summary(report(at(0))))["Began"] == "2026-11-24 07:00:00 +0100"
    assert tables.clock(report(at(0)).figures, 61.9995) == "07:01:01.999"
    odd = report(packet(1e20, telegram(PLC, 3)), episodes=[Episode.of(Hit("late", 1, 1e20, 1e20, 3))])
    assert said(tables.summary(odd))["Began"] == row(tables.episodes(odd), "From") == "a time in no calendar"
    assert tables.clock(odd.figures, 1.0) == "" and not tables.legend(odd).startswith("Times")
    assert said(tables.summary(report()))["Began"] == "there is no packet"


def test_intervals_in_one_read() -> None:
    records = [at(n, paused(1.2), intervals_s=[1 * MS] * 3, same_read=n) for n in range(3)]
    alike: Any = object()
    both = [at(n, paused(1.2), intervals_s=[1 * MS] * 3, same_read=2, alike=alike) for n in range(2)]
    assert said(tables.summary(report(*both)))["In the same read"].startswith("4 of 6 intervals")
    same = said(tables.summary(report(*records)))["In the same read"]
    assert same == "3 of 9 intervals in telegrams: their length is not known"


def test_silences_are_those_above_200_ms_and_of_the_longest_the_first_counts() -> None:
    silences = (0.0, 0.2, 0.201, 0.5, 0.5, 0.3)
    alike: Any = object()  # as packets have it that say the same
    each, polls = (
        [at(n, telegram(PLC, 3, silence=Judged(one, None, None)), **more) for n, one in enumerate(silences)]
        for more in ({}, {"alike": alike})
    )
    for made in (report(*each), report(*reversed(each)), report(*polls)):
        assert said(tables.summary(made))["Silences above 200 ms"] == "4"
        assert (made.figures.silences.longest_s, made.figures.silences.before) == (0.5, 31)
    assert report(at(0, telegram(PLC, 3))).figures.silences.before is None


def test_the_whole_capture_shows_who_talked_when_and_the_faults() -> None:
    """Over 4 s, a step is 16 ms: what came within one is together."""
    errors = tuple(fault for fault in FAULTS if fault.name == "line_error")
    drawing = plots.overview(
        report(
            *(at(0, telegram(PLC, 3)) for _ in range(2)),
            at(1, telegram(PLC, 3, load_percent=40.0)),
            at(2, answered(load_percent=0.0), faults=errors),
            at(4, telegram(PLC, 3)),
        )
    )
    assert drawing
    (upper,), (lower,) = drawing.draw()
    (load,) = (mark for mark in upper.marks if isinstance(mark, Area))
    assert [*itertools.chain(*load.points)] == pytest.approx([1.0, 40.0, 2.0, 0.0], abs=0.016)
    master, station = (mark for mark in lower.marks if isinstance(mark, Area))
    heights = [(round(x, 1), round(y - master.base, 2)) for x, y in master.points[::2] if y > master.base]
    assert heights == [(0.0, 0.8), (1.0, 0.4), (4.0, 0.4)]
    assert [round(x, 1) for x, y in station.points[::2] if y > station.base] == [2.0]
    (red,) = (mark for mark in lower.marks if isinstance(mark, Strokes))
    assert [*red.at] == pytest.approx([2.0], abs=0.016)


def test_events_of_the_tap_are_the_first_twenty() -> None:
    events = [at(n, type=EVENT, event=int(Event.MARKER), text=f"{n}") for n in range(22)]
    table = tables.events(report(at(0, telegram(PLC, 3)), *events))
    assert table.title == "Events of the tap (and 2 times more)" and len(table.rows) == 20
    assert cells(table, 2) == {
        **{"Packet": "21", "Second": "2.000000", "Clock": "07:00:02.000", "Event": "Marker", "Text": "2"}
    }
    later = tables.events(report(at(0, type=EVENT, event=99)))  # of a later version
    assert (later.title, later.rows[0][3]) == ("Events of the tap", "Event 99")


@pytest.mark.parametrize(("lasts_s", "day"), [(86_399, ""), (86_401, "2026-11-24 ")])
def test_beyond_a_day_a_time_has_its_date(lasts_s: float, day: str) -> None:
    made = report(at(0), at(lasts_s), episodes=[Episode.of(Hit("late", 1, BEGIN_S + 1, BEGIN_S + 1, 3))])
    assert tables.clock(made.figures, 1.5) == f"{day}07:00:01.500"
    assert row(tables.episodes(made), "From") == f"{day}07:00:01"
    first, *_, limits = tables.answer(made)
    assert first.startswith("NOT OK, 2026-11-24 07:00:00 to 2026-11-25 0") and f", {day}07:00:01)" in limits


@posix("no rules of summer time in TZ")
def test_where_the_clock_is_put_back_a_time_says_how_it_differs() -> None:
    """2026-10-25, from 02:30 in summer to 02:30 in winter."""
    begin_s = BEGIN_S - 30 * tables.DAY_S - 5.5 * 3600
    late = Episode.of(Hit("late", 1, begin_s, begin_s, 3))
    made = report(packet(begin_s, time_s=0.0), packet(begin_s + 3600, time_s=3600.0), episodes=[late])
    assert row(tables.episodes(made), "From") == "02:30:00 UTC+2"
    assert tables.answer(made)[0].startswith("NOT OK, 02:30:00 UTC+2 to 02:30:00 UTC+1: ")


SAYS, DENIES = "line errors at their character", "no line errors are reported"  # the adapter, as a capture begins


def started(text: str) -> Packet:
    return at(0, type=EVENT, event=int(Event.CAPTURE_STARTED), text=text)


REMARKS: Sequence[tuple[str, Callable[[], Report]]] = (
    ("The capture has no packets.", report),
    ("The capture has no SIS telegrams.", lambda: report(at(0))),
    ("The packets are no records of the tap: there are no times of characters", lambda: report(at(0, type=None))),
    (
        "It has 1 handshakes and blocks of 3964R and 2 lines of text: their limits are not judged here.",
        lambda: report(*(at(0, framing=int(one)) for one in (Framing.ASCII, Framing.PROCEDURE_3964R, Framing.ASCII))),
    ),
    (
        "Reactions that came in one read with their command, or without one, are in no median: "
        "station 3 (1 of 1), station 4 (1 of 1). ",
        lambda: report(*(at(0, replace(answered(judged(0, 1, OK)), talker=station)) for station in (4, 3))),
    ),
    ("TrS was not set (service 0x03) while this was captured", lambda: report(at(0, answered(Judged(1, None, None))))),
    ("TzA was not set (service 0x03) while this was captured", lambda: report(at(0, paused(1, None, None)))),
    ("The packet numbers count through all 2 files", lambda: report(at(0), files=2)),
    ("A recorder kept these files one by one", lambda: report(started(f"a tap{KEPT}late"), files=2)),
    (
        "b.pcapng: only what comes before the damage",
        lambda: report(at(0), left_out=["b.pcapng: only what comes before the damage"]),
    ),
    (
        "The limits TrS = 9 ms were given for this capture (--tza, --trs). They apply until",
        lambda: report(at(0, type=EVENT, event=int(Event.LIMITS_TOLD), text="TrS = 9 ms")),
    ),
    ("Judged by TzA = 2 ms, as given for this report", lambda: replace(report(at(0)), limits_ms={"tza": 2})),
    (
        "The installed dissector does not know sis.a, sis.b; what they would tell is left out.",
        lambda: replace(report(at(0)), missing=["sis.a", "sis.b"]),
    ),
    ("The adapter reports no line errors: damaged", lambda: report(started(DENIES))),
    (
        "Telegrams are damaged, but there is not one line error",
        lambda: report(started(SAYS), at(1, answered(good=False))),
    ),
    (
        "Reactions that came in one read with their command, or without one, are in no median: station 3 (1 of 3). ",
        lambda: report(*exchanges()),
    ),
)


@pytest.mark.parametrize(("text", "make"), REMARKS, ids=lambda one: one[:30] if isinstance(one, str) else "")
def test_what_a_reader_has_to_know(text: str, make: Callable[[], Report]) -> None:
    assert any(one.startswith(text) for one in tables.remarks(make()))


LINE_ERROR = tuple(fault for fault in FAULTS if fault.name == "line_error")
QUIET: Sequence[tuple[str, Callable[[], Report], list[str]]] = (
    (
        "all is well",
        lambda: report(
            started(SAYS),
            at(0, type=EVENT, event=int(Event.MARKER), text=DENIES),
            at(0, telegram(PLC, 3)),
            at(0.1, answered(judged(10 * MS, 50 * MS, OK))),
        ),
        [],
    ),
    ("noise beside", lambda: report(at(0, telegram(PLC, 3)), at(1, type=OTHER)), []),
    ("nothing", report, ["The capture has no packets."]),
    (
        "limits of two captures",
        lambda: report(
            *(at(0, type=EVENT, event=int(Event.LIMITS_TOLD), text="TrS = 9 ms") for _ in range(2)),
            at(0, telegram(PLC, 3)),
        ),
        [
            "The limits TrS = 9 ms were given for this capture (--tza, --trs). They apply until the bus sets others.",
        ],
    ),
    (
        "damage with line errors",
        lambda: report(started(SAYS), at(1, answered(good=False)), at(2, faults=LINE_ERROR)),
        [],
    ),
    ("damage, of an adapter unknown", lambda: report(started("a tap"), at(1, answered(good=False))), []),
    (
        "damage at one of two adapters",
        lambda: report(started(SAYS), started(DENIES), at(1, answered(good=False))),
        ["The adapter reports no line errors: damaged characters look like good ones."],
    ),
    ("one file of a recorder", lambda: report(started(f"a tap{KEPT}late"), at(0, telegram(PLC, 3))), []),
    (
        "two files of a ring",
        lambda: report(started("a tap"), at(0, telegram(PLC, 3)), files=2),
        [
            "The packet numbers count through all 2 files in the order of their time. "
            "`mergecap -a -w all.pcapng FILES` makes the capture that has them."
        ],
    ),
    (
        "an older dissector",
        lambda: replace(report(at(0, answered(Judged(0.01, None, None)))), missing=["sis.trs.limit"]),
        ["The installed dissector does not know sis.trs.limit; what they would tell is left out."],
    ),
)


@pytest.mark.parametrize(("make", "expected"), [one[1:] for one in QUIET], ids=[one[0] for one in QUIET])
def test_what_he_has_not_to_know(make: Callable[[], Report], expected: list[str]) -> None:
    assert tables.remarks(make()) == expected


def test_one_unmeasured_reaction_of_a_hundred_does_not_matter() -> None:
    def told(of: int) -> list[str]:
        times = [0.0, *[0.01] * (of - 1)]
        return tables.remarks(report(*(at(n, answered(judged(one, 0.05, OK))) for n, one in enumerate(times))))

    assert not told(100) and told(99)[0].endswith(
        "are in no median: station 3 (1 of 99). Uncertainty of the times: 0.300 ms."
    )


# -- Parameters and episodes -----------------------------------------------------------------------------------------


def test_parameters() -> None:
    values = [access(3, "S-0-0040", one) for one in (7.0, 9.0, 5.0)]
    wrote = access(3, "S-0-0040", 6.0, is_write=True, master=LAPTOP)
    refused = access(3, "S-0-0040", "", error="0x7002")
    made = report(*(at(n, accesses=[one]) for n, one in enumerate([*values, wrote, refused])))
    table = tables.parameters(made)
    assert (table.title, table.links) == ("Parameters", {(0, 0): "parameter0"})
    (curve,) = made.figures.curves.moved().values()
    assert [(point.begin_s, point.last) for point in curve.points] == [(0, 7), (1, 9), (2, 5), (3, 6)]
    assert cells(table) == {
        **{"Parameter": "S-0-0040", "Device": "station 3, device 4", "Name": "", "Unit": "rpm"},
        **{"Reads": "3", "Writes": "1", "Errors": "1", "First": "7.0 rpm", "Last": "6.0 rpm"},
        **{"Least": "5.0 rpm", "Greatest": "9.0 rpm", "Written by": "127", "In packet": "31"},
    }


def test_parameters_of_two_ports_and_who_wrote_them() -> None:
    """Master 0, and somebody in ASCII."""
    masters: tuple[tuple[str, int | None], ...] = ("COM3", 0), ("COM4", None)
    written = [access(3, "S-0-0040", 1.0, is_write=True, master=master, port=port) for port, master in masters]
    table = tables.parameters(report(at(0, accesses=written)))
    assert [(one[1], one[-2], one[-1]) for one in table.rows] == [
        ("COM3, station 3, device 4", "0", "1"),
        ("COM4, station 3, device 4", "", "1"),
    ]


def test_more_than_500_parameters_are_not_read_by_anybody() -> None:
    made = report(at(0, accesses=[access(3, f"P-0-{number:04}", 1.0) for number in range(502)]))
    table = tables.parameters(made)
    assert table.title == "Parameters (and 2 more: `sistap parameters` lists all)" and len(table.rows) == 500


def test_a_row_of_an_episode_leads_to_the_curve_of_its_parameter() -> None:
    hit = Hit("step", 7, BEGIN_S, BEGIN_S + 2, 4, "S-0-0040", "9 rpm below S-0-0036")
    found = Episode.of(hit)
    found.join(Episode.of(hit._replace(packet=9, station=3)))
    values = [at(n, accesses=[access(3, "S-0-0040", float(n))]) for n in range(2)]
    table = tables.episodes(report(*values, episodes=[Episode.of(Hit("late", 1, BEGIN_S, BEGIN_S, 3)), found]))
    assert cells(table, 1) == {
        **{"From": "07:00:00", "Duration": "2.0 s", "Severity": "note", "Station": "3, 4", "What": found.rule.title},
        **{"Parameter": "S-0-0040", "Details": "9 rpm below S-0-0036", "What to do": found.rule.do, "Count": "2"},
        "Display filter": "frame.number in {7, 9}",
    }
    assert cells(table)["What to do"] == RULES["late"].do != ""
    assert (table.kinds, table.links) == (["error", "note"], {(1, 5): "parameter0"})
    assert table.heads[5] == "Parameter"


def test_episodes_have_a_duration_in_words() -> None:
    def lasting(seconds: float) -> str:
        found = Episode.of(Hit("late", 7, BEGIN_S, BEGIN_S + seconds, 3))
        return row(tables.episodes(report(at(0), episodes=[found])), "Duration")

    spans = (0.9, 1.0, 9.94, 299, 300, 7199, 7200, 35_940)
    assert [*map(lasting, spans)] == ["", "1.0 s", "9.9 s", "299 s", "5 min", "120 min", "2 h 0 min", "9 h 59 min"]


def test_in_several_files_an_episode_is_found_by_its_time() -> None:
    found = Episode.of(Hit("late", 7, BEGIN_S, BEGIN_S, 3))
    of_one, of_two = (row(tables.episodes(report(at(0), episodes=[found], files=n)), "Display filter") for n in (1, 2))
    assert of_one == "frame.number in {7}" and of_two.startswith("frame.time_epoch >= ")


# -- Windows ---------------------------------------------------------------------------------------------------------


def test_a_window_has_what_reaches_into_it() -> None:
    window = windows.asked(1, 2)
    assert (window.title, window.start_s, window.end_s) == ("Asked for: 2 s from 1 s", 1, 3)
    times = (0.8, 0.9, 1, 3, 3.1)  # each lasts 0.1 s
    for second in times:
        window.add(at(second, intervals_s=[0.0995]))
        window.add(at(second, type=EVENT))
    assert [one.time_s for one in window.packets] == [1, 3]
    window.add(at(0.9, type=OTHER, intervals_s=[0.1]))
    assert window.packets[-1].time_s == 0.9
    assert window.shows(1, 3) and not window.shows(0.99, 3) and not window.shows(1, 3.01)


def test_a_window_is_bounded() -> None:
    window = ReportWindow("", 0, 10)
    for _ in range(windows.PACKETS_KEPT + 2):
        window.add(at(1))
    assert (len(window.packets), window.left_out) == (1000, 2)


def test_windows_are_around_the_worst_of_each_kind() -> None:
    def one(kind: str, second: float, worst: float, lasts_s: float = 0.0) -> Episode:
        from_s = BEGIN_S + second
        return Episode.of(Hit(kind, int(second), from_s, from_s + lasts_s, 3, worst=worst))

    found = [
        one("late", 10, 0.2),
        one("late", 20, 0.5),
        one("interval", 30, 0.1, 4.0),
        one("fault", 40, 1),
        one("clock", 50, 1),
    ]
    late, interval = windows.around(found, BEGIN_S, [])
    assert late.title == "Packet 20: Reaction later than TrS"
    # It begins with the command, 0.5 s before, and has half of that more, at both ends.
    assert [late.start_s, late.end_s] == pytest.approx([19.25, 20.25])
    assert [interval.start_s, interval.end_s] == pytest.approx([28, 36])
    (other,) = windows.around(found, BEGIN_S, [ReportWindow("", 19, 21)])  # is seen there
    assert other.title == "Packet 30: Interval longer than TzA"
    both = [one("late", 20, 0.5), one("interval", 20, 0.1)]  # of one telegram: it is seen once
    assert [window.title for window in windows.around(both, BEGIN_S, [])] == ["Packet 20: Reaction later than TrS"]
    many = [one(kind, 10 * place, 0) for place, kind in enumerate(("repeated", "damaged", "early", "late"))]
    titles = ["Reaction later than TrS", "Sent again too early", "Damaged telegram"]  # the three worst
    assert [window.title.partition(": ")[2] for window in windows.around(many, BEGIN_S, [])] == titles
    unmeasured = Episode.of(Hit("late", 20, BEGIN_S + 20, BEGIN_S + 20, 3))  # perhaps late
    assert [window.start_s for window in windows.around([unmeasured], BEGIN_S, [])] == pytest.approx([19.97])
    (worse,) = windows.around([unmeasured, one("late", 10, 0.2)], BEGIN_S, [])
    assert worse.title.startswith("Packet 10: ")
    (short,) = windows.around([one("interval", 0, 0.1)], BEGIN_S, [])
    assert [short.start_s, short.end_s] == pytest.approx([0, 0.03])


def test_an_answer_with_nothing_in_it() -> None:
    assert tables.answer(report()) == ["There is nothing to judge."]
    foreign = Episode.of(Hit("foreign", 0, BEGIN_S, BEGIN_S, detail="none of 5 records is a telegram"))
    assert tables.answer(report(episodes=[foreign]))[0].startswith("NOT OK, ")
    assert tables.answer(report(at(0, telegram(PLC, 3))))[0].startswith("OK, ")
    began_before = report(episodes=[Episode.of(Hit("late", 1, BEGIN_S, BEGIN_S, 3))])  # and ended later, --since
    assert tables.legend(began_before).startswith("Times: UTC") and row(tables.episodes(began_before), "Count") == "1"


@pytest.mark.parametrize("ident", ["S-0-0040", "P-0-0012"])
def test_short_names_in_the_answer_are_explained(ident: str) -> None:
    late = Episode.of(Hit("late", 1, BEGIN_S, BEGIN_S, 3, "", "60.000 ms, TrS 50 ms"))
    cycle = Episode.of(Hit("cycle", 1, BEGIN_S, BEGIN_S, 3))
    foreign = Episode.of(Hit("foreign", 0, BEGIN_S, BEGIN_S, detail="none of 5 records is a telegram"))
    beyond = Episode.of(Hit("beyond", 1, BEGIN_S, BEGIN_S, 3, ident, "3001.0 rpm above its maximum 3000 rpm"))
    read = at(0, telegram(3, PLC, is_reaction=True), accesses=[access(3, ident, 1, name="Velocity feedback value")])
    unnamed = at(1, accesses=[access(4, ident, 1)])
    assert f"{ident}: Velocity feedback value" in tables.legend(report(read, unnamed, episodes=[beyond]))
    assert tables.legend(report(read, episodes=[late])) == "Times: UTC+0100; TrS: longest reaction time allowed."
    words = "Tmas: longest time allowed between two master control words."
    assert tables.legend(report(read, episodes=[cycle])) == f"Times: UTC+0100; {words}"
    assert tables.legend(report(read, episodes=[foreign])) == "Times: UTC+0100."
    summer = report(packet(BEGIN_S - 150 * tables.DAY_S), episodes=[foreign])
    assert tables.legend(summer) == f"Times: UTC+0{1 if WINDOWS else 2}00."
    assert (
        tables.legend(report(at(0, paused(1, None, None)))) == "TzA: longest interval allowed between two characters."
    )
    assert tables.legend(report(at(0, telegram(PLC, 3)))) == ""


def test_the_worst_thousand_episodes_are_shown() -> None:
    found = [Episode.of(Hit("late", 7, BEGIN_S, BEGIN_S, 3))] * 1002
    table = tables.episodes(report(at(0), episodes=found))
    assert (table.title, len(table.rows)) == ("What happened (and 2 more)", 1000)
    assert tables.episodes(report(at(0), episodes=found[:999])).title == "What happened"


def test_windows_are_filled_with_what_may_reach_into_them() -> None:
    """A packet may have begun five seconds earlier."""
    asked: list[object] = []

    class Kept:
        def again(self, spans: Sequence[object]) -> Sequence[Packet]:
            asked.extend(spans)
            return [at(1.5), at(7, intervals_s=[3.5])]

    shown = [ReportWindow("", 1, 2), ReportWindow("", 10, 11)]
    windows.fill(cast(Dissection, Kept()), shown)
    assert asked == [(0, 2), (5, 11)]
    assert [[packet.time_s for packet in one.packets] for one in shown] == [[1.5], [7]]
    windows.fill(cast(Dissection, None), [])


# -- Captures --------------------------------------------------------------------------------------------------------

TOLD = {"sertap.type": FRAME, "sis.start": "0x02", "sis.checksum.status": "1", "sis.service": "0x10"}


def printing(error: str = "", **captures: tuple[int, Sequence[float]]) -> Tshark:
    """Return a tshark that has captures: a master that asks station 3, and when."""
    rows = {
        name: [
            {"frame.number": number, "frame.time_epoch": BEGIN_S + second, "frame.time_relative": second}
            | {"sis.talker": master, "sis.listener": 3}
            | TOLD
            for number, second in enumerate(seconds, 1)
        ]
        for name, (master, seconds) in captures.items()
    }
    return cast(Tshark, Printing(rows, [*next(iter(rows.values()))[0]], error))


def test_while_a_capture_is_read_something_is_said() -> None:
    told: list[str] = []
    tshark, portion = printing(long=(PLC, range(10_001))), Portion(Path("long"))
    made = gather(tshark, [portion], [windows.asked(2, 1)], told.append)
    read = ["5000 packets read, 4999 s of the capture", "10000 packets read, 9999 s of the capture"]
    assert told == [*read, "10001 packets read; reading the worst of them once more"]
    assert [[packet.number for packet in window.packets] for window in made.windows] == [[3, 4]]
    told.clear()
    assert gather(tshark, [portion], [windows.asked(2, 1)], told.append, has_windows=False).windows == []
    assert told == read


def test_the_worst_comes_first_then_what_was_earlier(monkeypatch: pytest.MonkeyPatch) -> None:
    hits = [
        Hit(kind, 1, BEGIN_S + second, BEGIN_S + second) for kind, second in (("late", 9), ("lost", 2), ("late", 5))
    ]
    monkeypatch.setattr(Engine, "finish", lambda _: [*map(Episode.of, hits)])
    made = gather(printing(a=(PLC, range(10))), [Portion(Path("a"))], [], print)
    assert [one.from_s - BEGIN_S for one in made.episodes] == [5, 9, 2]


def test_what_a_person_tells_of_the_bus_is_judged_by() -> None:
    tshark = printing(a=(PLC, [*range(100), 130]))
    made = gather(tshark, [Portion(Path("a"))], [], print, {"tza": 2, "trs": 50})
    asked = " ".join(cast(Printing, tshark).asked)
    assert "-o sis.tza_ms:2" in asked and "-o sis.trs_ms:50" in asked
    assert any(one.startswith("Judged by TzA = 2 ms, TrS = 50 ms, ") for one in tables.remarks(made))
    patient = THRESHOLDS._replace(bus_silent_s=60.0)
    calm = gather(tshark, [Portion(Path("a"))], [], print, thresholds=patient)
    assert [[one.kind for one in each.episodes] for each in (made, calm)] == [["bus_silent"], []]


def test_what_the_report_lacks_is_said() -> None:
    made = gather(printing("tshark: Killed", a=(PLC, [0])), [Portion(Path("a"))], [], print)
    warning, missing = tables.remarks(made)[:2]
    assert warning == "tshark could not read the capture to its end: Killed"
    assert missing.startswith("The installed dissector does not know ") and "sis.trs.limit" in missing


def test_of_how_many_parameters_only_bytes_are_known_is_said() -> None:
    said = {"access": "read", "station": "3", "device": 4, "parameter": "P-0-0012", "value": "01", "data": "01"}
    row = {"frame.number": 1, "frame.time_epoch": BEGIN_S, "sis.access": json.dumps(said | {"raw": True})} | TOLD
    made = gather(cast(Tshark, Printing({"a": [row]}, [*row])), [Portion(Path("a"))], [], print)
    assert "parameters without a description: 1" in made.answer[2].text


def test_who_asked_in_a_good_capture_is_usual() -> None:
    tshark = printing(good=(PLC, range(100)), other=(LAPTOP, range(100)))
    good = learned(tshark, [Portion(Path("good"))], THRESHOLDS)
    kinds = [
        [one.kind for one in gather(tshark, [Portion(Path("other"))], [], print, before=before).episodes]
        for before in (None, good)
    ]
    assert "master" in kinds[1] and "master" not in kinds[0]


# -- Distributions ---------------------------------------------------------------------------------------------------


def test_bars_have_five_bins_and_no_gap() -> None:
    """A bin is a hundredth of a decade; a bar, a twentieth."""
    times = Distribution()
    times.add([0.0, 1.01 * MS, 1.1 * MS, 1.13 * MS, 10.1 * MS])
    counts, edges = times.bars()
    assert counts[0] == 2 and counts[1] == 1 and counts[-1] == 1 and sum(counts) == 4 and len(counts) == 21
    assert edges[:2] == pytest.approx([1 * MS, 1.122 * MS], abs=0.001 * MS) and len(edges) == 22
    assert Distribution().bars() == ([], [])


@pytest.mark.parametrize(("name", "value"), [("shortest_s", 0.0), ("longest_s", 2.0), ("zeros", 1), ("average_s", 1.0)])
def test_it_matters_not_what_is_asked_first(name: str, value: float) -> None:
    times = Distribution()
    times.add([2.0, 0.0])
    assert getattr(times, name) == value


def test_parts_are_joined() -> None:
    parts = Distribution(), Distribution()
    parts[0].add([0.0, 1.0, 3.0])
    parts[1].add([2.0, 0.0])
    both = Distribution.union(parts)
    assert (both.count, both.zeros, both.shortest_s, both.longest_s) == (5, 2, 0.0, 3.0)
    assert (both.average_s, both.within_s(0.6), both.within_s(1)) == (1.2, 1.0, 3.0)
    assert Distribution().shortest_s is None and Distribution().average_s == 0


def test_slices_become_twice_as_wide() -> None:
    slices = Slices()
    slices.count("x", slices.at([0.0, 0.4799]))
    assert (slices.width_s, slices.used) == (0.001, 480)
    slices.count("x", slices.at([0.48]))
    assert (slices.width_s, slices.used, slices.at([-1])) == (0.002, 241, [0])
    assert [place for place, count in enumerate(slices.counts["x"]) if count] == [0, 239, 240]
