# SPDX-License-Identifier: GPL-2.0-or-later
"""The statistics that sis.lua prints have the figures of the plugin."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from make import Scenario, scenarios
from merging import Group
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.sis.telegram import build
from test_packed import COMMAND, NOISE, REACTION, written
from test_parity import groups_and_passes, options

COUNT = re.compile(r"^( *)(\S.*?) {2,}(\d+)(?: |$)", re.MULTILINE)
TIMES = re.compile(r"^ +(\d+) +(\S.*?) +(\d+) +([\d.]+) +([\d.]+) +([\d.]+)", re.MULTILINE)

CAPTURE = Path(__file__).parent.parent / "test-captures" / "statistics.pcapng"

# The titles of the statistics in the output, and how to read what is below.
READERS = {
    "tree": ("telegrams", COUNT),
    "srt": ("SRT Statistics|reaction times by service", TIMES),
}
TITLE = "^(?:SIS / )?SIS (?:{}):$"  # from 4.4 on, tshark also writes the submenu

Figures = dict[str, list[tuple[str, ...]]]  # by kind


def figures(text: str) -> Figures:
    """Return the rows of each table, in a common order; the plugin's tree has empty branches."""
    found = {}
    for kind, (title, row) in READERS.items():
        (_, after) = re.split(TITLE.format(title), text, flags=re.MULTILINE)
        table = re.split(TITLE.format(".*"), after, maxsplit=1, flags=re.MULTILINE)[0]
        found[kind] = sorted(cells for cells in row.findall(table) if kind != "tree" or cells[-1] != "0")
    return found


def check(plugin: Tshark, script: Tshark, capture: Path, *given: str) -> Figures:
    """Compare the figures of both for a capture; return them."""
    reading = ("-q", "-r", str(capture), *given)
    asked = [word for kind in READERS for word in ("-z", f"sis,{kind}")]
    counted = figures(plugin.output(*asked, *reading))
    assert figures(script.output("-o", f"sis.statistics:{','.join(READERS)}", *reading)) == counted
    return counted


def test_a_capture(plugin: Tshark, script: Tshark) -> None:
    counted = check(plugin, script, CAPTURE)
    assert all(counted.values()), "there is nothing to compare"


def test_bytes_after_a_telegram(plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    capture = written(tmp_path, COMMAND + NOISE, REACTION + NOISE)
    assert check(plugin, script, capture)["tree"]


@pytest.mark.thorough
def test_accesses_to_parameters(plugin: Tshark, script: Tshark) -> None:
    capture = CAPTURE.with_name("accesses.pcapng")
    asked = ("-r", str(capture), "-T", "fields", "-e", "frame.number", "-e", "sis.access", "-Y", "sis.access")
    assert plugin.output(*asked) == script.output(*asked) != ""


def test_names_of_a_drive_as_json(plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """All characters that a name can have, the name of P-0-0001 of station 3 (chapter 6); then its value is read."""
    telegrams = []
    for control, data in ((0x14, bytes(range(128))), (0x24, bytes(range(128, 240))), (0x3C, b"\5\0")):
        telegrams.append(build(0x10, 16, 3, bytes([control, 3, 0, 1, 0x80])))
        telegrams.append(build(0x10, 16, 3, bytes([0, control, 3]) + data, reaction=True))
    capture = written(tmp_path, *telegrams)
    asked = ("-r", str(capture), "-T", "fields", "-e", "sis.access", "-Y", "sis.access")
    text = plugin.output(*asked)
    assert script.output(*asked) == text
    text = text.replace("\\\\", "\\")  # since 4.2, tshark doubles each in the fields that it prints
    assert text.isascii() and "\\\\" not in text
    said = json.loads(text)
    pictures = "".join(chr(0x2400 + code) for code in range(32))
    assert said["name"] == pictures + bytes(range(32, 127)).decode() + "\u2421"
    assert said["unit"].endswith(
        "\xa0" + bytes(range(0xA1, 0xAD)).decode("latin-1") + "<ad>" + "".join(map(chr, range(0xAE, 240)))
    )


@pytest.mark.thorough
@pytest.mark.parametrize("path", scenarios(), ids=lambda path: path.stem)
def test_each_capture(path: Path, plugin: Tshark, script: Tshark) -> None:
    check(plugin, script, path.with_suffix(".pcapng"), *options(Scenario(path).options, ()))


@groups_and_passes
def test_all_captures_together(
    group: Group, passes: tuple[str, ...], plugin: Tshark, script: Tshark, tmp_path: Path
) -> None:
    capture = tmp_path / "merged.pcapng"
    group.write(capture)
    counted = check(plugin, script, capture, *options(group.options, passes))
    assert all(counted.values()) or group.name == "tcp", "there is nothing to compare"


def test_an_unknown_name_is_told(script: Tshark) -> None:
    said = script.output("-q", "-o", "sis.statistics:tre", "-r", str(CAPTURE))
    assert "'tre' is none of tree, srt" in said
