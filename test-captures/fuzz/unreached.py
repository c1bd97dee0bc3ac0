#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Compares the lines of the plugin that nothing reaches with unreached.toml, which says why.

python3 unreached.py PLUGIN LCOV...    PLUGIN is the folder of the sources; what any LCOV counts is reached
"""

from __future__ import annotations

import sys
import tomllib
from bisect import bisect_right
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

LIST = Path(__file__).with_suffix(".toml")
DONE, FAILED = 0, 1


class Place(NamedTuple):
    """A function of a source: the name lives longer than the number of a line."""

    file: str
    function: str

    def __str__(self) -> str:
        """Return it as a person reads it."""
        return f"{self.file} {self.function}()"


class Coverage:
    """How often each line was reached, and where the functions begin."""

    def __init__(self, plugin: Path) -> None:
        """Count nothing yet. Lines of other folders, such as the fuzzer itself, are left out."""
        self._plugin = plugin
        self._counts: dict[str, Counter[int]] = defaultdict(Counter)
        self._functions: dict[str, dict[int, str]] = defaultdict(dict)

    def add(self, lines: Iterable[str]) -> None:
        """Take what `llvm-cov export -format=lcov` says."""
        file = ""
        for line in lines:
            word, _, text = line.rstrip("\n").partition(":")
            if word == "SF":
                path = Path(text)
                file = path.relative_to(self._plugin).as_posix() if path.is_relative_to(self._plugin) else ""
            elif file and word == "FN":
                begin, _, name = text.partition(",")
                self._functions[file][int(begin)] = name.rpartition(":")[2]  # a static one has its file before it
            elif file and word == "DA":
                number, count = map(int, text.split(",")[:2])
                self._counts[file][number] += count

    @property
    def all(self) -> int:
        """Return how many lines can be reached."""
        return sum(map(len, self._counts.values()))

    def unreached(self) -> dict[Place, list[int]]:
        """Return the numbers of the lines that nothing has reached."""
        found: dict[Place, list[int]] = defaultdict(list)
        for file, counts in sorted(self._counts.items()):
            begins = sorted(self._functions[file])
            for number in sorted(number for number, count in counts.items() if not count):
                begin = begins[bisect_right(begins, number) - 1]
                found[Place(file, self._functions[file][begin])].append(number)
        return found


def explained(text: str) -> dict[Place, int]:
    """Return how many lines of each function the list explains."""
    return {
        Place(file, function): lines
        for kind in tomllib.loads(text)["kind"]
        for file, functions in kind["lines"].items()
        for function, lines in functions.items()
    }


def differences(unreached: Mapping[Place, list[int]], listed: Mapping[Place, int], plugin: Path) -> Iterator[str]:
    """Yield where the list is wrong, with the lines that nothing explains."""
    for place in sorted({*unreached, *listed}):
        numbers, expected = unreached.get(place, []), listed.get(place, 0)
        if len(numbers) != expected:
            yield f"{place}: {len(numbers)} lines are not reached, the list has {expected}"
            if len(numbers) > expected:
                text = (plugin / place.file).read_text("utf-8").splitlines()
                yield from (f"    {number}: {text[number - 1].strip()}" for number in numbers)


def main(plugin: str, *reports: str) -> int:
    """Print the differences; return the exit code."""
    coverage = Coverage(Path(plugin))
    for report in reports:
        with Path(report).open(encoding="utf-8") as lines:
            coverage.add(lines)
    unreached = coverage.unreached()
    found = list(differences(unreached, explained(LIST.read_text("utf-8")), Path(plugin)))
    reached = coverage.all - sum(map(len, unreached.values()))
    print(*found, f"coverage: {reached} of {coverage.all} lines are reached", sep="\n")
    return FAILED if found else DONE


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
