# SPDX-License-Identifier: GPL-2.0-or-later
"""A capture shows the same when it is read in portions, wherever it is cut, and beside another tap."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from itertools import accumulate, chain, pairwise
from pathlib import Path

import pytest

from make import HERE, Scenario
from merging import groups
from rings import FIELDS, records_of, ring
from sistap import cli
from sistap.dissected.captures import joining, portions, reading
from sistap.dissected.captures.portions import Portion, in_turn
from sistap.dissected.episodes.engine import Engine
from sistap.dissected.packets.dissection import Dissection
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.terminal.exits import NotCaptured

# Commands, reactions, refusals, repeats, damage, long data, names and units, limits and rates, routes, two directions.
CAPTURES = (
    *("course/02-status-and-errors", "course/03-parameters", "course/04-bad-line", "course/05-new-times-and-rate"),
    *("course/09-long-data", "lists-anew", "routes", "repeats", "duplex"),
)
SHOWN = (*FIELDS, "sis.command.unanswered", "sis.sequence.ended", "sis.silence_before", "_ws.expert.message")
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


@pytest.mark.parametrize("blocks", [6, 8, 12])
def test_each_file_of_a_ring_tells_what_happened_in_it(blocks: int, tshark: Tshark, tmp_path: Path) -> None:
    """Writes, refusals and phases; a phase that is the first in a file is no start of the machine."""
    capture = tmp_path / "phases.pcapng"
    assert cli.main(["bus", "phase-switch", "-w", str(capture)]) == 0
    whole, *alone = (told(tshark, file) for file in (capture, *ring(records_of(capture), tmp_path / "ring", blocks)))
    assert {kind for kind, _ in whole} == {"write", "error", "phase"}
    assert set(chain.from_iterable(alone)) == set(whole)


def told(tshark: Tshark, capture: Path) -> list[tuple[str, str]]:
    """Return what is told of a capture: kinds and parameters."""
    engine = Engine()
    with Dissection(tshark, [Portion(capture)]) as dissection:
        for packet in dissection.packets():
            engine.add(packet)
    return [(one.kind, one.hit.parameter) for one in engine.finish()]


def is_in_order(capture: Path) -> bool:
    """Tell whether it is of one line, and each packet is later than the one before."""
    try:
        records = [*reading.records(capture)]
    except NotCaptured:  # a record of a later version
        return False
    return {one.line for one in records} == {0} and all(one.time_ns < after.time_ns for one, after in pairwise(records))


def test_a_tap_shows_the_same_beside_another_one(tshark: Tshark, tmp_path: Path) -> None:
    """Both hear the same at the same times, so every packet is between two of the other tap."""
    alone, both, two = (tmp_path / name for name in ("alone.pcapng", "both.pcapng", "two.pcapng"))
    with alone.open("wb") as one_by_one, both.open("wb") as beside:
        for capture in (text.with_suffix(".pcapng") for text in groups()[0].paths):
            if Scenario(capture.with_suffix(".txt")).link == "sertap" and is_in_order(capture):
                subprocess.run(["mergecap", "-I", "none", "-w", two, capture, capture], check=True)
                one_by_one.write(capture.read_bytes())
                beside.write(two.read_bytes())
    expected, found = [*shown(tshark, alone)], [*shown(tshark, both)]
    assert len(expected) > 1000
    assert found[::2] == expected
    assert found[1::2] == expected
