# SPDX-License-Identifier: GPL-2.0-or-later
"""Every link in the documents leads somewhere, and every field that they name exists."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from sistap.wireshark.tshark import Tshark

HOUSE = Path(__file__).parent.parent
FOLDERS = (
    "",
    "plugin",
    "capture",
    "capture/benchmark",
    "capture/package",
    "lua-fallback",
    "test-captures",
    "test-captures/course",
    "test-captures/pages",
)
DOCUMENTS = [path for folder in FOLDERS for path in sorted((HOUSE / folder).glob("*.md"))]

LINK = re.compile(r"\]\(([^)\s]+)\)")
CODE = re.compile(r"`([^`\n]+)`|^ {4}(.+)$", re.MULTILINE)
PROTOCOLS = r"(?:sis|sertap|synax\w*|3964r|rk512i|arcnet7f)"
NAME = re.compile(rf"(?<![\w./-]){PROTOCOLS}[.]\w+(?:[.]\w+)*(?![\w/])")
FILES = {"sis.so", "sis.lua", "sis.dll"}
OF_THE_SCRIPT = {"sis.statistics"}  # a preference

every_document = pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(HOUSE)))


@every_document
def test_links(path: Path) -> None:
    links = [link for link in LINK.findall(path.read_text()) if "://" not in link]
    missing = [link for link in links if not (path.parent / link.partition("#")[0]).exists()]
    assert not missing


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


@every_document
def test_names(path: Path, names: set[str]) -> None:
    text = path.read_text()
    if path.name == "CHANGELOG.md":  # of a renamed field, the old name stands in the first column
        text = re.sub(r"^\| [^|]* \|", "|", text, flags=re.MULTILINE)
    code = "\n".join("".join(found) for found in CODE.findall(text))
    assert sorted(set(NAME.findall(code)) - names) == []
