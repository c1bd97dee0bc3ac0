# SPDX-License-Identifier: GPL-2.0-or-later
"""sis.lua says what the C plugin says: of every capture, in one pass and in two, and of every field there is."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest

import parity
from make import Scenario, scenarios
from sistap.tshark import Tshark

every_scenario = pytest.mark.parametrize("path", scenarios(), ids=lambda path: path.stem)


TABLE = "uat:sis_parameters:"  # the user's table of parameters: Lua cannot have one


def options(scenario: Scenario, passes: tuple[str, ...]) -> list[str]:
    """Give the options that both understand, with two passes so that the first of them has fields.

    A script knows section and interface from fields, and the first of two passes has none, unless a read filter needs
    them.
    """
    words = scenario.options
    given = [word for word in zip(words[::2], words[1::2], strict=True) if not word[1].startswith(TABLE)]
    has_lines = any(item.interface or item.section for item in scenario.items)
    reading = ("-R", "frame") if passes and has_lines else ()
    return [*passes, *reading, *(word for pair in given for word in pair)]


@every_scenario
@pytest.mark.parametrize("passes", [(), ("-2",)], ids=["one_pass", "two_passes"])
def test_every_item(path: Path, passes: tuple[str, ...], plugin: Tshark, script: Tshark) -> None:
    """The whole trees, and the packet list alone, for which most of the work is left out."""
    parity.check(plugin, script, path.with_suffix(".pcapng"), *options(Scenario(path), passes))


@every_scenario
def test_expected_text(path: Path, script: Tshark) -> None:
    """What is generated stands in brackets here."""
    scenario = Scenario(path)
    if any(TABLE in word for word in scenario.options):
        pytest.skip("Lua cannot have a table of the user's")
    assert scenario.dissection(script, path.with_suffix(".pcapng")) == path.with_suffix(".expected").read_text()


# What differs, and cannot be the same: C's way to declare a status of a checksum, Decode As of a table of ours, and
# from 4.2 on the name of a heuristic.
DIFFERENT = {
    "fields": {"sis.checksum.status": ("BASE_NONE", "BASE_DEC")},
    "heuristic-decodes": {"sis": ("SIS over TCP", "SIS")},
    "dissector-tables": {"sertap.framing": ("Decode As supported", "Decode As not supported")},
}
OURS = re.compile(r"(^|\t)(sis|sertap)([.\t]|$)", re.MULTILINE)


@pytest.mark.parametrize(
    "report", ["fields", "values", "protocols", "decodes", "heuristic-decodes", "dissector-tables"]
)
def test_registered(report: str, plugin: Tshark, script: Tshark) -> None:
    """Every field with its type, base and description, every value with its text, and where packets come from."""
    expected, found = (
        Counter(line for line in tshark.output("-G", report).splitlines() if OURS.search(line))
        for tshark in (plugin, script)
    )
    assert expected
    for name, (in_c, in_lua) in DIFFERENT.get(report, {}).items():
        (line,) = (line for line in expected if name in line.split("\t"))
        expected -= Counter([line])
        expected[line.replace(in_c, in_lua)] += 1
    assert sorted((expected - found).elements()) == []
    assert sorted((found - expected).elements()) == []


def test_preferences(plugin: Tshark, script: Tshark) -> None:
    """Names, defaults and descriptions, as they stand in a file of preferences."""
    expected, found = (
        [entry for entry in tshark.output("-G", "currentprefs").split("\n\n") if re.search("^#sis[.]", entry, re.M)]
        for tshark in (plugin, script)
    )
    assert expected
    assert found == expected
