# SPDX-License-Identifier: GPL-2.0-or-later
"""Text from elsewhere (a drive, an adapter, a file and its name), made safe to print.

A terminal obeys control characters, and some Unicode marks reverse the text after them. Then a text seems to say
something else. So invisible characters are shown as Python escapes them in a string: \\x1b, \\u202e.
"""

from __future__ import annotations

_FIRST_BYTE, _LAST_BYTE = 0xDC80, 0xDCFF  # how Python decodes a byte of a name that is not UTF-8


def visible(text: str, keep: str = "") -> str:
    """Escape invisible characters, and those that look like a space; leave the characters in `keep`."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep else _escape(c) for c in text)


def _escape(character: str) -> str:
    code = ord(character)
    if _FIRST_BYTE <= code <= _LAST_BYTE:
        return f"\\x{code & 0xFF:02x}"
    return character.encode("unicode_escape").decode()
