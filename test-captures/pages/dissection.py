# SPDX-License-Identifier: GPL-2.0-or-later
"""What Wireshark says about the packets of a lesson, and which packets display filters leave, for the page's script."""

from __future__ import annotations

import re
import subprocess
import sys
from base64 import b64decode
from collections.abc import Iterable, Iterator
from csv import reader
from pathlib import Path
from typing import Any, NamedTuple

from sharkd import Sharkd, SharkdError

from lesson import Filter, Value, recording
from make import Scenario
from pages import markdown
from pages.questions import Lesson
from sistap.annotate import meanings

PROFILE = Path(meanings.__file__).parents[1] / "profile" / "SIS"

MOST = 300  # packets of a page; of a longer capture those that the lesson names, with those around them
AROUND = 3
MOST_FOR_FIELDS = 100  # packets of a capture whose every field is tried as a filter

USUAL = {"sis.edition": "IF02"}  # preferences that a lesson may change

_OUTER = ("frame", "exported_pdu")  # what is around the record: nothing of it was on the line
_TAP = "sertap"
_COLUMNS = (1, 2, 3, 6)  # of sharkd's: time, source, destination, information
_NAME = re.compile(r"[a-z0-9]\w*(?:\.\w+)*")
_TOLD_ALREADY = re.compile(r"sertap\.(interval|flags == 0x00)\b")  # a character's own line says it

# Label, first byte, how many, source of the bytes, filter, items below; in a field that names a packet, its number.
Tree = list[Any]


class Rule(NamedTuple):
    """A rule that colours packets."""

    name: str
    filter: str
    paper: str
    ink: str


def rules() -> list[Rule]:
    """Return the colour rules of Wireshark's profile; the first that holds is taken."""
    lines = (PROFILE / "colorfilters").read_text().splitlines()
    fields = [line.split("@") for line in lines if line.startswith("@")]
    return [Rule(name, rule, *map(_colour, colours[1:-1].split("]["))) for _, name, rule, colours in fields]


def _colour(parts: str) -> str:
    return "#" + "".join(f"{int(part) >> 8:02x}" for part in parts.split(","))


def buttons() -> list[tuple[str, str, str]]:
    """Return the filter buttons of the profile: word, filter, and what it is for."""
    lines = (PROFILE / "dfilter_buttons").read_text().splitlines()
    return [(row[1], row[2], row[3]) for row in reader(lines) if row[0] == "TRUE"]


def capture(lesson: Lesson, folder: Path) -> Path:
    """Return the capture of a lesson. One that is not beside it the virtual bus writes into the folder."""
    arguments = recording(lesson.path)
    if not arguments:
        return lesson.path.with_suffix(".pcapng")
    written = folder / f"{lesson.path.stem}.pcapng"
    arguments[arguments.index("-w") + 1] = str(written.resolve())
    written.unlink(missing_ok=True)
    command = [sys.executable, "-m", "sistap", *arguments]
    done = subprocess.run(command, cwd=PROFILE.parents[2], capture_output=True, text=True, check=False)
    if done.returncode:
        raise OSError(f"{lesson.path.name}: {done.stderr.strip()}")
    return written


def dissection(sharkd: Sharkd, lesson: Lesson, path: Path) -> dict[str, Any]:
    """Return packets, filters, buttons and how many packets the capture at the path has."""
    preferences = _preferences(lesson)
    for name, value in preferences.items():
        sharkd.prefer(name, value)
    try:
        return _dissection(sharkd, lesson, path)
    finally:
        for name in preferences:
            sharkd.prefer(name, USUAL[name])


def _preferences(lesson: Lesson) -> dict[str, str]:
    """Return what the lesson sets with options of Wireshark."""
    text = lesson.path.with_suffix(".txt")
    words = Scenario(text).options if text.exists() else []
    return dict(word.split(":", 1) for word in words if ":" in word)


def _dissection(sharkd: Sharkd, lesson: Lesson, path: Path) -> dict[str, Any]:
    rows = sharkd.rows(path)
    shown = chosen(lesson, len(rows))
    styles = _styles(sharkd, path)
    packets = [_packet(sharkd, path, row, styles) for row in rows if row["num"] in shown]
    filters = _filters(sharkd, lesson, path, packets if len(rows) <= MOST_FOR_FIELDS else [])
    return {"packets": packets, "filters": filters, "buttons": buttons(), "count": len(rows)}


def chosen(lesson: Lesson, count: int) -> set[int]:
    """Return which packets of a capture with so many are in the page: in a long one, those that the lesson names."""
    if count <= MOST:
        return set(range(1, count + 1))
    named = {claim.packet for claim in lesson.claims if isinstance(claim, Value)} | {1} | _linked(lesson)
    for claim in lesson.claims:
        if isinstance(claim, Filter):
            named.update(claim.packets[:20])
    return {near for packet in named for near in range(packet - AROUND, packet + AROUND + 1)}


def _linked(lesson: Lesson) -> set[int]:
    """Return the packets that its texts lead to."""
    said = [lesson.text, lesson.end]
    said += [words for question in lesson.questions for words in (question.lead, question.hint, question.answer)]
    return set().union(*map(markdown.packets, said))


def _styles(sharkd: Sharkd, path: Path) -> dict[int, int]:
    """Return which rule colours a packet."""
    found: dict[int, int] = {}
    for number, rule in enumerate(rules()):
        for packet in sharkd.frames(path, rule.filter):
            found.setdefault(packet, number)
    return found


def _packet(sharkd: Sharkd, path: Path, row: dict[str, Any], styles: dict[int, int]) -> dict[str, Any]:
    number = row["num"]
    said = sharkd.details(path, number)
    whole = b64decode(said["bytes"])
    layers = [layer for layer in said["tree"] if _field(layer) not in _OUTER]
    first, count = _on_the_line(layers, whole)
    time, sender, receiver, words = (row["c"][column] for column in _COLUMNS)
    tree = [*_interface(said["tree"]), *(_tree(layer, first, count) for layer in layers)]
    return {
        "number": number,
        "columns": [time, sender, receiver, words.removeprefix(f"{sender} -> {receiver} ").lstrip()],
        "style": styles.get(number, -1),
        "bytes": whole[first : first + count].hex(),
        "kinds": _kinds(tree, count),
        "others": [[other["name"], b64decode(other["bytes"]).hex()] for other in said.get("ds", [])],
        "tree": tree,
    }


def _interface(layers: list[dict[str, Any]]) -> list[Tree]:
    """Return the name of the interface: a capture may have several."""
    frame = [item for layer in layers if _field(layer) == "frame" for item in layer.get("n", [])]
    names = [below for item in frame for below in item.get("n", []) if _field(below) == "frame.interface_name"]
    return [[item["l"], 0, 0, 0, item["f"], []] for item in names]


def _field(item: dict[str, Any]) -> str:
    found = _NAME.match(item.get("f", ""))
    return found[0] if found else ""


def _on_the_line(layers: list[dict[str, Any]], whole: bytes) -> tuple[int, int]:
    """Return where the characters are that were on the line, and how many: a tap's record has more around them."""
    if not layers:
        return 0, 0
    first, count = layers[0].get("h", (0, len(whole)))
    if _field(layers[0]) == _TAP:
        return first + whole[first + 1], int.from_bytes(whole[first + 16 : first + 18], "big")
    return first, count


def _tree(item: dict[str, Any], first: int, count: int) -> Tree:
    start, size = item.get("h", (0, 0))
    source = item.get("ds", 0)
    if not source:
        start -= first
        if start < 0 or start + size > count:
            start, size = 0, 0
    expression = item.get("f", "") if _field(item) not in ("", "frame", "text") else ""
    below = [_tree(one, first, count) for one in item.get("n", []) if not _TOLD_ALREADY.match(one.get("f", ""))]
    return [item["l"], start, size, source, expression, below, *([item["fnum"]] if "fnum" in item else [])]


def _kinds(tree: Iterable[Tree], count: int) -> list[str]:
    """Return of each byte what kind of field it is, as `sistap annotate` colours it."""
    kinds = [""] * count
    for _, first, size, source, expression, *_ in _all(tree):
        name = expression.split(" ")[0]
        if name.startswith(_TAP) or source or " " not in expression:
            continue
        for at in range(first, first + size):
            if name in meanings.KINDS or not kinds[at]:
                kinds[at] = meanings.KINDS.get(name, meanings.DATA)
    return kinds


def _all(tree: Iterable[Tree]) -> Iterator[Tree]:
    for item in tree:
        yield item
        yield from _all(item[5])


def _filters(sharkd: Sharkd, lesson: Lesson, path: Path, packets: list[dict[str, Any]]) -> dict[str, list[int]]:
    """Return what filters leave: those of the lesson, of its answers, of the buttons; the fields of the packets."""
    expressions = {claim.expression for claim in lesson.claims if isinstance(claim, Filter)}
    expressions |= {button[1] for button in buttons()}
    for claim in lesson.claims:
        if isinstance(claim, Value):  # as the lesson prints it, which may not be as Wireshark shows it
            expressions.add(f"{claim.field} == {claim.value}")
    for question in lesson.questions:
        for ask in question.asks:
            expressions.update(ask.accepted if ask.kind == "filter" else ())
    for packet in packets:
        for item in _all(packet["tree"]):
            expressions |= {item[4], item[4].split(" ")[0]} - {""}
    found = {}
    for expression in sorted(expressions):
        try:
            found[expression] = sharkd.frames(path, expression)
        except SharkdError:
            continue  # the label of a tree that is no field
    return found
