# SPDX-License-Identifier: GPL-2.0-or-later
"""The description as a page to read: plugin/REFERENCE.md."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from description import Code, Description, Expert, Fault, Field, Table

HEAD = """# Reference: warnings, faults, fields, codes

Search this page for what stands in Wireshark: a filter name, a text in brackets, a code. It is made
from the description in [protocol/](protocol/): edit there, then run `protocol/generate.py`.
"""
SEVERITIES = {"chat": "chat", "note": "note", "warn": "warning", "error": "error"}
PROTOCOLS = {
    "sertap": "sertap: the record of the tap",
    "sis": "sis: telegrams of SIS, and parameters in every transport",
}


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    yield f"| {' | '.join(head)} |"
    yield "|" + "---|" * len(head)
    for row in rows:
        yield f"| {' | '.join(map(_cell, row))} |"
    yield ""


def _expert(item: Expert) -> tuple[str, ...]:
    return f"`{item.filter}`", SEVERITIES[item.severity], item.says, item.means, item.do


def _fault(fault: Fault) -> tuple[str, ...]:
    return fault.title, f"`{' || '.join(fault.tests)}`", fault.button, fault.name.replace("_", "-")


def _field(field: Field) -> tuple[str, ...]:
    return f"`{field.filter}`", field.name, field.kind if field.kind != "packet" else "packet number", field.means


def _code(code: Code) -> tuple[str, ...]:
    return code.key, code.text


def _codes(table: Table) -> Iterator[str]:
    yield from (f"### {table.name.replace('_', ' ')}", "", table.about, "")
    yield from _table(("code", "text"), map(_code, table.codes))


def reference(description: Description) -> str:
    """Return the page."""
    lines = [HEAD, "## Warnings: expert information", ""]
    lines += _table(("filter", "severity", "text", "what it means", "what to do"), map(_expert, description.experts))
    lines += ["## Faults", "", "Colours, buttons, the recorder and the report find the same ones.", ""]
    lines += _table(("fault", "filter", "button", "in names of kept files"), map(_fault, description.faults))
    lines += ["## Fields", ""]
    for protocol in description.protocols:
        fields = [field for field in description.fields if field.protocol == protocol.key]
        if fields:
            lines += [f"### {PROTOCOLS.get(protocol.key, protocol.key)}", ""]
            lines += _table(("filter", "name", "type", "what it means"), map(_field, fields))
    lines += ["## Codes", ""]
    for table in description.tables.values():
        lines += _codes(table)
    return "\n".join(lines)
