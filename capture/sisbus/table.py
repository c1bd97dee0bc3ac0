# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads a table of a scenario key by key. An error is one line with the table, the key and the cure."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime, timedelta
from typing import Any, TypeVar

from sistap.tap.wire.protocol import TIME_END_NS

T = TypeVar("T")
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
Reading = Callable[[Any], T]  # converts a TOML value; ValueError says what is expected


class Misread(ValueError):
    """A table cannot be read; the text says which, the key and the cure."""


class Table:
    """A table, and the keys that were read."""

    def __init__(self, values: object, where: str) -> None:
        """`where` names the table in messages. ValueError if it is not a table."""
        if not isinstance(values, Mapping):
            raise ValueError(f"{where} is not a table: write {{ key = value }}")
        self.where = where
        self._values = values
        self._known: list[str] = []

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def take(self, key: str, reading: Reading[T], default: T) -> T:
        """Return the value of a key, or `default` if it is missing. ValueError if the value is invalid."""
        self._known.append(key)
        return self._read(key, reading) if key in self._values else default

    def need(self, key: str, reading: Reading[T]) -> T:
        """Return the value of a key. ValueError if it is missing or invalid."""
        self._known.append(key)
        if key not in self._values:
            raise Misread(f"{self.where}: {key} is missing")
        return self._read(key, reading)

    def each(self, key: str, where: str, reading: Callable[[Table], T]) -> list[T]:
        """Return what is read of each table in a list, which may be missing."""
        none: list[T] = []
        return self.take(key, each(where, reading), none)

    def one_of(self, keys: Sequence[str]) -> str:
        """Return the value of the one key that is there. ValueError if none or several are."""
        found = [key for key in keys if key in self._values]
        self._known += found
        if len(found) != 1:
            what = f"{found[0]} and {found[1]} do not go together" if found else "a key is missing"
            raise Misread(f"{self.where}: {what}; give one of {', '.join(keys)}")
        return found[0]

    def end(self) -> None:
        """Refuse keys that were not read."""
        for key in self._values:
            if key not in self._known:
                raise Misread(f"{self.where}: unknown key {key}; the keys are {', '.join(dict.fromkeys(self._known))}")

    def _read(self, key: str, reading: Reading[T]) -> T:
        value = self._values[key]
        try:
            return reading(value)
        except Misread:
            raise
        except ValueError as error:
            raise Misread(f"{self.where}: {key} = {_shown(value)}: {error}") from None


def _shown(value: object) -> str:
    text = f'"{value}"' if isinstance(value, str) else str(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def whole(least: int, most: int) -> Reading[int]:
    """Return a reader of a whole number within limits."""

    def read(value: object) -> int:
        if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
            raise ValueError(f"use a whole number from {least} to {most}")
        return value

    return read


BYTE, WORD, LONG = whole(0, 0xFF), whole(0, 0xFFFF), whole(0, 0xFFFFFFFF)
STATION = whole(0, 126)
RATE = whole(75, 4_000_000)  # in Bd; below, the times of a bus would not fit into service 0x03


def number(least: float, most: float) -> Reading[float]:
    """Return a reader of a number within limits."""

    def read(value: object) -> float:
        if not isinstance(value, int | float) or isinstance(value, bool) or not least <= value <= most:
            raise ValueError(f"use a number from {least:g} to {most:g}")
        return float(value)

    return read


def instant_ns(value: object) -> int:
    """Return a date with time and zone as ns since 1970; the file has it without quotation marks."""
    if not isinstance(value, datetime) or value.tzinfo is None:
        raise ValueError(f"{_shown(value)} is no time with a zone (for example 2026-03-14T21:00:00Z)")
    ns = (value - _EPOCH) // timedelta(microseconds=1) * 1000
    if not 0 <= ns < TIME_END_NS:
        raise ValueError(f"{_shown(value)} is not between 1970 and 2095, where all files and sockets can say it")
    return ns


def flag(value: object) -> bool:
    """Read true or false."""
    if not isinstance(value, bool):
        raise ValueError("use true or false")
    return value


def milliseconds(value: object) -> int:
    """Convert a time in ms to ns."""
    return int(number(0, 86_400_000)(value) * 1_000_000)


def seconds(value: object) -> int:
    """Convert a time in s to ns."""
    return int(number(0, 86_400)(value) * 1_000_000_000)


def choice(meanings: Mapping[str, T]) -> Reading[T]:
    """Return a reader of one of several words."""

    def read(value: object) -> T:
        if not isinstance(value, str) or value not in meanings:
            raise ValueError(f"use one of {', '.join(meanings)}")
        return meanings[value]

    return read


def text(value: object) -> str:
    """Read a text."""
    if not isinstance(value, str):
        raise ValueError('use a text in quotes, "..."')
    return value


def ascii_text(longest: int = 0xFFFF) -> Reading[str]:
    """Return a reader of ASCII text up to that length."""

    def read(value: object) -> str:
        if not isinstance(value, str) or not value.isascii() or len(value) > longest:
            raise ValueError(f'use a text of up to {longest} ASCII characters in quotes, "..."')
        return value

    return read


def characters(value: object) -> bytes:
    """Read a text whose characters have one byte each."""
    try:
        return text(value).encode("latin-1")
    except UnicodeEncodeError:
        raise ValueError("use characters of one byte (Latin-1)") from None


def octets(value: object) -> bytes:
    """Read bytes in hexadecimal, with or without spaces."""
    try:
        return bytes.fromhex(text(value))
    except ValueError:
        raise ValueError('use bytes in hexadecimal, "02 1F ..."') from None


def several(reading: Reading[T]) -> Reading[list[T]]:
    """Return a reader of a value, or of a list of such values."""

    def read(value: object) -> list[T]:
        return [reading(item) for item in (value if isinstance(value, list) else [value])]

    return read


def tables(where: str) -> Reading[list[Table]]:
    """Return a reader of a list of tables; each is named by its position."""

    def read(value: object) -> list[Table]:
        if not isinstance(value, list):
            raise ValueError("use a list of tables, [{ ... }, { ... }]")
        return [Table(item, f"{where} {place}") for place, item in enumerate(value, start=1)]

    return read


def each(where: str, reading: Callable[[Table], T]) -> Reading[list[T]]:
    """Return a reader of a list of tables whose keys `reading` must read, all of them."""

    def read(value: object) -> list[T]:
        found = []
        for table in tables(where)(value):
            found.append(reading(table))
            table.end()
        return found

    return read
