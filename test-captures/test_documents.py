# SPDX-License-Identifier: GPL-2.0-or-later
"""Every link in the documents leads somewhere, and every field that they name exists."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from sistap.dissected.wireshark.tshark import Tshark

HOUSE = Path(__file__).parent.parent
BUILT = ("build", "node_modules", ".pytest_cache", ".mypy_cache")
DOCUMENTS = [path for path in sorted(HOUSE.rglob("*.md")) if not {*path.relative_to(HOUSE).parts} & {*BUILT}]

LINK = re.compile(r"\]\(([^)\s]+)\)")
CODE = re.compile(r"`([^`\n]+)`|^ {4}(.+)$", re.MULTILINE)
PROTOCOLS = r"(?:sis|sertap|synax\w*|3964r|rk512i|arcnet7f|sisascii)"
NAME = re.compile(rf"(?<![\w./-]){PROTOCOLS}[.]\w+(?:[.]\w+)*(?![\w/])")
FILES = {"sis.so", "sis.lua", "sis.dll", "sis.html"}
OF_THE_SCRIPT = {"sis.statistics", "sis.fields"}  # preferences

pytestmark = pytest.mark.style


def anchors(path: Path) -> set[str]:
    """Return the names of the headings of a document, as GitHub and MyST make them."""
    text = re.sub(r"^```.*?^```", "", path.read_text(), flags=re.MULTILINE | re.DOTALL)
    titles = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}


def leads_somewhere(path: Path, link: str) -> bool:
    """Tell whether the file of a link exists, and the heading in it."""
    place, _, anchor = link.partition("#")
    target = path.parent / place if place else path
    return target.exists() and (not anchor or target.suffix != ".md" or anchor in anchors(target))


def test_links() -> None:
    links = [(path, link) for path in DOCUMENTS for link in LINK.findall(path.read_text()) if "://" not in link]
    assert len(links) > 200
    assert [(path, link) for path, link in links if not leads_somewhere(path, link)] == []


@pytest.fixture(scope="module")
def names(tshark: Tshark) -> set[str]:
    """Return all names that may be typed: fields, preferences and tables of dissectors."""
    preferences = re.findall(rf"^#?({PROTOCOLS}[.]\w+):", tshark.output("-G", "currentprefs"), re.MULTILINE)
    reports = [tshark.output("-G", report).splitlines() for report in ("fields", "dissector-tables")]
    fields, tables = ([line.split("\t") for line in report] for report in reports)
    return {
        *preferences,
        *(columns[2] for columns in fields),
        *(columns[0] for columns in tables),
        *FILES,
        *OF_THE_SCRIPT,
    }


def test_names(names: set[str]) -> None:
    for path in DOCUMENTS:
        text = path.read_text()
        if path.name == "CHANGELOG.md":  # of a renamed field, the old name stands in the first column
            text = re.sub(r"^\| [^|]* \|", "|", text, flags=re.MULTILINE)
        code = "\n".join("".join(found) for found in CODE.findall(text))
        assert sorted(set(NAME.findall(code)) - names) == [], path
