# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameters from tables: the sets of the virtual bus (sets/*.toml), and the changes of a scenario."""

from __future__ import annotations

import struct
import tomllib
from collections.abc import Mapping
from functools import cache, partial
from importlib import resources
from typing import NamedTuple

from sisbus.devices.parameters import (
    PARAMETER_MODE_ONLY,
    READ_ONLY,
    SIZES,
    Format,
    Length,
    Parameter,
    Procedure,
    as_list,
    attribute,
    ident,
)
from sisbus.table import WORD, Reading, Table, ascii_text, choice, flag, whole
from sistap.tap.sis.names import S_NAMES

Rows = Mapping[str, Mapping[str, object]]


class _Type(NamedTuple):
    length: Length
    format: Format
    command: bool = False


_TYPES = {
    "binary 2": _Type(Length.TWO_BYTES, Format.BINARY),
    "hex 2": _Type(Length.TWO_BYTES, Format.HEXADECIMAL),
    "hex 4": _Type(Length.FOUR_BYTES, Format.HEXADECIMAL),
    "unsigned 2": _Type(Length.TWO_BYTES, Format.UNSIGNED),
    "unsigned 4": _Type(Length.FOUR_BYTES, Format.UNSIGNED),
    "signed 2": _Type(Length.TWO_BYTES, Format.SIGNED),
    "signed 4": _Type(Length.FOUR_BYTES, Format.SIGNED),
    "float": _Type(Length.FOUR_BYTES, Format.FLOAT),
    "ident": _Type(Length.TWO_BYTES, Format.IDENT_NUMBER),
    "text": _Type(Length.LIST_OF_BYTES, Format.TEXT),
    "list of idents": _Type(Length.LIST_OF_TWO_BYTES, Format.IDENT_NUMBER),
    "list of unsigned 2": _Type(Length.LIST_OF_TWO_BYTES, Format.UNSIGNED),
    "list of unsigned 4": _Type(Length.LIST_OF_FOUR_BYTES, Format.UNSIGNED),
    "list of signed 4": _Type(Length.LIST_OF_FOUR_BYTES, Format.SIGNED),
    "list of hex 4": _Type(Length.LIST_OF_FOUR_BYTES, Format.HEXADECIMAL),
    "command": _Type(Length.TWO_BYTES, Format.BINARY, command=True),
}
_WRITABLE = {"always": 0, "phase 2": PARAMETER_MODE_ONLY, "never": READ_ONLY}


class Made(NamedTuple):
    """The parameters made from a set of rows."""

    parameters: list[Parameter]
    modulo: dict[str, str]  # maps a parameter to the one with its modulo value


@cache
def built_in(name: str) -> Rows:
    """Read a set that comes with sistap, such as "drive"."""
    rows: Rows = tomllib.loads(resources.files("sisbus.devices").joinpath(f"sets/{name}.toml").read_text("utf-8"))
    return rows


def changed(rows: Rows, changes: object) -> Rows:
    """Return the rows with changed keys and new rows. ValueError: a change is not a table."""
    result = dict(rows)
    if not isinstance(changes, Mapping) or not all(isinstance(change, Mapping) for change in changes.values()):
        raise ValueError("use a table of tables, { S-0-0036 = { value = 1 } }")
    for name, change in changes.items():
        result[name] = {**result.get(name, {}), **change}
    return result


def make(rows: Rows, where: str) -> Made:
    """Make the parameters. ValueError is one line with the row, the key and the cure."""
    made = Made([], {})
    for name, row in rows.items():
        try:
            ident(name)
        except ValueError as error:
            raise ValueError(f"{where}: {error}") from None
        table = Table(row, f"{where}: {name}")
        made.parameters.append(_parameter(name, table))
        modulo = table.take("modulo", _ident_name, "")
        if modulo:
            made.modulo[name] = modulo
        table.end()
    return made


def _parameter(name: str, table: Table) -> Parameter:
    kind = table.need("type", choice(_TYPES))
    decimals = table.take("decimals", whole(0, 15), 0)
    value = partial(_value, kind, decimals)
    protection = table.take("writable", choice(_WRITABLE), 0)
    return Parameter(
        name,
        table.take("name", ascii_text(), _standard_name(name)),
        attribute(kind.length, kind.format, decimals, protection, command=kind.command),
        _data(table, kind, value),
        table.take("unit", ascii_text(), None),
        table.take("minimum", value, None),
        table.take("maximum", value, None),
        valid=table.take("valid", flag, True),
        fixed_length=table.take("fixed", flag, False),
        procedure=_procedure(table) if kind.command else None,
        refuse=table.take("refuse", WORD, None),
    )


def _standard_name(name: str) -> str | None:
    """Return the name of an S parameter of set 0, if SERCOS III has one."""
    return S_NAMES.get(int(name[4:])) if name.startswith("S-0-") else None


def _procedure(table: Table) -> Procedure:
    return Procedure(table.take("takes", whole(0, 3_600_000), 0), table.take("fails", flag, False))


def _data(table: Table, kind: _Type, value: Reading[bytes]) -> bytes:
    if kind.length in (Length.TWO_BYTES, Length.FOUR_BYTES):
        return table.take("value", value, bytes(SIZES[kind.length]))
    size = SIZES[kind.length]
    room = table.take("room", whole(0, 0xFFFF // size), 0) * size
    if kind.format == Format.TEXT:
        return as_list(table.take("value", ascii_text(), "").encode("ascii"), room)
    return as_list(table.take("value", partial(_list, value), b""), room)


def _list(value: Reading[bytes], elements: object) -> bytes:
    if not isinstance(elements, list):
        raise ValueError("use a list, [1, 2]")
    return b"".join(map(value, elements))


def _value(kind: _Type, decimals: int, value: object) -> bytes:
    """Parse a value as a person writes it, in the unit of the parameter."""
    if kind.format == Format.IDENT_NUMBER and isinstance(value, str):
        return ident(value)[1:]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError("use a number")
    if kind.format == Format.FLOAT:
        return struct.pack("<f", value)
    size = SIZES[kind.length]
    try:
        scaled = round(value * 10.0**decimals)
        return scaled.to_bytes(size, "little", signed=kind.format == Format.SIGNED)
    except OverflowError:
        raise ValueError(f"use a number that fits into {size} bytes, with {decimals} decimals") from None


def _ident_name(value: object) -> str:
    name = ascii_text()(value)
    ident(name)
    return name
