# SPDX-License-Identifier: GPL-2.0-or-later
"""sis.lua makes fields that somebody wants with the values that they have among all others."""

from __future__ import annotations

import random
from collections.abc import Sequence
from pathlib import Path

import pytest
from description import Description

from merging import groups
from sistap.dissected.packets.apart import PACKED
from sistap.dissected.wireshark.rows import printing
from sistap.dissected.wireshark.tshark import Tshark

EXPERTS = {item.filter for item in Description().experts}
EXPERT = "_ws.expert.message"  # always there, in the order of the items that have them
OF_A_TEXT = "Trailing stray characters"  # Wireshark 4.2 and later add it to a text, if that is made
NAMES = sorted(
    field.filter
    for field in Description().fields
    if field.filter.startswith(("sertap.", "sis.")) and field.filter != PACKED
)
SHUFFLED = random.Random(48).sample(NAMES, len(NAMES))
TOGETHER = 60
CHUNKS = [SHUFFLED[at : at + TOGETHER] for at in range(0, len(NAMES), TOGETHER)]
PAIRS = [SHUFFLED[at : at + 2] for at in range(0, len(NAMES), 2)]

Columns = dict[str, tuple[str, ...]]


def columns(script: Tshark, capture: Path, names: Sequence[str], *options: str) -> Columns:
    """Return the values of fields, a text for each packet."""
    asked = [*names, EXPERT, PACKED]
    lines = list(script.lines(["-r", str(capture), *options, *printing(asked)]))
    found = dict(zip(asked, zip(*(line.split("\t") for line in lines), strict=True), strict=True))
    found[EXPERT] = tuple("\n".join(_ours(text.split("\x1f"))) for text in found[EXPERT])
    made = {*names, *EXPERTS}
    found[PACKED] = tuple(  # says of each telegram what was made
        " ".join(part for part in text.split(" ") if part.split("\x1f")[0].split("=")[0] in made)
        for text in found[PACKED]
    )
    return found


def _ours(messages: Sequence[str]) -> list[str]:
    return sorted(message for message in messages if message != OF_A_TEXT)


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write all captures but those over TCP as one."""
    path = tmp_path_factory.mktemp("wanted") / "merged.pcapng"
    groups()[0].write(path)
    return path


@pytest.fixture(scope="module")
def among_all(script: Tshark, capture: Path) -> Columns:
    """Return what every field has if all are made."""
    return columns(script, capture, NAMES)


def wanted(names: Sequence[str]) -> tuple[str, str]:
    """Return the options that name fields; a wrong name changes nothing."""
    return "-o", f"sis.fields:{','.join(names)}, no.such_field"


def check(script: Tshark, capture: Path, names: Sequence[str], among_all: Columns) -> None:
    """Compare the values of fields."""
    found = columns(script, capture, names, *wanted(names))
    for name in [*names, EXPERT]:
        assert found[name] == among_all[name], name


@pytest.mark.parametrize("names", CHUNKS, ids=lambda names: names[0])
def test_many_fields(names: list[str], script: Tshark, capture: Path, among_all: Columns) -> None:
    """As sistap asks for them: whatever is above them in the tree is not made."""
    check(script, capture, names, among_all)


@pytest.mark.thorough
@pytest.mark.parametrize("names", PAIRS, ids=lambda names: names[0])
def test_pairs_and_filters(names: list[str], script: Tshark, capture: Path, among_all: Columns) -> None:
    """As the page asks for them: a filter leaves the same packets, with the same words in the list."""
    check(script, capture, names, among_all)
    for name in names:
        check(script, capture, [name], among_all)
        filtering = ("-r", str(capture), "-Y", name)
        assert script.output(*filtering, *wanted([name])) == script.output(*filtering)


@pytest.mark.thorough
@pytest.mark.parametrize("protocol", ["sertap", "sis"])
def test_a_protocol_has_all_of_its_fields(protocol: str, script: Tshark, capture: Path, among_all: Columns) -> None:
    names = [name for name in NAMES if name.startswith(f"{protocol}.")]
    found = columns(script, capture, names, *wanted([protocol]))
    assert {name: found[name] for name in names} == {name: among_all[name] for name in names}
