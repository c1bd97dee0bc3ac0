# SPDX-License-Identifier: GPL-2.0-or-later
"""The layers of the plugin: every file uses only those before it in the list of plugin/DEVELOP.md.

Two proofs: the includes of a file, and the symbols that its compiled object takes from other objects.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

HOUSE = Path(__file__).resolve().parent.parent
PLUGIN = HOUSE / "plugin"
OBJECTS = HOUSE / "build" / "plugin" / "plugin" / "CMakeFiles" / "sis.dir"

LINE = re.compile(r"    (?P<folder>[a-z0-9/]+/)? *(?P<files>[a-z0-9-]+(, [a-z0-9-]+)*)")
INCLUDE = re.compile(r'#include "(?P<file>[^"]+)\.h"')
APART = {"parameters", "sertap"}  # two families that do not know each other


def listed() -> list[str]:
    """Return the files in the order of the list, without suffix: "sis/exchange"."""
    section = (PLUGIN / "DEVELOP.md").read_text().split("## Where to find what\n")[1].split("\n\n    ")[1]
    lines = [LINE.fullmatch(line) for line in ("    " + section.split("\n\n")[0]).splitlines()]
    return [f"{line['folder'] or ''}{file}" for line in lines if line for file in line["files"].split(", ")]


FILES = listed()
pytestmark = pytest.mark.style


def may_use(file: str, other: str) -> bool:
    """Tell whether a file may know another one."""
    families = {file.split("/")[0], other.split("/")[0]}
    return FILES.index(other) < FILES.index(file) and families != APART


def included(file: str) -> set[str]:
    """Return the files of the plugin that a file includes."""
    sources = [path for suffix in (".c", ".h") if (path := PLUGIN / (file + suffix)).exists()]
    return {include["file"] for path in sources for include in INCLUDE.finditer(path.read_text())} - {file}


def symbols(file: str) -> Iterator[tuple[str, bool]]:
    """Return the global symbols of a compiled file, each with whether it is defined there."""
    path = OBJECTS / f"{file}.c.o"
    if (PLUGIN / f"{file}.c").exists():
        output = subprocess.run(["nm", "-g", "-P", path], check=True, capture_output=True, text=True).stdout
        for line in output.splitlines():
            name, kind = line.split()[:2]
            yield name, kind != "U"


def test_every_file_is_in_the_list() -> None:
    files = {str(path.relative_to(PLUGIN).with_suffix("")) for path in PLUGIN.rglob("*.[ch]")}
    assert set(FILES) == files
    assert len(FILES) == len(files)


def test_every_file_is_built() -> None:
    built = set(re.findall(r"^    ([a-z0-9/-]+)\.c\)?$", (PLUGIN / "CMakeLists.txt").read_text(), re.MULTILINE))
    assert built == {file for file in FILES if (PLUGIN / f"{file}.c").exists()}


def test_includes_look_down() -> None:
    assert [(file, other) for file in FILES for other in included(file) if not may_use(file, other)] == []


def test_symbols_look_down() -> None:
    all_of_them = {file: list(symbols(file)) for file in FILES}
    owners = {name: file for file, found in all_of_them.items() for name, is_defined in found if is_defined}
    taken = [(file, name) for file, found in all_of_them.items() for name, is_defined in found if not is_defined]
    assert [(file, name) for file, name in taken if name in owners and not may_use(file, owners[name])] == []


@pytest.mark.parametrize("family", ["parameters", "sertap"])
def test_a_family_below_knows_no_telegram(family: str) -> None:
    """Other transports use these families without SIS."""
    used = {other.split("/")[0] for file in FILES if file.startswith(f"{family}/") for other in included(file)}
    assert used <= {family, "compat", "kept", "parts", "protocol"}
