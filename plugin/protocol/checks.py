# SPDX-License-Identifier: GPL-2.0-or-later
"""What the description may not say, because Wireshark refuses it, or C and Lua would read it otherwise.

Each function yields what is wrong with an entry. Without them a layout with a wrong size ends in a segmentation fault.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from description import Field, Item, Service, Services, Table

BYTES = {"uint8": 1, "uint16": 2, "uint32": 4}
_BYTE = range(256)


def of_field(field: Field) -> Iterator[str]:
    """Wireshark ends when such a field is registered."""
    is_integer, is_boolean = field.kind in BYTES, field.kind == "boolean"
    bits = 8 * BYTES.get(field.kind, 0) if is_integer else field.width
    if is_integer and not field.base and not field.codes:
        yield "an integer needs dec or hex"
    if not is_integer and (field.base or field.codes or field.unit):
        yield "only an integer has dec or hex, codes or a unit"
    if field.mask and not (is_integer or is_boolean):
        yield "only an integer or a boolean has a mask"
    if field.mask and is_boolean and field.width not in {8, 16, 32}:
        yield "a boolean with a mask needs a width of 8, 16 or 32"
    elif field.mask >> bits:
        yield f"its mask has more than {bits} bits"
    if field.texts and not is_boolean:
        yield "only a boolean has texts"
    if field.link and field.kind != "packet":
        yield "only a packet has a link"


def of_services(services: Services, fields: Mapping[str, Field], tables: Mapping[str, Table]) -> Iterator[str]:
    """A table is looked up as a single code; C keeps numbers in a byte."""
    with_layouts = [service.number for service in services.layouts.values()]
    for number in with_layouts:
        if number not in _BYTE or with_layouts.count(number) > 1:
            yield f"service 0x{number:02X} is no byte, or has layouts twice"
    for like in (services.like, *services.like_if_set.values()):
        for number, general in like.items():
            if general in with_layouts:
                yield f"0x{number:02X} cannot be like 0x{general:02X}, which has layouts"
    for name, service in services.layouts.items():
        for table in filter(None, (service.subservices, service.errors)):
            if table not in tables or tables[table].has_ranges:
                yield f"{name}: codes.toml has no {table}, or it has ranges"
        if unknown := {*(service.functions or ())} - {item.field for item in service.items}:
            yield f"{name}: functions of no item: {', '.join(sorted(unknown))}"
        yield from (f"{name}: {wrong}" for wrong in _of_layouts(service, fields, tables))


def _of_layouts(service: Service, fields: Mapping[str, Field], tables: Mapping[str, Table]) -> Iterator[str]:
    named = {code.first for code in tables[service.subservices].codes} if service.subservices in tables else {0}
    numbers = [layout.subservice for layout in service.layouts]
    for number in numbers:
        if number not in named or numbers.count(number) > 1:
            yield f"0x{number:02X} is no subservice of it, or stands there twice"
    for layout in service.layouts:
        for items in (layout.command, layout.reaction):
            yield from _of_order(items)
            for item in items:
                field = fields.get(f"sis.{item.field}")
                wrong = _of_item(item, field, tables, item.field in (service.functions or ())) if field else [_UNKNOWN]
                yield from (f"sis.{item.field}: {text}" for text in wrong)


_UNKNOWN = "fields.toml has no such field"


def _of_order(items: Sequence[Item]) -> Iterator[str]:
    """What follows the rest, or follows an item that may be missing, is never found."""
    for item, after in zip(items, items[1:], strict=False):
        if not item.size or item.may_be_missing > after.may_be_missing:
            yield f"sis.{item.field}: nothing can follow it"
    for item in items:
        if not item.size and item.may_be_missing:
            yield f"sis.{item.field}: the rest cannot be missing"


def _of_item(item: Item, field: Field, tables: Mapping[str, Table], has_function: bool) -> Iterator[str]:  # noqa: FBT001
    size = BYTES.get(field.kind, 0)
    if size and not 1 <= item.size <= size:
        yield f"it has {size} bytes: {item.field}:{size}"
    if has_function:
        return
    if size and item.size < size:
        yield f"it has {size} bytes: {item.field}:{size}"
    if not size and field.kind not in {"string", "bytes"}:
        yield f"a {field.kind} needs a function"
    if not size and item.size:
        yield f"it is the rest: {item.field}:*"
    if field.mask or field.shown_by:
        yield "a field with a mask, or shown by a function, needs a function here, too"
    if field.codes and tables[field.codes].has_ranges:
        yield "its codes have ranges"
