# SPDX-License-Identifier: GPL-2.0-or-later
"""The results of self-tests: where they are kept, and when they still hold.

One file in the user's state folder has a list of results. A result holds only under exactly the conditions of its
measurement. Anything else in the file is skipped with one line, never an error.
"""

from __future__ import annotations

import json
import platform
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from sistap.tap.line import priority
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN
from sistap.tap.terminal import state

MACHINE = "machine"  # the place of a result that holds for every port

_NAME = "selftest.json"
_LARGEST_FILE = 1_000_000  # bytes; sistap writes no larger file
_KEPT = 50  # results

Conditions = dict[str, str]


class Result(NamedTuple):
    """One self-test: how late characters were seen."""

    place: str  # MACHINE, or the identity of a port (ports.identity)
    date: str  # "2026-11-21", local
    characters: int
    p999_ns: int
    longest_ns: int
    conditions: Conditions


def conditions(**more: str) -> Conditions:
    """Return what a result depends on: this computer, its kernel, the present priority, and conditions of the port."""
    return {"machine": platform.node(), "kernel": platform.release(), "priority": priority.words(), **more}


def file() -> Path:
    """Return the path of the results. RuntimeError if this user has no home."""
    return state.folder() / _NAME


def load() -> tuple[list[Result], str]:
    """Return all results, newest last, and a message if the file cannot be used."""
    try:
        path = file()
        if not path.exists():
            return [], ""
        if state.is_root():
            state.check(path)
        return [_checked(Result(**entry)) for entry in json.loads(_text(path))["results"]], ""
    except (ValueError, TypeError, KeyError, RecursionError):
        return [], f"{path} is not what `sistap selftest` writes and is ignored: run it again to replace the file"
    except (OSError, RuntimeError) as error:
        return [], f"the result of the last self-test cannot be read and is ignored: {error}"


def store(result: Result) -> Path:
    """Add a result, replacing one with the same conditions; return the file. May raise OSError or RuntimeError."""
    path = file()
    others = [old for old in load()[0] if (old.place, old.conditions) != (result.place, result.conditions)]
    kept = [old._asdict() for old in [*others, result][-_KEPT:]]
    return state.save(path.name, (json.dumps({"results": kept}, indent=2) + "\n").encode())


def forget() -> None:
    """Remove all results."""
    state.forget(_NAME)


def fitting(results: Iterable[Result], place: str, now: Conditions) -> tuple[Result | None, str]:
    """Return the newest result of a place that holds now, or a message why none of its results holds."""
    of_place = [result for result in results if result.place == place]
    for result in reversed(of_place):
        if result.conditions == now:
            return result, ""
    if not of_place:
        return None, ""
    newest = of_place[-1]
    others = [
        f"{name} {newest.conditions.get(name, 'not known')}, now {value}"
        for name, value in now.items()
        if newest.conditions.get(name) != value
    ]
    return None, f"the self-test of {newest.date} does not hold here ({'; '.join(others)}): run `sistap selftest` again"


def _text(path: Path) -> str:
    if not path.is_file() or path.stat().st_size > _LARGEST_FILE:  # reading a pipe would block
        raise ValueError
    return path.read_bytes().decode()


def _checked(result: Result) -> Result:
    if not isinstance(result.conditions, dict):
        raise TypeError
    texts = (result.place, result.date, *result.conditions, *result.conditions.values())
    numbers = (result.characters, result.p999_ns, result.longest_ns)
    if not all(isinstance(text, str) for text in texts) or not all(type(number) is int for number in numbers):
        raise TypeError
    if not 0 < result.p999_ns <= result.longest_ns < UNCERTAINTY_UNKNOWN or result.characters <= 0:
        raise ValueError
    return result
