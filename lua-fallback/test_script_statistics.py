# SPDX-License-Identifier: GPL-2.0-or-later
"""The statistics that sis.lua prints have the figures of the plugin."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import pytest

from make import Scenario, scenarios
from merging import Group, groups
from sistap.wireshark.tshark import Tshark
from test_packed import COMMAND, NOISE, REACTION, written
from test_parity import options

ROW = re.compile(r"^ *(All|\d+) +(\|.*\|)$", re.MULTILINE)
COUNT = re.compile(r"^( *)(\S.*?) {2,}(\d+)(?: |$)", re.MULTILINE)
PARAMETER = re.compile(r"^(?:All|\d+) +\|.*\|$", re.MULTILINE)
TIMES = re.compile(r"^ +(\d+) +(\S.*?) +(\d+) +([\d.]+) +([\d.]+) +([\d.]+)", re.MULTILINE)

CAPTURE = Path(__file__).parent.parent / "test-captures" / "statistics.pcapng"

# How to read each of the statistics from the output.
READERS = {"tree": COUNT, "tza": ROW, "bus": ROW, "srt": TIMES, "parameters": PARAMETER}


def figures(kind: str, text: str) -> list[tuple[str, ...]]:
    """Return the rows of a table, in a common order; the plugin's tree has empty branches."""
    rows = sorted(READERS[kind].findall(text))
    return [row for row in rows if kind != "tree" or row[-1] != "0"]


def check(
    plugin: Tshark, script: Tshark, capture: Path, *given: str, kinds: Iterable[str] = READERS
) -> dict[str, list[tuple[str, ...]]]:
    """Compare the figures of both for a capture; return them."""
    reading = ("-q", "-r", str(capture), *given)
    counted = {}
    for kind in kinds:
        counted[kind] = figures(kind, plugin.output("-z", f"sis,{kind}", *reading))
        assert figures(kind, script.output("-o", f"sis.statistics:{kind}", *reading)) == counted[kind], kind
    return counted


@pytest.mark.thorough
def test_a_capture(plugin: Tshark, script: Tshark) -> None:
    counted = check(plugin, script, CAPTURE)
    assert all(counted.values()), "there is nothing to compare"


def test_bytes_after_a_telegram(plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """They are characters of the line, and of no station."""
    capture = written(tmp_path, COMMAND + NOISE, REACTION + NOISE)
    assert len(check(plugin, script, capture, kinds=["bus"])["bus"]) == 3


@pytest.mark.thorough
def test_accesses_to_parameters(plugin: Tshark, script: Tshark) -> None:
    """In the list of parameters, and as JSON."""
    capture = CAPTURE.with_name("accesses.pcapng")
    assert len(check(plugin, script, capture)["parameters"]) == 7
    asked = ("-r", str(capture), "-T", "fields", "-e", "frame.number", "-e", "sis.access", "-Y", "sis.access")
    assert plugin.output(*asked) == script.output(*asked) != ""


@pytest.mark.thorough
@pytest.mark.parametrize("path", scenarios(), ids=lambda path: path.stem)
def test_each_capture(path: Path, plugin: Tshark, script: Tshark) -> None:
    check(plugin, script, path.with_suffix(".pcapng"), *options(Scenario(path).options, ()))


@pytest.mark.thorough
@pytest.mark.parametrize("passes", [(), ("-2",)], ids=["one_pass", "two_passes"])
def test_all_captures_together(passes: tuple[str, ...], plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    group: Group = groups()[0]
    capture = tmp_path / "merged.pcapng"
    group.write(capture)
    check(plugin, script, capture, *options(group.options, passes))


def test_an_unknown_name_is_told(script: Tshark) -> None:
    said = script.output("-q", "-o", "sis.statistics:tre", "-r", str(CAPTURE))
    assert "'tre' is none of tree, tza, bus, srt, parameters" in said
