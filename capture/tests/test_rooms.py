# SPDX-License-Identifier: GPL-2.0-or-later
"""The rooms of the virtual bus: each knows only those that sistap/bus/__init__.py has above it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from sistap import bus

BUS = Path(bus.__file__).parent
LINES = [line.split("  ")[2] for line in (bus.__doc__ or "").splitlines() if line.startswith("    ")]
ROOMS = [room.rstrip("/") for line in LINES for room in line.split(", ")]


def imported(file: Path) -> Iterator[str]:
    """The rooms that a file imports from, wherever in it."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("sistap.bus"):
            package = node.module.split(".")[2:]
            yield from package[:1] or [alias.name for alias in node.names]


def test_every_room_is_in_the_list() -> None:
    there = {path.stem for path in BUS.iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()}
    assert there - {"__init__"} == set(ROOMS)


@pytest.mark.parametrize("file", sorted(BUS.rglob("*.py")), ids=lambda file: str(file.relative_to(BUS)))
def test_arrows_go_one_way(file: Path) -> None:
    room = Path(file.relative_to(BUS).parts[0]).stem
    allowed = ROOMS[: ROOMS.index(room) + 1] if room in ROOMS else []
    assert set(imported(file)) <= set(allowed)
