# SPDX-License-Identifier: GPL-2.0-or-later
"""The page shows what tshark shows with the same script: rows and trees of all captures."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from make import Scenario, scenarios
from parity import SCRIPT
from sistap.wireshark.tshark import Tshark

PROFILE = SCRIPT.parents[1] / "capture" / "sistap" / "profile" / "SIS" / "preferences"
OURS = ("sertap", "sis", "3964r", "rk512i", "arcnet7f", "synaxpk", "synaxpd", "synaxobj", "synaxpcp")
TABLE = "uat:"  # a table that the user edits, which Lua cannot have
# A script knows section and interface from fields, and the first of two passes has none without a read filter.
TWO_PASSES = ("-2", "-R", "frame")
# wiregasm is another version of Wireshark, which has other words for TCP, for what it cuts, and for bytes that are no
# text.
OF_TCP = re.compile(r" \[TCP (PDU reassembled in \d+|segment of a reassembled PDU)\]$")
CUT = re.compile(r" \[(…|truncated)\]")
OCTAL = re.compile(r"\\([0-7]{3})")
MOST = 60  # characters that every version shows of long data

Node = Callable[..., Any]
Tree = tuple[str, int, int, list[Any]]  # text, first byte, count, what is below


def groups() -> list[tuple[tuple[str, ...], list[Path]]]:
    """Return options of tshark, and the captures that are read with them."""
    found = defaultdict(list)
    for path in scenarios():
        given = Scenario(path).options
        pairs = [pair for pair in zip(given[::2], given[1::2], strict=True) if not pair[1].startswith(TABLE)]
        if not any("udp.port" in value for _, value in pairs):  # Decode As, which the page has for RTAC alone
            found[tuple(word for pair in pairs for word in pair)].append(path.with_suffix(".pcapng"))
    return list(found.items())


def column_format() -> str:
    """Return the columns of the profile as a preference."""
    text = PROFILE.read_text()
    return "gui.column.format:" + text[text.index("gui.column.format:") :].partition(":")[2].replace("\n\t", "").strip()


def rows(script: Tshark, capture: Path, options: Sequence[str]) -> list[list[str]]:
    """Return the packet list as tshark prints it, the time left out: its precision is the profile's."""
    titles = re.findall(r'"([^"]*)", ?"', column_format())
    arguments = ["-T", "fields", *(word for title in titles for word in ("-e", f"_ws.col.{title}"))]
    printed = script.output("-r", str(capture), *TWO_PASSES, *options, "-o", column_format(), *arguments)
    return [without_time(line.split("\t")) for line in printed.splitlines()]


def without_time(cells: list[str]) -> list[str]:
    return [OF_TCP.sub("", cell) for place, cell in enumerate(cells) if place != 1]


def trees(script: Tshark, capture: Path, options: Sequence[str]) -> Iterator[list[Tree]]:
    """Yield the layers of ours of each packet."""
    printed = script.output("-r", str(capture), *TWO_PASSES, *options, "-T", "pdml")
    for packet in ElementTree.fromstring(printed).iterfind("packet"):
        yield [branch(layer) for layer in packet if layer.get("name") in OURS]


def branch(element: ElementTree.Element) -> Tree:
    below = [branch(one) for one in element if one.get("hide") != "yes"]
    size = int(element.get("size") or 0)
    return plain(element.get("showname") or element.get("show") or ""), int(element.get("pos") or 0), size, below


def plain(text: str) -> str:
    text = OCTAL.sub(lambda found: f"\\x{int(found[1], 8):02x}", CUT.sub("", text))
    return text[:MOST] if len(text) > MOST else text


def of_page(item: dict[str, Any], theirs: Tree) -> Tree:
    """Return an item as PDML has it: without bytes, and in bytes that were put together, it has another place."""
    at = item["start"] if item["length"] and not item["source"] else theirs[1]
    below = zip_longest(item["tree"], theirs[3], fillvalue=NOTHING)
    return plain(item["label"]), at, item["length"], [of_page(one, other) for one, other in below if one is not NOTHING]


NOTHING: Any = ("", 0, 0, [])


@pytest.mark.thorough
@pytest.mark.timeout(900)
@pytest.mark.parametrize(("options", "captures"), groups(), ids=lambda value: " ".join(map(str, value))[:40] or "none")
def test_rows_and_trees(
    options: tuple[str, ...], captures: list[Path], script: Tshark, node: Callable[..., Any]
) -> None:
    """`-d rtacser.data,sis` is usual in the page."""
    preferences = [word.partition(":") for word in options[1::2] if ":" in word]
    found = node(
        "dissect.mjs", *(word for name, _, value in preferences for word in ("--prefer", name, value)), *captures
    )
    for capture in captures:
        shown = found[str(capture)]
        assert [without_time(cells) for cells in shown["columns"]] == rows(script, capture, options), capture.name
        expected = list(trees(script, capture, options))
        assert len(shown["trees"]) == len(expected)
        for number, (layers, theirs) in enumerate(zip(shown["trees"], expected, strict=True), 1):
            ours = [layer for layer in layers if layer["filter"] in OURS]
            pairs = zip_longest(ours, theirs, fillvalue=NOTHING)
            assert [of_page(*pair) for pair in pairs] == theirs, f"{capture.name}, packet {number}"
