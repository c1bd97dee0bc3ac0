# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes the fields and expert items that the plugin registers into sis.lua, between two marks.

Run it without arguments after changing a registration in plugin/. A test checks that sis.lua is current.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
SCRIPT = HERE / "sis.lua"
PLUGIN = HERE.parent / "plugin"
BEGIN = "--- fields: made by fields.py from the registrations in plugin/; edit there\n"
END = "-- end of what fields.py has made\n"
WIDTH = 120

STRING = r'"(?:[^"\\]|\\.)*"'
FIELD = re.compile(
    rf"\{{&hf_\w+,\s*\{{(?P<text>{STRING}), (?P<name>{STRING}), FT_(?P<kind>\w+), (?P<display>[^,]+),"
    rf" (?P<strings>[^,]+(?:\([^)]*\))?), (?P<mask>\w+),\s*(?P<description>{STRING}|NULL), HFILL\}}\}},"
)
EXPERT = re.compile(
    rf"\{{&ei_\w+,\s*\{{(?P<name>{STRING}), PI_(?P<group>\w+), PI_(?P<severity>\w+),\s*(?P<text>{STRING}),"
    r" EXPFILL\}\},"
)
TABLE = re.compile(r"^static const value_string (?P<name>\w+)\[\] = \{(?P<entries>.*?)\};", re.MULTILINE | re.DOTALL)
ENTRY = re.compile(rf"\{{(?P<code>\w+|'.'),\s*(?P<text>{STRING})\}}")
PAIR = re.compile(
    rf"^static const true_false_string (?P<name>\w+) = \{{(?P<texts>{STRING}, {STRING})\}};", re.MULTILINE
)
UNIT = re.compile(rf"^static const unit_name_string (?P<name>\w+) = \{{(?P<text>{STRING}), NULL\}};", re.MULTILINE)
DEFINE = re.compile(r"^#define (?P<name>\w+) +(?P<number>'.'|(?:0x[0-9A-F]+|\d+)(?=u?\b))", re.MULTILINE)
ENUM = re.compile(r"\benum(?: \w+)? \{(?P<names>[^}]*)\}")

# What Wireshark itself defines.
CONSTANTS = {"PROTO_CHECKSUM_E_BAD": 0, "PROTO_CHECKSUM_E_GOOD": 1, "PROTO_CHECKSUM_E_UNVERIFIED": 2}
UNITS = {"units_byte_bytes": '{" byte", " bytes"}'}


class Source(NamedTuple):
    """A C file and the names in its registrations: its own numbers and those of the headers, its own units."""

    text: str
    numbers: dict[str, int]
    units: dict[str, str]


def _literal(word: str) -> int:
    return ord(word[1]) if word.startswith("'") else int(word, 0)


def _numbers(text: str) -> Iterator[tuple[str, int]]:
    for found in DEFINE.finditer(text):
        yield found["name"], _literal(found["number"])
    for found in ENUM.finditer(re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)):
        for number, name in enumerate(found["names"].split(",")):
            if name.strip():
                yield name.strip(), number


def read(path: Path, headers: dict[str, int]) -> Source:
    """Read a C file; `headers` are the numbers that all headers define."""
    text = path.read_text()
    units = {found["name"]: f"{{{found['text']}}}" for found in UNIT.finditer(text)}
    return Source(text, CONSTANTS | headers | dict(_numbers(text)), UNITS | units)


def _number(source: Source, word: str) -> int:
    return source.numbers[word] if word in source.numbers else _literal(word)


def _texts(source: Source) -> Iterator[str]:
    """Return the tables of a file that its fields name."""
    for table in TABLE.finditer(source.text):
        if f"VALS({table['name']})" in source.text:
            yield f"N.{table['name']} = {{"
            for entry in ENTRY.finditer(table["entries"]):
                yield f"  [{_number(source, entry['code'])}] = {entry['text']},"
            yield "}"
    for pair in PAIR.finditer(source.text):
        yield f"N.{pair['name']} = {{{pair['texts']}}}"


def _strings(source: Source, words: str) -> str:
    """Return what names the values of a field, or its unit."""
    if words == "NULL" or words.startswith("CF_FUNC"):  # a script cannot format a field
        return "nil"
    kind, name = re.fullmatch(r"(\w+)\(&?(\w+)\)", words).groups()  # type: ignore[union-attr]
    if kind == "FRAMENUM_TYPE":
        return f"frametype.{name.removeprefix('FT_FRAMENUM_')}"
    return source.units[name] if kind == "UNS" else f"N.{name.removeprefix('sis_')}"


def _display(words: str) -> str:
    parts = [part.strip() for part in words.replace("BASE_CUSTOM", "BASE_NONE").split("|")]
    return " + ".join(part if part.isdigit() else f"base.{part.removeprefix('BASE_')}" for part in parts)


def _field(source: Source, found: re.Match[str]) -> str:
    mask = _number(source, found["mask"])
    words = [
        found["name"],
        found["text"],
        f"ftypes.{found['kind']}",
        _display(found["display"]),
        _strings(source, found["strings"]),
        f"0x{mask:02x}" if mask else "0",
        "nil" if found["description"] == "NULL" else found["description"],
    ]
    while words[-1] in {"nil", "0", "base.NONE"}:
        words.pop()
    return _call("field", words)


def _expert(found: re.Match[str]) -> str:
    return _call("expert_field", [found["name"], f'"{found["group"]}"', f'"{found["severity"]}"', found["text"]])


def _call(function: str, words: Iterable[str]) -> str:
    """Return a call, in as many lines as it needs."""
    lines = [f"{function}("]
    for word in words:
        separator = "" if lines[-1].endswith("(") else ", "
        if len(lines[-1] + separator + word) >= WIDTH - 1:
            lines[-1] += separator.rstrip()
            lines.append("  ")
            separator = ""
        first, *rest = _parts(word)
        lines[-1] += separator + first
        lines += [f"    .. {part}" for part in rest]
    return "\n".join(lines) + ")"


def _parts(word: str) -> list[str]:
    """Cut a string that is too long for a line."""
    if len(word) < WIDTH - 10:
        return [word]
    cut = word.rindex(" ", 0, WIDTH - 20) + 1
    return [word[:cut] + '"', *_parts('"' + word[cut:])]


def _block(path: Path, headers: dict[str, int]) -> str:
    """Return what a C file registers; ValueError if a registration cannot be read."""
    source = read(path, headers)
    fields, experts = list(FIELD.finditer(source.text)), list(EXPERT.finditer(source.text))
    if len(fields) != source.text.count("HFILL") or len(experts) != source.text.count("EXPFILL"):
        raise ValueError(f"a registration in {path} cannot be read")
    lines = [*_texts(source), *(_field(source, found) for found in fields), *map(_expert, experts)]
    return "\n".join([f"-- {path.relative_to(PLUGIN)}", *lines])


def current() -> str:
    """Return the section as the sources have it now, marks included."""
    headers = dict(pair for path in sorted(PLUGIN.rglob("*.h")) for pair in _numbers(path.read_text()))
    paths = [path for path in sorted(PLUGIN.rglob("*.c")) if "FILL}}" in path.read_text()]
    return "\n\n".join([BEGIN.rstrip(), *(_block(path, headers) for path in paths), END])


def main() -> None:
    """Put the section in place of the one that sis.lua has."""
    before, rest = SCRIPT.read_text().split(BEGIN)
    SCRIPT.write_text(before + current() + rest.split(END)[1])


if __name__ == "__main__":
    main()
