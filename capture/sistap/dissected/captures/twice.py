# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds a capture that is named twice: all in it would count twice, or would be compared with itself.

A copy of its beginning is found, too; not one of its middle or its end, nor one that is damaged.
"""

from __future__ import annotations

import filecmp
from collections.abc import Hashable, Iterable
from itertools import zip_longest
from pathlib import Path

from sistap.dissected.captures import reading
from sistap.tap.terminal.exits import NotCaptured, Refusal

_HEADING = 1 << 16  # bytes


def check_once(captures: Iterable[Path]) -> None:
    """Refusal if one of them is there twice."""
    if reason := twice(captures):
        raise Refusal(f"{reason}: name it once, or it counts twice")


def twice(captures: Iterable[Path]) -> str:
    """Say which one is there twice: by any name, or as a copy, perhaps of its beginning. Empty if none is."""
    seen: dict[Hashable, list[Path]] = {}
    for capture in captures:
        beginning = _beginning(capture)
        if beginning is None:
            continue
        alike = seen.setdefault(beginning, [])
        for other in alike:
            if capture == other or _is_same(capture, other):
                return f"{capture} is named twice"
            if again := _again(capture, other):
                return f"{again[0]} is in {again[1]}, too"
        alike.append(capture)
    return ""


def _beginning(capture: Path) -> Hashable:
    """Return what all copies of a capture begin with. None: it has no packets, or cannot be read."""
    try:
        first = next(reading.packets(capture), None)
        return first and first[:3]
    except NotCaptured:
        return _heading(capture)
    except OSError:
        return None


def _heading(capture: Path) -> bytes | None:
    try:
        with capture.open("rb") as file:
            return file.read(_HEADING)
    except OSError:
        return None


def _is_same(capture: Path, other: Path) -> bool:
    """Tell whether they are one file, also through links."""
    try:
        return capture.samefile(other)
    except OSError:  # a ring has deleted it by now
        return False


def _again(capture: Path, other: Path) -> tuple[Path, Path] | None:
    """Return which one is in which one, if they begin alike."""
    try:
        for here, there in zip_longest(reading.packets(capture), reading.packets(other)):
            if here is None or there is None:
                return (capture, other) if here is None else (other, capture)
            if here[:3] != there[:3]:
                return None
    except NotCaptured:
        return (capture, other) if _is_copy(capture, other) else None
    except OSError:
        return None
    return capture, other


def _is_copy(capture: Path, other: Path) -> bool:
    try:
        return filecmp.cmp(capture, other, shallow=False)
    except OSError:
        return False
