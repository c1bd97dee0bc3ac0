# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables of Saleae's Async Serial analyser, from Logic 1 and Logic 2, in the form that its source code defines.

A frame begins with its start bit and ends in the middle of its stop bit.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from sistap.commands.imports.sampled import HEXADECIMAL, Row, SampledLine, UnreadableRow, bits_to_stop
from sistap.commands.imports.source import Stated, lines, need_rate
from sistap.tap.line.settings import Flag

_Cells = dict[str, str]


class Columns(NamedTuple):
    """A form of the table, defined by the names of its columns."""

    first_line: str  # regular expression
    time: str
    value: str
    channel: str = ""  # the column, if there is one
    duration: str = ""  # in s; without it, the time is that of the start bit, and the rate gives the length
    errors: tuple[str, ...] = ()  # columns that are empty without an error


LOGIC_2 = Columns(
    r'"?name"?,"?type"?,"?start_time"?,"?duration"?,', "start_time", "data", "name", "duration", ("error",)
)
LOGIC_1 = Columns(
    r"Time \[s\], ?Value, ?Parity Error, ?Framing Error", "Time [s]", "Value", errors=("Parity Error", "Framing Error")
)
# Several analysers in one table. An error follows the value in brackets: "0x02 (parity error)".
LOGIC_1_ALL = Columns(
    r"Time \[s\], ?Analyzer Name, ?Decoded Protocol Result", "Time [s]", "Decoded Protocol Result", "Analyzer Name"
)

# Of the ways to show a value, only hexadecimal is unambiguous: "2" may be the digit or the character.
_VALUE = re.compile(r"0x([0-9A-Fa-f]{1,2})")
_REMARK = re.compile(r" \(.*error\)$")
_SECONDS = re.compile(r"-?\d{1,9}(\.\d+)?([eE]-\d\d?)?")
_FRACTION = re.compile(r"\.(\d+)")


def reader(table: Columns) -> Callable[[Path, Stated], SampledLine]:
    """Return a function that opens a file with such a table."""

    def opened(path: Path, stated: Stated) -> SampledLine:
        need_rate(stated.settings, path)
        return SampledLine(path, _rows(path, table, stated), stated)

    return opened


def _rows(path: Path, table: Columns, stated: Stated) -> Iterator[Row | UnreadableRow]:
    settings = stated.settings
    frame_s = bits_to_stop(settings, after_start=True) / settings.baud
    rows = csv.DictReader((line.replace("\0", "") for line in lines(path)), skipinitialspace=True)
    while True:
        try:
            cells = next(rows, None)
        except csv.Error as error:
            yield UnreadableRow(rows.line_num, str(error))
            return
        if cells is None:
            return
        if cells.get("type") not in (None, "data"):  # Logic 2: a row of another analyser
            continue
        try:
            duration_s = seconds(cells[table.duration]) if table.duration else frame_s
            value, flags = _value(cells, table)
            yield Row(cells.get(table.channel) or "serial", seconds(cells[table.time]) + duration_s, value, flags)
        except (ValueError, TypeError, KeyError) as error:
            yield UnreadableRow(rows.line_num, str(error) if isinstance(error, ValueError) else "it is cut")


def _value(cells: _Cells, table: Columns) -> tuple[int, Flag]:
    text = cells[table.value]
    remark = _REMARK.search(text)
    match = _VALUE.fullmatch(text[: remark.start()] if remark else text)
    if not match:
        raise ValueError(f"'{text}' is no hexadecimal value; {HEXADECIMAL}")
    is_bad = remark or any(cells.get(column) for column in table.errors)
    return int(match[1], 16), Flag.CHARACTER_ERROR if is_bad else Flag(0)


def seconds(text: str) -> Fraction:
    """Convert seconds, or a date with time; ValueError if the text is neither."""
    if _SECONDS.fullmatch(text):
        return Fraction(text)
    fraction = _FRACTION.search(text)
    try:
        moment = datetime.fromisoformat(_FRACTION.sub("", text))
    except ValueError:
        raise ValueError(f"'{text}' is no time") from None
    whole = moment if moment.tzinfo else moment.replace(tzinfo=UTC)
    return Fraction(int(whole.timestamp())) + (Fraction("0" + fraction[0]) if fraction else 0)
