# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds what can be installed, in a checkout or in an installed package, and for which Wireshark."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import sistap
from sistap.dissected.wireshark.profile import NAME
from sistap.dissected.wireshark.tshark import Version
from sistap.tap.terminal.exits import FAILED, Refusal, why

PACKAGE = Path(sistap.__file__).resolve().parent

_BUILDS = ("build/plugin/sis.so", "build/*/plugin/sis.so")  # cmake -B build, -B build/plugin
_BUILD = (
    "`cmake -S . -B build/plugin && cmake --build build/plugin` in a checkout builds it for the Wireshark whose "
    "headers are installed"
)


_VERSION = "sis.version"  # cmake writes it beside the module: the version of Wireshark that this is for
_OF_A_PLUGIN = b"plugin_want_major"  # a name that each has


class Dissector(NamedTuple):
    """The module or the script to install."""

    file: Path
    is_module: bool
    notes: list[str]  # modules that were skipped, and why


def lua() -> Path:
    """Return sis.lua. Raise Refusal."""
    for file in (PACKAGE / "sis.lua", _checkout() / "lua-fallback/sis.lua"):
        if file.is_file():
            return file
    raise Refusal(f"sis.lua is missing beside {PACKAGE}: install sistap again, or run it from a whole checkout", FAILED)


def executable() -> Path | None:
    """Return sistap.exe, the launcher for Windows: from the package, or as capture/launcher/build has made it."""
    places = (PACKAGE / "sistap.exe", _checkout() / "build/windows/sistap.exe")
    return next((file for file in places if file.is_file()), None)


def profile() -> list[Path]:
    """Return the files of the profile. Raise Refusal."""
    files = sorted((PACKAGE / "profile" / NAME).glob("*"))
    if not files:
        raise Refusal(f"the profile is missing in {PACKAGE}: install sistap again", FAILED)
    return files


def dissector(named: Path | None, wireshark: Version) -> Dissector:
    """Choose the module that the user named, else one built here that fits this Wireshark, else sis.lua.

    Refusal if there is none at all, or if it is not known what the named file is for.
    """
    notes = []
    for file in [named] if named else _built():
        try:
            wanted = _wanted_version(file)
        except Refusal as error:
            if named:
                raise
            notes.append(str(error))
            continue
        if wanted == (wireshark.major, wireshark.minor):
            return Dissector(file, True, notes)
        notes.append(f"{file} was built for Wireshark {wanted[0]}.{wanted[1]}, this is {wireshark.text}: {_BUILD}")
    return Dissector(lua(), False, notes)


def _wanted_version(module: Path) -> tuple[int, int]:
    """Return the major and minor version of the Wireshark that a module needs. Raise Refusal."""
    try:
        major, minor, *_ = (module.parent / _VERSION).read_text("utf-8").split(".")
        wanted = int(major), int(minor)
    except (OSError, ValueError):
        raise Refusal(f"{module} has no {_VERSION} beside it: name one as cmake makes it, or copy both") from None
    try:
        if _OF_A_PLUGIN in module.read_bytes():
            return wanted
    except OSError as error:
        raise Refusal(f"cannot read {module}: {why(error)}") from None
    raise Refusal(f"{module} is no plugin of Wireshark: build it again")


def _built() -> Iterator[Path]:
    """Return what cmake has built in this checkout, newest first."""
    found = [file for pattern in _BUILDS for file in _checkout().glob(pattern)]
    return iter(sorted(found, key=lambda file: file.stat().st_mtime, reverse=True))


def _checkout() -> Path:
    """Return the root of the checkout, if this is one."""
    return PACKAGE.parents[1]
