# SPDX-License-Identifier: GPL-2.0-or-later
"""Every capture is what its text makes, and dissects to what is expected."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest

from make import Scenario, scenarios
from sistap.tshark import Tshark
from tables import LATER as LATER_NAMES

every_scenario = pytest.mark.parametrize("path", scenarios(), ids=lambda path: path.stem)


@every_scenario
def test_capture_is_made_from_its_text(path: Path) -> None:
    assert Scenario(path).capture() == path.with_suffix(".pcapng").read_bytes()


@every_scenario
def test_dissection(path: Path, tshark: Tshark) -> None:
    expected = path.with_suffix(".expected").read_text()
    assert Scenario(path).dissection(tshark, path.with_suffix(".pcapng")) == expected


LATER = {f"sis.{name}" for name in LATER_NAMES}


def fields(element: ElementTree.Element) -> Iterator[str]:
    """Give all fields of a PDML packet with what they show, but those of LATER and the expert items made of them."""
    for field in element:
        is_expert = field.get("name") == "_ws.expert" and any(child.get("name") in LATER for child in field)
        if field.get("name") not in LATER and not is_expert:
            yield f"{field.get('name')}: {field.get('showname') or field.get('show')}"
            yield from fields(field)


@every_scenario
def test_second_pass_says_the_same(path: Path, tshark: Tshark) -> None:
    scenario, capture = Scenario(path), str(path.with_suffix(".pcapng"))
    if scenario.link == "tcp":
        pytest.skip("in the first of two passes TCP does not know yet where a split telegram ends")
    command = ("-r", capture, *scenario.options, "-T", "pdml")
    first, second = (ElementTree.fromstring(tshark.output(*passes, *command)) for passes in ((), ("-2",)))
    assert len(first) == len(second)
    for one, two in zip(first, second, strict=True):
        assert list(fields(one)) == list(fields(two))


@every_scenario
def test_second_pass_lists_the_same(path: Path, tshark: Tshark) -> None:
    scenario, capture = Scenario(path), str(path.with_suffix(".pcapng"))
    if scenario.link == "tcp":
        pytest.skip("in the first of two passes TCP does not know yet where a split telegram ends")
    command = ("-r", capture, *scenario.options)
    assert tshark.output(*command) == tshark.output("-2", *command)


@every_scenario
def test_nothing_is_left_to_wiresharks_own_emergency_exits(path: Path) -> None:
    expected = path.with_suffix(".expected").read_text()
    assert "Malformed Packet" not in expected
    assert "Dissector bug" not in expected
