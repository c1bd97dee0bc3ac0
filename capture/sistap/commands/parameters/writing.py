# SPDX-License-Identifier: GPL-2.0-or-later
"""The list of parameters, and changes, as lines of text for people and of CSV for programs; and Wireshark's table."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Iterator

from sistap.commands.parameters.backup import Drive, Saved
from sistap.dissected.accesses.access import Parameter
from sistap.dissected.accesses.listing import ChangedValue, Listed
from sistap.dissected.telegrams.values import shown_limit
from sistap.tap.common.calendar import local
from sistap.tap.common.table import aligned
from sistap.tap.sis.telegram import shown

_UNKNOWN = "unknown"
_LIST_HEADS = (
    *("Port", "Station", "Device", "Parameter", "Name", "Unit", "Reads", "Writes", "Errors", "First", "Last", "Least"),
    *("Greatest", "Bytes", "Written by", "In packet", "File"),
)
_NUMBERS = {"Reads", "Writes", "Errors", "Bytes", "Written by", "In packet"}  # right-aligned columns
_CSV_LIST = (
    *("port", "station", "device", "parameter", "name", "unit", "minimum", "maximum", "reads", "writes", "errors"),
    *("first", "last", "least", "greatest", "written_by", "written_in_packet", "written_in_file", "written_at"),
    "bytes",
)
CSV_CHANGES = (
    *("time", "master", "port", "station", "device", "parameter"),
    *("name", "unit", "from", "to", "packet", "file"),
)

_FORMULAS = tuple("=+-@\t\r")  # the first character of a cell that spreadsheets calculate
_NUMBER = re.compile(r"[+-][\d.,]+(?:e[+-]?\d+)?(?: [\w°%/²³·^]*)?")


def list_as_text(listing: Iterable[Listed], *, several_files: bool) -> Iterator[str]:
    """Yield the lines of a table. It counts values in bytes only if the lowest or highest may be among them."""
    found = list(listing)
    rows = [_row(listed) for listed in found]
    if not rows:
        return
    left_out = {0} if len({row[0] for row in rows}) == 1 else set()
    left_out |= set() if several_files else {_LIST_HEADS.index("File")}
    left_out |= set() if any(one.raw and one.least for one in found) else {_LIST_HEADS.index("Bytes")}
    shown = [[text for column, text in enumerate(row) if column not in left_out] for row in (_LIST_HEADS, *rows)]
    yield from aligned(shown, right=_NUMBERS)


def _row(listed: Listed) -> tuple[str, ...]:
    parameter, place = listed.parameter, listed.written_in
    return (
        *(parameter.port, parameter.station, str(parameter.device), parameter.ident, listed.name, listed.unit),
        *(str(listed.reads), str(listed.writes), str(listed.errors), listed.first, listed.last),
        listed.least.value if listed.least else "",
        listed.greatest.value if listed.greatest else "",
        str(listed.raw or ""),
        "" if listed.written_by is None else str(listed.written_by),
        str(place.packet) if place else "",
        place.file if place else "",
    )


def list_as_csv(listing: Iterable[Listed]) -> Iterator[str]:
    """Yield the lines of CSV; lowest and highest values are numbers without their unit."""
    yield csv_line(_CSV_LIST)
    for listed in listing:
        place = listed.written_in
        yield csv_line(
            (
                *(*listed.parameter, listed.name, listed.unit, listed.minimum, listed.maximum),
                *(listed.reads, listed.writes, listed.errors, listed.first, listed.last),
                listed.least.number if listed.least else None,
                listed.greatest.number if listed.greatest else None,
                listed.written_by,
                *((place.packet, place.file, time_text(place.epoch_s)) if place else ("", "", "")),
                listed.raw,
            )
        )


def change_as_text(change: ChangedValue, *, several_files: bool) -> str:
    """Return a change as a line: when, who, what, from, to, packet."""
    place, access = change.place, change.access
    name = f" ({access.name})" if access.name else ""
    before = _UNKNOWN if change.before is None else change.before
    where = f"packet {place.packet}{f' of {place.file}' if several_files else ''}"
    time = time_text(place.epoch_s, " ")
    words = [time] if time else []
    words += [f"{access.by} -> {_station(access.parameter)}", f"{access.parameter.ident}{name}"]
    return "  ".join([*words, f"{before} -> {access.value or _UNKNOWN}", where])


def _station(parameter: Parameter) -> str:
    return f"{parameter.station} device {parameter.device}"


def change_as_csv(change: ChangedValue) -> str:
    """Return a change as a line of CSV; unknown values are empty."""
    place, access = change.place, change.access
    values = (access.name, access.unit, change.before, access.value, place.packet, place.file)
    return csv_line((time_text(place.epoch_s), access.master, *access.parameter, *values))


def csv_line(values: Iterable[object]) -> str:
    """Return a line of CSV that a spreadsheet does not run."""
    line = io.StringIO()
    csv.writer(line, lineterminator="").writerow(map(_text_for_spreadsheets, values))
    return line.getvalue()


def _text_for_spreadsheets(cell: object) -> object:
    """Mark a text of a drive that a spreadsheet would run as a formula. A number with its unit stays as it is."""
    is_formula = isinstance(cell, str) and cell[:1] in _FORMULAS and not _NUMBER.fullmatch(cell)
    return f"'{cell}" if is_formula else cell


def time_text(epoch_s: float, between: str = "T") -> str:
    """Return local time with its zone; empty for 0, the time of a log without times."""
    then = local(epoch_s) if epoch_s else None
    return then.isoformat(between, timespec="microseconds") if then else ""


_PLAIN_BYTES = frozenset(range(0x20, 0x7F)) - frozenset(b'"\\')


def user_table(drive: Drive, station: str) -> Iterator[str]:
    """Yield the rows of a drive in Wireshark's table "SIS parameters", its file `sis_parameters`, which the plugin and
    sis.lua read. An empty station is every station.
    """
    for saved in drive.parameters:
        yield ",".join(map(_user_cell, _user_row(saved, station)))


def _user_row(saved: Saved, station: str) -> tuple[str, ...]:
    kind, set_, number = saved.ident.split("-")
    limits = (shown_limit(saved.attribute, limit, saved.unit) for limit in (saved.minimum, saved.maximum))
    attribute = f"0x{saved.attribute.bits:08x}"
    return (kind, number if set_ == "0" else f"{set_}-{number}", saved.name, saved.unit, attribute, *limits, station)


def _user_cell(text: str) -> str:
    """Quote a text as Wireshark reads it."""
    return '"' + "".join(chr(byte) if byte in _PLAIN_BYTES else f"\\x{byte:02x}" for byte in shown(text).encode()) + '"'
