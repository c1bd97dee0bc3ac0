# SPDX-License-Identifier: GPL-2.0-or-later
"""The poster is what the tables make it, and its telegrams and times are right."""

from __future__ import annotations

import re
from itertools import pairwise
from xml.etree import ElementTree

import pytest

import poster
from pages.profile import buttons

SPACE = "{http://www.w3.org/2000/svg}"


def test_checked_in_poster_is_current() -> None:
    assert poster.SVG.read_text() == poster.poster(), "python3 poster.py --pdf"


@pytest.mark.parametrize("name", poster.SHEETS)
def test_pdfs_are_made_from_it(name: str) -> None:
    pdf = poster.SVG.with_name(f"poster-{name}.pdf").read_bytes()
    assert pdf.startswith(b"%PDF-")
    assert pdf.endswith(poster.digest(poster.SVG.read_text()).encode()), "python3 poster.py --pdf"


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


def test_every_button_is_named() -> None:
    texts = [element.text for element in ElementTree.fromstring(poster.poster()).iter(f"{SPACE}text")]
    assert all(word in texts for word, _, _ in buttons())


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
