# SPDX-License-Identifier: GPL-2.0-or-later
"""The glossary, with the words of other languages behind the English ones.

glossary.LANGUAGE.txt has the name of its language as its first line, `# German`, and lines such as
`Checksum = Prüfsumme (CS)`. Who wants another language adds a file.
"""

from __future__ import annotations

import re

from pages import HERE

TEXT = HERE / "glossary.md"
_WORD = re.compile(r"^- \*\*(.+?)\*\*", re.MULTILINE)


def words() -> list[str]:
    """Return the words that the glossary explains."""
    return _WORD.findall(TEXT.read_text())


def languages() -> dict[str, dict[str, str]]:
    """Return the words of each language by the English ones. ValueError if a line has no such form."""
    found = {}
    for path in sorted(HERE.glob("glossary.*.txt")):
        name, *lines = path.read_text().splitlines()
        pairs = [line.split(" = ") for line in lines if line]
        if not name.startswith("# ") or any(len(pair) != 2 for pair in pairs):
            raise ValueError(f"{path.name} begins with # LANGUAGE, and has lines such as Checksum = Prüfsumme (CS)")
        found[name.removeprefix("# ")] = dict(pairs)
    return found


def text() -> str:
    """Return the Markdown, without its title."""
    others = languages()

    def beside(match: re.Match[str]) -> str:
        known = [f"{name}: {there[match[1]]}" for name, there in others.items() if match[1] in there]
        said = re.sub(r" \(([^)]*)\)", r", \1", "; ".join(known))
        return f"{match[0]} ({said})" if said else match[0]

    return _WORD.sub(beside, TEXT.read_text().partition("\n")[2])
