# SPDX-License-Identifier: GPL-2.0-or-later
"""Packed files: told from others, and how to unpack them."""

from __future__ import annotations

import re
from pathlib import Path

from sistap.terminal.advice import shell_word

_PACKED = {
    rb"\xfd7zXZ\x00": "xz -dk",
    rb"\x1f\x8b": "gunzip -k",
    rb"BZh[1-9]1A": "bunzip2 -k",
    rb"PK\x03\x04": "unzip",
    rb"7z\xbc\xaf": "7z x",
}


def unpack(path: Path) -> str:
    """Return how to unpack a packed file; empty if it is not packed, or cannot be read."""
    try:
        if not path.is_file():  # opening a pipe would wait for a writer
            return ""
        with path.open("rb") as file:
            head = file.read(6)
    except OSError:
        return ""
    command = next((command for magic, command in _PACKED.items() if re.match(magic, head)), "")
    return f"{path} is packed: unpack it first, for example with `{command} {shell_word(str(path))}`" if command else ""
