# SPDX-License-Identifier: GPL-2.0-or-later
"""The description as a page to read: plugin/REFERENCE.md."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from description import Code, Description, Expert, Fault, Field, Table

HEAD = """# Reference: warnings, faults, fields, codes

Search this page for the words that Wireshark shows: a text in brackets, a filter name, a code. A warning says
what it means and what to do. A fault is what the filter buttons, the recorder and the report find. A field is
a line of the tree, for a filter or a column.
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


# On a telephone a table with more than two columns hides the last ones. So items are headings and lists.


def _expert(item: Expert) -> Iterator[str]:
    yield from (f"### {item.says}", "", f"`{item.filter}` ({SEVERITIES[item.severity]})", "")
    yield from (f"{item.means} **What to do:** {item.do}", "")


def _fault(fault: Fault) -> Iterator[str]:
    yield from (f"### {fault.title}", "", f"Button *{fault.button}*. {fault.expert.do}", "")
    yield from (f"Filter: {', or '.join(f'`{test}`' for test in fault.tests)}", "")


def _field(field: Field) -> str:
    kind = field.kind if field.kind != "packet" else "packet number"
    return f"- `{field.filter}`: **{field.name}** ({kind}). {field.means}"


def _code(code: Code) -> tuple[str, ...]:
    return code.key, code.text


def _codes(table: Table) -> Iterator[str]:
    yield from (f"### {table.name.replace('_', ' ')}", "", table.about, "")
    yield from _table(("code", "text"), map(_code, table.codes))


def reference(description: Description) -> str:
    """Return the page."""
    lines = [HEAD, "## Warnings: expert information", ""]
    lines += [line for item in description.experts for line in _expert(item)]
    lines += ["## Faults", "", "Colours, buttons, the recorder and the report find the same ones.", ""]
    lines += [line for fault in description.faults for line in _fault(fault)]
    lines += ["## Fields", ""]
    for protocol in description.protocols:
        fields = [field for field in description.fields if field.protocol == protocol.key]
        if fields:
            lines += [f"### {PROTOCOLS.get(protocol.key, protocol.key)}", ""]
            lines += [*map(_field, fields), ""]
    lines += ["## Codes", ""]
    for table in description.tables.values():
        lines += _codes(table)
    return "\n".join(lines)
