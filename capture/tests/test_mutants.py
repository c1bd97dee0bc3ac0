# SPDX-License-Identifier: GPL-2.0-or-later
"""The mutants that `./bootstrap check` makes: what they change, what they leave alone, which are chosen."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest

CAPTURE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(CAPTURE / "mutants"))

import making_c  # noqa: E402
from covering import PARTS, Part  # noqa: E402
from making import difference, mutants, mutated  # noqa: E402


def made(source: str, *functions: str) -> set[str]:
    """Return the mutants of one line."""
    return {difference(source, mutant)[1] for mutant in mutants(source, functions)}


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("x = a < b", {"x = a <= b"}),
        ("x = a == b", {"x = a != b"}),
        ("x = a + b", {"x = a - b"}),
        ("x = a | b", {"x = a & b", "x = a", "x = b"}),
        ("x = a and b", {"x = a or b", "x = a", "x = b"}),
        ("x = not a", {"x = a"}),
        ("x = 5", {"x = 6", "x = 4"}),
        ("x = 0.5", {"x = 1.0", "x = 0.25"}),
        ("x = True", {"x = False"}),
        ("LIMIT = 100", {"LIMIT = 200", "LIMIT = 50"}),
        ("LIMIT = 4096", {"LIMIT = 8192", "LIMIT = 2048"}),
        ("CODE = 101", {"CODE = 102", "CODE = 100"}),
        ("x += a", {"x -= a", "pass"}),
        ("f(a)", {"pass"}),
        ("x.y = a", {"pass"}),
        ("del a", {"pass"}),
        ("raise E(1 + 1)", {"pass"}),
        ("if a: b", {"if not a:"}),
        ("while a > b: c", {"while a >= b:", "while not a > b:"}),
        ("x = a if b else c", {"x = a if not b else c"}),
    ],
)
def test_what_is_changed(line: str, expected: set[str]) -> None:
    assert made(line) == expected


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("return a", {"return None"}),
        ("return a > b", {"return a >= b", "return not a > b"}),
        ("return a is b", {"return a is not b"}),
        ("return True", {"return False"}),
        ("return", set()),
        ("return None", set()),
    ],
)
def test_what_is_returned(statement: str, expected: set[str]) -> None:
    assert made(f"def f():\n    {statement}") == expected


@pytest.mark.parametrize("jump", ["break", "continue"])
def test_a_jump_goes_to_the_other_end(jump: str) -> None:
    assert made(f"for x in y:\n    {jump}") == {"break", "continue"} - {jump}


@pytest.mark.parametrize(
    "source",
    [
        "'''A text with 1 + 1.'''",
        "import a",
        "from a import b",
        "assert a > 1",
        "x: Literal[1] | None",
        "def f(a: Literal[1] | None) -> Literal[2] | None: 'text'",
        "__slots__ = (1, 2)",
        "x = 'text' + y",
        "x = 0.0",
        "if TYPE_CHECKING:\n    x = 1",
        "if sys.platform == 'win32':\n    x = 1",
        "if sys.platform != 'win32':\n    pass\nelse:\n    x = 1",
        "class C:\n    def __init__(self):\n        self.x = y",
        "x = getattr(y, 'z', 0)",
        "x = sys.platform == 'win32'",
    ],
)
def test_what_cannot_matter_is_left_alone(source: str) -> None:
    assert made(source) == set()


def test_code_for_this_system_is_changed() -> None:
    assert made("if sys.platform != 'win32' and a:\n    b = 1") == {"if not a:", "b = 2", "b = 0"}


def test_only_some_functions() -> None:
    source = "x = 1\nclass C:\n    def f(self):\n        y = 2\n    def g(self):\n        z = 3"
    assert made(source, "g") == {"z = 4", "z = 2"}


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("if (a < b && !c)", {"if (a <= b && !c)", "if (a < b || !c)", "if (a < b && c)"}),
        ("x = a + 1;", {"x = a - 1;", "x = a + 2;"}),
        ("x->y = true;", {"x->y = false;", ";"}),
        ("f(&a); /* 1 < 2 */", {"; /* 1 < 2 */"}),
        ("continue;", {";"}),
        ('x = "a < 1";', set()),
        ("x = (int *)&y[-i];", set()),
    ],
)
def test_what_is_changed_in_c(line: str, expected: set[str]) -> None:
    source = f"static int x = 1;\nint\nf(int a)\n{{\n    {line}\n}}\n"
    found = making_c.mutants(source)
    assert {making_c.difference(source, one)[1] for one in found} == expected
    assert all(making_c.mutated(source, one).count("\n") == 6 and one.function == "f" for one in found)
    assert making_c.mutants(source, "g") == []


def test_other_code_does_not_move_a_choice() -> None:
    source = "def f(a):\n    return a + 1"
    elsewhere = f"B = 7\ndef g(b):\n    return b - 2\n{source}"
    keys = {mutant.key(source) for mutant in mutants(source)}
    assert len(keys) == 4
    assert keys == {one.key(elsewhere) for one in mutants(elsewhere) if one.function == "f"}


@pytest.mark.style
@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.module)
def test_the_table_of_the_engine(part: Part) -> None:
    assert all((CAPTURE / "tests" / name).exists() for name in part.tests)
    source = (CAPTURE / part.module).read_text()
    if part.is_c:
        assert making_c.mutants(source)
        return
    found = mutants(source, part.functions)
    assert found
    for mutant in found[::40]:
        before, after = difference(source, mutant)
        assert before != after
        assert after in mutated(source, mutant)
    named = {node.name for node in ast.walk(ast.parse(source)) if isinstance(node, ast.FunctionDef)}
    assert set(part.functions) <= named
