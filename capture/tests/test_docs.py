# SPDX-License-Identifier: GPL-2.0-or-later
"""The documents say what the code says: generated pages are current, and troubleshooting has every message."""

from __future__ import annotations

import ast
import re
import runpy
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from sistap.commands.extcap import dialog
from sistap.tap.capture import hints

CAPTURE = Path(__file__).parents[1]
HOUSE = CAPTURE.parent
GENERATE = CAPTURE / "docs" / "generate.py"

MOST_WORDS = 1200
LONGER = {  # lists to look something up in
    *("CHANGELOG.md", "SECURITY.md", "plugin/REFERENCE.md", "test-captures/pages/glossary.md"),
    *(
        "capture/benchmark/README.md",
        "capture/docs/kinds.md",
        "capture/sisbus/scenarios/README.md",
        "capture/sisbus/devices/sets/README.md",
    ),
}

pytestmark = pytest.mark.style


def test_generated_pages_are_current() -> None:
    check = [sys.executable, str(GENERATE), "--check"]
    done = subprocess.run(check, capture_output=True, text=True, check=False)
    assert done.stdout == "" and done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("capture/bundle/build", "Makes the bundle for Windows and its installer in build/windows"),
        ("capture/benchmark/hostile.py", "Does the work of the dissector grow faster than hostile traffic?"),
        ("plugin/windows/filters.c", "*Conversation Filter*: for an exchange, and for two stations"),
        (
            "lua-fallback/sis.lua",
            "The SIS telegram and the serial tap's record in Lua: one file for Wireshark 4.0 and later, no compiler",
        ),
        ("plugin/sis/address.c", "Station addresses: their kinds in the two editions (fig. "),
    ],
)
def test_the_table_of_files_has_what_a_file_says_of_itself(name: str, said: str) -> None:
    subject = runpy.run_path(str(GENERATE))["subject"]
    assert subject((HOUSE / name).read_text("utf-8")).startswith(said)


def messages() -> Iterator[str]:
    """Yield each hint as a pattern, up to what it advises; numbers and settings may be any."""
    for node in ast.walk(ast.parse(Path(hints.__file__).read_text())):
        if isinstance(node, ast.Assign) and "hint" in ast.unparse(node.targets[0]):
            value = node.value
            if isinstance(value, ast.Constant) and isinstance(value.value, str):
                yield re.escape(value.value.partition(":")[0])
            elif isinstance(value, ast.JoinedStr):
                parts = [re.escape(part.value) if isinstance(part, ast.Constant) else r"\S+" for part in value.values]
                yield "".join(parts).partition(":")[0]


def page(name: str) -> str:
    """Return a page without marks, in one line."""
    return " ".join(re.sub(r"[*`>]", "", (CAPTURE / "docs" / name).read_text()).split())


def test_troubleshooting_has_every_hint() -> None:
    found = list(messages())
    assert len(found) >= 7
    assert [hint for hint in found if not re.search(hint, page("troubleshooting.md"))] == []


def test_troubleshooting_has_what_is_seen_on_windows() -> None:
    text = (CAPTURE / "bundle" / "README.html").read_text()
    table = text.partition("<th>what you see</th>")[2].partition("</table>")[0]
    cells = re.findall(r"<tr>\s*<td>(.*?)</td>", table, re.DOTALL)
    seen = [" ".join(re.sub("<.*?>", "", cell).split()) for cell in cells]
    assert len(seen) >= 7
    assert [words for words in seen if words not in page("troubleshooting.md")] == []


def test_the_dialog_explains_every_framing_that_it_offers() -> None:
    (field,) = (field for field in dialog.OPTIONS if field.display == "Framing")
    assert field.choices is not None
    words = [re.split(r"[ :]", choice[1])[0] for choice in field.choices("")]
    assert words == ["SIS", "3964R", "ASCII"]
    assert [word for word in words if word not in field.tooltip] == []


def test_each_statistic_is_explained() -> None:
    """The table of names and menus is made from the code. A heading names each menu, or the menu above it."""
    text = (HOUSE / "plugin" / "docs" / "statistics.md").read_text("utf-8")
    menus = re.findall(r"^\| `\S+` \| \*(.+?)(?: > .*)?\* \|$", text, re.MULTILINE)
    assert len(menus) == 7
    said = " ".join(" ".join(part) for part in re.findall(r"^## (.*)|(\*[^*]+\*) counts", text, re.MULTILINE))
    assert [menu for menu in menus if menu not in said] == []


def test_the_script_prints_the_statistics_that_its_page_names() -> None:
    script = (HOUSE / "lua-fallback" / "sis.lua").read_text("utf-8")
    words = re.findall(r'"(\w+)"', re.search(r"local ORDER = \{(.*?)\}", script)[1])  # type: ignore[index]
    table = (HOUSE / "lua-fallback" / "README.md").read_text("utf-8").partition("| word | content |")[2]
    assert sorted(re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE)) == sorted(words)


def count(path: Path) -> int:
    """Return the words of a page; marks of tables are none."""
    return sum(any(map(str.isalnum, word)) for word in path.read_text().split())


def test_pages_are_short() -> None:
    pages = [
        *HOUSE.glob("*.md"),
        *HOUSE.glob("*/README.md"),
        *HOUSE.glob("*/docs/*.md"),
        *CAPTURE.glob("docs/commands/*.md"),
    ]
    assert len(pages) > 40
    words = {path.relative_to(HOUSE).as_posix(): count(path) for path in pages}
    assert {name: number for name, number in words.items() if number > MOST_WORDS and name not in LONGER} == {}
