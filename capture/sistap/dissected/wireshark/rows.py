# SPDX-License-Identifier: GPL-2.0-or-later
"""The rows that tshark prints, one for each packet."""

from __future__ import annotations

import itertools
import re
import struct
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from operator import eq, gt

from sistap.dissected.wireshark.trouble import TsharkError, unknown_fields
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.terminal.console import visible

NO_DISSECTOR = (
    "tshark has no dissector for SIS: `sistap install` puts one where it looks, or name its folder in "
    "WIRESHARK_PLUGIN_DIR"
)
NECESSARY = "sis.start"  # a field that every dissector for SIS has
# The text in the packet list: a column in 4.0, a field of another name since 4.2.
INFO_FIELDS = ("_ws.col.Info", "_ws.col.info")
FRAME, OTHER, EVENT, BEFORE = 0, 1, 2, 3  # sertap.type
JOINT = "\x1f"  # between several values of a field; no text contains it

_TAP = "sis,rows"  # plugin/windows/rows.c
_VERSION = "sis,rows 1"
_HEAD = struct.Struct("=IHH")  # of each entry
_NO_TAP = "Invalid -z argument"
_WANTED = "sis.fields"  # a preference of sis.lua: it makes these fields only

_ODD = re.compile(f"[^ -~\t{JOINT}]")  # may have to be escaped; rare
_USUAL = bytes(byte for byte in range(128) if not _ODD.match(chr(byte)))
_NAMED = {"Bad": "0", "Good": "1", "Unverified": "2", "Not present": "3"}  # checksum.status of later versions


def printing(names: Iterable[str], joint: str = JOINT) -> list[str]:
    """Return the arguments that make tshark print these fields; `joint` separates several values of one."""
    return ["-T", "fields", "-E", f"aggregator={joint}", *(word for name in names for word in ("-e", name))]


def told(
    tshark: Tshark, arguments: Sequence[str], names: Sequence[str]
) -> tuple[list[str], Iterator[tuple[str, bytes]]] | None:
    """Return rows of the plugin's tap, and those of the fields besides that the plugin knows. None: there is no tap.

    Each row is what it has in common with others, as text, and the bytes of its own (plugin/docs/rows.md). TsharkError,
    also after the last row.
    """
    begun = b""
    try:
        pieces = tshark.pieces([*arguments, "-q", "-z", ",".join((_TAP, *names))])
        while b"\n" not in begun:
            begun += next(pieces)
    except StopIteration:
        return None
    except TsharkError as error:
        if _NO_TAP not in str(error):
            raise
        return None
    head, _, rest = begun.partition(b"\n")
    version, *known = head.decode().split("\t")
    return (known, _entries(itertools.chain([rest], pieces))) if version == _VERSION else None


def _entries(pieces: Iterable[bytes]) -> Iterator[tuple[str, bytes]]:
    kinds: dict[int, str] = {}
    data = b""
    for piece in pieces:
        data += piece
        at = 0
        while len(data) - at >= _HEAD.size:
            length, is_row, kind = _HEAD.unpack_from(data, at)
            if at + length > len(data):
                break
            if is_row:
                yield kinds[kind], data[at : at + length]
            else:
                kinds[kind] = data[at + _HEAD.size : at + length].decode(errors="replace")
            at += length
        data = data[at:]


def printed(tshark: Tshark, arguments: Sequence[str], names: Sequence[str]) -> tuple[list[str], Iterator[str]]:
    """Return those of the fields that the installed dissector knows, and a safe row of them for each packet.

    sis.lua has no tap: there `-T fields` prints rows, and takes longer. TsharkError, also after the last row.
    """
    return _printed(tshark, [*arguments, "-o", f"{_WANTED}:{','.join(names)}"], names)


def _printed(tshark: Tshark, arguments: Sequence[str], names: Sequence[str]) -> tuple[list[str], Iterator[str]]:
    try:
        lines = tshark.lines([*arguments, *printing(names), "-E", "header=y"])
        return next(lines, "").split("\t"), map(safe, lines)
    except TsharkError as error:
        if _WANTED in str(error):  # an older dissector
            return _printed(tshark, arguments[:-2], names)
        known = [name for name in names if name not in unknown_fields(str(error))]
        if len(known) == len(names):
            raise
    return _printed(tshark, arguments, known)


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
