# SPDX-License-Identifier: GPL-2.0-or-later
"""A capture that is cut into the files of a ring shows what the whole shows, wherever it is cut."""

from __future__ import annotations

from pathlib import Path

import pytest

from make import HERE
from rings import FIELDS, as_sections, records_of, ring, shown
from sistap.dissected.wireshark.tshark import Tshark

# Each has something that later telegrams need: names, attributes, types, limits, rates, routes, pieces.
CAPTURES = (
    *("values", "twins", "accesses-late", "commands", "initialization", "timing-limits", "timing-rates"),
    *("routes", "routes-interleaved", "exchanges", "exchanges-swapped", "sequences", "sequences-apart", "duplex"),
    *("statistics", "phases", "accesses", "parameters", "specification"),
)
# A file does not wait for a reaction that comes twice, and has no limits that belong to an attribute from before.
ONLY = {"accesses": 22, "parameters": 38}
SHORTEST = 9  # blocks of a file: section, interfaces and events are up to six of them


def check(tshark: Tshark, folder: Path, captures: tuple[str, ...], blocks: int) -> int:
    """Compare the rings of captures with the wholes, in two runs of tshark; return the number of files."""
    wholes: list[Path] = []
    rings: list[Path] = []
    for name in captures:
        records = records_of(HERE / f"{name}.pcapng")[: ONLY.get(name)]
        wholes += ring(records, folder / f"{name}-whole", 1_000_000)
        rings += ring(records, folder / f"{name}-ring", blocks)
    assert len(wholes) == len(captures)
    expected = shown(tshark, as_sections(wholes, folder / "wholes.pcapng"))
    found = shown(tshark, as_sections(rings, folder / "rings.pcapng"))
    assert all(any(column) for column in list(zip(*expected, strict=True))[2:]), "a field is nowhere"
    assert len(found) == len(expected)
    for number, (cut, whole) in enumerate(zip(found, expected, strict=True), 1):
        wrong = [
            f"{name}: {one!r}, expected {other!r}"
            for name, one, other in zip(FIELDS, cut, whole, strict=True)
            if one != other
        ]
        assert not wrong, f"record {number}: {'; '.join(wrong)}"
    return len(rings)


def test_a_ring_shows_what_the_whole_shows(tshark: Tshark, tmp_path: Path) -> None:
    assert check(tshark, tmp_path, CAPTURES, SHORTEST) > 100


@pytest.mark.thorough
@pytest.mark.parametrize("blocks", range(SHORTEST + 1, 30))
def test_wherever_it_is_cut(blocks: int, tshark: Tshark, tmp_path: Path) -> None:
    assert check(tshark, tmp_path, CAPTURES, blocks) > 20
