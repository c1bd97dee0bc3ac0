# SPDX-License-Identifier: GPL-2.0-or-later
"""A capture that is read in portions shows what the whole shows, wherever it is cut."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import accumulate
from pathlib import Path

import pytest

from make import HERE
from rings import FIELDS
from sistap.dissected.captures import joining, portions, reading
from sistap.dissected.captures.portions import in_turn
from sistap.dissected.wireshark.tshark import Tshark

# Commands, reactions, refusals, repeats, damage, long data, names and units, limits and rates, routes, two directions.
CAPTURES = (
    *("course/02-status-and-errors", "course/03-parameters", "course/04-bad-line", "course/05-new-times-and-rate"),
    *("course/09-long-data", "lists-anew", "routes", "repeats", "duplex"),
)
SHOWN = (*FIELDS, "sis.command.unanswered", "sis.sequence.ended", "sis.silence_before")
AROUND = 12  # packets on either side of a seam that are in both portions: long data of these have no more pieces


def shown(tshark: Tshark, capture: Path) -> Iterator[list[str]]:
    """Yield the fields of each packet, and whether it is a repeat."""
    fields = [word for name in ("sis.repeat_of", *SHOWN) for word in ("-e", name)]
    for line in tshark.lines(["-r", str(capture), "-2", "-T", "fields", *fields]):
        repeat_of, *others = line.split("\t")
        yield [str(bool(repeat_of)), *others]


def cuts(capture: Path) -> Iterator[int]:
    """Yield sizes of portions: the first ends after each packet in turn."""
    sizes = accumulate(len(packet.body) for packet in joining.packets(capture, pytest.fail))
    return (size - 1 for size in sizes)


@pytest.mark.parametrize("name", CAPTURES)
def test_a_seam_changes_nothing(name: str, tshark: Tshark, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All portions are sections of a file, which share nothing."""
    monkeypatch.setattr(portions, "_AROUND", AROUND)
    capture = HERE / f"{name}.pcapng"
    sections: list[bytes] = []
    is_own: list[bool] = []
    mosts = [*cuts(capture)]
    for most in mosts:
        for portion in in_turn([capture], most, pytest.fail):
            sections.append(portion.path.read_bytes())
            count = sum(1 for _ in reading.packets(portion.path))
            is_own += [portion.owns(number) for number in range(1, count + 1)]
    every = tmp_path / "portions.pcapng"
    every.write_bytes(b"".join(sections))
    found = [row for row, is_one in zip(shown(tshark, every), is_own, strict=True) if is_one]
    whole = [*shown(tshark, capture)]
    assert len(whole) > 5
    assert len(found) == len(whole) * len(mosts)
    for number, row in enumerate(found):
        assert row == whole[number % len(whole)], f"packet {number % len(whole) + 1} of cut {number // len(whole) + 1}"
