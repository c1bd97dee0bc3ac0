#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes from the description (the .toml files beside it) all that the other languages of the project have of it.

Run it without arguments after a change of the description. A test says when a file is stale.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import in_c
import in_lua
import in_markdown
import in_profile
import in_python
from description import HERE, Description

HOUSE = HERE.parent.parent
SCRIPT = HOUSE / "lua-fallback" / "sis.lua"
SISTAP = HOUSE / "capture" / "sistap"
GRAPHS = SISTAP / "profile" / "SIS" / "io_graphs"


def _between(whole: str, name: str, block: str) -> str:
    """Return a text with a new block between two marks. ValueError if the marks are missing."""
    begin, end = rf"^(?:--- {name}: made by .*?\n|# {name}: made by [^\n]*)\n", rf"^(?:--|#) end of {name}\n"
    marks = re.compile(rf"({begin}).*?({end})", re.MULTILINE | re.DOTALL)
    text, count = marks.subn(lambda found: found[1] + block + found[2], whole)
    if count != 1:
        raise ValueError(f"the marks of {name} are missing")
    return text


def _script(description: Description) -> str:
    """Return sis.lua with its blocks renewed."""
    text = SCRIPT.read_text("utf-8")
    for name in ("protocols", "codes", "limits", "services", "names", "fields"):
        text = _between(text, name, getattr(in_lua, name)(description))
    return text


def _graphs(description: Description) -> str:
    """Return the profile's file of I/O graphs with its block renewed."""
    return _between(GRAPHS.read_text("utf-8"), "faults", in_profile.io_graphs(description))


def made(description: Description) -> Iterator[tuple[Path, str]]:
    """Return each file that the description makes, with its contents."""
    for name in ("codes_h", "codes_c", "limits_h", "services_h", "services_c", "fields_h", "fields_c"):
        yield HERE / name.replace("_", "."), getattr(in_c, name)(description)
    yield SCRIPT, _script(description)
    yield HERE.parent / "REFERENCE.md", in_markdown.reference(description)
    for name in ("codes", "faults", "names"):
        yield SISTAP / "tap/sis" / f"{name}.py", getattr(in_python, name)(description)
    yield SISTAP / "dissected/episodes/standard.py", in_python.standard(description)
    for name in ("colorfilters", "dfilter_buttons"):
        yield GRAPHS.with_name(name), getattr(in_profile, name)(description)
    yield GRAPHS, _graphs(description)


def main() -> None:
    """Write what has changed."""
    description = Description()
    for path, text in made(description):
        if not path.exists() or path.read_text("utf-8") != text:
            path.write_text(text, "utf-8")
            print(f"wrote {path.relative_to(HOUSE)}")


if __name__ == "__main__":
    main()
