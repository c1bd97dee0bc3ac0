# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes the mutants of a module: each is its source with one small fault (operators.py).

It skips code that cannot change behaviour, and code that cannot run here. The rules below define both.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Collection, Iterator
from typing import NamedTuple

from operators import OPERATORS, is_named_number

Step = tuple[str, int | None]  # a field of a syntax node, and the index in it if it is a list

# Annotations and the like; operators and contexts have no fault of their own.
UNCHANGED_FIELDS = {"annotation", "returns", "decorator_list", "bases", "keywords", "op", "ops", "ctx", "type_params"}
UNCHANGED_NAMES = {"__slots__", "__all__"}


class Mutant(NamedTuple):
    """A fault: its place, and the replacement."""

    line: int
    steps: tuple[Step, ...]  # from the module to the replaced node
    new: ast.AST
    function: str  # in which it is

    def key(self, source: str) -> str:
        """Return what it is known by: its function, its line and the replacement. No code elsewhere changes that."""
        return f"{self.function}: {source.splitlines()[self.line - 1].strip()} -> {ast.dump(self.new)}"


def mutants(source: str, functions: Collection[str] = ()) -> list[Mutant]:
    """Return all mutants of a module; with `functions`, only those inside functions of these names."""
    return list(_visit(_parsed(source), (), functions, ""))


def mutated(source: str, mutant: Mutant) -> str:
    """Return the source of the mutant."""
    return ast.unparse(_replaced(source, mutant))


def difference(source: str, mutant: Mutant) -> tuple[str, str]:
    """Return the statement with the fault, before and after; of a block, only its first line."""
    return _statement(_parsed(source), mutant), _statement(_replaced(source, mutant), mutant)


class _Here(ast.NodeTransformer):
    """Keeps only code that can run here: nothing for another system, nothing for the type checker only."""

    def visit_If(self, node: ast.If) -> ast.AST | list[ast.stmt]:  # noqa: N802 - a name of ast
        """Replace an `if` by the branch that runs, if that is known."""
        self.generic_visit(node)
        is_run = False if "TYPE_CHECKING" in ast.unparse(node.test) else _platform_is(node.test)
        return node if is_run is None else node.body if is_run else node.orelse or [ast.Pass()]

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.AST:  # noqa: N802 - a name of ast
        """Remove tests of the system that are constant here."""
        self.generic_visit(node)
        neutral = isinstance(node.op, ast.And)
        node.values = [value for value in node.values if _platform_is(value) is not neutral]
        return node.values[0] if len(node.values) == 1 else node


def _parsed(source: str) -> ast.Module:
    tree = ast.parse(source)
    _Here().visit(tree)
    return ast.fix_missing_locations(tree)


def _replaced(source: str, mutant: Mutant) -> ast.Module:
    tree = _parsed(source)
    owner = _at(tree, mutant.steps[:-1])
    field, index = mutant.steps[-1]
    if index is None:
        setattr(owner, field, mutant.new)
    else:
        getattr(owner, field)[index] = mutant.new
    return ast.fix_missing_locations(tree)


def _at(node: ast.AST, steps: tuple[Step, ...]) -> ast.AST:
    for field, index in steps:
        node = getattr(node, field) if index is None else getattr(node, field)[index]
    return node


def _statement(tree: ast.Module, mutant: Mutant) -> str:
    whole = [_at(tree, mutant.steps[:length]) for length in range(1, len(mutant.steps) + 1)]
    statement = next(node for node in reversed(whole) if isinstance(node, ast.stmt))
    lines = ast.unparse(statement).splitlines()
    return next(line for line in lines if not line.startswith("@"))


def _visit(node: ast.AST, steps: tuple[Step, ...], wanted: Collection[str], function: str) -> Iterator[Mutant]:
    """Yield the mutants of a node and its descendants; `function` is its function, `wanted` the functions to mutate."""
    if _does_nothing(node):
        return
    if isinstance(node, ast.FunctionDef):
        function = node.name
        wanted = () if function in wanted else wanted
    if not wanted and type(node) in OPERATORS:
        assert isinstance(node, ast.expr | ast.stmt)
        for new in OPERATORS[type(node)](node):
            # A missing attribute of __init__ is always noticed.
            if not (function == "__init__" and isinstance(node, ast.Assign) and isinstance(new, ast.Pass)):
                yield Mutant(node.lineno, steps, new, function)
    for step, child in _children(node):
        yield from _visit(child, (*steps, step), wanted, function)


def _children(node: ast.AST) -> Iterator[tuple[Step, ast.AST]]:
    """Yield the child nodes that can run."""
    if is_named_number(node) or isinstance(node, ast.Raise):  # texts of exceptions are messages
        return
    for field, value in ast.iter_fields(node):
        if field in UNCHANGED_FIELDS:
            continue
        if isinstance(value, ast.AST):
            yield (field, None), value
        elif isinstance(value, list):
            items = value[:2] if _is_getattr(node) and field == "args" else value
            yield from (((field, i), item) for i, item in enumerate(items) if isinstance(item, ast.AST))


def _does_nothing(node: ast.AST) -> bool:
    """Tell whether no fault in this node can change the program's behaviour."""
    match node:
        case ast.Import() | ast.ImportFrom() | ast.Assert() | ast.Expr(ast.Constant()):  # the last: a docstring
            return True
        case ast.Assign([ast.Name(name)]):
            return name in UNCHANGED_NAMES
    return _platform_is(node) is not None


def _platform_is(test: ast.AST) -> bool | None:
    """Return the value of `sys.platform == "..."` here; None for any other expression."""
    if not isinstance(test, ast.Compare) or not isinstance(test.comparators[0], ast.Constant):
        return None
    if ast.unparse(test.left) != "sys.platform":
        return None
    return bool(sys.platform == test.comparators[0].value) == isinstance(test.ops[0], ast.Eq)


def _is_getattr(node: ast.AST) -> bool:
    """Tell whether this is a getattr: its fallback is for other systems."""
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "getattr"
