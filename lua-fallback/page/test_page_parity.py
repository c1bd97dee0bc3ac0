# SPDX-License-Identifier: GPL-2.0-or-later
"""The page shows what tshark shows with the same script: rows and trees of all captures and lessons."""

from __future__ import annotations

import json
import re
import tempfile
from base64 import b64encode
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import pytest

from chromium import Chromium
from make import Scenario, scenarios
from pages import content
from parity import SCRIPT
from sistap.dissected.wireshark.tshark import Tshark

PROFILE = SCRIPT.parents[1] / "capture" / "sistap" / "profile" / "SIS" / "preferences"
PLAYED = SCRIPT.parents[1] / "build" / "course"  # captures of lessons that the virtual bus plays
OURS = ("sertap", "sis", "sisascii", "3964r", "rk512i", "arcnet7f", "synaxpk", "synaxpd", "synaxobj", "synaxpcp")
TREES = 500  # of a capture; only lessons 13 and 14 have more packets
# Tables that a user edits, which Lua cannot have. Of this one sis.lua reads the file, as the plugin does.
TABLE = "uat:sis_parameters:"
OF_LINK_TYPES = "uat:user_dlts:"  # Wireshark's own: it reads the file itself
# The other one has no effect with sis.lua, in tshark or in the page: its file is not read (README.md of lua-fallback).
OF_PLUGIN = "uat:synax_process_data:"
# Decode As, in wiregasm and Wireshark a file of the profile; the page's own line of it.
DECODE_AS = re.compile(r"([\w.]+)==(\d+),(\w+)")
OF_PAGE = "decode_as_entry: rtacser.data,0,(none),SIS\n"
# wiregasm reads it before the preferences, which give a port of AFS (RX) back to AFS. So the other port of the datagram
# is decoded.
OTHER_PORT = {"7003": "50000"}
# A script knows section and interface from fields, and the first of two passes has none without a read filter.
TWO_PASSES = ("-2", "-R", "frame")
# wiregasm is another version of Wireshark, which has other words for TCP, for what it cuts, and for bytes that are no
# text.
OF_TCP = re.compile(r" \[TCP (PDU reassembled in \d+|segment of a reassembled PDU)\]$")
CUT = re.compile(r" \[(…|truncated)\]")
OCTAL = re.compile(r"\\([0-7]{3})")
MOST = 60  # characters that every version shows of long data

Node = Callable[..., Any]
Printed = Callable[..., str]
Tree = tuple[str, int, int, list[Any]]  # text, first byte, count, what is below


def played() -> list[Path]:
    """Return the captures of lessons that have no text from which they are made."""
    return [content.capture(one, PLAYED) for one in content.lessons() if not one.path.with_suffix(".txt").exists()]


class Settings(NamedTuple):
    """How captures are read: pairs of an option of tshark and its value."""

    pairs: tuple[tuple[str, str], ...] = ()

    @property
    def options(self) -> list[str]:
        """Those of tshark. Its table is a file."""
        return [word for pair in self.pairs if not pair[1].startswith(TABLE) for word in pair]

    @property
    def preferences(self) -> dict[str, str]:
        """Those of the page. Its tables are files, too."""
        return dict(value.split(":", 1) for name, value in self.pairs if name == "-o" and not value.startswith("uat:"))

    def table(self, beginning: str) -> str:
        return "".join(f"{value.removeprefix(beginning)}\n" for _, value in self.pairs if value.startswith(beginning))

    @property
    def files(self) -> dict[str, str]:
        """Files of the page's profile; `-d rtacser.data,sis` is usual in the page."""
        entries = [DECODE_AS.fullmatch(value) for name, value in self.pairs if name == "-d"]
        more = "".join(
            f"decode_as_entry: {one[1]},{OTHER_PORT.get(one[2], one[2])},(none),{one[3].upper()}\n"
            for one in entries
            if one
        )
        named = {
            "sis_parameters": self.table(TABLE),
            "user_dlts": self.table(OF_LINK_TYPES),
            "decode_as_entries": more and OF_PAGE + more,
        }
        return {name: text for name, text in named.items() if text}


def groups() -> list[tuple[Settings, list[Path]]]:
    """Return settings, and the captures that are read with them."""
    found = defaultdict(list)
    for path in scenarios():
        given = Scenario(path).options
        pairs = (pair for pair in zip(given[::2], given[1::2], strict=True) if not pair[1].startswith(OF_PLUGIN))
        found[Settings(tuple(pairs))].append(path.with_suffix(".pcapng"))
    return list(found.items())


@pytest.fixture
def printed(script: Tshark) -> Iterator[Printed]:
    """Return what tshark prints of a capture that is read with some settings."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o755)  # tshark may be run by nobody

        def run(settings: Settings, capture: Path, *arguments: str) -> str:
            (folder / "sis_parameters").write_text(settings.table(TABLE))
            words = ["-r", str(capture), *TWO_PASSES, *settings.options, *arguments]
            done = script.run(words, extra_environment={"WIRESHARK_CONFIG_DIR": name})
            assert done.returncode == 0, done.stderr
            return done.stdout

        yield run


def column_format() -> str:
    """Return the columns of the profile as a preference."""
    text = PROFILE.read_text()
    return "gui.column.format:" + text[text.index("gui.column.format:") :].partition(":")[2].replace("\n\t", "").strip()


def rows(printed: Printed, settings: Settings, capture: Path) -> list[list[str]]:
    """Return the packet list as tshark prints it, the time left out: its precision is the profile's."""
    titles = re.findall(r'"([^"]*)", ?"', column_format())
    arguments = ["-T", "fields", *(word for title in titles for word in ("-e", f"_ws.col.{title}"))]
    lines = printed(settings, capture, "-o", column_format(), *arguments).splitlines()
    return [without_time(line.split("\t")) for line in lines]


def without_time(cells: list[str]) -> list[str]:
    return [OF_TCP.sub("", cell) for place, cell in enumerate(cells) if place != 1]


def trees(printed: Printed, settings: Settings, capture: Path, step: int) -> Iterator[list[Tree]]:
    """Yield the layers of ours of one packet in so many."""
    some = ("-Y", f"frame.number % {step} == 0") if step > 1 else ()
    for packet in ElementTree.fromstring(printed(settings, capture, *some, "-T", "pdml")).iterfind("packet"):
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


def in_node(node: Node, settings: Settings, captures: Sequence[Path]) -> dict[str, Any]:
    """Return what the page shows of captures."""
    said = json.dumps(settings.preferences), json.dumps(settings.files)
    found: dict[str, Any] = node("dissect.mjs", str(TREES), *said, *captures)
    return found


def compare(shown: dict[str, Any], printed: Printed, settings: Settings, capture: Path) -> None:
    """Compare what the page shows of a capture with what tshark prints."""
    assert [without_time(cells) for cells in shown["columns"]] == rows(printed, settings, capture), capture.name
    expected = list(trees(printed, settings, capture, shown["step"]))
    assert len(shown["trees"]) == len(expected)
    for number, (layers, theirs) in enumerate(zip(shown["trees"], expected, strict=True), 1):
        ours = [layer for layer in layers if layer["filter"] in OURS]
        pairs = zip_longest(ours, theirs, fillvalue=NOTHING)
        assert [of_page(*pair) for pair in pairs] == theirs, f"{capture.name}, packet {number * shown['step']}"


pytestmark = [pytest.mark.thorough, pytest.mark.timeout(900)]


def name_of(value: object) -> str:
    words = " ".join(map(" ".join, value.pairs)) if isinstance(value, Settings) else "captures"
    return words[:40] or "none"


@pytest.mark.parametrize(("settings", "captures"), groups(), ids=name_of)
def test_rows_and_trees(settings: Settings, captures: list[Path], printed: Printed, node: Node) -> None:
    found = in_node(node, settings, captures)
    for capture in captures:
        compare(found[str(capture)], printed, settings, capture)


def test_no_scenario_is_left_out() -> None:
    """Also those with a table, and those of UDP."""
    assert {path.stem for _, captures in groups() for path in captures} == {path.stem for path in scenarios()}
    (table,) = (settings.files["sis_parameters"] for settings, _ in groups() if settings.table(TABLE))
    assert '"S","0047","Table position","mm","04220001"' in table.splitlines()


def test_lessons_that_are_played(printed: Printed, node: Node) -> None:
    captures = played()
    assert len(captures) >= 3
    for capture in captures:
        compare(in_node(node, Settings(), [capture])[str(capture)], printed, Settings(), capture)


def test_chromium_shows_what_node_shows(chromium: Chromium, node: Node) -> None:
    """So chromium shows what tshark shows, too."""
    chromium.run((SCRIPT.parent / "page" / "test" / "dissecting.js").read_text())
    for settings, captures in [*groups(), (Settings(), played()[:1])]:
        found = in_node(node, settings, captures)
        said = f"{json.dumps(settings.preferences)}, {json.dumps(settings.files)}"
        chromium.run(f"startDissecting({said}).then(() => 0)")
        for capture in captures:
            data = b64encode(capture.read_bytes()).decode()
            shown = json.loads(chromium.run(f"dissected('{data}', {TREES})"))
            assert shown == found[str(capture)], capture.name
