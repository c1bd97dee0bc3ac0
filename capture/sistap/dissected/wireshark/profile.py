# SPDX-License-Identifier: GPL-2.0-or-later
"""The profile SIS: a copy in a user's folder, beside the one of this version.

Wireshark itself copies a profile of all users into the user's folder when it is first used, and reads nothing but that
copy from then on.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import sistap

NAME = "SIS"
FOLDER = Path(sistap.__file__).resolve().parent / "profile"
RECENT = "recent"  # written anew whenever Wireshark ends: widths of columns, positions of panes
COLUMNS = "preferences"

_WIDTHS = re.compile(r"^column\.width:.*\n(?:[ \t].*\n?)*", re.MULTILINE)
_FORMAT = re.compile(r'^[ \t]+"?(%[^",]+)"?,', re.MULTILINE)


@cache
def _installed() -> frozenset[str]:
    lines = (FOLDER / "installed").read_text().splitlines()
    return frozenset(line.split()[0] for line in lines if not line.startswith("#"))


def is_as_installed(file: Path) -> bool:
    """Tell whether a file is byte for byte as some version of sistap has installed it."""
    if not file.is_file() or file.is_symlink():
        return False
    return hashlib.sha256(file.read_bytes()).hexdigest() in _installed()


class Copy(NamedTuple):
    """The names of the files in a copy that differ from those of this version."""

    outdated: list[str]  # those of an earlier version; files that are missing here
    changed: list[str]  # by the user


def look(copy: Path, files: Iterable[Path]) -> Copy:
    """Compare a copy with the files of this version. May raise OSError."""
    found = Copy([], [])
    for file in files:
        own = copy / file.name
        if file.name == RECENT or (own.is_file() and own.read_bytes() == file.read_bytes()):
            continue
        (found.outdated if is_as_installed(own) or not own.exists() else found.changed).append(file.name)
    return found


def with_widths(recent: str, of_version: str) -> str:
    """Return `recent` with the widths of this version's columns, unless it has widths of just these columns."""
    old, new = _WIDTHS.search(recent), _WIDTHS.search(of_version)
    if not new or (old and _FORMAT.findall(old[0]) == _FORMAT.findall(new[0])):
        return recent
    return (_WIDTHS.sub("", recent) if old else recent).rstrip("\n") + "\n" + new[0]
