# SPDX-License-Identifier: GPL-2.0-or-later
"""The page shows what tshark shows with the same script: rows and trees of all captures and lessons."""

from __future__ import annotations

import json
import re
from base64 import b64encode
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from chromium import Chromium
from make import Scenario, scenarios
from pages import content
from parity import SCRIPT
from sistap.wireshark.tshark import Tshark

PROFILE = SCRIPT.parents[1] / "capture" / "sistap" / "profile" / "SIS" / "preferences"
PLAYED = SCRIPT.parents[1] / "build" / "course"  # captures of lessons that the virtual bus plays
OURS = ("sertap", "sis", "sisascii", "3964r", "rk512i", "arcnet7f", "synaxpk", "synaxpd", "synaxobj", "synaxpcp")
TREES = 500  # of a capture; only lessons 19 and 20 have more packets
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


def played() -> list[Path]:
    """Return the captures of lessons that have no text from which they are made."""
    return [content.capture(one, PLAYED) for one in content.lessons() if not one.path.with_suffix(".txt").exists()]


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


def trees(script: Tshark, capture: Path, options: Sequence[str], step: int) -> Iterator[list[Tree]]:
    """Yield the layers of ours of one packet in so many."""
    some = ("-Y", f"frame.number % {step} == 0") if step > 1 else ()
    printed = script.output("-r", str(capture), *TWO_PASSES, *some, *options, "-T", "pdml")
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


def preferences(options: Sequence[str]) -> dict[str, str]:
    """`-d rtacser.data,sis` is usual in the page."""
    return dict(word.split(":", 1) for word in options[1::2] if ":" in word)


def in_node(node: Callable[..., Any], options: Sequence[str], captures: Sequence[Path]) -> dict[str, Any]:
    """Return what the page shows of captures."""
    preferred = [word for pair in preferences(options).items() for word in ("--prefer", *pair)]
    found: dict[str, Any] = node("dissect.mjs", str(TREES), *preferred, *captures)
    return found


def compare(shown: dict[str, Any], script: Tshark, capture: Path, options: Sequence[str]) -> None:
    """Compare what the page shows of a capture with what tshark prints."""
    assert [without_time(cells) for cells in shown["columns"]] == rows(script, capture, options), capture.name
    expected = list(trees(script, capture, options, shown["step"]))
    assert len(shown["trees"]) == len(expected)
    for number, (layers, theirs) in enumerate(zip(shown["trees"], expected, strict=True), 1):
        ours = [layer for layer in layers if layer["filter"] in OURS]
        pairs = zip_longest(ours, theirs, fillvalue=NOTHING)
        assert [of_page(*pair) for pair in pairs] == theirs, f"{capture.name}, packet {number * shown['step']}"


pytestmark = [pytest.mark.thorough, pytest.mark.timeout(900)]


@pytest.mark.parametrize(("options", "captures"), groups(), ids=lambda value: " ".join(map(str, value))[:40] or "none")
def test_rows_and_trees(
    options: tuple[str, ...], captures: list[Path], script: Tshark, node: Callable[..., Any]
) -> None:
    found = in_node(node, options, captures)
    for capture in captures:
        compare(found[str(capture)], script, capture, options)


def test_lessons_that_are_played(script: Tshark, node: Callable[..., Any]) -> None:
    captures = played()
    assert len(captures) >= 3
    for capture in captures:
        compare(in_node(node, (), [capture])[str(capture)], script, capture, ())


def test_chromium_shows_what_node_shows(chromium: Chromium, node: Callable[..., Any]) -> None:
    """So chromium shows what tshark shows, too."""
    chromium.run((SCRIPT.parent / "page" / "test" / "dissecting.js").read_text())
    for options, captures in [*groups(), ((), played()[:1])]:
        found = in_node(node, options, captures)
        chromium.run(f"startDissecting({json.dumps(preferences(options))}).then(() => 0)")
        for capture in captures:
            data = b64encode(capture.read_bytes()).decode()
            shown = json.loads(chromium.run(f"dissected('{data}', {TREES})"))
            assert shown == found[str(capture)], capture.name
