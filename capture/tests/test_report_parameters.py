# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameters in a report: the table, and the curves of the values that moved."""

from __future__ import annotations

import html
import json
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sharkd import Sharkd

from sistap.commands.report import curved, plain, plots, tables
from sistap.commands.report.curves import MOST_CURVES, MOST_POINTS, Curve, Curves
from sistap.commands.report.figures import Figures
from sistap.commands.report.gather import Report, gather
from sistap.commands.report.page import page
from sistap.dissected.accesses.access import Access, Parameter
from sistap.dissected.accesses.listing import AccessPlace, Listed
from sistap.dissected.captures.portions import Portion
from sistap.dissected.draw.panel import Bar, Dots, Panel, Polyline
from sistap.dissected.episodes.episode import Episode, Hit
from sistap.dissected.wireshark.tshark import Tshark

CAPTURE = Path(__file__).parent.parent.parent / "test-captures" / "accesses.pcapng"


@pytest.fixture(scope="module")
def report() -> Report:
    with Tshark() as tshark:
        return gather(tshark, [Portion(CAPTURE)], [], lambda text: None)


@pytest.mark.thorough
def test_the_table(report: Report) -> None:
    """As accesses.txt has it."""
    first, *rest = tables.parameters(report).rows
    assert first == (
        *("P-0-0012", "station 3, device 5", "Limit", "Nm", "2", "3", "2"),
        *("5.00 Nm", "-3.00 Nm", "-3.00 Nm", "7.50 Nm", "17", "18"),
    )
    assert [(row[0], row[1]) for row in rest] == [
        ("S-0-0047", "station 3, device 5"),
        ("S-0-0048", "station 3, device 5"),
        ("S-0-0047", "station 3, device 6"),
        ("P-0-0012", "station 4/8, device 0"),
        ("S-0-0047", "station 4/8, device 0"),
    ]
    assert "Values that moved" in page(report)
    assert "P-0-0012   station 3, device 5" in plain.as_text(report)


def test_json(report: Report) -> None:
    first = json.loads(plain.as_json(report))["parameters"][0]
    names = (
        "port",
        "station",
        "device",
        "ident",
        "minimum",
        "maximum",
        "least",
        "greatest",
        "written_by",
        "written_in",
    )
    assert [first[name] for name in names] == ["accesses", "3", 5, "P-0-0012", "-10.00 Nm", "10.00 Nm", -3, 7.5, 17, 18]


def test_refused_ones_are_found(report: Report) -> None:
    """Packets 20, 38 and 40. One refuses what the station has never told: that is life."""
    refused = [episode for episode in report.episodes if episode.kind in ("busy", "error", "never")]
    assert sorted((episode.kind, episode.count) for episode in refused) == [("busy", 1), ("error", 1), ("never", 1)]
    assert sorted(packet for episode in refused for packet in episode.packets) == [20, 38, 40]
    (row,) = (row for row in tables.faults(report).rows if row[0] == "Reaction with an error")
    assert row[1] == "3"


@pytest.fixture
def panel(report: Report) -> Panel:
    """The curve of P-0-0012: of all values, its are the only numbers."""
    (drawing,) = plots.values(report)
    ((shown,),) = drawing.draw()
    return shown


def test_the_curve_has_all_values_and_limits(panel: Panel) -> None:
    lines: dict[str, list[list[float]]] = {}
    for mark in (mark for mark in panel.marks if not isinstance(mark, Bar)):
        assert isinstance(mark, Polyline | Dots)
        lines.setdefault(mark.role, []).append([y for _, y in mark.points])
    assert lines["reaction"] == [[5.0, 5.0, 7.5, -3.0, -3.0]]
    assert lines["command"] == [[5.0, 7.5, -3.0]], "what was written has a dot"
    assert lines["bad"] == [[-10.0, -10.0], [10.0, 10.0]]
    assert panel.title == [
        "P-0-0012 Limit in Nm",
        "station 3, device 5",
        "at least -10.00 Nm, at most 10.00 Nm",
    ]


def test_a_curve_of_diagnoses_has_their_numbers(report: Report) -> None:
    figures, of_drive = Figures(), Parameter("", "3", 7, "S-0-0390")
    for second, number in enumerate((0xA0101, 0xA0101, 0xF2028, 0xA0102)):
        value = f"0x{number:08X}"
        access = Access(of_drive, False, 16, "", value, number, value, "", "", "", "")
        figures.parameters.add(AccessPlace("", second, second), access)
        figures.curves.add(second, access)
    (drawing,) = plots.values(replace(report, figures=figures, episodes=[]))
    ((panel,),) = drawing.draw()
    assert [(tick.value, tick.words) for tick in panel.y.ticks] == [(0xA0101, "A0101"), (0xF2028, "F2028")]


def test_a_curve_has_what_happened_and_its_place_on_the_page(report: Report, sharkd: Sharkd) -> None:
    """Links alone lead from a parameter to its curve, from there to what happened, and back."""
    begin_s = report.figures.first_epoch_s or 0.0
    of_it = Hit("step", 1, begin_s + 1, begin_s + 2, 3, "P-0-0012", port="accesses")
    hits = [of_it, of_it._replace(parameter="S-0-0047"), of_it._replace(station=4), of_it._replace(port="other")]
    told = replace(report, episodes=[Episode.of(hit) for hit in hits])
    (drawing,) = plots.values(told)
    ((panel,),) = drawing.draw()
    (bar,) = (mark for mark in panel.marks if isinstance(mark, Bar))
    assert [bar.begin, bar.end] == pytest.approx([1, 2]) and bar.link == "#episode0"
    text = page(told)
    assert text.count('<a href="#parameter0">P-0-0012</a>') == 2, "in the table of what happened, and of parameters"
    assert '<figure id="parameter0">' in text and "<script" not in text
    (listed,) = curved.parameters(told)
    found = sharkd.frames(CAPTURE, f"({curved.wireshark_filter(listed)}) && sis.value.number")
    assert found and f"<code>{html.escape(curved.wireshark_filter(listed))}</code>" in text


@pytest.mark.parametrize(("reads", "who"), [(1, "talker"), (0, "station")])
def test_who_only_writes_hears_no_value_from_the_station(reads: int, who: str) -> None:
    listed = Listed(Parameter("", "3/8", 5, "S-0-0036"), reads=reads)
    assert curved.wireshark_filter(listed) == f'sis.{who} == 3 && sis.parameter == "S-0-0036"'


def curve(times_s: list[float]) -> Curve:
    made = Curve()
    for number, time_s in enumerate(times_s):
        made.add(time_s, float(number), is_written=False)
    return made


def test_a_long_time_without_a_value_is_a_gap() -> None:
    """Every 2 s, but for 80 s; of 20 s, ten times the usual, nobody can say so."""
    times_s = [*range(0, 20, 2), *range(38, 60, 2), *range(138, 160, 2)]
    pieces = list(curve([float(time_s) for time_s in times_s]).pieces(duration_s=160))
    assert [(piece[0].begin_s, piece[-1].end_s) for piece in pieces] == [(0, 58), (138, 158)]


def test_a_gap_too_short_to_be_seen_is_none() -> None:
    assert len(list(curve([0.0, 0.1, 0.2, 0.3, 1.5, 1.6]).pieces(duration_s=1000))) == 1


def test_one_value_is_a_piece() -> None:
    assert [len(piece) for piece in curve([5.0]).pieces(duration_s=10)] == [1]


@given(st.lists(st.tuples(st.floats(-1e6, 1e6), st.integers(-50, 50), st.booleans()), min_size=1, max_size=60))
def test_points_are_bounded_and_keep_the_extremes(values: list[tuple[float, int, bool]]) -> None:
    made = Curve()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sistap.commands.report.curves.MOST_POINTS", 7)
        for time_s, number, is_written in values:
            made.add(time_s, number, is_written=is_written)
    assert len(made.points) <= 7
    assert min(point.least for point in made.points) == min(number for _, number, _ in values)
    assert max(point.greatest for point in made.points) == max(number for _, number, _ in values)
    assert any(point.is_written for point in made.points) == any(is_written for *_, is_written in values)
    assert (made.points[0].first, made.points[-1].last) == (values[0][1], values[-1][1])


def test_a_written_value_is_still_one_when_it_is_joined() -> None:
    made = Curve()
    for number in range(20 * MOST_POINTS):
        made.add(number / 100, 0.0, is_written=number == 777)
    assert [point.begin_s <= 7.77 <= point.end_s for point in made.points if point.is_written] == [True]


def test_many_values_are_joined_where_they_lie_close() -> None:
    made = curve([number / 100 for number in range(20 * MOST_POINTS)])
    assert MOST_POINTS / 4 <= len(made.points) <= MOST_POINTS
    assert len(list(made.pieces(20 * MOST_POINTS / 100))) == 1


def test_which_curves_are_kept_and_shown() -> None:
    """Those that moved; what somebody wrote comes before what was only read."""
    curves = Curves()

    def add(ident: str, *values: float, is_write: bool = False) -> None:
        parameter = Parameter("", "3", 5, ident)
        for value in values:
            curves.add(value, Access(parameter, is_write, 16, "", str(value), value, "", "", "", "", ""))

    add("still", 1, 1, 1)
    add("read", 1, 2, 3)
    add("often", 1, 2, 3, 4)
    add("written", 1, 2, is_write=True)
    assert [parameter.ident for parameter in curves.moved()] == ["written", "often", "read"]
    for number in range(MOST_CURVES):
        add(f"other {number}", 1, 2)
    assert len(curves.moved()) == MOST_CURVES - 1
