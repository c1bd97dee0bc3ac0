# SPDX-License-Identifier: GPL-2.0-or-later
"""What tshark says with the C plugin beside what it says with sis.lua, line by line."""

from __future__ import annotations

import difflib
import re
from itertools import zip_longest
from pathlib import Path

from sistap.tshark import Tshark

SCRIPT = Path(__file__).parent / "sis.lua"

# One element of PDML is one line, with name, text, position, size and value; the first lines name file and time.
_PACKET = re.compile(r"^<packet>$.*?^</packet>$", re.MULTILINE | re.DOTALL)
_SHOWN = 5  # packets that differ


def packets(tshark: Tshark, capture: Path, *options: str) -> list[str]:
    """Give the whole trees of all packets, as PDML. AssertionError if tshark complains."""
    done = tshark.run(["-r", str(capture), *options, "-T", "pdml"])
    assert done.returncode == 0, done.stderr
    assert not done.stderr, done.stderr
    assert "Lua Error" not in done.stdout
    return _PACKET.findall(done.stdout)


def difference(expected: list[str], found: list[str]) -> str:
    """Tell how packets differ: nothing, or how many of them, and the first of them line by line."""
    pairs = list(zip_longest(expected, found, fillvalue=""))
    differing = [(number, *pair) for number, pair in enumerate(pairs, 1) if pair[0] != pair[1]]
    if not differing:
        return ""
    words = [f"{len(differing)} of {len(pairs)} packets differ"]
    for number, one, two in differing[:_SHOWN]:
        words += difflib.unified_diff(one.splitlines(), two.splitlines(), f"{number} C", f"{number} Lua", "", "", 1, "")
    return "\n".join(words)


def compare(plugin: Tshark, script: Tshark, capture: Path, *options: str) -> str:
    """Dissect a capture with both, and give the difference."""
    return difference(packets(plugin, capture, *options), packets(script, capture, *options))
