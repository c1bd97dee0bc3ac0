# SPDX-License-Identifier: GPL-2.0-or-later
"""The rows that tshark prints, one for each packet, and its messages about damaged captures."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from operator import eq, gt
from pathlib import Path

from sistap.dissected.wireshark.tshark import Tshark, TsharkError
from sistap.tap.common.packed import no_capture
from sistap.tap.terminal.console import visible
from sistap.tap.terminal.exits import Error

NO_DISSECTOR = (
    "tshark has no dissector for SIS: `sistap install` puts one where it looks, or name its folder in "
    "WIRESHARK_PLUGIN_DIR"
)
NECESSARY = "sis.start"  # a field that every dissector for SIS has
# The text in the packet list: a column in 4.0, a field of another name since 4.2.
INFO_FIELDS = ("_ws.col.Info", "_ws.col.info")
FRAME, OTHER, EVENT, BEFORE = 0, 1, 2, 3  # sertap.type
JOINT = "\x1f"  # between several values of a field; no text contains it

_TAP = "sis,rows"  # plugin/sis/rows.c
_NO_TAP = "Invalid -z argument"

_ODD = re.compile(f"[^ -~\t{JOINT}]")  # may have to be escaped; rare
_USUAL = bytes(byte for byte in range(128) if not _ODD.match(chr(byte)))
_NAMED = {"Bad": "0", "Good": "1", "Unverified": "2", "Not present": "3"}  # checksum.status of later versions
_CUT = ("cut short", "damaged")
_NOT_A_CAPTURE = "isn't a capture file"


class NotACapture(Error):
    """tshark cannot read the file; the text is the line to show."""


def printing(names: Iterable[str], joint: str = JOINT) -> list[str]:
    """Return the arguments that make tshark print these fields; `joint` separates several values of one."""
    return ["-T", "fields", "-E", f"aggregator={joint}", *(word for name in names for word in ("-e", name))]


def told(tshark: Tshark, arguments: Sequence[str], names: Sequence[str]) -> tuple[list[str], Iterator[str]]:
    """Return those of the fields that the installed dissector knows, and a safe row of them for each packet.

    The plugin's tap makes these fields only and no words. sis.lua has none: there `-T fields` prints the same rows, and
    takes longer. TsharkError, also after the last row.
    """
    try:
        known, lines = _headed(tshark.lines([*arguments, "-q", "-z", ",".join((_TAP, *names))]))
    except TsharkError as error:
        if _NO_TAP not in str(error):
            raise
        known, lines = _printed(tshark, arguments, names)
        return known, map(safe, lines)
    return known, (line if line.isascii() else safe(line) for line in lines)  # the tap escapes what ASCII has


def _printed(tshark: Tshark, arguments: Sequence[str], names: Sequence[str]) -> tuple[list[str], Iterator[str]]:
    try:
        return _headed(tshark.lines([*arguments, *printing(names), "-E", "header=y"]))
    except TsharkError as error:
        known = [name for name in names if name not in unknown_fields(str(error))]
        if len(known) == len(names):
            raise
    return _printed(tshark, arguments, known)


def _headed(lines: Iterator[str]) -> tuple[list[str], Iterator[str]]:
    return next(lines, "").split("\t"), lines


def columns(names: Sequence[str], line: str) -> dict[str, str]:
    """Split what tshark prints for one packet, and make its text safe."""
    return dict(zip(names, safe(line).split("\t"), strict=False))


def safe(line: str) -> str:
    """Make a text of tshark safe: it may come from elsewhere."""
    is_odd = line.encode(errors="surrogatepass").translate(None, _USUAL)  # takes a third of the time of a search
    return _ODD.sub(lambda found: visible(found[0]), line) if is_odd else line


def tested(tests: Iterable[str]) -> list[str]:
    """Return the fields of tests: FIELD (it is there), FIELD == NUMBER, or FIELD > NUMBER."""
    return list(dict.fromkeys(test.partition(" ")[0] for test in tests))


def passes(tests: Iterable[str], columns: Mapping[str, str]) -> bool:
    """Tell whether a packet passes one of the tests, as their display filter does: one value of a field is enough."""
    for test in tests:
        field, _, wanted = test.partition(" ")
        text = columns.get(field)
        if text and (not wanted or _compares(wanted, text)):
            return True
    return False


@lru_cache(1024)
def _compares(wanted: str, text: str) -> bool:
    operator, number = wanted.split()
    compare = {"==": eq, ">": gt}[operator]
    values = (_NAMED.get(value, value) for value in text.split(JOINT) if value)
    return any(compare(int(value, 0), int(number, 0)) for value in values)


def first(text: str) -> str:
    """Return the first of several values."""
    return text.partition(JOINT)[0]


def info(columns: dict[str, str]) -> str:
    """Return the text in the packet list; its own escapes (`\\r` for a carriage return) stay.

    A field is escaped once more when it is printed, a column is not.
    """
    column, field = INFO_FIELDS
    return columns.get(column) or columns.get(field, "").replace("\\\\", "\\")


def unknown_fields(said: str) -> set[str]:
    """Return the fields that tshark refuses as unknown, from its message."""
    return set(re.findall(r"^\s+(\S+)$", said, re.MULTILINE)) if "fields aren't valid" in said else set()


def is_no_capture(error: TsharkError) -> bool:
    """Tell whether tshark failed because the file is not a capture."""
    return _NOT_A_CAPTURE in str(error)


def is_cut(error: TsharkError) -> bool:
    """Tell whether tshark failed at the end of a capture that is cut off or damaged."""
    return any(words in str(error) for words in _CUT)


def last_words(error: TsharkError, capture: str = "the capture") -> str:
    """Return the last line of tshark's message, with `capture` as its name: as root, tshark reads a copy."""
    return re.sub(r'The file "[^"]*"', capture, str(error).splitlines()[-1].removeprefix("tshark: "))


def damage(capture: Path, error: TsharkError, came: bool) -> str:
    """Describe the damage of a capture at whose end tshark failed; `came`: tshark printed something before.

    NotACapture if it is none, TsharkError if tshark failed for another reason.
    """
    if is_no_capture(error):
        raise NotACapture(no_capture(capture)) from None
    last = last_words(error)
    if not came and not is_cut(error):
        raise TsharkError(f"tshark: {last}") from None
    return last
