# SPDX-License-Identifier: GPL-2.0-or-later
"""The poster is what the tables make it, and its telegrams and times are right."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from itertools import pairwise
from xml.etree import ElementTree

import pytest

import poster
import wiring
from pages.profile import buttons
from printing import digest

SPACE = "{http://www.w3.org/2000/svg}"


def texts(svg: str) -> list[str]:
    return [element.text or "" for element in ElementTree.fromstring(svg).iter(f"{SPACE}text")]


def test_checked_in_posters_are_current() -> None:
    assert poster.SVG.read_text() == poster.poster(), "python3 poster.py --pdf"
    assert poster.CHART.read_text() == poster.wall_chart(), "python3 poster.py --pdf"


def test_pdfs_are_made_from_them() -> None:
    papers = {f"poster-{name}.pdf": poster.sized(poster.poster(), scale) for name, scale in poster.SHEETS.items()}
    for name, svg in {**papers, "wall-chart.pdf": poster.wall_chart()}.items():
        pdf = poster.SVG.with_name(name).read_bytes()
        assert pdf.startswith(b"%PDF-")
        assert pdf.endswith(digest(svg).encode()), "python3 poster.py --pdf"


def test_papers_have_their_sizes() -> None:
    """ISO 216."""
    sizes = {name: poster.sized(poster.poster(), scale).split(" viewBox")[0] for name, scale in poster.SHEETS.items()}
    assert 'width="420mm" height="297mm"' in sizes["a3"]
    found = re.search(r'width="297mm" height="([\d.]+)mm"', sizes["a4"])
    assert found
    assert abs(float(found[1]) - 210) < 0.1


@pytest.mark.parametrize("pairs", [poster.COMMAND, poster.REACTION])
def test_telegrams_are_right(pairs: str) -> None:
    """Chapter 2.2: start character, sum, and both lengths."""
    telegram = bytes.fromhex(pairs)
    assert telegram[0] == 2
    assert sum(telegram) % 256 == 0
    assert telegram[2] == telegram[3] == len(telegram) - 8


def test_checksum_is_worked_out() -> None:
    """2 + 5 + 5 + 16 + 16 + 3 + 60 + 3 + 36 is 146, 92 in hexadecimal; 256 - 146 is 110, 6E."""
    steps = dict(poster.checksum_steps(poster.COMMAND))
    assert steps["Sum"].startswith("92 ")
    assert steps["100 - 92"].startswith("= 6E")


def test_every_button_is_named_with_its_whole_filter() -> None:
    found = texts(poster.poster())
    for word, expression, _ in buttons():
        following = found[found.index(word) + 1 :]
        assert expression in " ".join(following)
    assert not any("..." in text for text in found)


def test_parts_of_a_telegram_are_named_as_in_the_definition() -> None:
    """Chapter 2.3: contents are a useful data header and useful data. A command that reads has no useful data."""
    for svg in (poster.poster(), poster.wall_chart()):
        found = texts(svg)
        assert [text for text in found if text in ("header", *poster.PARTS.values())][:5] == [
            *("header", "useful data header"),
            *("header", "useful data header", "useful data"),
        ]


def test_type_does_not_decide_between_s_and_p() -> None:
    """Fig. 8-3: bit 15 of the number does."""
    found = " ".join(texts(poster.poster()))
    assert "Type: S or P" not in found
    assert "Bit 15 of the number: 0 is S, 1 is P." in found


@pytest.mark.parametrize("draw", [poster.poster, poster.wall_chart])
def test_ground_is_wired_to_every_station(draw: Callable[[], str]) -> None:
    root = ElementTree.fromstring(draw())
    assert "ground" in texts(draw())
    down = [
        one
        for one in root.iter(f"{SPACE}line")
        if one.get("stroke") == wiring.GROUND and one.get("x1") == one.get("x2")
    ]
    assert len(down) == 4


def test_the_chart_is_read_from_two_metres() -> None:
    """A1, and no letter below 24 pt (8.47 mm)."""
    svg = poster.wall_chart()
    assert 'width="841mm" height="594mm"' in svg

    def sizes(element: ElementTree.Element, scale: float) -> Iterator[float]:
        scaled = re.search(r"scale\(([\d.]+)\)", element.get("transform", ""))
        scale *= float(scaled[1]) if scaled else 1
        if element.tag == f"{SPACE}text":
            yield scale * float(element.get("font-size", 0))
        for below in element:
            yield from sizes(below, scale)

    assert min(sizes(ElementTree.fromstring(svg), 1)) >= 24 * 25.4 / 72


def test_arrows_begin_and_end_where_a_character_has_arrived() -> None:
    """Times are measured from arrival to arrival: each end of an arrow is the end of a character."""
    root = ElementTree.fromstring(poster.poster())
    boxes = [box for box in root.iter(f"{SPACE}rect") if box.get("stroke")]
    places = [float(box.get("x", 0)) for box in boxes if box.get("width") == f"{poster.CHARACTER:g}"]
    arrived = {round(place + poster.CHARACTER, 3) for place in places}
    heads = [path.get("d", "") for path in root.iter(f"{SPACE}path")]
    tips = [round(float(head[1:].split(" ")[0]), 3) for head in heads]
    assert len(tips) == 8
    assert set(tips[1:]) <= arrived  # the first is the beginning of a silence
    tza = tips[2:4]
    assert not [one for one in arrived if tza[0] < one < tza[1]]
    assert all(one < other for one, other in pairwise(tips[:4]))
