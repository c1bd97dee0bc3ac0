#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Try the attacks that the tests know, and print the table of SECURITY.md: what was tried, and what came of it.

After `./bootstrap test`: build/venv/bin/python3 capture/tests/attacks.py. With `--write` first, SECURITY.md gets the
table, if all were tried and none failed. Other arguments are those of pytest; some attacks take root. A test is an
attack by its mark, such as
@pytest.mark.attack("a toolbar says what no Wireshark says", "passed over, the capture goes on").
"""

from __future__ import annotations

import ast
import os
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = [ROOT / "capture/tests", ROOT / "lua-fallback", ROOT / "test-captures"]
SECURITY = ROOT / "SECURITY.md"
MARK = "attack"
WRITE = "--write"
HEADS = ("| attack | tried | result |", "|---|---|---|")


def known() -> Iterator[tuple[str, str]]:
    """Yield each attack and its expected result, as the tests state them."""
    for file in sorted(file for folder in FOLDERS for file in folder.rglob("test_*.py")):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == MARK:
                tried, result = (ast.literal_eval(argument) for argument in node.args)
                yield tried, result


class Table:
    """A pytest plugin that records the result of each attack."""

    def __init__(self) -> None:
        """Nothing was tried."""
        self._attacks: dict[str, tuple[str, str]] = {}  # by the name of the test
        self._outcomes: dict[tuple[str, str], Counter[str]] = {}

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Note which attack each test is."""
        for item in items:
            if mark := item.get_closest_marker(MARK):
                self._attacks[item.nodeid] = (str(mark.args[0]), str(mark.args[1]))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Count what came of a test."""
        if report.when == "call" or report.outcome != "passed":
            self._outcomes.setdefault(self._attacks[report.nodeid], Counter())[report.outcome] += 1

    @property
    def is_whole(self) -> bool:
        """Tell whether all were tried, and none failed."""
        return set(self._outcomes) == set(known()) and all(
            counts["passed"] == counts.total() for counts in self._outcomes.values()
        )

    def lines(self) -> Iterator[str]:
        """Yield the table."""
        yield from HEADS
        for (tried, result), counts in self._outcomes.items():
            came = (
                f"**{counts['failed']} FAILED**"
                if counts["failed"]
                else result
                if counts["passed"]
                else "not tried here"
            )
            yield f"| {tried} | {counts.total() - counts['skipped']} | {came} |"


def written(document: str, table: list[str]) -> str:
    """Return the document with this table in place of its own."""
    before, _, rest = document.partition(HEADS[0])
    return before + "\n".join(table) + "\n\n" + rest.partition("\n\n")[2]


def main(arguments: list[str]) -> int:
    """Try them all; return pytest's exit code."""
    is_for_document = arguments[:1] == [WRITE]
    table = Table()
    os.environ.setdefault("WIRESHARK_PLUGIN_DIR", str(ROOT / "build/wireshark"))
    options = ["-q", "-c", str(ROOT / "capture/pyproject.toml"), "--rootdir", str(ROOT), "-m", MARK]
    code = pytest.main([*options, *arguments[is_for_document:], *map(str, FOLDERS)], plugins=[table])
    print(*table.lines(), sep="\n")
    if is_for_document and table.is_whole:
        SECURITY.write_text(written(SECURITY.read_text("utf-8"), list(table.lines())), "utf-8")
    return int(code)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
