# SPDX-License-Identifier: GPL-2.0-or-later
"""The folders of a Wireshark, as `tshark -G folders` names them on every system."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from sistap.dissected.wireshark.trouble import TsharkError


class Folders(NamedTuple):
    """The folders for each kind of file."""

    plugins: Path  # C modules, for this minor version only
    lua: Path
    extcap: Path
    profiles: Path


# The possible names of each folder (the first found counts), and the path below it. Before 4.2 the personal extcap
# folder is part of the configuration folder and has no name.
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
    """Return the folders of this user, or those for all users, from the output of `tshark -G folders`. Raise
    TsharkError.
    """
    named = _named(text)
    return Folders(**{kind: _first(named, places) for kind, places in (_GLOBAL if for_all else _PERSONAL).items()})


class Own:
    """Wireshark's own folders, of this user or for all users. Nothing outside of them is removed.

    The exception is `others`, which are not Wireshark's.
    """

    def __init__(self, text: str, *, for_all: bool, others: Iterable[Path] = ()) -> None:
        """Parse the output of `tshark -G folders`. TsharkError if it lacks them."""
        parse(text, for_all=for_all)
        named = _named(text)
        names = {name for places in (_GLOBAL if for_all else _PERSONAL).values() for name, _ in places}
        own = [Path(named[name]) for name in sorted(names) if named.get(name)]
        self._folders = [folder.resolve() for folder in (*own, *others)]

    @classmethod
    def of(cls, folders: Iterable[Path]) -> Own:
        """Make it of folders that are known without tshark."""
        own = cls.__new__(cls)
        own._folders = [folder.resolve() for folder in folders]
        return own

    def have(self, file: Path) -> bool:
        """Tell whether a file is in one of them or below, after resolving links."""
        folder = file.parent.resolve()
        return file.is_absolute() and any(folder.is_relative_to(own) for own in self._folders)

    def are_below(self, folder: Path) -> bool:
        """Tell whether a folder is one of them, or above or below one: install makes missing parents."""
        place = folder.resolve()
        return folder.is_absolute() and any(
            place.is_relative_to(own) or own.is_relative_to(place) for own in self._folders
        )


def _named(text: str) -> dict[str, str]:
    named: dict[str, str] = {}
    for line in text.splitlines():
        name, separator, path = line.partition(":")
        if line and not separator:
            raise TsharkError(_strange(line))
        named.setdefault(name.strip(), path.strip())
    return named


def _strange(path: str) -> str:
    """Say that a path is relative, or has a line break: then it would lead to another folder."""
    return (
        f"Wireshark's folders cannot be told from '{path}': set HOME and XDG_CONFIG_HOME to absolute paths in one line"
    )


def _first(named: dict[str, str], places: tuple[tuple[str, str], ...]) -> Path:
    for name, below in places:
        if named.get(name):
            if not (folder := Path(named[name])).is_absolute():
                raise TsharkError(_strange(named[name]))
            return folder / below
    raise TsharkError(f"`tshark -G folders` names no {places[0][0]}: install Wireshark 4.0 or later")
