# SPDX-License-Identifier: GPL-2.0-or-later
"""The rooms of sistap use only those that sistap/__init__.py allows; rooms of the virtual bus only those above them."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import sistap
from sistap import bus

PACKAGE, BUS = Path(sistap.__file__).parent, Path(bus.__file__).parent
LOOSE = {"__main__", "cli", "doctor", "selftest"}  # modules that are in no room


def rows(documentation: str | None) -> list[list[str]]:
    """Return the columns of each line of the table in the first lines of a package."""
    return [re.split("  +", line.strip()) for line in (documentation or "").splitlines() if line.startswith("    ")]


def allowed() -> dict[str, set[str]]:
    """Return what each room may use, itself included: the table's rooms, and what these may use."""
    table = [(room, uses) for rooms, uses, _ in rows(sistap.__doc__)[1:] for room in rooms.split(", ")]
    everything = {room for room, _ in table}
    products = {room for room, uses in table if uses == "all above"}
    may: dict[str, set[str]] = {}
    for room, uses in table:
        if uses == "everything":
            may[room] = everything
        elif uses == "all above":
            may[room] = {room} | (may.keys() - products)
        else:
            named = [] if uses == "nothing" else uses.split(", ")
            may[room] = {room}.union(*(may[used] for used in named))
    return may


ALLOWED = allowed()
BUS_ROOMS = [room.rstrip("/") for first, *_ in rows(bus.__doc__) for room in first.split(", ")]


def imported(tree: ast.AST) -> Iterator[str]:
    """Return the modules of sistap that a file imports anywhere, with the names imported from them."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, "an import that begins with a dot hides its room"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def rooms_used(file: Path, package: str) -> set[str]:
    """Return the rooms of a package that one of its files imports from."""
    of_package = [name for name in imported(ast.parse(file.read_text("utf-8"))) if name.startswith(f"{package}.")]
    return {name.removeprefix(f"{package}.").partition(".")[0] for name in of_package} - {"__version__"}


def room_of(file: Path, package: Path) -> str:
    return Path(file.relative_to(package).parts[0]).stem


def there(package: Path) -> set[str]:
    return {path.stem for path in package.iterdir() if path.suffix == ".py" or any(path.glob("*.py"))} - {"__init__"}


def files(package: Path) -> pytest.MarkDecorator:
    return pytest.mark.parametrize(
        "file", sorted(package.rglob("*.py")), ids=lambda file: str(file.relative_to(package))
    )


def test_every_room_is_in_the_table() -> None:
    assert there(PACKAGE) == ALLOWED.keys()
    assert there(BUS) == set(BUS_ROOMS)


def test_no_module_is_outside_of_the_rooms() -> None:
    assert {path.stem for path in PACKAGE.glob("*.py")} == LOOSE | {"__init__"}


def test_every_room_says_what_is_in_it() -> None:
    for room in PACKAGE.rglob("__init__.py"):
        assert ast.get_docstring(ast.parse(room.read_text("utf-8"))), room


@files(PACKAGE)
def test_a_room_uses_only_what_the_table_allows(file: Path) -> None:
    assert rooms_used(file, "sistap") <= ALLOWED.get(room_of(file, PACKAGE), set())


@files(BUS)
def test_a_room_of_the_bus_uses_only_those_above_it(file: Path) -> None:
    room = room_of(file, BUS)
    assert rooms_used(file, "sistap.bus") <= set(BUS_ROOMS[: BUS_ROOMS.index(room) + 1] if room in BUS_ROOMS else [])


@pytest.mark.parametrize(
    "code",
    [
        "import sistap.report.page",
        "from sistap import report",
        "from sistap.report import page",
        "def late():\n    from sistap.report.page import html",
        "if TYPE_CHECKING:\n    import os, sistap.report",
    ],
)
def test_an_import_is_seen_however_it_is_written(tmp_path: Path, code: str) -> None:
    (tmp_path / "file.py").write_text(code)
    assert rooms_used(tmp_path / "file.py", "sistap") == {"report"}


def test_the_readme_names_what_is_there() -> None:
    """Every file in its table exists, and so does every name after a file."""
    text = (PACKAGE.parent / "README.md").read_text("utf-8")
    table = text[text.index("| what you look for |") : text.index("Beside the package")]
    cells = [line.split("|")[2] for line in table.splitlines()[2:] if line]
    found = 0
    for file, names in re.findall(r"`([\w/]+(?:\.py|/))`((?::|, `[A-Za-z_]+`| `[A-Za-z_]+`)*)", " ".join(cells)):
        found += 1
        assert (PACKAGE / file).exists(), file
        for name in re.findall("`(.*?)`", names):
            source = (PACKAGE / file).read_text("utf-8")
            assert re.search(rf"^(def |class |){name}\b", source, re.MULTILINE), (file, name)
    assert found > 60
