# SPDX-License-Identifier: GPL-2.0-or-later
"""Turns the Markdown that the lessons use into HTML: headings, lists, tables, code, links, pictures, folded parts.

Everything is escaped; no HTML of a lesson passes but the tags that fold a part.
"""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Iterator
from html import escape
from itertools import groupby

from pages import COURSE

_FOLDING = re.compile(r"</?(details|summary)>")
_ITEM = re.compile(r"(-|\d+\.) +")
_LINK = re.compile(r"(!?)\[([^]]*)\]\(([^)\s]+)\)")
_PACKETS = re.compile(r"\b(packets? )(\d+(?![.:]?\d)(?:(?:, | and | or | to )\d+(?![.:]?\d))*)", re.IGNORECASE)
_EMPHASIS = re.compile(r"(?<![\w*])\*(?=\S)(.+?)(?<=\S)\*(?![\w*])", re.DOTALL)
_PICTURES = {".svg": "image/svg+xml", ".png": "image/png"}


def html(text: str) -> str:
    """Turn blocks of Markdown into HTML."""
    return "\n".join(_blocks(text.strip("\n").split("\n")))


def inline(text: str) -> str:
    """Turn the text of one block into HTML. Numbers of packets become links to them."""
    parts = re.split(r"(`[^`]+`|!?\[[^]]*\]\([^)\s]+\))", text)
    return "".join(_special(part) if at % 2 else _words(part) for at, part in enumerate(parts))


def packets(text: str) -> set[int]:
    """Return the packets that a text links to."""
    return {int(number) for number in re.findall(r'href="#packet-(\d+)"', html(text))}


def cells(row: str) -> list[str]:
    """Split a row of a table; a bar that is escaped belongs to its cell."""
    return [cell.strip().replace(r"\|", "|") for cell in re.split(r"(?<!\\)\|", row.strip())[1:-1]]


def _words(text: str) -> str:
    shown = _PACKETS.sub(lambda found: found[1] + re.sub(r"\d+", _packet, found[2]), escape(text))
    shown = re.sub(r"\*\*(\S.*?)\*\*", r"<strong>\1</strong>", shown, flags=re.DOTALL)
    return _EMPHASIS.sub(_emphasis, shown)


def _emphasis(found: re.Match[str]) -> str:
    """Mark a path through menus: those of Wireshark are not in the page."""
    return f'<em class="menu">{found[1]}</em>' if " &gt; " in found[1] else f"<em>{found[1]}</em>"


def _packet(number: re.Match[str]) -> str:
    return f'<a class="packet" href="#packet-{number[0]}">{number[0]}</a>'


def _special(text: str) -> str:
    if text.startswith("`"):
        return f"<code>{escape(text[1:-1])}</code>"
    found = _LINK.fullmatch(text)
    assert found is not None
    picture, words, target = found.groups()
    return _picture(words, target) if picture else _link(words, target)


_PLACES = {"../README.md": "#learn", "../pages/glossary.md": "#learn/glossary", "sheet.pdf": "#learn/sheet"}


def _link(words: str, target: str) -> str:
    """Make a link to another place of the course. Other files are not in the page: keep the words."""
    place, _, _ = target.partition("#")
    if place.endswith(".md") and (COURSE / place).parent == COURSE:
        target = f"#learn/{place.removesuffix('.md')}"
    elif place in _PLACES:
        target = _PLACES[place]
    else:
        return _words(words)
    return f'<a href="{escape(target)}">{_words(words)}</a>'


def _picture(words: str, target: str) -> str:
    path = COURSE / target
    kind = _PICTURES[path.suffix]
    return f'<img alt="{escape(words)}" src="data:{kind};base64,{b64encode(path.read_bytes()).decode()}">'


def _blocks(lines: list[str]) -> Iterator[str]:
    for kind, grouped in groupby(_kinds(lines), lambda entry: entry[0]):
        block = [line for _, line in grouped]
        if kind == "text":
            yield f"<p>{inline(' '.join(line.strip() for line in block))}</p>"
        elif kind == "table":
            yield _table(block)
        elif kind == "code":
            yield f"<pre>{escape(chr(10).join(line.removeprefix('    ') for line in block))}</pre>"
        elif kind == "fenced":
            yield f"<pre>{escape(chr(10).join(block[1:-1]))}</pre>"
        elif kind == "list":
            yield from _lists(block)
        elif kind == "heading":
            yield from map(_heading, block)
        elif kind == "folding":
            yield from map(_folding, block)


def _kinds(lines: list[str]) -> Iterator[tuple[str, str]]:
    """Tell of each line what kind of block it belongs to."""
    before = "blank"
    for line in lines:
        if before == "fenced":
            yield "fenced", line
            before = "end" if line.startswith("```") else "fenced"
            continue
        before = _kind(line, before)
        yield before, line


def _kind(line: str, before: str) -> str:
    for start, kind in (("|", "table"), ("#", "heading"), ("```", "fenced")):
        if line.startswith(start):
            return kind
    if not line.strip():
        return "blank"
    if _FOLDING.match(line):
        return "folding"
    if _ITEM.match(line) or (before == "list" and line.startswith(" ")):
        return "list"
    return "code" if line.startswith("    ") else "text"


def _folding(line: str) -> str:
    """Keep the tags that fold a part; everything else is text."""
    return "".join(part if _FOLDING.fullmatch(part) else inline(part) for part in re.split(r"(<[^<>]*>)", line))


def _heading(line: str) -> str:
    marks, _, words = line.partition(" ")
    name = re.sub(r"\W+", "-", words.lower()).strip("-")
    return f'<h{len(marks)} id="{name}">{inline(words)}</h{len(marks)}>'


def _lists(block: list[str]) -> Iterator[str]:
    items: list[str] = []
    for line in block:
        if _ITEM.match(line):
            items.append(line)
        else:
            items[-1] += " " + line.strip()
    kind = "ul" if block[0].startswith("-") else "ol"
    shown = "".join(f"<li>{inline(_ITEM.sub('', item, count=1))}</li>" for item in items)
    yield f"<{kind}>{shown}</{kind}>"


def _table(block: list[str]) -> str:
    heading, *rows = (cells(line) for at, line in enumerate(block) if at != 1)
    head = "".join(f'<th scope="col">{inline(cell)}</th>' for cell in heading)
    body = "".join(f"<tr>{''.join(f'<td>{inline(cell)}</td>' for cell in row)}</tr>" for row in rows)
    kind = " ".join(re.sub(r"\W", "", cell) for cell in heading[:2])
    table = f'<table class="{kind}"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
    # Who has no mouse scrolls a wide table when it has the focus.
    return f'<div class="wide" role="group" aria-label="Table" tabindex="0">{table}</div>'
