# SPDX-License-Identifier: GPL-2.0-or-later
"""The useful data of commands in a scenario: which keys belong to which service (IF02 chapters 3 to 9)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from sisbus.devices.parameters import Element, as_list, control, ident
from sisbus.table import BYTE, WORD, Reading, Table, characters, choice, octets, text, whole
from sistap.tap.sis.codes import LAYOUTS, Item
from sistap.tap.sis.rates import BAUD_MASKS


class Body(NamedTuple):
    """A service and the useful data of its command."""

    service: int
    data: bytes


_ELEMENTS = {element.name.lower().replace("_", "-"): element for element in Element}
_IDENTIFICATIONS = {"version": 1, "firmware": 2, "type": 3, "rates": 4}
_TIMES = {"TrS": 0x01, "TzA": 0x02, "Tmas": 0x03}
_SETTINGS = {**_TIMES, "rate": 0x07, "accept": 0xFF}
_TARGETS = {"firmware": 0, "loader": 1}


def _sized(size: int) -> Reading[bytes]:
    """Parse a number of that many bytes; negative ones become two's complement."""
    limit = 1 << 8 * size
    reading = whole(-limit // 2, limit - 1)
    return lambda value: (reading(value) % limit).to_bytes(size, "little")


def _characters(value: object) -> bytes:
    said = characters(value)
    return as_list(said, len(said))


_OPERATING_DATA: dict[str, Reading[bytes]] = {
    "data": octets,
    "word": _sized(2),
    "value": _sized(4),
    "text": _characters,
}

# Subservices of service 0x02 (chapter 5).
_FLASH = {
    "shutdown": 0x90,
    "reboot": 0x91,
    "read": 0x92,
    "find-header": 0x93,
    "erase": 0x94,
    "program": 0x96,
    "checksum": 0x97,
    "reset-errors": 0x9F,
}


def operating_data(table: Table) -> bytes:
    """Read the operating data to write: data, word, value or text."""
    key = table.one_of(list(_OPERATING_DATA))
    return table.need(key, _OPERATING_DATA[key])


def access(table: Table, key: str, device: int) -> bytes:
    """Read the element and the parameter: control byte, device address, parameter (chapter 8)."""
    which = table.need(key, lambda name: ident(text(name)))
    element = table.take("element", choice(_ELEMENTS), Element.DATA)
    return bytes([control(element), table.take("device", BYTE, device)]) + which


def _addressed(table: Table, device: int, service: int, subservice: int, data: bytes = b"") -> Body:
    return Body(service, bytes([table.take("device", BYTE, device), subservice]) + data)


def _flash(table: Table, device: int) -> Body:
    subservice = table.need("flash", choice(_FLASH))
    data = b"".join(_flash_item(table, item) for item in LAYOUTS[0x02][subservice].command)
    return _addressed(table, device, 0x02, subservice, data)


def _flash_item(table: Table, item: Item) -> bytes:
    """Read a part of a flash command: its key is the last word of the field (sis.flash.address: address)."""
    key = item.field.rpartition(".")[2]
    if key == "target":
        return bytes([table.need(key, choice(_TARGETS))])
    return table.need(key, _sized(item.size) if item.size else octets)


def _set(table: Table, device: int) -> Body:
    subservice = table.need("set", choice(_SETTINGS))
    data = b""
    if subservice in _TIMES.values():
        data = table.need("ms", WORD).to_bytes(2, "little")
    elif subservice == _SETTINGS["rate"]:
        data = table.need("rate", rate_mask)
    return _addressed(table, device, 0x03, subservice, data)


def _segment(table: Table, key: str, device: int) -> bytes:
    """Read the part of a list, in bytes."""
    where = access(table, key, device)
    return where + b"".join(table.need(name, WORD).to_bytes(2, "little") for name in ("offset", "length"))


def _phase(table: Table, device: int) -> Body:
    table.need("phase", choice({"read": 0}))
    return Body(0x12, b"")


def rate_mask(value: object) -> bytes:
    """Read a rate; return its mask (fig. 6-11)."""
    return bytes([choice({str(rate): mask for rate, mask in BAUD_MASKS.items()})(str(value))])


# Maps the key of a command to its reader. The second argument is the device, unless a key names one.
BODIES: Mapping[str, Callable[[Table, int], Body]] = {
    "identify": lambda table, device: _addressed(table, device, 0x00, table.need("identify", choice(_IDENTIFICATIONS))),
    "cancel": lambda table, device: _addressed(table, device, 0x01, table.need("cancel", BYTE)),
    "flash": _flash,
    "set": _set,
    "read": lambda table, device: Body(0x10, access(table, "read", device)),
    "write": lambda table, device: Body(0x1F, access(table, "write", device) + operating_data(table)),
    "read_list": lambda table, device: Body(0x11, _segment(table, "read_list", device)),
    "write_list": lambda table, device: Body(0x1E, _segment(table, "write_list", device) + operating_data(table)),
    "phase": _phase,
    "switch": lambda table, _: Body(0x1D, bytes([table.need("switch", BYTE)])),
    "service": lambda table, _: Body(table.need("service", BYTE), table.take("data", octets, b"")),
}
