# SPDX-License-Identifier: GPL-2.0-or-later
"""A table of text: columns two spaces apart."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence


def aligned(rows: Sequence[Sequence[str]], right: Container[str] = ()) -> Iterator[str]:
    """Yield a line for each row. Columns with these heads, in the first row, are aligned at their right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = zip(rows[0], row, widths, strict=True)
        yield "  ".join(
            text.rjust(width) if head in right else text.ljust(width) for head, text, width in cells
        ).rstrip()
