# SPDX-License-Identifier: GPL-2.0-or-later
"""The list of the plugin's lines that nothing reaches: it names what is there, and a new one is noticed."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "fuzz"))

from unreached import LIST, Coverage, Place, differences, explained  # noqa: E402

PLUGIN = HERE.parent / "plugin"
# A function of another file, one that is static, and one that is not.
REPORT = """SF:{plugin}/x.c
FN:1,x.c:first
FN:4,second
DA:1,7
DA:2,{count}
DA:4,1
DA:5,0
end_of_record
SF:/usr/include/glib.h
FN:1,g_new
DA:1,0
""".splitlines()


def counted(plugin: Path, *counts: int) -> Coverage:
    coverage = Coverage(plugin)
    for count in counts:
        coverage.add(line.format(plugin=plugin, count=count) for line in REPORT)
    return coverage


def test_what_any_report_counts_is_reached(tmp_path: Path) -> None:
    assert counted(tmp_path, 0).unreached() == {Place("x.c", "first"): [2], Place("x.c", "second"): [5]}
    assert counted(tmp_path, 0, 3).unreached() == {Place("x.c", "second"): [5]}
    assert counted(tmp_path, 0).all == 4


@pytest.mark.parametrize(
    ("listed", "said"),
    [
        ({"first": 1, "second": 1}, []),
        ({"second": 1}, ["x.c first(): 1 lines are not reached, the list has 0", "    2: two"]),
        ({"first": 1, "second": 1, "gone": 2}, ["x.c gone(): 0 lines are not reached, the list has 2"]),
    ],
)
def test_where_the_list_is_wrong(tmp_path: Path, listed: dict[str, int], said: list[str]) -> None:
    (tmp_path / "x.c").write_text("one\n  two\nthree\nfour\nfive\n")
    places = {Place("x.c", function): lines for function, lines in listed.items()}
    assert list(differences(counted(tmp_path, 0).unreached(), places, tmp_path)) == said


def test_the_list_names_functions_that_are_there() -> None:
    for place in explained(LIST.read_text("utf-8")):
        assert re.search(rf"\b{place.function}\(", (PLUGIN / place.file).read_text("utf-8")), place
