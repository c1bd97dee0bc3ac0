# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads what a lesson of the course and its solutions claim, so that a test can hold it against the capture.

They claim these things, in forms that a person reads, too:

    | filter | packets |            a display filter and the packets that it leaves, or `none`
    | packet | field | value |      what a field of a packet is, as `tshark -T fields` writes it, or `there`
    | telegram | field | value |    the same of telegrams that need not be in a capture: of the last one of A / B / C
    | telegram | bytes | says |     bytes of a packet, explained: all rows of a packet together are its telegram
        $ tshark ARGUMENTS          a command, and under it all that it prints
        02 D9 00 ...                bytes that are somewhere in the capture, one after the other
    1. The button *Late*.           under "Look": steps, of which `clicks` tells filters and packets

Further columns of a table are for the reader, and so are tables with other headings. There are no other indented blocks
but what the reader types. If that is `python3 -m sistap bus ... -w FILE`, the lesson has a scenario, and no capture.

In a step, these words change the display filter: "button *NAME*", "filter `EXPRESSION`", "Clear the filter". What is
named as "packet 4" or "packets 1 to 4" is clicked, so the filter must show it. A dialog is opened without a filter.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterator
from itertools import groupby
from pathlib import Path
from typing import NamedTuple


class Filter(NamedTuple):
    """A display filter, and the packets that match."""

    line: int
    expression: str
    packets: list[int]


class Value(NamedTuple):
    """A field of a packet, and its value; `there` for a field without a value of its own."""

    line: int
    packet: int
    field: str
    value: str


class Command(NamedTuple):
    """Arguments of tshark, and what it prints, without spaces at the ends of lines."""

    line: int
    arguments: list[str]
    output: list[str]


class Bytes(NamedTuple):
    """Characters that were on the line one after the other."""

    line: int
    data: bytes


class Given(NamedTuple):
    """Telegrams that need not be in a capture, and the value of a field of the last one."""

    line: int
    telegrams: list[bytes]
    field: str
    value: str


class Explained(NamedTuple):
    """Bytes of a packet that are explained in place."""

    line: int
    packet: int
    data: bytes


Claim = Filter | Value | Command | Bytes | Given | Explained

Row = Callable[[int, list[str]], Claim]

HEX = re.compile(r"(?:[0-9A-F]{2} )*[0-9A-F]{2}")
PROMPT = "$ "
RECORDS = "python3 -m sistap bus "
TYPED = ("cd ", "wireshark -C SIS ", "python3 -m sistap ", "py -m sistap ")  # what the reader types


class Button(NamedTuple):
    """A click on a button of the profile, which puts its filter in force."""

    name: str


class Typed(NamedTuple):
    """A filter that comes into force; empty: none."""

    expression: str


class Clicked(NamedTuple):
    """Packets that are clicked, one after the other."""

    packets: list[int]


class Dialog(NamedTuple):
    """A dialog that is opened from the menu."""

    menu: str


def recording(path: Path) -> list[str]:
    """Return the arguments of sistap, run in capture/, that write the capture; none if it is beside the lesson."""
    lines = (line[4:] for line in path.read_text().splitlines() if line.startswith("    " + RECORDS) and " -w " in line)
    return shlex.split(next(lines, ""))[3:]


Click = Button | Typed | Clicked | Dialog

STEPS = re.compile(r"^## Look\n\n(.*?)\n\n## ", re.MULTILINE | re.DOTALL)
STEP = re.compile(r"^\d+\. (.*(?:\n   .*)*)", re.MULTILINE)
CLICKS = re.compile(
    r"button \*(?P<button>\w+)\*"
    r"|[Ff]ilter `(?P<typed>[^`]+)`"
    r"|(?P<clear>[Cc]lear the filter)"
    r"|[Pp]ackets? (?P<packets>\d+(?:(?:, | to | and |, and )\d+)*)"
    r"|\*(?P<menu>(?:Statistics|Analyze|File) > [^*]+)\*"
)


def clicks(text: str) -> list[list[Click]]:
    """Return what is clicked in each step of a lesson, in its order."""
    found = STEPS.search(text)
    steps = STEP.findall(found[1]) if found else []
    return [[_click(match) for match in CLICKS.finditer(" ".join(step.split()))] for step in steps]


def _click(match: re.Match[str]) -> Click:
    if match["button"]:
        return Button(match["button"])
    if match["packets"]:
        return Clicked(_numbers(match["packets"]))
    if match["menu"]:
        return Dialog(match["menu"])
    return Typed(match["typed"] or "")


def _numbers(text: str) -> list[int]:
    ranges = [list(map(int, part.split(" to "))) for part in re.split(r",? and |, ", text)]
    return [number for ends in ranges for number in range(ends[0], ends[-1] + 1)]


def _filter(line: int, cells: list[str]) -> Filter:
    expression = cells[0].strip("`").replace(r"\|", "|")  # a bar ends a cell of Markdown, unless it is escaped
    packets = [] if cells[1] == "none" else [int(number) for number in cells[1].split(",")]
    return Filter(line, expression, packets)


def _value(line: int, cells: list[str]) -> Value:
    return Value(line, int(cells[0]), cells[1].strip("`"), cells[2].strip("`"))


def _given(line: int, cells: list[str]) -> Given:
    telegrams = [bytes.fromhex(text) for text in cells[0].replace("`", "").split("/")]
    return Given(line, telegrams, cells[1].strip("`"), cells[2].strip("`"))


def _explained(line: int, cells: list[str]) -> Explained:
    return Explained(line, int(cells[0]), bytes.fromhex(cells[1].replace("`", "")))


TABLES: dict[tuple[str, ...], Row] = {
    ("filter", "packets"): _filter,
    ("packet", "field", "value"): _value,
    ("telegram", "field", "value"): _given,
    ("telegram", "bytes", "says"): _explained,
}


def claims(text: str, name: str) -> list[Claim]:
    """Return all claims of a text; lines count from 1 in it. ValueError names a line that is none of them."""
    return list(_claims(text.splitlines(), name))


def _claims(lines: list[str], name: str) -> Iterator[Claim]:
    for kind, numbered in groupby(enumerate(lines, 1), lambda entry: _kind(entry[1])):
        block = list(numbered)
        try:
            if kind == "table":
                yield from _table(block)
            elif kind == "indented":
                yield from _indented(block)
        except (ValueError, KeyError, IndexError) as error:
            raise ValueError(f"{name}:{block[0][0]}: {error!r}") from error


def _kind(line: str) -> str:
    if line.startswith("|"):
        return "table"
    return "indented" if line.startswith("    ") else "text"


def _table(block: list[tuple[int, str]]) -> Iterator[Claim]:
    rows = [(line, [cell.strip() for cell in re.split(r"(?<!\\)\|", text)[1:-1]]) for line, text in block]
    header = rows[0][1]
    for columns, read in TABLES.items():
        if tuple(header[: len(columns)]) == columns:
            for line, cells in rows[2:]:
                yield read(line, cells)


def _indented(block: list[tuple[int, str]]) -> Iterator[Claim]:
    line, first = block[0][0], block[0][1][4:]
    if first.startswith(PROMPT):
        program, *arguments = shlex.split(first.removeprefix(PROMPT))
        if program != "tshark":
            raise ValueError("a command is one of tshark")
        yield Command(line, arguments, [text[4:].rstrip() for _, text in block[1:]])
    elif not first.startswith(TYPED):
        for number, text in block:
            if not HEX.fullmatch(text.strip()):
                raise ValueError(f"neither a command nor bytes: {text.strip()}")
            yield Bytes(number, bytes.fromhex(text))
