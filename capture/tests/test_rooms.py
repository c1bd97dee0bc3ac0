# SPDX-License-Identifier: GPL-2.0-or-later
"""The rooms of sistap use only those that sistap/__init__.py allows; rooms of the virtual bus only those above them."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

import sisbus
import sistap

pytestmark = pytest.mark.style

PACKAGE, BUS = Path(sistap.__file__).parent, Path(sisbus.__file__).parent
LATE = PACKAGE / "tap/capture/running.py"  # it imports explain, when text is shown
TEXT = "sistap.dissected.explain.live.explained"
STOREYS = ("tap", "dissected", "commands")
LOOSE = {"__init__", "__main__", "cli", "library"}  # modules that are in no storey


def rows(documentation: str | None) -> list[list[str]]:
    """Return the columns of each line of the table in the first lines of a package."""
    return [re.split("  +", line.strip()) for line in (documentation or "").splitlines() if line.startswith("    ")]


ROWS = rows(sistap.__doc__)[1:]


def allowed() -> dict[str, set[str]]:
    """Return what each room may use, itself included: the table's rooms, and what these may use."""
    table = [(room.rpartition("/")[2], uses) for rooms, uses, _ in ROWS for room in rooms.split(", ")]
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
# The storey of each room; none for what is in no storey.
STOREY = {room.rpartition("/")[2]: room.rpartition("/")[0] for room, *_ in ROWS}
BUS_ROOMS = [room.rstrip("/") for first, *_ in rows(sisbus.__doc__) for room in first.split(", ")]


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
    return {room_in(name.removeprefix(f"{package}.").split(".")) for name in of_package} - {"__version__"}


def room_in(parts: Sequence[str]) -> str:
    """Return the room of a module or file, from its place in the package: that in a storey, or what is in none."""
    return parts[parts[0] in STOREYS]


def room_of(file: Path, package: Path) -> str:
    return room_in(file.relative_to(package).with_suffix("").parts)


def there(package: Path) -> set[str]:
    return {path.stem for path in package.iterdir() if path.suffix == ".py" or any(path.glob("*.py"))} - {"__init__"}


def test_every_room_is_in_the_table() -> None:
    rooms = {room: storey for storey in STOREYS for room in there(PACKAGE / storey)}
    assert rooms == {room: storey for room, storey in STOREY.items() if storey}
    assert there(BUS) == set(BUS_ROOMS)


def test_no_module_is_outside_of_the_storeys() -> None:
    assert {path.stem for path in PACKAGE.glob("*.py")} == LOOSE
    assert there(PACKAGE) | {"__init__"} == LOOSE.union(STOREYS)


def test_no_room_uses_a_storey_above() -> None:
    for room, uses in ALLOWED.items():
        if STOREY.get(room):
            height = STOREYS.index(STOREY[room])
            assert room == "web" or all(STOREY[used] in STOREYS[: height + 1] for used in uses), room


def test_every_room_says_what_is_in_it() -> None:
    for room in (*PACKAGE.rglob("__init__.py"), *BUS.rglob("__init__.py")):
        assert ast.get_docstring(ast.parse(room.read_text("utf-8"))), room


def test_a_room_uses_only_what_the_table_allows() -> None:
    for file in PACKAGE.rglob("*.py"):
        may = {"library"} if file == PACKAGE / "__init__.py" else ALLOWED.get(room_of(file, PACKAGE), set())
        if file == LATE:
            assert [name for name in imported(ast.parse(file.read_text("utf-8"))) if "explain" in name] == [TEXT]
            may = {*may, "explain"}
        assert rooms_used(file, "sistap") <= may, file


def test_a_room_of_the_bus_uses_only_those_above_it() -> None:
    for file in BUS.rglob("*.py"):
        room = room_of(file, BUS)
        above = BUS_ROOMS[: BUS_ROOMS.index(room) + 1] if room in BUS_ROOMS else []
        assert rooms_used(file, "sisbus") <= set(above), file


def test_the_bus_has_one_door() -> None:
    for file in PACKAGE.rglob("*.py"):
        names = {name for name in imported(ast.parse(file.read_text("utf-8"))) if name.startswith("sisbus")}
        assert all(f"{name}.".startswith("sisbus.library.") for name in names), file
        assert not names or room_of(file, PACKAGE) in ("library", "extcap", "install", "web"), file


def test_the_bus_uses_the_tap_attributes_and_for_replay_captures() -> None:
    for file in BUS.rglob("*.py"):
        above = {"captures"} if file == BUS / "replay.py" else {"telegrams"}
        assert rooms_used(file, "sistap") <= rooms_used(file, "sistap.tap") | above, file
        assert rooms_used(file, "sistap.dissected") <= above, file


TAP = ("terminal", "sis", "line", "records", "files", "capture")
MOST_LINES, MOST_MODULES = 8250, 41
MODULES = """
import contextlib, io, sys
from sistap import cli
with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
    cli.main(sys.argv[1:])
print(*sorted(name for name in sys.modules if name.partition(".")[0] == "sistap"))
"""


def loaded(*arguments: str) -> list[str]:
    """Return the modules of sistap that a command has loaded when it ends."""
    command = [sys.executable, "-c", MODULES, *arguments]
    return subprocess.run(command, cwd=PACKAGE.parent, capture_output=True, text=True, check=True).stdout.split()


def test_the_tap_is_small_and_stands_alone() -> None:
    """What is generated does not count. One module imports text, and only to show it."""
    lines = 0
    for file in (file for room in TAP for file in (PACKAGE / "tap" / room).rglob("*.py")):
        text = file.read_text("utf-8")
        if "\nMade by plugin/protocol/generate.py" not in text:
            lines += text.count("\n")
        assert rooms_used(file, "sistap") <= {*TAP} | ({"explain"} if file == LATE else set()), file
    assert lines < MOST_LINES


@pytest.mark.parametrize("command", ["capture", "report"])
def test_help_loads_little(command: str) -> None:
    assert len(loaded(command, "--help")) <= MOST_MODULES


def test_a_capture_loads_the_tap_alone(tmp_path: Path) -> None:
    names = [name.split(".")[1:] for name in loaded("capture", "-i", str(tmp_path), "-w", "x")]
    assert {room_in(name) for name in names if name and name != ["tap"]} == {*TAP, "cli"}


@pytest.mark.parametrize(
    "code",
    [
        "import sistap.commands.report.page",
        "from sistap import report",
        "from sistap.commands.report import page",
        "def late():\n    from sistap.commands.report.page import html",
        "if TYPE_CHECKING:\n    import os, sistap.commands.report",
    ],
)
def test_an_import_is_seen_however_it_is_written(tmp_path: Path, code: str) -> None:
    (tmp_path / "file.py").write_text(code)
    assert rooms_used(tmp_path / "file.py", "sistap") == {"report"}
