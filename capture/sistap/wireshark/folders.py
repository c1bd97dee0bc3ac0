# SPDX-License-Identifier: GPL-2.0-or-later
"""Where a Wireshark looks: what `tshark -G folders` says is the one truth, on every system."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple


class FoldersError(Exception):
    """A folder that is needed is not named; the text is the one line to show."""


class Folders(NamedTuple):
    """Where to put what."""

    plugins: Path  # modules in C, of this minor version only
    lua: Path
    extcap: Path
    profiles: Path


# Each folder by the names it can have, the first that is there, and what comes below it. Before 4.2 the personal
# folder of extcaps is part of the configuration and not named.
_PERSONAL = {
    "plugins": (("Personal Plugins", "epan"),),
    "lua": (("Personal Lua Plugins", ""),),
    "extcap": (("Personal Extcap path", ""), ("Personal configuration", "extcap")),
    "profiles": (("Personal configuration", "profiles"),),
}
_GLOBAL = {
    "plugins": (("Global Plugins", "epan"),),
    "lua": (("Global Lua Plugins", ""),),
    "extcap": (("Global Extcap path", ""), ("Extcap path", "")),
    "profiles": (("Global configuration", "profiles"),),
}


def parse(text: str, *, for_all: bool) -> Folders:
    """Find the folders of this user, or those for all users, in the output of `tshark -G folders`. FoldersError."""
    named = _named(text)
    return Folders(**{kind: _first(named, places) for kind, places in (_GLOBAL if for_all else _PERSONAL).items()})


class Own:
    """The folders that are Wireshark's own, of this user or for all users: nothing outside of them is removed.

    But in `others`, which are no folders of Wireshark.
    """

    def __init__(self, text: str, *, for_all: bool, others: Iterable[Path] = ()) -> None:
        """Take the output of `tshark -G folders`. FoldersError if it does not name them."""
        parse(text, for_all=for_all)
        named = _named(text)
        names = {name for places in (_GLOBAL if for_all else _PERSONAL).values() for name, _ in places}
        own = [Path(named[name]) for name in sorted(names) if named.get(name)]
        self._folders = [folder.resolve() for folder in (*own, *others)]

    def have(self, file: Path) -> bool:
        """Tell whether a file is in one of them, or further down, whatever links lead there."""
        folder = file.parent.resolve()
        return file.is_absolute() and any(folder.is_relative_to(own) for own in self._folders)

    def are_below(self, folder: Path) -> bool:
        """Tell whether a folder is one of them, above one or in one: install makes what is missing on the way."""
        place = folder.resolve()
        return folder.is_absolute() and any(
            place.is_relative_to(own) or own.is_relative_to(place) for own in self._folders
        )


def _named(text: str) -> dict[str, str]:
    named: dict[str, str] = {}
    for line in text.splitlines():
        name, _, path = line.partition(":")
        named.setdefault(name.strip(), path.strip())
    return named


def _first(named: dict[str, str], places: tuple[tuple[str, str], ...]) -> Path:
    for name, below in places:
        if named.get(name):
            return Path(named[name]) / below
    raise FoldersError(f"`tshark -G folders` names no {places[0][0]}: install Wireshark 4.0 or later")
