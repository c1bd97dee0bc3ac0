# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes the codes and texts of plugin/sis/names.c into sis.lua, between its two marks.

Run it without arguments after changing names.c. A test checks that sis.lua is current.
"""

from __future__ import annotations

import re
from pathlib import Path

HERE = Path(__file__).parent
SCRIPT = HERE / "sis.lua"
NAMES = HERE.parent / "plugin" / "sis" / "names.c"
BEGIN = "--- names: made by names.py from plugin/sis/names.c; edit there\n"
END = "-- end of what names.py has made\n"

COMMENT = re.compile(r"/\*(.*?)\*/\n", re.DOTALL)
TABLE = re.compile(r"const (?P<kind>range|value)_string sis_(?P<name>\w+)\[\] = \{\n?(?P<entries>.*?)\};", re.DOTALL)
ENTRY = re.compile(r'\{(?P<codes>[^"]+), (?P<text>"[^"]*")\}')
LAST = re.compile(r"\{0, (0, )?NULL\}")
KINDS = re.compile(r"typedef enum \{(?P<kinds>[^}]+)\} sis_address_kind_t;")


def _comment(above: str) -> list[str]:
    """Convert the C comment directly above a table into a Lua comment."""
    words = " ".join(COMMENT.findall(above)[-1].split())
    return [f"-- {words}"] if len(words) <= 115 else _wrapped(words)


def _wrapped(words: str) -> list[str]:
    cut = words.rindex(" ", 0, 115)
    return [f"-- {words[:cut]}", *_comment(f"/*{words[cut:]}*/\n")]


def _entry(kind: str, codes: str, text: str) -> str:
    first, *last = (code.replace("SIS_", "K.") for code in codes.split(", "))
    return f"  {{{first}, {last[0]}, {text}}}," if kind == "range" else f"  [{first}] = {text},"


def section(names: str, header: str) -> str:
    """Return the section of sis.lua, including marks, from the text of names.c and of names.h.

    Ranges become {first, last, text}, in order; other codes become keys. ValueError if a table cannot be read.
    """
    kinds = KINDS.search(header)
    if kinds is None:
        raise ValueError("names.h has no sis_address_kind_t")
    lines = ["-- What kinds of addresses there are; this order counts."]
    for number, kind in enumerate(re.findall(r"SIS_(\w+)", kinds["kinds"])):
        lines.append(f"K.{kind} = {number}")
    end = 0
    for table in TABLE.finditer(names):
        lines += ["", *_comment(names[end : table.start()]), f"N.{table['name']} = {{"]
        lines += [_entry(table["kind"], entry["codes"], entry["text"]) for entry in ENTRY.finditer(table["entries"])]
        lines += ["}"]
        end = table.end()
        if "{" in LAST.sub("", ENTRY.sub("", table["entries"])):
            raise ValueError(f"an entry of sis_{table['name']} cannot be read")
    return "\n".join([BEGIN, *lines, "", END])


def current() -> str:
    """Return the section as the sources have it now."""
    return section(NAMES.read_text(), NAMES.with_suffix(".h").read_text())


def main() -> None:
    """Put the section in place of the one that sis.lua has."""
    before, rest = SCRIPT.read_text().split(BEGIN)
    after = rest.split(END)[1]
    SCRIPT.write_text(before + current() + after)


if __name__ == "__main__":
    main()
