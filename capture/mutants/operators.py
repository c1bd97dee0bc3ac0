# SPDX-License-Identifier: GPL-2.0-or-later
"""The changes of mutants: small faults that a tired programmer could make, one in each mutant.

An operator takes a syntax node and yields possible replacements. It never changes the node itself.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator

COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.FloorDiv,
    ast.FloorDiv: ast.Mult,
    ast.Div: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.Pow: ast.Mult,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.BitXor: ast.BitAnd,
}
OPPOSITES = (ast.Eq, ast.NotEq, ast.Is, ast.IsNot, ast.In, ast.NotIn)  # of each other


def compared(node: ast.Compare) -> Iterator[ast.expr]:
    """Change a comparison at its border, or to its opposite."""
    for i, old in enumerate(node.ops):
        new = COMPARISONS[type(old)]()
        yield ast.Compare(node.left, [*node.ops[:i], new, *node.ops[i + 1 :]], node.comparators)


def calculated(node: ast.BinOp) -> Iterator[ast.expr]:
    """Replace an arithmetic or bit operator, or remove one of several flags."""
    if not any(_is_text(side) for side in (node.left, node.right)) and type(node.op) in ARITHMETIC:
        yield ast.BinOp(node.left, ARITHMETIC[type(node.op)](), node.right)
    if isinstance(node.op, ast.BitOr):
        yield from (node.left, node.right)


def assigned_with(node: ast.AugAssign) -> Iterator[ast.stmt]:
    """Replace the operator of `+=` and the like, or remove the statement."""
    if type(node.op) in ARITHMETIC and not _is_text(node.value):
        yield ast.AugAssign(node.target, ARITHMETIC[type(node.op)](), node.value)
    yield ast.Pass()


def joined(node: ast.BoolOp) -> Iterator[ast.expr]:
    """Swap `and` and `or`, or remove one of the conditions."""
    yield ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)
    for i in range(len(node.values)):
        rest = [*node.values[:i], *node.values[i + 1 :]]
        yield rest[0] if len(rest) == 1 else ast.BoolOp(node.op, rest)


def unary(node: ast.UnaryOp) -> Iterator[ast.expr]:
    """Remove `not`, `-` or `~`."""
    yield node.operand


def constant(node: ast.Constant) -> Iterator[ast.expr]:
    """Change a number by one, double or halve a fraction, swap True and False; texts are only messages and names.

    Twice 0.0 is 0.0.
    """
    if isinstance(node.value, bool):
        yield ast.Constant(not node.value)
    elif isinstance(node.value, int):
        yield ast.Constant(node.value + 1)
        yield ast.Constant(node.value - 1)
    elif isinstance(node.value, float) and node.value:
        yield from _scaled(node.value)


def named_number(node: ast.Assign) -> Iterator[ast.stmt]:
    """Double or halve a round number with a name: one more or less would be as good."""
    if is_named_number(node) and isinstance(node.value, ast.Constant):
        for value in _scaled(node.value.value):
            yield ast.Assign(node.targets, value)


def is_named_number(node: ast.AST) -> bool:
    """Tell whether this is NAME = 100 or a larger number that ends with 0 or is a power of 2."""
    return (
        isinstance(node, ast.Assign)
        and isinstance(node.targets[0], ast.Name)
        and node.targets[0].id.isupper()
        and isinstance(node.value, ast.Constant)
        and type(node.value.value) is int
        and node.value.value >= 100
        and (node.value.value % 10 == 0 or node.value.value.bit_count() == 1)
    )


def negated(node: ast.If | ast.While | ast.IfExp) -> Iterator[ast.AST]:
    """Negate a condition."""
    if not _is_swapped(node.test):
        yield type(node)(**dict(ast.iter_fields(node)) | {"test": ast.UnaryOp(ast.Not(), node.test)})


def left_out(node: ast.stmt) -> Iterator[ast.stmt]:
    """Remove a statement."""
    yield ast.Pass()


def called(node: ast.Expr) -> Iterator[ast.stmt]:
    """Remove a call whose value is not used."""
    if isinstance(node.value, ast.Call):
        yield ast.Pass()


def kept(node: ast.Assign) -> Iterator[ast.stmt]:
    """Remove an assignment to something that outlives the function; a missing local is always noticed."""
    yield from named_number(node)
    if all(isinstance(target, ast.Attribute | ast.Subscript) for target in node.targets):
        yield ast.Pass()


def jumped(node: ast.Break | ast.Continue) -> Iterator[ast.stmt]:
    """Swap `break` and `continue`."""
    yield ast.Continue() if isinstance(node, ast.Break) else ast.Break()


def returned(node: ast.Return) -> Iterator[ast.stmt]:
    """Return the opposite of a condition, otherwise nothing."""
    value = node.value
    if value is None or isinstance(value, ast.Constant) or _is_swapped(value):
        return
    condition = isinstance(value, ast.Compare | ast.BoolOp)
    yield ast.Return(ast.UnaryOp(ast.Not(), value) if condition else ast.Constant(None))


OPERATORS: dict[type[ast.AST], Callable[..., Iterator[ast.AST]]] = {
    ast.Compare: compared,
    ast.BinOp: calculated,
    ast.AugAssign: assigned_with,
    ast.BoolOp: joined,
    ast.UnaryOp: unary,
    ast.Constant: constant,
    ast.If: negated,
    ast.While: negated,
    ast.IfExp: negated,
    ast.Expr: called,
    ast.Assign: kept,
    ast.Delete: left_out,
    ast.Raise: left_out,
    ast.Break: jumped,
    ast.Continue: jumped,
    ast.Return: returned,
}


def _is_swapped(condition: ast.expr) -> bool:
    """Tell whether another operator already makes the opposite of this."""
    if isinstance(condition, ast.Compare):
        return len(condition.ops) == 1 and isinstance(condition.ops[0], OPPOSITES)
    return isinstance(condition, ast.UnaryOp) and isinstance(condition.op, ast.Not)


def _is_text(node: ast.expr) -> bool:
    """Tell whether this is certainly text or bytes, from which nothing can be subtracted."""
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str | bytes))


def _scaled(value: float) -> Iterator[ast.Constant]:
    yield ast.Constant(value * 2)
    yield ast.Constant(value // 2 if isinstance(value, int) else value / 2)
