# SPDX-License-Identifier: GPL-2.0-or-later
"""The lines of a log: time, sender and bytes, with the explanation below."""

from __future__ import annotations

from sistap.dissected.explain.fields import EXPLANATION
from sistap.tap.common.calendar import local

_DIRECTIONS = {1: "RX  ", 2: "TX  "}


def stamp(seconds: int, ns: int) -> str:
    """Return local time with its zone; empty for 0, the time of a log without times, and for one in no calendar."""
    then = local(seconds) if seconds or ns else None
    return f"{then:%Y-%m-%d %H:%M:%S}.{ns:09d}{then:%z}  " if then else ""


def head(stamp: str, line: int) -> str:
    """Return the text before the bytes."""
    return stamp + _DIRECTIONS.get(line, "")


def under(head: str, text: str) -> str:
    """Return the line that explains the bytes after such a head."""
    return f"{' ' * len(head)}{EXPLANATION}{text}\n"
