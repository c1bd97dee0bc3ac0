# SPDX-License-Identifier: GPL-2.0-or-later
"""sis.lua declares the fields and expert items that the plugin registers."""

from __future__ import annotations

from pathlib import Path

import pytest

import fields

HEAD = 'static const value_string colours[] = {\n    {RED, "Red"},\n    {7, "Blue"},\n    {0, NULL},\n};\n'


@pytest.fixture
def plugin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A plugin with one header."""
    monkeypatch.setattr(fields, "PLUGIN", tmp_path)
    (tmp_path / "x.h").write_text("#define RED 3\ntypedef enum { FIRST, /* one, two */ SECOND } order_t;\n")
    return tmp_path


def made(plugin: Path, source: str) -> list[str]:
    (plugin / "x.c").write_text(source)
    return fields.current().splitlines()[3:-2]


def test_script_is_current() -> None:
    assert fields.current() in fields.SCRIPT.read_text(), "run lua-fallback/fields.py"


def test_a_field_with_all_that_it_can_have(plugin: Path) -> None:
    source = HEAD + '{&hf_x, {"Text", "sis.x.y", FT_UINT8, BASE_HEX, VALS(colours), RED,\n  "Said", HFILL}},\n'
    assert made(plugin, source) == [
        "N.colours = {",
        '  [3] = "Red",',
        '  [7] = "Blue",',
        "}",
        'field("sis.x.y", "Text", ftypes.UINT8, base.HEX, N.colours, 0x03, "Said")',
    ]


def test_a_number_of_an_enum_and_a_field_with_nothing(plugin: Path) -> None:
    source = (
        '{&hf_a, {"A", "sis.a", FT_BOOLEAN, 8, NULL, SECOND, NULL, HFILL}},\n'
        '{&hf_b, {"B", "sis.b", FT_NONE, BASE_NONE, NULL, 0, NULL, HFILL}},\n'
    )
    assert made(plugin, source) == [
        'field("sis.a", "A", ftypes.BOOLEAN, 8, nil, 0x01)',
        'field("sis.b", "B", ftypes.NONE)',
    ]


def test_units_and_frames(plugin: Path) -> None:
    source = (
        'static const unit_name_string units_baud = {" Bd", NULL};\n'
        '{&hf_a, {"A", "sis.a", FT_UINT32, BASE_DEC | BASE_UNIT_STRING, UNS(&units_baud), 0, NULL, HFILL}},\n'
        '{&hf_b, {"B", "sis.b", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_REQUEST), 0, NULL, HFILL}},\n'
    )
    assert made(plugin, source) == [
        'field("sis.a", "A", ftypes.UINT32, base.DEC + base.UNIT_STRING, {" Bd"})',
        'field("sis.b", "B", ftypes.FRAMENUM, base.NONE, frametype.REQUEST)',
    ]


def test_an_expert_item_too_long_for_a_line(plugin: Path) -> None:
    words = "many words " * 20
    lines = made(plugin, f'{{&ei_x, {{"sis.x.y", PI_PROTOCOL, PI_WARN, "{words}", EXPFILL}}}},\n')
    assert lines[0] == 'expert_field("sis.x.y", "PROTOCOL", "WARN",'
    assert all(len(line) <= fields.WIDTH for line in lines)
    assert (
        "".join(line.strip().removeprefix('.. "').removeprefix('"') for line in lines[1:]).replace('"', "")
        == words + ")"
    )


def test_a_registration_that_cannot_be_read(plugin: Path) -> None:
    with pytest.raises(ValueError, match=r"a registration in .*x\.c cannot be read"):
        made(plugin, '{&hf_x, {"Text", name, FT_UINT8, BASE_HEX, NULL, 0, NULL, HFILL}},\n')
