# SPDX-License-Identifier: GPL-2.0-or-later
"""The tables of the telegram workbench: the header, the codes of plugin/sis/names.c, and what useful data begin with."""

from __future__ import annotations

from typing import Any

import sheet

# What is in the useful data: name of the field, how many bytes, and what they mean: a table below, or a word that the
# script knows. A field without a size takes the rest.
Field = tuple[str, int, str]

DEVICE: Field = ("Device address", 1, "number")
CONTROL: Field = ("Parameter control", 1, "parameter control")
PARAMETER: Field = ("Parameter", 3, "parameter")
SEGMENT: tuple[Field, ...] = (("List offset", 2, "number"), ("List length", 2, "number"))
DATA: Field = ("Data", 0, "data")
PHASE: Field = ("Phase", 1, "phases")
CHANNEL_ERROR: Field = ("Error code", 2, "errors_channel")


def _parameter(*more: Field) -> dict[str, Any]:
    return {
        "command": [CONTROL, DEVICE, PARAMETER, *more],
        "good": [CONTROL, DEVICE, DATA],
        "1": [CONTROL, DEVICE, ("Error code", 2, "errors_parameter")],
        "2": [CONTROL, DEVICE, CHANNEL_ERROR],
        "head": [CONTROL, DEVICE],
    }


def _general(table: str, errors: str = "") -> dict[str, Any]:
    head: list[Field] = [DEVICE, ("Subservice", 1, table)]
    failed: list[Field] = [*head, ("Error code", 1, errors)] if errors else [*head, DATA]
    return {"command": [*head, DATA], "good": [*head, DATA], "1": failed, "2": [*head, CHANNEL_ERROR], "head": head}


_SWITCHED: dict[str, Any] = {"command": [PHASE], "good": [PHASE], "2": [PHASE, ("Error code", 2, "errors_phase")]}

# By service; chapters 3 to 9 of the definition.
BODIES: dict[int, dict[str, Any]] = {
    0x00: _general("subservices_identification"),
    0x01: {"command": [DEVICE, ("Service to cancel", 1, "services")], "good": [DEVICE]},
    0x02: _general("subservices_flash", "errors_flash"),
    0x03: _general("subservices_initialization", "errors_initialization"),
    **dict.fromkeys((0x10, 0x80, 0x90), _parameter()),
    **dict.fromkeys((0x11, 0x81, 0x91), _parameter(*SEGMENT)),
    **dict.fromkeys((0x12, 0x92), {**_SWITCHED, "command": []}),
    **dict.fromkeys((0x1D, 0x9D), _SWITCHED),
    **dict.fromkeys((0x1E, 0x8E, 0x9E), _parameter(*SEGMENT, DATA)),
    **dict.fromkeys((0x1F, 0x8F, 0x9F), _parameter(DATA)),
}

TABLES = (
    "services",
    "status",
    "errors_channel",
    "subservices_identification",
    "subservices_flash",
    "errors_flash",
    "subservices_initialization",
    "errors_initialization",
    "elements",
    "errors_parameter",
    "errors_phase",
    "phases",
)
KINDS = ("frame", "frame", "frame", "frame", "control", "service", "address", "address")  # of the bytes of the header


def tables() -> dict[str, Any]:
    """Return everything the script needs to take a telegram apart."""
    names = [(name, kind) for (_, name, _), kind in zip(sheet.HEADER, KINDS, strict=True)]
    return {
        "header": names,
        "control": sheet.CONTROL,
        "addresses": [[*_range(numbers), text] for numbers, text in sheet.addresses()],
        "bodies": BODIES,
        "tables": {
            name: [[int(row.first, 0), int(row.last, 0), row.text] for row in sheet.table(name)] for name in TABLES
        },
    }


def _range(numbers: str) -> tuple[int, int]:
    first, _, last = numbers.partition("-")
    return int(first), int(last or first)
