# SPDX-License-Identifier: GPL-2.0-or-later
"""Packed files: told from others, and how to unpack them; recordings of logic analysers are zips, too."""

from __future__ import annotations

import re
from pathlib import Path
from zipfile import BadZipFile, ZipFile

from sistap.terminal.advice import shell_word

_PACKED = {
    rb"\xfd7zXZ\x00": "xz -dk",
    rb"\x1f\x8b": "gunzip -k",
    rb"BZh[1-9]1A": "bunzip2 -k",
    rb"PK\x03\x04": "unzip",
    rb"7z\xbc\xaf": "7z x",
}
# The recordings of logic analysers among zips, by a file in them.
_RECORDINGS = {
    "metadata": "is a session of sigrok: `sistap import` reads it",
    "header": "is a session of DSView: `sistap import` reads it",
    "meta.json": "is a capture of Saleae Logic 2: export its raw data there, as CSV; `sistap import` reads that",
}


def unpack(path: Path) -> str:
    """Return what to do with a packed file; empty if it is not packed, or cannot be read."""
    try:
        if not path.is_file():  # opening a pipe would wait for a writer
            return ""
        with path.open("rb") as file:
            head = file.read(6)
    except OSError:
        return ""
    names = _names(path) if head.startswith(b"PK") else []
    if recording := next((what for name, what in _RECORDINGS.items() if name in names), ""):
        return f"{path} {recording}"
    if head.startswith(b"PK\x03\x04") and not names:
        return f"{path} is a damaged zip: copy it again from where it was recorded"
    command = next((command for magic, command in _PACKED.items() if re.match(magic, head)), "")
    return f"{path} is packed: unpack it first, for example with `{command} {shell_word(str(path))}`" if command else ""


def _names(path: Path) -> list[str]:
    """Return what is in a zip."""
    try:
        with ZipFile(path) as archive:
            return archive.namelist()
    except (BadZipFile, OSError):
        return []
