# SPDX-License-Identifier: GPL-2.0-or-later
"""Every capture matches its text, and dissects to the expected result."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.etree import ElementTree

import pytest

from make import HERE, Scenario, scenarios
from merging import Group, groups
from sistap.dissected.wireshark.tshark import Tshark
from tables import LATER as LATER_NAMES
from tables import LATER_ELSEWHERE

every_scenario = pytest.mark.parametrize("path", scenarios(), ids=lambda path: path.stem)
PLAIN, WITH_OPTIONS, _ = groups()
LISTS = Group("lists", tuple(path for path in PLAIN.paths if not (Scenario(path).show or Scenario(path).options)))
NUMBER = re.compile(r"^ *\d+|(?<=frame )\d+", re.MULTILINE)


def test_captures_are_made_from_their_texts() -> None:
    for path in scenarios():
        assert Scenario(path).capture() == path.with_suffix(".pcapng").read_bytes(), path.stem


def renumbered(text: str, before: int) -> str:
    """Return a packet list as it is after so many packets of other captures."""
    return NUMBER.sub(lambda found: str(int(found[0]) + before).rjust(len(found[0])), text)


def test_packet_lists(tshark: Tshark, tmp_path: Path) -> None:
    """Of captures without trees and options, dissected together."""
    LISTS.write(tmp_path / "lists.pcapng")
    expected = ""
    for path in LISTS.paths:
        expected += renumbered(path.with_suffix(".expected").read_text(), expected.count("\n"))
    assert Scenario(LISTS.paths[0]).dissection(tshark, tmp_path / "lists.pcapng") == expected


@pytest.mark.parametrize("path", [path for path in scenarios() if path not in LISTS.paths], ids=lambda path: path.stem)
def test_trees(path: Path, tshark: Tshark) -> None:
    expected = path.with_suffix(".expected").read_text()
    assert Scenario(path).dissection(tshark, path.with_suffix(".pcapng")) == expected


PASSES = ((), ("-2",))
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


# Codes in texts: Wireshark groups by them. What follows is read as a code, whatever its value.
CODE = re.compile(
    r"\b(?:error|status|subservice|phase|object|Service code|Operation|Error class|code|additional|parameter type|"
    r"channel|fieldbus:|element|not defined:) \d\w*(?:, \d+)*|^0x\w+(?= is not defined)|"
    r"\b(?:more than|at least) \d+|= \d+|\d+ Bd",  # limits and rates: the same all the time
    re.IGNORECASE,
)


def test_texts_of_experts_are_the_same_in_each_packet(tshark: Tshark, tmp_path: Path) -> None:
    """Otherwise Wireshark cannot group them. Numbers of packets, counts and times belong into fields."""
    capture = tmp_path / "merged.pcapng"
    WITH_OPTIONS.write(capture)
    command = ("-2", "-r", str(capture), *WITH_OPTIONS.options, "-T", "fields", "-E", "aggregator=|")
    messages = set(re.split(r"[|\n]", tshark.output(*command, "-e", "_ws.expert.message")))
    literals = re.sub(r'"\s*"', "", "".join(path.read_text() for path in (HERE.parent / "plugin").rglob("*.c")))
    wrong = [text for text in messages if re.search(r"\b\d", CODE.sub("", text)) and text not in literals]
    assert len(messages) > 100
    assert not wrong, "\n".join(sorted(wrong))


@pytest.mark.style
def test_nothing_is_left_to_wiresharks_own_emergency_exits() -> None:
    for path in scenarios():
        expected = path.with_suffix(".expected").read_text()
        assert "Malformed Packet" not in expected, path.stem
        assert "Dissector bug" not in expected, path.stem
