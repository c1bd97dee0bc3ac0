# SPDX-License-Identifier: GPL-2.0-or-later
"""The limits TzA and TrS that the user gives because the bus set them before the capture began."""

from __future__ import annotations

from collections.abc import Mapping

NAMES = {"tza": "TzA", "trs": "TrS"}
LARGEST_MS = 0xFFFF  # the largest that a telegram can set


def milliseconds(text: str) -> int:
    """Parse a limit. ValueError says what it must be."""
    if text.isascii() and text.isdigit() and len(text) < 9 and 0 < (value := int(text)) <= LARGEST_MS:
        return value
    raise ValueError(f"'{text}' is not a whole number of milliseconds from 1 to {LARGEST_MS}")


def limit_text(limit_s: float) -> str:
    """Write a limit, which is a whole number of ms."""
    return f"{limit_s * 1e3:g} ms"


def told(limits_ms: Mapping[str, int | None]) -> str:
    """Return limits as text that the dissector reads in a capture; empty if there are none."""
    return ", ".join(f"{NAMES[name]} = {value} ms" for name, value in limits_ms.items() if value)
