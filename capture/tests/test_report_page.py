# SPDX-License-Identifier: GPL-2.0-or-later
"""The page and the pictures: whole, self-contained, escaped, and red where necessary."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from html import escape
from html.parser import HTMLParser
from itertools import accumulate
from pathlib import Path

import pytest
from portable import WINDOWS
from report_capture import ACCEPT, BUS, LINE, READ, SET_TZA, STARTED, Sent, write

from sistap.commands.report import plots, tables
from sistap.commands.report.gather import Report, gather
from sistap.commands.report.page import page
from sistap.commands.report.windows import asked
from sistap.dissected.accesses.access import Access, Parameter
from sistap.dissected.accesses.listing import AccessPlace, Listing
from sistap.dissected.captures.portions import Portion
from sistap.dissected.draw.panel import Area, Bar, Strokes, Text
from sistap.dissected.draw.svg import stacked, svg
from sistap.dissected.episodes.episode import Episode, Hit
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.line.settings import Flag

NAME = "a & c.pcapng" if WINDOWS else "a <b> & c.pcapng"  # no file of Windows has < or >
VOID = {"meta", "br"}


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Report:
    capture = write(tmp_path_factory.mktemp("page") / NAME, BUS)
    with Tshark() as tshark:
        report = gather(tshark, [Portion(capture)], [asked(100, 1)], lambda text: None)
    report.name = NAME
    return report


@pytest.fixture(scope="module")
def text(report: Report) -> str:
    return page(report)


class Checker(HTMLParser):
    """Notes what is in a page, and whether every element is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.tags: set[str] = set()
        self.links: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        if tag not in VOID:
            self.open.append(tag)
        self._note(attrs)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._note(attrs)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def _note(self, attrs: list[tuple[str, str | None]]) -> None:
        self.ids += [value or "" for name, value in attrs if name == "id"]
        self.links += [value or "" for name, value in attrs if name in ("src", "href", "xlink:href")]


def test_the_page_is_whole_and_needs_nothing_else(text: str) -> None:
    checker = Checker(text)
    assert checker.open == []
    assert len(checker.ids) == len(set(checker.ids)) > 0
    assert all(link.startswith("#") and link[1:] in checker.ids for link in checker.links)
    assert set(re.findall(r"url\((.).*?\)", text)) <= {"#"}
    assert not checker.tags & {"script", "link", "iframe", "img", "object"}


def test_what_others_wrote_is_escaped(text: str) -> None:
    assert STARTED not in text
    assert "test &lt;b&gt;adapter&lt;/b&gt; &amp; &quot;quotes&quot;" in text
    assert f"<h1>{escape(NAME)}</h1>" in text


def test_below_the_answer_stands_what_its_short_names_mean(report: Report, text: str) -> None:
    legend = tables.legend(report)
    assert legend.startswith("Times: UTC")
    assert "TzA: longest interval allowed between two characters" in legend
    assert "Tmas" not in legend  # it is not in the answer
    assert f"</ol><p>{legend}</p>" in text
    happened = [Episode.of(Hit("step", 1, 0.0, 9.0, 3, "S-0-0040", "9 rpm below S-0-0036"))]
    known = Listing()
    for ident, name in (("S-0-0036", "Set"), ("P-0-0001", "Not told")):
        access = Access(Parameter("", "3", 7, ident), False, 16, "", "9", 9.0, "09", name, "", "", "")
        known.add(AccessPlace("", 1, 0.0), access)
    one = replace(report, episodes=happened, figures=replace(report.figures, parameters=known))
    assert tables.legend(one).split("; ")[1:] == ["S-0-0036: Set."]


def test_every_colour_of_the_pictures_changes_in_the_dark(text: str) -> None:
    body = text[text.index("<body>") :]
    assert not re.search(r"#[0-9a-f]{6}", body)
    light, dark = (set(re.findall(r"--(\w+):", line)) for line in text.splitlines() if ":root" in line)
    assert light == dark >= set(re.findall(r"var\(--(\w+)\)", text))


def test_a_window_with_nothing_in_it_says_so(text: str) -> None:
    assert "Asked for: 1 s from 100 s</b><br>Nothing was on the bus." in text


class Drawn:
    """A window that shows a packet, as it was drawn; times in ms since its beginning."""

    def __init__(self, report: Report, number: int) -> None:
        self.window = next(
            window for window in report.windows if number in [packet.number for packet in window.packets]
        )
        drawing = plots.window(self.window)
        assert drawing
        ((panel,),) = drawing.draw()
        self.words = [mark.words for mark in panel.marks if isinstance(mark, Text)]
        self.strokes = sorted(x for mark in panel.marks if isinstance(mark, Strokes) for x in mark.at)
        bars = [mark for mark in panel.marks if isinstance(mark, Bar)]
        self.red = [[bar.begin, bar.end] for bar in bars if bar.role == "bad" and not bar.is_outline]


def test_a_pause_that_exceeds_tza_is_red_from_character_to_character(report: Report) -> None:
    drawn = Drawn(report, 7)
    packet = next(packet for packet in drawn.window.packets if packet.number == 7)
    fifth = packet.time_s - drawn.window.start_s + 4 * LINE.character_ns / 1e9
    assert drawn.red == [pytest.approx([fifth * 1e3, fifth * 1e3 + 7.5], abs=1e-3)]
    assert "7.500 ms" in drawn.words


def test_every_pause_that_exceeds_tza_is_red(tmp_path: Path) -> None:
    two = Sent(READ, pauses_ms={3: 6.0, 9: 9.0, 11: 5.2})  # the third is not certain: 0.31 ms
    in_one_read = Sent(READ, silence_ms=500, pauses_ms={3: 6.0, 9: 9.0}, flags={4: Flag.SAME_READ})
    capture = write(tmp_path / "two.pcapng", [Sent(SET_TZA), Sent(ACCEPT), two, in_one_read])
    with Tshark() as tshark:
        report = gather(tshark, [Portion(capture)], [asked(0, 0.3), asked(0.4, 1)], lambda text: None)
    widths = {number: [end - begin for begin, end in Drawn(report, number).red] for number in (4, 5)}
    assert widths[4] == pytest.approx([6.0, 9.0], abs=1e-3)
    assert widths[5] == pytest.approx([9.0], abs=1e-3)  # the other one the dissector does not name


def test_the_wait_for_a_late_reaction_is_red(report: Report) -> None:
    drawn = Drawn(report, 10)
    late = next(packet for packet in drawn.window.packets if packet.number == 10)
    begin = (late.time_s - drawn.window.start_s) * 1e3
    assert drawn.red[-1] == pytest.approx([begin - 80, begin], abs=1e-3)
    assert "80.000 ms" in drawn.words


def test_a_command_without_a_reaction_is_marked(report: Report) -> None:
    assert "no reaction" in Drawn(report, 11).words


def test_every_character_is_a_stroke(report: Report) -> None:
    drawn = Drawn(report, 7)
    expected: list[float] = []
    for packet in drawn.window.packets:
        expected += accumulate(packet.intervals_s, initial=packet.time_s - drawn.window.start_s)
    assert drawn.strokes == pytest.approx(sorted(time * 1e3 for time in expected))
    assert len(expected) == 3 * 13  # packets 6 to 8


def test_limits_are_drawn(report: Report) -> None:
    intervals, reactions = plots.intervals(report), plots.reactions(report)
    assert intervals
    assert reactions
    assert "TzA 5 ms" in svg(intervals, "x")
    assert "0x10 Read parameter" in svg(reactions, "x")


def test_the_pauses_of_each_place_have_a_lane_with_tza(report: Report) -> None:
    for drawing in (plots.pauses_by_place(report), plots.pauses_by_talker(report)):
        assert drawing
        ((panel,),) = drawing.draw()
        assert panel.lanes == sum(isinstance(mark, Area) for mark in panel.marks) > 1
        assert {tuple(mark.at) for mark in panel.marks if isinstance(mark, Strokes)} <= {(0.005,), ()}


def test_the_first_screen_of_a_laptop_has_room_for_the_lanes_of_four_stations(report: Report) -> None:
    """They are as wide as the screen, 1366 points of which are 768 high; the five lines need half of it."""
    hits = [Hit("late", 1, 1.0, 1.0, station) for station in (None, 3, 4, 5, 6)]
    drift = Hit("drift", 0, 0.0, 10.0, 5)
    drawing = plots.timeline(replace(report, episodes=[Episode.of(hit) for hit in (*hits, drift)]))
    assert drawing and drawing.height_in / drawing.width_in * 1366 < 768 / 3
    ((panel,),) = drawing.draw()
    *late, slow = (mark for mark in panel.marks if isinstance(mark, Bar))
    assert slow.height < min(bar.height for bar in late) / 4


def test_the_overview_names_stations_and_faults(report: Report) -> None:
    drawing = plots.overview(report)
    assert drawing
    drawn = svg(drawing, "x")
    for name in ("station 3", "station 4", "station 16", "TzA exceeded", "TrS exceeded", "no reaction"):
        assert f">{name}<" in drawn
    assert ">Tmas exceeded<" not in drawn
    assert "bus load" not in drawn  # the capture is shorter than the second that it needs


def test_the_load_is_drawn_from_its_first_whole_second_on(tmp_path: Path) -> None:
    with Tshark() as tshark:
        capture = write(tmp_path / "load.pcapng", [Sent(READ, silence_ms=100.0)] * 30)
        figures = gather(tshark, [Portion(capture)], [], lambda text: None).figures
    # 30 times 100 ms of silence and 12 intervals of a character.
    loads = [(number * figures.slices.width_s, load) for number, load in enumerate(figures.slices.loads) if load]
    assert loads[0][0] == pytest.approx(1.0, abs=0.12)
    for _, load in loads:
        assert load == pytest.approx(100 * 13 * 1.1458 / (100 + 12 * 1.1458), abs=2.0)


def test_the_file_of_all_pictures_is_svg(report: Report) -> None:
    root = ET.fromstring(stacked(report.name, plots.drawings(report)).partition("\n")[2])
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    assert {NAME, "The whole capture"} <= {text.text for text in root.iter() if text.text}
