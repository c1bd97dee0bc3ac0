# SPDX-License-Identifier: GPL-2.0-or-later
"""Compares a capture with a table of what each frame must show, in one pass and in two.

A table has the fields of a frame, without their "sis.", as `field=value; field=value`; several values of a field have
commas between them. A name without value is an expert item, there or not. Frames and fields that are not in the table
must not be in the capture.
"""

from __future__ import annotations

from pathlib import Path

from sistap.dissected.wireshark.tshark import Tshark

HERE = Path(__file__).parent

Table = dict[int, str]

# Fields that only a later packet can tell: there in the second pass, not in the first.
LATER = {
    "reaction_in",
    "sequence.whole_in",
    "command.unanswered",
    "next_command_in",
    "access",  # of a value that came before its attribute
    "synax.answer_in",
    "synax.pieces.whole_in",
}
LATER_ELSEWHERE = {
    "sis.reaction_in",
    "sis.command.unanswered",
    "synax.answer_in",
    "synax.unanswered",
    "synax.next_request_in",
    "synax.pieces.whole_in",
    "synaxpcp.response_in",
    "3964r.answer_in",
}

BOOLEANS = {"False": "0", "True": "1"}  # how Wireshark 4.2 and later write them


def row(text: str) -> dict[str, str]:
    """Read a row of a table."""
    pairs = (entry.partition("=") for entry in text.split("; ") if entry)
    return {name: value or "there" for name, _, value in pairs}


def shown(tshark: Tshark, capture: Path, fields: str, *options: str, prefix: str = "sis.") -> dict[int, dict[str, str]]:
    """Return the fields that tshark shows, by frame, without empty ones."""
    names = fields.split()
    columns = [option for name in names for option in ("-e", prefix + name)]
    lines = tshark.output("-r", str(capture), *options, "-T", "fields", *columns).splitlines()
    frames = {}
    for number, line in enumerate(lines, 1):
        cells = [BOOLEANS.get(cell, cell) for cell in line.split("\t")]
        frames[number] = {name: cell for name, cell in zip(names, cells, strict=True) if cell}
    return frames


def check(  # noqa: PLR0913
    tshark: Tshark, name: str, fields: str, experts: str, table: Table, *options: str, prefix: str = "sis."
) -> None:
    """Compare NAME.pcapng with its table; without a prefix, fields have their full names there."""
    for passes in ((), ("-2",)):
        wrong = []
        frames = shown(tshark, HERE / f"{name}.pcapng", f"{fields} {experts}", *passes, *options, prefix=prefix)
        assert set(table) <= set(frames), "the table has more frames than the capture"
        for number, cells in frames.items():
            found = cells | {expert: "there" for expert in experts.split() if expert in cells}
            expected = row(table.get(number, ""))
            if not passes:
                expected = {field: value for field, value in expected.items() if field not in LATER | LATER_ELSEWHERE}
            if found != expected:
                wrong.append(f"frame {number} {' '.join(passes)}: shows {found}, expected {expected}")
        assert not wrong, "\n".join(wrong)
