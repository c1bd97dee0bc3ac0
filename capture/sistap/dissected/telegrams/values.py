# SPDX-License-Identifier: GPL-2.0-or-later
"""Values of parameters: their bytes on the bus (IEC 61491; low byte first), as a backup writes them, as a number."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable, Mapping
from datetime import UTC, datetime, timedelta
from decimal import Decimal
from functools import lru_cache

from sistap.dissected.telegrams.attribute import LENGTH_WORDS, Attribute, Format

_KINDS = {"S": 0, "P": 0x8000}
_DECIMAL = re.compile(r"[+-]?(\d{1,40}(\.\d{1,40})?|\.\d{1,40})", re.ASCII)  # some backups write .80
_UTC = re.compile(r"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d)(?:\.(\d{1,9}))?Z", re.ASCII)
_1970 = datetime(1970, 1, 1, tzinfo=UTC)


class Unreadable(Exception):
    """A text is no value of its attribute; the text says why."""


def _number(text: str, attribute: Attribute) -> bytes:
    if not _DECIMAL.fullmatch(text):
        raise ValueError
    raw = Decimal(text).scaleb(attribute.decimals) / attribute.factor
    return round(raw).to_bytes(attribute.size, "little", signed=attribute.format == Format.SIGNED)


def _bits(text: str, attribute: Attribute) -> bytes:
    return int(text.replace(".", ""), 2).to_bytes(attribute.size, "little")


def _hexadecimal(text: str, attribute: Attribute) -> bytes:
    return int(text, 16).to_bytes(attribute.size, "little")


def _ident(text: str, attribute: Attribute) -> bytes:
    found = re.fullmatch(r"([SP])-([0-7])-(\d{4})(?:\.(\d+)\.(\d+))?", text)
    if not found or int(found[3]) > 0xFFF:
        raise ValueError
    structure = int(found[4] or 0) << 24 | int(found[5] or 0) << 16
    return (structure | _KINDS[found[1]] | int(found[2]) << 12 | int(found[3])).to_bytes(attribute.size, "little")


def _float(text: str, attribute: Attribute) -> bytes:
    return struct.pack("<d" if attribute.size == 8 else "<f", float(text))


def _time(text: str, attribute: Attribute) -> bytes:
    """Return four bytes of seconds since 1970, then four of nanoseconds (mlpiParameterLib.h of Rexroth's MLPI)."""
    found = _UTC.fullmatch(text)
    if not found or attribute.size != 8:
        raise ValueError
    seconds = int((datetime.fromisoformat(f"{found[1]}+00:00") - _1970).total_seconds())
    return struct.pack("<II", seconds, int((found[2] or "").ljust(9, "0")))


_WRITTEN: Mapping[int, tuple[Callable[[str, Attribute], bytes], str]] = {
    Format.BINARY: (_bits, "binary digits such as 0000.0001"),
    Format.UNSIGNED: (_number, "a number"),
    Format.SIGNED: (_number, "a number"),
    Format.HEXADECIMAL: (_hexadecimal, "a hexadecimal number such as 0x12AB"),
    Format.IDENT_NUMBER: (_ident, "an ident such as S-0-0001"),
    Format.FLOAT: (_float, "a number"),
    Format.TIME: (_time, "a time such as 2026-11-23T21:00:00.5Z"),
}


def encoded(attribute: Attribute, text: str) -> bytes | None:
    """Return the bytes of a value; None if it is not known how such values are written. Raise Unreadable."""
    if attribute.is_text:
        return text.encode("latin-1", errors="replace")
    write, what = _WRITTEN.get(attribute.format, (None, ""))
    if write is None or attribute.size == 0:
        return None
    try:
        return write(text, attribute)
    except (ValueError, OverflowError, struct.error):
        raise Unreadable(f"'{text}' is not {what} of {attribute.size} bytes") from None


def without_lengths(attribute: Attribute, data: bytes) -> bytes:
    """Return the elements of a list without the two length words that may stand before them."""
    actual, most = int.from_bytes(data[:2], "little"), int.from_bytes(data[2:4], "little")
    has_lengths = attribute.is_list and len(data) == actual + LENGTH_WORDS and actual <= most
    return data[LENGTH_WORDS:] if has_lengths else data


def _decoded_one(attribute: Attribute, data: bytes) -> str:
    raw = int.from_bytes(data, "little", signed=attribute.format == Format.SIGNED)
    if attribute.format in (Format.UNSIGNED, Format.SIGNED):
        return f"{Decimal(raw * attribute.factor).scaleb(-attribute.decimals):.{attribute.decimals}f}"
    if attribute.format == Format.BINARY:
        return ".".join(re.findall("....", f"{raw:0{attribute.size * 8}b}"))
    if attribute.format == Format.IDENT_NUMBER and attribute.size in (2, 4):
        structure = f".{raw >> 24}.{raw >> 16 & 0xFF}" if raw >> 16 else ""
        return f"{'P' if raw & 0x8000 else 'S'}-{raw >> 12 & 7}-{raw & 0xFFF:04}{structure}"
    if attribute.format == Format.FLOAT and attribute.size in (4, 8):
        return f"{struct.unpack('<d' if attribute.size == 8 else '<f', data)[0]:.7g}"
    if attribute.format == Format.TIME and attribute.size == 8 and raw >> 32 < 1_000_000_000:
        seconds, ns = struct.unpack("<II", data)
        return f"{_1970 + timedelta(seconds=seconds):%Y-%m-%dT%H:%M:%S}.{ns:09}Z"
    return f"0x{raw:0{attribute.size * 2}X}"


def decoded(attribute: Attribute, data: bytes) -> str | None:
    """Return bytes as a backup writes them; None if they do not fit the attribute."""
    if attribute.is_text:
        return data.decode("latin-1")
    if attribute.size == 0 or len(data) % attribute.size or (not attribute.is_list and len(data) != attribute.size):
        return None
    return ", ".join(
        _decoded_one(attribute, data[at : at + attribute.size]) for at in range(0, len(data), attribute.size)
    )


Value = int | float | str


@lru_cache(4096)
def value(attribute: Attribute, data: bytes) -> Value | None:
    """Return a number, or a text: lists, idents and times as a backup writes them. None if the bytes do not fit."""
    elements = without_lengths(attribute, data)
    text = None if attribute.is_list and elements is data else decoded(attribute, elements)
    if text is None or attribute.is_list:
        return text
    if attribute.format in (Format.BINARY, Format.HEXADECIMAL):
        return int.from_bytes(data, "little")
    if text.startswith("0x"):  # no document describes such values of this length
        return None
    if attribute.format in (Format.IDENT_NUMBER, Format.TIME):
        return text
    return float(text) if attribute.decimals or attribute.format == Format.FLOAT else int(text)


def shown_limit(attribute: Attribute, limit: str, unit: str) -> str:
    """Return a limit of a backup as the dissector shows it: binary digits in groups, numbers with their unit."""
    try:
        data = encoded(attribute, limit) if limit else None
    except Unreadable:
        data = None
    shown = limit if data is None else decoded(attribute, data) or limit
    if data is not None and attribute.format == Format.BINARY:
        return "0b" + shown.replace(".", " ")
    return f"{shown} {unit}" if shown and unit and attribute.has_unit else shown


def same(attribute: Attribute, one: bytes, other: bytes) -> bool:
    """Tell whether two values are equal; floating point only as exactly as people write it."""
    if attribute.format != Format.FLOAT or len(one) != len(other) or len(one) != attribute.size:
        return one == other
    numbers = (struct.unpack("<d" if attribute.size == 8 else "<f", data)[0] for data in (one, other))
    return math.isclose(*numbers, rel_tol=1e-6)
