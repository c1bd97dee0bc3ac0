# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes the mutants of a file in C: one token of a function is another one, or a statement is missing.

It reads lines as clang-format leaves them: a function begins with its name in the first column, and only operators with
two sides have spaces around them.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from typing import NamedTuple

_FUNCTION = re.compile(r"(\w+)\(")
_TEXT = re.compile(r'/\*.*?\*/|"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])*\'', re.DOTALL)
_SWAPPED = {
    **{"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "&&": "||", "||": "&&"},
    **{"+": "-", "-": "+", "+=": "-=", "-=": "+=", "&": "|", "|": "&", "|=": "&="},
}
_OPERATOR = re.compile(f"(?<= )({'|'.join(map(re.escape, sorted(_SWAPPED, key=len, reverse=True)))})(?= )")
_WORD = re.compile(r"\b(true|false|\d+)\b|!(?=[\w(])")
_KEPT = re.compile(r"(\w+(?:->|\.)[\w.>\[\]-]+ [-+|&]?= .*|\w+\(.*\)|continue|break);")  # outlives its line


class Change(NamedTuple):
    """A fault: its place, and the replacement."""

    line: int
    column: int
    old: str
    new: str
    function: str

    def key(self, source: str) -> str:
        """Return what it is known by: its function, its line and the replacement. No code elsewhere changes that."""
        line = source.splitlines()[self.line - 1].strip()
        return f"{self.function}: {line} -> {self.old} {self.new}"


def mutants(source: str, functions: Collection[str] = ()) -> list[Change]:
    """Return all mutants of a file; with `functions`, only those inside functions of these names."""
    found: list[Change] = []
    function = ""
    for number, line in enumerate(_TEXT.sub(_blank, source).splitlines(), 1):
        if begun := _FUNCTION.match(line):
            function = begun[1]
        if line[:1].isspace() and function and (not functions or function in functions):
            found += (Change(number, *change, function) for change in _of_line(line))
        elif line.startswith("}"):
            function = ""
    return found


def mutated(source: str, mutant: Change) -> str:
    """Return the source of the mutant."""
    lines = source.splitlines(keepends=True)
    line = lines[mutant.line - 1]
    lines[mutant.line - 1] = line[: mutant.column] + mutant.new + line[mutant.column + len(mutant.old) :]
    return "".join(lines)


def difference(source: str, mutant: Change) -> tuple[str, str]:
    """Return the line with the fault, before and after."""
    before, after = (text.splitlines()[mutant.line - 1].strip() for text in (source, mutated(source, mutant)))
    return before, after


def _blank(found: re.Match[str]) -> str:
    """Make a comment or a text spaces of the same length."""
    return re.sub(r"[^\n]", " ", found[0])


def _of_line(line: str) -> Iterator[tuple[int, str, str]]:
    """Yield column, old and new text of the faults in a line."""
    for found in _OPERATOR.finditer(line):
        yield found.start(), found[0], _SWAPPED[found[0]]
    for found in _WORD.finditer(line):
        word = found[0]
        other = {"true": "false", "false": "true", "!": ""}
        yield found.start(), word, other[word] if word in other else str(int(word) + 1)
    if whole := _KEPT.fullmatch(line.strip()):
        yield len(line) - len(line.lstrip()), whole[0], ";"
