# SPDX-License-Identifier: GPL-2.0-or-later
"""The limits TzA and TrS, where a person tells them because the bus was not heard setting them."""

from __future__ import annotations

import argparse
from collections.abc import Mapping

NAMES = {"tza": "TzA", "trs": "TrS"}
LARGEST_MS = 0xFFFF  # that a telegram can set


def milliseconds(text: str) -> int:
    """Read a limit. ValueError says what it has to be."""
    if text.isascii() and text.isdigit() and len(text) < 9 and 0 < (value := int(text)) <= LARGEST_MS:
        return value
    raise ValueError(f"'{text}' is not a whole number of milliseconds from 1 to {LARGEST_MS}")


def argument(text: str) -> int:
    """Read a limit, as an argument."""
    try:
        return milliseconds(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def told(limits_ms: Mapping[str, int | None]) -> str:
    """Write limits as the dissector reads them in a capture; empty where there are none."""
    return ", ".join(f"{NAMES[name]} = {value} ms" for name, value in limits_ms.items() if value)
