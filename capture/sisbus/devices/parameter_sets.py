# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameters from tables: the sets of the virtual bus (sets/*.toml), and the changes of a scenario."""

from __future__ import annotations

import struct
import tomllib
from collections.abc import Mapping
from functools import cache, partial
from importlib import resources
from typing import NamedTuple

from sisbus.devices.parameters import Parameter, ProcedureCommand, as_list, ident
from sisbus.table import WORD, Misread, Reading, Table, ascii_text, choice, flag, whole
from sistap.dissected.telegrams.attribute import PROCEDURE_COMMAND, READ_ONLY, Attribute, Format
from sistap.tap.sis.names import S_NAMES

Rows = Mapping[str, Mapping[str, object]]


PARAMETER_MODE_ONLY = 0x6000_0000  # of READ_ONLY

_TYPES = {
    "binary 2": Attribute.of(2, Format.BINARY),
    "hex 2": Attribute.of(2, Format.HEXADECIMAL),
    "hex 4": Attribute.of(4, Format.HEXADECIMAL),
    "unsigned 2": Attribute.of(2, Format.UNSIGNED),
    "unsigned 4": Attribute.of(4, Format.UNSIGNED),
    "signed 2": Attribute.of(2, Format.SIGNED),
    "signed 4": Attribute.of(4, Format.SIGNED),
    "float": Attribute.of(4, Format.FLOAT),
    "ident": Attribute.of(2, Format.IDENT_NUMBER),
    "text": Attribute.of(1, Format.TEXT, is_list=True),
    "list of idents": Attribute.of(2, Format.IDENT_NUMBER, is_list=True),
    "list of unsigned 2": Attribute.of(2, Format.UNSIGNED, is_list=True),
    "list of unsigned 4": Attribute.of(4, Format.UNSIGNED, is_list=True),
    "list of signed 4": Attribute.of(4, Format.SIGNED, is_list=True),
    "list of hex 4": Attribute.of(4, Format.HEXADECIMAL, is_list=True),
    "command": Attribute.of(2, Format.BINARY, more=PROCEDURE_COMMAND),
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
            raise Misread(f"{where}: {error}") from None
        table = Table(row, f"{where}: {name}")
        made.parameters.append(_parameter(name, table))
        modulo = table.take("modulo", _ident_name, "")
        if modulo:
            made.modulo[name] = modulo
        table.end()
    return made


def _parameter(name: str, table: Table) -> Parameter:
    bits = table.need("type", choice(_TYPES)).bits | table.take("decimals", whole(0, 15), 0) << 24
    attribute = Attribute(bits | table.take("writable", choice(_WRITABLE), 0))
    value = partial(_value, attribute)
    standard = S_NAMES.get(int(name[4:])) if name.startswith("S-0-") else None
    return Parameter(
        name,
        table.take("name", ascii_text(), standard),
        attribute,
        _data(table, attribute, value),
        table.take("unit", ascii_text(), None),
        table.take("minimum", value, None),
        table.take("maximum", value, None),
        valid=table.take("valid", flag, True),
        fixed_length=table.take("fixed", flag, False),
        procedure=ProcedureCommand(table.take("takes", whole(0, 3_600_000), 0), table.take("fails", flag, False))
        if attribute.is_command
        else None,
        refuse=table.take("refuse", WORD, None),
    )


def _data(table: Table, attribute: Attribute, value: Reading[bytes]) -> bytes:
    size = attribute.size
    if not attribute.is_list:
        return table.take("value", value, bytes(size))
    room = table.take("room", whole(0, 0xFFFF // size), 0) * size
    if attribute.format == Format.TEXT:
        return as_list(table.take("value", ascii_text(), "").encode("ascii"), room)
    return as_list(table.take("value", partial(_list, value), b""), room)


def _list(value: Reading[bytes], elements: object) -> bytes:
    if not isinstance(elements, list):
        raise ValueError("use a list, [1, 2]")
    return b"".join(map(value, elements))


def _value(attribute: Attribute, value: object) -> bytes:
    """Parse a value as a person writes it, in the unit of the parameter."""
    if attribute.format == Format.IDENT_NUMBER and isinstance(value, str):
        return ident(value)[1:]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError("use a number")
    if attribute.format == Format.FLOAT:
        return struct.pack("<f", value)
    size, decimals = attribute.size, attribute.decimals
    try:
        scaled = round(value * 10.0**decimals)
        return scaled.to_bytes(size, "little", signed=attribute.format == Format.SIGNED)
    except OverflowError:
        raise ValueError(f"use a number that fits into {size} bytes, with {decimals} decimals") from None


def _ident_name(value: object) -> str:
    name = ascii_text()(value)
    ident(name)
    return name
