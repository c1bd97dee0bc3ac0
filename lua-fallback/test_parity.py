# SPDX-License-Identifier: GPL-2.0-or-later
"""sis.lua has the same output as the C plugin: for every capture, in one pass and in two, and for every field."""

from __future__ import annotations

import random
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from description import Description

import bad_input
import parity
from bad_input import Packet
from make import CLIENT_PORT, HERE, Scenario, scenarios
from merging import Group, groups
from rings import as_sections, records_of, ring
from sistap.dissected.wireshark.tshark import Tshark

every_scenario = pytest.mark.parametrize("path", scenarios(), ids=lambda path: path.stem)


EXPERTS = {item.filter for item in Description().experts}
HEADERS = 40  # of IP and TCP
TABLE = "uat:"  # a table that the user edits, which Lua cannot have
PLAIN, WITH_OPTIONS, OVER_TCP = groups()
PASSES = pytest.mark.parametrize("passes", [(), ("-2",)], ids=["one_pass", "two_passes"])


def options(given: Sequence[str], passes: tuple[str, ...]) -> list[str]:
    """Return the options that both understand, with two passes so that the first of them has fields.

    A script knows section and interface from fields, and the first of two passes has none, unless a read filter needs
    them.
    """
    understood = [word for word in zip(given[::2], given[1::2], strict=True) if not word[1].startswith(TABLE)]
    reading = ("-R", "frame") if passes else ()
    return [*passes, *reading, *(word for pair in understood for word in pair)]


GATE = ((PLAIN, ()), (WITH_OPTIONS, ("-2",)), (OVER_TCP, ()))  # every capture, with and without options, both passes
groups_and_passes = pytest.mark.parametrize(
    ("group", "passes"),
    [
        pytest.param(group, passes, marks=() if (group, passes) in GATE else pytest.mark.thorough)
        for group in groups()
        for passes in ((), ("-2",))
    ],
    ids=lambda value: value.name if isinstance(value, Group) else "two_passes" if value else "one_pass",
)


@groups_and_passes
def test_every_item(group: Group, passes: tuple[str, ...], plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """The whole trees, and the packet list alone, for which most of the work is left out."""
    capture = tmp_path / "merged.pcapng"
    group.write(capture)
    parity.check(plugin, script, capture, *options(group.options, passes), whose=group.whose)


def test_a_file_of_a_ring(plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """It begins with what was told before."""
    files = [
        file
        for name in ("accesses", "timing-limits")
        for file in ring(records_of(HERE / f"{name}.pcapng"), tmp_path / name, 30)
    ]
    parity.check(plugin, script, as_sections(files, tmp_path / "ring.pcapng"))


@pytest.mark.thorough
@every_scenario
@PASSES
def test_every_item_of_each_alone(path: Path, passes: tuple[str, ...], plugin: Tshark, script: Tshark) -> None:
    parity.check(plugin, script, path.with_suffix(".pcapng"), *options(Scenario(path).options, passes))


def cut_segments(source: random.Random) -> Iterator[Packet]:
    """Yield the segments of all captures over TCP several times, some cut by the capture."""
    scenarios = [(number, Scenario(path)) for number, path in enumerate(OVER_TCP.paths * 4)]
    for number, scenario in scenarios:
        for item in scenario.items:
            data = (item.raw or b"").replace(CLIENT_PORT.to_bytes(2), (CLIENT_PORT + number).to_bytes(2))
            yield Packet(data[: source.randrange(HEADERS, len(data)) if source.random() < 0.5 else None], len(data))


def test_segments_that_the_capture_has_cut(plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    packets = list(cut_segments(random.Random(1)))
    bad_input.write(tmp_path / "cut.pcapng", packets, "ip")
    parity.check(plugin, script, tmp_path / "cut.pcapng", *OVER_TCP.options, "-d", "tcp.port==4200,sis")


@pytest.mark.parametrize("counts_from", ["end", "start"])
def test_where_tza_begins_to_count(counts_from: str, plugin: Tshark, script: Tshark) -> None:
    limits = ("-o", "sis.tza_ms:5", "-o", "sis.trs_ms:50", "-o", f"sis.tza_from:{counts_from}")
    parity.check(plugin, script, HERE / "timing-readings.pcapng", *limits)


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["timing-reads", "3964r"])
def test_without_limits(name: str, plugin: Tshark, script: Tshark) -> None:
    """A limit of 0 is none."""
    limits = ("-o", "sis.tza_ms:0", "-o", "3964r.zvz_ms:0", "-o", "3964r.qvz_ms:0")
    parity.check(plugin, script, HERE / f"{name}.pcapng", *limits)


@pytest.mark.thorough
@pytest.mark.parametrize("group", groups(), ids=lambda group: group.name)
def test_text(group: Group, plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """The text output: generated items are in brackets here."""
    capture = tmp_path / "merged.pcapng"
    group.write(capture)
    layers = "sis,sisascii,sertap,3964r,rk512i,arcnet7f,synaxpk,synaxobj,synaxpcp,synaxpd"
    shown = ("-r", str(capture), *options(group.options, ()), "-V", "-O", layers)
    expected, found = (
        re.split(r"^(?=Frame \d+:)", tshark.output(*shown), flags=re.MULTILINE) for tshark in (plugin, script)
    )
    words = parity.difference(expected[1:], found[1:], whose=group.whose)
    assert not words, words


@pytest.mark.thorough
@every_scenario
def test_expected_text(path: Path, script: Tshark) -> None:
    """Exactly the expected text of the plugin."""
    scenario = Scenario(path)
    if any(TABLE in word for word in scenario.options):
        pytest.skip("Lua cannot have a table of the user's")
    assert scenario.dissection(script, path.with_suffix(".pcapng")) == path.with_suffix(".expected").read_text()


def test_the_bytes_of_a_telegram_have_a_source_of_their_own(plugin: Tshark, script: Tshark) -> None:
    """Figure 6-14, sets 9600 Bd: the hexadecimal dump begins with the start character, not with the tap's record."""
    for tshark in (plugin, script):
        shown = tshark.output("-r", str(HERE / "specification.pcapng"), "-Vx", "-Y", "frame.number == 7")
        (dump,) = re.findall(r"^Characters \((\d+) bytes\):\n0000  ([0-9a-f ]+?)   ", shown, re.MULTILINE)
        assert dump[1].startswith("02 ")
        assert len(bytes.fromhex(dump[1])) == int(dump[0])


# Unavoidable differences: C's way to declare a status of a checksum, Decode As of a table of ours, and from 4.2 on the
# name of a heuristic.
DIFFERENT = {
    "fields": {name: ("BASE_NONE", "BASE_DEC") for name in ("sis.checksum.status", "3964r.bcc.status")},
    "heuristic-decodes": {
        "sis": ("SIS over (TCP|UDP)", "SIS"),
        "sisascii": ("SIS ASCII over TCP", "SISASCII"),
    },
    "dissector-tables": {"sertap.framing": ("Decode As supported", "Decode As not supported")},
}
OURS = re.compile(r"(^|\t)(sis|sisascii|sertap|synax\w*|3964r|rk512i|arcnet7f)([.\t]|$)")
NAMED = ("sis", "sertap", "synax", "3964r", "rk512i", "arcnet7f")  # quicker to search for


def is_ours(line: str) -> bool:
    """Check a million lines: the expression alone takes seconds."""
    return any(word in line for word in NAMED) and OURS.search(line) is not None


def without_meaning(line: str) -> str:
    """Return a line without the description of an expert item: a script cannot give it one."""
    *columns, meaning = line.split("\t")
    return "\t".join([*columns, "" if EXPERTS.intersection(columns) else meaning])


@pytest.mark.parametrize(
    "report",
    [
        "fields",
        *(
            pytest.param(report, marks=pytest.mark.thorough)
            for report in ("values", "protocols", "decodes", "heuristic-decodes", "dissector-tables")
        ),
    ],
)
def test_registered(report: str, plugin: Tshark, script: Tshark) -> None:
    """Every field with its type, base and description, every value with its text, and the sources of packets."""
    expected, found = (
        Counter(line for line in tshark.output("-G", report).splitlines() if is_ours(line))
        for tshark in (plugin, script)
    )
    assert expected
    expected = Counter(map(without_meaning, expected.elements()))
    for name, (in_c, in_lua) in DIFFERENT.get(report, {}).items():
        lines = [line for line in expected if name in line.split("\t")]
        assert lines
        expected -= Counter(lines)
        expected += Counter(re.sub(in_c, in_lua, line) for line in lines)
    assert sorted((expected - found).elements()) == []
    assert sorted((found - expected).elements()) == []


def test_preferences(plugin: Tshark, script: Tshark) -> None:
    """Names, defaults and descriptions, as in a file of preferences; only the script has two for what is printed."""
    ours = re.compile(r"^#(sis|synax\w*|3964r)[.]", re.MULTILINE)
    script_only = re.compile(r"^#sis[.](fields|statistics):", re.MULTILINE)
    expected, found = (
        [entry for entry in tshark.output("-G", "currentprefs").split("\n\n") if ours.search(entry)]
        for tshark in (plugin, script)
    )
    assert expected
    assert [entry for entry in found if not script_only.search(entry)] == expected
