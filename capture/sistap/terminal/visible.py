# SPDX-License-Identifier: GPL-2.0-or-later
"""Text that somebody else has chosen (a drive, an adapter, a file and its name), made fit for a line.

A terminal obeys control characters, and a page turns around what follows some marks of Unicode: then a text says
something else than what is in it. So what cannot be seen is shown as Python writes it in a string: \\x1b, \\u202e.
"""

from __future__ import annotations

_FIRST_BYTE, _LAST_BYTE = 0xDC80, 0xDCFF  # as which Python reads a byte of a name that is no UTF-8


def visible(text: str, keep: str = "") -> str:
    """Show what cannot be seen, and what is no space but looks like one; leave the characters in `keep`."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep else _escape(c) for c in text)


def _escape(character: str) -> str:
    code = ord(character)
    if _FIRST_BYTE <= code <= _LAST_BYTE:
        return f"\\x{code & 0xFF:02x}"
    return character.encode("unicode_escape").decode()
