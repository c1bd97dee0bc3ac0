# SPDX-License-Identifier: GPL-2.0-or-later
"""The claims of SECURITY.md match the tests; the installed files match its list."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from attacks import HEADS, ROOT, SECURITY, known, written

LOCK = (ROOT / "capture/develop.lock").read_text()
PROJECT = tomllib.loads((ROOT / "capture/pyproject.toml").read_text())["project"]


@pytest.mark.style
def test_the_table_of_attacks_is_that_of_the_tests() -> None:
    rows = re.findall(r"^\| (.+) \| (\d+) \| (.+) \|$", (ROOT / "SECURITY.md").read_text("utf-8"), re.MULTILINE)
    assert {(tried, result) for tried, _, result in rows} == set(known())
    assert all(int(count) for _, count, _ in rows)


def test_the_script_writes_the_table_and_nothing_else() -> None:
    document = SECURITY.read_text("utf-8")
    row = "| an attack | 1 | refused |"
    changed = written(document, [*HEADS, row])
    assert changed.count("\n| an attack | 1 | refused |\n\n") == 1 and "a log with an endless line" not in changed
    table = document[document.index(HEADS[0]) :].partition("\n\n")[0].splitlines()
    assert written(changed, table) == document


@pytest.mark.thorough
def test_the_script_that_tries_them_finds_them() -> None:
    """Its order of folders is its own, and so is what hides a module of the same name."""
    command = [sys.executable, str(Path(__file__).with_name("attacks.py")), "--collect-only"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def test_the_list_of_packages_has_all_that_is_asked_for_with_sums() -> None:
    locked = dict(re.findall(r"^([\w.-]+)==(\S+) \\$", LOCK, re.MULTILINE))
    assert "develop.lock" in (ROOT / "bootstrap").read_text()
    for asked in PROJECT["optional-dependencies"]["develop"]:
        name, version = asked.split("==")
        assert locked[name] == version, "capture/develop.lock says how it is made again"
    assert "pyserial" in locked and "pyarrow" in locked
    for entry in re.split(r"^(?=[\w.-]+==)", LOCK, flags=re.MULTILINE)[1:]:
        assert re.search(r"^    --hash=sha256:[0-9a-f]{64}", entry, re.MULTILINE), entry.partition(" ")[0]
    assert "--find-links" not in re.sub(r"^#.*", "", LOCK, flags=re.MULTILINE)


def test_the_licence_of_each_library_is_said() -> None:
    table = (ROOT / "CONTRIBUTING.md").read_text("utf-8").partition("## Licences")[2]
    asked = [*PROJECT["dependencies"], *(name for names in PROJECT["optional-dependencies"].values() for name in names)]
    for name in {re.split("[=>]", text)[0] for text in asked}:
        assert re.search(rf"\b{name}\b", table), name
