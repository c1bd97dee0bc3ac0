# SPDX-License-Identifier: GPL-2.0-or-later
"""Every capture matches its text, and dissects to the expected result."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.etree import ElementTree

import pytest

from make import Scenario, scenarios
from merging import Group, groups
from sistap.wireshark.tshark import Tshark
from tables import LATER as LATER_NAMES
from tables import LATER_ELSEWHERE

every_scenario = pytest.mark.parametrize("path", scenarios(), ids=lambda path: path.stem)


@every_scenario
def test_capture_is_made_from_its_text(path: Path) -> None:
    assert Scenario(path).capture() == path.with_suffix(".pcapng").read_bytes()


@every_scenario
def test_dissection(path: Path, tshark: Tshark) -> None:
    expected = path.with_suffix(".expected").read_text()
    assert Scenario(path).dissection(tshark, path.with_suffix(".pcapng")) == expected


PASSES = ((), ("-2",))
PLAIN, WITH_OPTIONS = groups()
GROUP_NAMES = (PLAIN.name, WITH_OPTIONS.name)
LATER = {f"sis.{name}" for name in LATER_NAMES} | LATER_ELSEWHERE


def fields(element: ElementTree.Element) -> Iterator[str]:
    """Return all fields of a PDML packet with their text, except those of LATER and the expert items made of them."""
    for field in element:
        is_expert = field.get("name") == "_ws.expert" and any(child.get("name") in LATER for child in field)
        if field.get("name") not in LATER and not is_expert:
            yield f"{field.get('name')}: {field.get('showname') or field.get('show')}"
            yield from fields(field)


def check_passes(capture: Path, options: Sequence[str], tshark: Tshark) -> None:
    """Compare trees and packet lists of a first and a second pass."""
    command = ("-r", str(capture), *options)
    first, second = (ElementTree.fromstring(tshark.output(*passes, *command, "-T", "pdml")) for passes in PASSES)
    assert len(first) == len(second)
    for number, (one, two) in enumerate(zip(first, second, strict=True), 1):
        assert list(fields(one)) == list(fields(two)), number
    assert tshark.output(*command) == tshark.output("-2", *command).replace("  [no reaction]", "")


# Without TCP, which does not know in the first of two passes where a split telegram ends.
@pytest.mark.thorough
@pytest.mark.parametrize("group", [PLAIN, WITH_OPTIONS], ids=GROUP_NAMES)
def test_second_pass_says_the_same(group: Group, tshark: Tshark, tmp_path: Path) -> None:
    capture = tmp_path / "merged.pcapng"
    group.write(capture)
    check_passes(capture, group.options, tshark)


@pytest.mark.thorough
@every_scenario
def test_second_pass_says_the_same_of_each_alone(path: Path, tshark: Tshark) -> None:
    scenario = Scenario(path)
    if scenario.link != "tcp":
        check_passes(path.with_suffix(".pcapng"), scenario.options, tshark)


@every_scenario
def test_nothing_is_left_to_wiresharks_own_emergency_exits(path: Path) -> None:
    expected = path.with_suffix(".expected").read_text()
    assert "Malformed Packet" not in expected
    assert "Dissector bug" not in expected
