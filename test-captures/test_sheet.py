# SPDX-License-Identifier: GPL-2.0-or-later
"""The page for the wall is what the tables make it, and what hangs there is what is checked in."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest
from description import Code, Table

import sheet
from drawing import Column, Page, width, wrapped
from printing import digest


def texts(svg: str) -> list[str]:
    return [element.text or "" for element in ElementTree.fromstring(svg).iter("{http://www.w3.org/2000/svg}text")]


def test_checked_in_page_is_current() -> None:
    assert sheet.SVG.read_text() == sheet.sheet(), "python3 sheet.py --pdf"


def test_pdf_is_made_from_it() -> None:
    pdf = sheet.SVG.with_suffix(".pdf").read_bytes()
    assert pdf.startswith(b"%PDF-")
    assert pdf.endswith(digest(sheet.SVG.read_text()).encode()), "python3 sheet.py --pdf"


# Of the facts about the protocol, not of the tables: a code, and a word of what stands beside it.
@pytest.mark.parametrize(
    ("code", "word"),
    [
        ("03", "Initialization"),
        ("10 80 90", "Read parameter"),
        ("12 92", "Read phase"),
        ("F4", "Wrong checksum"),
        ("F8", "Invalid sequential telegram"),
        ("7007", "greater than the maximum"),
        ("800B", "cancelled"),
        ("D007", "master axis"),
        ("9701", "Additive checksum"),
        ("0801", "Test time too large"),
        ("9010 9110", "operating mode"),
        ("FF", "Accept"),
        ("254", "one hierarchy level"),
    ],
)
def test_code_stands_beside_its_text(code: str, word: str) -> None:
    found = texts(sheet.sheet())
    places = [place for place, text in enumerate(found) if text == code]
    assert any(word in " ".join(found[place + 1 : place + 3]) for place in places)


def test_all_codes_of_flash_and_parameters_are_on_it() -> None:
    """Those of parameters that are not there follow the rule beside them."""
    found = texts(sheet.sheet())
    written = {code for text in found for code in text.split()}
    assert {sheet.code(entry) for entry in sheet.table("errors_flash")} <= written
    for entry in sheet.table("errors_parameter"):
        if sheet.RULED.fullmatch(entry.key):
            assert entry.text.endswith(sheet.DIGITS[entry.first % 16])
        else:
            assert sheet.code(entry) in written


def test_a_bus_begins_with_9600() -> None:
    """Chapter 2.5. Times have no default values."""
    found = " ".join(texts(sheet.sheet()))
    assert "9600 Bd after switching on" in found
    assert "TzA, TrS and Tmas have no default values" in found
    assert "rate" not in found.split("no default values")[0].rsplit(".", 1)[1]


def test_telegrams_on_it_are_right() -> None:
    """Chapter 2.2: start character, sum, and both lengths."""
    written = re.findall(r"02(?: [0-9A-F]{2})+", f"{sheet.EXAMPLE} {sheet.READING}")
    telegrams = [bytes.fromhex(text) for text in written]
    assert len(telegrams) == 3
    for telegram in telegrams:
        assert sum(telegram) % 256 == 0
        assert telegram[2] == telegram[3] == len(telegram) - 8


def test_a_changed_text_changes_the_page(monkeypatch: pytest.MonkeyPatch) -> None:
    erase = Code(0x94, 0x94, "Wipe flash", "", "0x94")
    monkeypatch.setitem(sheet.TABLES, "subservices_flash", Table("subservices_flash", "", [erase], ""))
    assert "Wipe flash" in texts(sheet.sheet())


def test_lines_are_no_wider_than_their_room() -> None:
    lines = wrapped("0 binary, 1 unsigned, 2 signed, 3 hexadecimal, 4 text, 5 ident number", 2.6, 40)
    assert all(width(line, 2.6) <= 40 for line in lines)
    assert not any(line[-1].isdigit() for line in lines), "a number stays with its word"


def test_nothing_leaves_the_page_or_its_column() -> None:
    page = Page(100, 50, "small")
    with pytest.raises(ValueError, match="outside"):
        page.text(90, 20, "too far to the right", 3)
    column = Column(page, 5, (5, 20), 40, 3)
    with pytest.raises(ValueError, match="too short"):
        column.rows([("00", "text")] * 9, 10)
