# SPDX-License-Identifier: GPL-2.0-or-later
"""The description of the protocol: what is made from it is current, and what makes no sense in it is refused."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import generate
import pytest
from description import HERE, Description

DESCRIPTION = Description()

NEW_FIELD = """
["sis.new.colour"]
name = "Colour"
type = "uint8 hex"
mask = 0x03
codes = "colours"
means = "What colour it has"
"""
NEW_CODES = """
[colours]
about = "Of a service that does not exist."
[colours.codes]
0x01 = "Red"
0x02 = { text = "Blue", constant = "SIS_BLUE" }
"""
NEW_EXPERT = """
["sis.new.grey"]
group = "protocol"
severity = "note"
says = "Grey is no colour"
means = "The colour is not known."
do = "Look at the lamp."
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of the description."""
    for path in HERE.glob("*.toml"):
        shutil.copy(path, tmp_path)
    return tmp_path


def add(folder: Path, name: str, text: str) -> None:
    with (folder / name).open("a", encoding="utf-8") as file:
        file.write(text)


def test_what_is_made_from_it_is_current() -> None:
    stale = [path for path, text in generate.made(DESCRIPTION) if path.read_text("utf-8") != text]
    assert not stale, "run plugin/protocol/generate.py"


def test_what_is_new_appears_everywhere(folder: Path) -> None:
    add(folder, "fields.toml", NEW_FIELD)
    add(folder, "codes.toml", NEW_CODES)
    add(folder, "experts.toml", NEW_EXPERT)
    texts = {path.name: text for path, text in generate.made(Description(folder))}
    assert "extern int hf_sis_new_colour;" in texts["fields.h"]
    assert "#define SIS_NEW_COLOUR 0x03" in texts["fields.h"]
    assert (
        '{&hf_sis_new_colour, {"Colour", "sis.new.colour", FT_UINT8, BASE_HEX, VALS(sis_colours), 0x03, '
        '"What colour it has", HFILL}},'
    ) in texts["fields.c"]
    assert '{&ei_sis_new_grey, {"sis.new.grey", PI_PROTOCOL, PI_NOTE, "Grey is no colour", 0, ' in texts["fields.c"]
    assert "SIS_BLUE = 0x02," in texts["codes.h"]
    assert '{0x01, "Red"},\n    {SIS_BLUE, "Blue"},' in texts["codes.c"]
    script = texts["sis.lua"]
    assert 'field("sis.new.colour", "Colour", ftypes.UINT8, base.HEX, N.colours, 0x03, "What colour it has")' in script
    assert 'expert_field("sis.new.grey", "PROTOCOL", "NOTE", "Grey is no colour")' in script
    assert 'N.colours = {\n  [0x01] = "Red",\n  [K.BLUE] = "Blue",\n}' in script


def test_a_limit_is_the_same_in_both(folder: Path) -> None:
    add(folder, "limits.toml", '[SIS_MOST_LAMPS]\nis = 7\nabout = "Lamps of a station (chapter 0)."\n')
    texts = {path.name: text for path, text in generate.made(Description(folder))}
    assert "/* Lamps of a station (chapter 0). */\n#define SIS_MOST_LAMPS 7\n" in texts["limits.h"]
    assert "-- Lamps of a station (chapter 0).\nK.MOST_LAMPS = 7\n" in texts["sis.lua"]


def test_a_limit_stands_in_the_description_only() -> None:
    """A limit of sis.lua alone is that of its memory of results, which only makes it faster."""
    script = re.sub(r"\n--- limits: .*\n-- end of limits\n", "", generate.SCRIPT.read_text("utf-8"), flags=re.DOTALL)
    assert re.findall(r"\bMOST_\w+(?:, \w+)* = \d+", script) == ["MOST_GIVEN = 4000"]


@pytest.mark.parametrize(
    ("name", "entry", "error"),
    [
        ("fields.toml", NEW_FIELD.replace("uint8", "uint7"), "sis.new.colour has an unknown type"),
        ("fields.toml", NEW_FIELD.replace("mask", "msk"), "sis.new.colour has an unknown type, link or key"),
        ("fields.toml", NEW_FIELD, "sis.new.colour has codes that codes.toml lacks: colours"),
        ("experts.toml", NEW_EXPERT.replace("note", "hint"), "sis.new.grey has an unknown severity"),
        ("experts.toml", NEW_EXPERT.replace("protocol", "colour"), "sis.new.grey has an unknown severity or group"),
    ],
)
def test_an_entry_that_makes_no_sense(folder: Path, name: str, entry: str, error: str) -> None:
    add(folder, name, entry)
    with pytest.raises(ValueError, match=error):
        Description(folder)


def test_a_layout_of_what_is_no_field(folder: Path) -> None:
    path = folder / "services.toml"
    path.write_text(path.read_text("utf-8").replace('"flash.target ', '"flash.colour '), "utf-8")
    with pytest.raises(ValueError, match=r"flash: sis.flash.colour: fields.toml has no such field"):
        Description(folder)


LAMP = """
[layouts.lamp]
service = "0x05"
all = { command = "lamp.colour:2 lamp.hours:4" }
"""
LAMP_FIELDS = """
["sis.lamp.colour"]
name = "Colour"
type = "uint16 hex"
codes = "colours"
["sis.lamp.range"]
name = "Range"
type = "uint8 hex"
codes = "ranges"
["sis.lamp.bits"]
name = "Bits"
type = "uint8 hex"
mask = 0x03
["sis.lamp.hours"]
name = "Hours"
type = "uint32 dec"
["sis.lamp.on"]
name = "On for"
type = "time"
["sis.lamp.weight"]
name = "Weight"
type = "double"
["sis.lamp.lit"]
name = "Lit"
type = "boolean"
["sis.lamp.text"]
name = "Text"
type = "string"
"""
LAMP_CODES = (
    NEW_CODES
    + """
[ranges]
about = "Of a service that does not exist."
[ranges.codes]
0x01-0x07 = "Bright"
"""
)


@pytest.fixture
def with_lamp(folder: Path) -> Path:
    """A description with fields for a lamp."""
    add(folder, "fields.toml", LAMP_FIELDS)
    add(folder, "codes.toml", LAMP_CODES)
    return folder


@pytest.mark.parametrize(
    ("command", "error"),
    [
        ("lamp.colour", "sis.lamp.colour: it has 2 bytes: lamp.colour:2"),
        ("lamp.colour:4", "sis.lamp.colour: it has 2 bytes"),
        ("lamp.hours:3", "sis.lamp.hours: it has 4 bytes"),
        ("lamp.hours:*", "sis.lamp.hours: it has 4 bytes"),
        ("lamp.on:2", "sis.lamp.on: a time needs a function"),
        ("lamp.weight:8", "sis.lamp.weight: a double needs a function"),
        ("lamp.lit", "sis.lamp.lit: a boolean needs a function"),
        ("lamp.text:4", r"sis.lamp.text: it is the rest: lamp.text:\*"),
        ("data:3", r"sis.data: it is the rest: data:\*"),
        ("lamp.bits", "sis.lamp.bits: a field with a mask"),
        ("lamp.range", "sis.lamp.range: its codes have ranges"),
        ("data:* lamp.colour:2", "sis.data: nothing can follow it"),
        ("lamp.colour:2? lamp.hours:4", "sis.lamp.colour: nothing can follow it"),
        ("data:*?", "sis.data: the rest cannot be missing"),
    ],
)
def test_an_item_that_cannot_be_read(with_lamp: Path, command: str, error: str) -> None:
    """C and Lua would show something else, or read outside the useful data."""
    add(with_lamp, "services.toml", LAMP.replace("lamp.colour:2 lamp.hours:4", command))
    with pytest.raises(ValueError, match=f"services.toml: lamp: {error}"):
        Description(with_lamp)


@pytest.mark.parametrize(
    ("old", "new", "error"),
    [
        ("all", "0x01", "lamp has neither subservices with layouts nor the one layout"),
        ("all", 'subservices = "colours"\nall', "lamp has neither"),
        ("all", 'subservices = "colours"\n0x03', "lamp: 0x03 is no subservice of it"),
        ("all", 'subservices = "ranges"\n0x01', "lamp: codes.toml has no ranges, or it has ranges"),
        ("all", 'errors = "lamps"\nall', "lamp: codes.toml has no lamps"),
        ("all", 'functions = "lamp.text"\nall', "lamp: functions of no item: lamp.text"),
        ("0x05", "0x02", "service 0x02 is no byte, or has layouts twice"),
        ("0x05", "0x105", "service 0x105 is no byte"),
        ("0x05", "0x10", "0x80 cannot be like 0x10, which has layouts"),
    ],
)
def test_a_service_that_cannot_be_read(with_lamp: Path, old: str, new: str, error: str) -> None:
    add(with_lamp, "services.toml", LAMP.replace(old, new))
    with pytest.raises(ValueError, match=error):
        Description(with_lamp)


def test_a_layout_has_as_many_items_as_it_needs(with_lamp: Path) -> None:
    """An item without a field ends it in C."""
    add(with_lamp, "services.toml", LAMP.replace("lamp.colour:2 ", "lamp.colour:2 " * 9))
    texts = {path.name: text for path, text in generate.made(Description(with_lamp))}
    items = ["{NULL, &hf_sis_lamp_colour, sis_colours, 2, false}"] * 9
    items += ["{NULL, &hf_sis_lamp_hours, NULL, 4, false}", "{0}"]
    assert f"{{0x00, (const sis_item_t[]){{{', '.join(items)}}}, (const sis_item_t[]){{{{0}}}}}}" in texts["services.h"]


def test_a_service_without_a_status_may_have_subservices(with_lamp: Path) -> None:
    add(with_lamp, "services.toml", LAMP.replace("0x05", "0x30").replace("all", 'subservices = "colours"\n0x01'))
    texts = {path.name: text for path, text in generate.made(Description(with_lamp))}
    assert "[0x30] = {0x00, NULL, sis_colours, false, false}," in texts["services.c"]


@pytest.mark.parametrize(
    ("type_", "error"),
    [
        ('"uint8"', "an integer needs dec or hex"),
        ('"string hex"', "only an integer has dec or hex"),
        ('"time"\ncodes = "services"', "only an integer has dec or hex, codes or a unit"),
        ('"bytes"\nmask = 1', "only an integer or a boolean has a mask"),
        ('"boolean"\nmask = 1', "a boolean with a mask needs a width"),
        ('"uint8 hex"\nmask = 0x100', "its mask has more than 8 bits"),
        ('"uint8 hex"\ntexts = ["On", "Off"]', "only a boolean has texts"),
        ('"uint8 hex"\nlink = "request"', "only a packet has a link"),
    ],
)
def test_a_field_that_wireshark_would_not_register(folder: Path, type_: str, error: str) -> None:
    add(folder, "fields.toml", f'["sis.new.colour"]\nname = "Colour"\ntype = {type_}\n')
    with pytest.raises(ValueError, match=f"sis.new.colour: {error}"):
        Description(folder)


def test_a_new_subservice_appears_everywhere(folder: Path) -> None:
    path = folder / "services.toml"
    path.write_text(
        path.read_text("utf-8").replace("0x9F = {}", '0x9E = { command = "flash.address:4 data:*" }'), "utf-8"
    )
    codes = folder / "codes.toml"
    codes.write_text(
        codes.read_text("utf-8").replace("[subservices_flash.codes]", "[subservices_flash.codes]\n0x9E = 'New'")
    )
    texts = {path.name: text for path, text in generate.made(Description(folder))}
    assert "{take_flash_address, &hf_sis_flash_address, NULL, 4, false}, {take_data" in texts["services.h"]
    assert '[0x9E] = {\n      command = {{"flash_address", 4}, {"data", 0}},' in texts["sis.lua"]
    assert '0x9E: Layout((Item("flash.address", 4), Item("data", 0)), ()),' in texts["codes.py"]


def test_a_new_service_needs_no_function(folder: Path) -> None:
    """Its fields are shown as they say; a field with codes by their texts."""
    add(folder, "fields.toml", NEW_FIELD.replace("mask = 0x03\n", "").replace("sis.new.colour", "sis.lamp.colour"))
    add(folder, "codes.toml", NEW_CODES)
    add(folder, "services.toml", '[layouts.lamp]\nservice = "0x05"\nall = { command = "lamp.colour data:*" }\n')
    texts = {path.name: text for path, text in generate.made(Description(folder))}
    items = "{NULL, &hf_sis_lamp_colour, sis_colours, 1, false}, {NULL, &hf_sis_data, NULL, 0, false}"
    assert (
        f"{{0x05, NULL, 1, (const sis_layout_t[]){{ \\\n        {{0x00, (const sis_item_t[]){{{items}, {{0}}}}"
        in texts["services.h"]
    )
    assert (
        'is_by_layout = true,\n    [0x00] = {\n      command = {{"lamp_colour", 1, false, N.colours},'
        in texts["sis.lua"]
    )
    made: dict[str, Any] = {"__name__": "sistap.tap.sis.codes"}
    exec(texts["codes.py"], made)  # noqa: S102 - our own
    assert made["LAYOUTS"][0x05] == {0: made["Layout"]((("lamp.colour", 1, False), ("data", 0, False)), ())}
    assert made["WITHOUT_SUBSERVICES"] == {0x05}


def test_a_preference_is_the_same_everywhere(folder: Path) -> None:
    path = folder / "protocols.toml"
    path.write_text(path.read_text("utf-8").replace("default = 220", "default = 230"), "utf-8")
    texts = {path.name: text for path, text in generate.made(Description(folder))}
    assert "unsigned pref_3964r_zvz_ms = 230;" in texts["fields.c"]
    assert 'p3964r.prefs.zvz_ms = Pref.uint("ZVZ in ms", 230,' in texts["sis.lua"]


def test_a_fault_is_the_same_everywhere(folder: Path) -> None:
    """Colours, buttons, the recorder and the report: one of them may not find more than another."""
    path = folder / "faults.toml"
    path.write_text(path.read_text("utf-8").replace('["sis.repeat_of"]', '["sis.repeat_of", "sis.new > 3"]'), "utf-8")
    texts = {path.name: text for path, text in generate.made(Description(folder))}
    new = "sis.command.unanswered || sis.repeat_of || sis.new > 3"
    assert f"@SIS: unanswered or repeated@{new}@" in texts["colorfilters"]
    assert f'"TRUE","Unanswered","{new}",' in texts["dfilter_buttons"]
    assert '("sis.repeat_of", "sis.new > 3"),' in texts["faults.py"]


def test_what_to_do_about_a_fault_is_what_its_expert_item_says(folder: Path) -> None:
    """The report and the explanation of a log show it."""
    path = folder / "experts.toml"
    text = path.read_text("utf-8").replace("Look what kept the master", "Look who kept the master")
    text = text.replace("Make the times more exact:", "Measure better:")
    path.write_text(text, "utf-8")
    texts = {path.name: text for path, text in generate.made(Description(folder))}
    assert texts["faults.py"].count("Look who kept the master") == 1
    assert texts["faults.py"].count('"Measure better:') == 1
    (folder / "faults.toml").write_text(
        (folder / "faults.toml").read_text("utf-8").replace('"sis.tmas.exceeded"', '"sis.no.such"'), "utf-8"
    )
    with pytest.raises(ValueError, match="experts.toml has no sis.no.such"):
        Description(folder)


def test_the_reference_hides_no_column_on_a_telephone() -> None:
    """There a table with more than two columns is wider than the screen."""
    (page,) = (text for path, text in generate.made(DESCRIPTION) if path.name == "REFERENCE.md")
    rows = [line for line in page.replace("\\|", "").splitlines() if line.startswith("|")]
    assert rows and [row for row in rows if row.count("|") > 3] == []
    for item in DESCRIPTION.experts:
        heading, _, rest = page.partition(f"`{item.filter}` (")
        assert heading.endswith(f"### {item.says}\n\n")
        assert f"{item.means} **What to do:** {item.do}" in rest.partition("###")[0]


def test_every_field_and_expert_item_says_what_it_means() -> None:
    """The status line, the reference and the report show it."""
    assert [field.filter for field in DESCRIPTION.fields if not field.means] == []
    assert [item.filter for item in DESCRIPTION.experts if not (item.means and item.do)] == []


def test_single_services_come_first() -> None:
    """The first entry that fits gives a service its name."""
    singles = [code.first == code.last for code in DESCRIPTION.tables["services"].codes]
    assert singles == sorted(singles, reverse=True)


@pytest.mark.parametrize("name", ["services", "status"])
def test_every_code_of_a_byte_has_a_text(name: str) -> None:
    rows = DESCRIPTION.tables[name].codes
    assert {code for row in rows for code in range(row.first, row.last + 1)} == set(range(256))


def test_filters_are_named_as_wireshark_wants_them() -> None:
    names = [field.filter for field in DESCRIPTION.fields] + [item.filter for item in DESCRIPTION.experts]
    assert len(names) == len(set(names))
    assert all(re.fullmatch(r"[a-z0-9_]+(\.[a-z0-9_]+)+", name) for name in names)
