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


@every_scenario
@pytest.mark.parametrize("passes", [(), ("-2",)], ids=["one_pass", "two_passes"])
def test_every_item(path: Path, passes: tuple[str, ...], plugin: Tshark, script: Tshark) -> None:
    options = (*passes, *Scenario(path).options)
    assert not parity.compare(plugin, script, path.with_suffix(".pcapng"), *options)


@every_scenario
def test_expected_text(path: Path, script: Tshark) -> None:
    """What is generated stands in brackets here, and the columns are here."""
    expected = path.with_suffix(".expected").read_text()
    assert Scenario(path).dissection(script, path.with_suffix(".pcapng")) == expected


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
