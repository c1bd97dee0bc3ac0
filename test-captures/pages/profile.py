# SPDX-License-Identifier: GPL-2.0-or-later
"""The filter buttons of Wireshark's profile, which lessons and poster name."""

from __future__ import annotations

from csv import reader
from pathlib import Path

import sistap

PROFILE = Path(sistap.__file__).parent / "profile" / "SIS"


def buttons() -> list[tuple[str, str, str]]:
    """Return the filter buttons: word, filter, and what it is for."""
    lines = (PROFILE / "dfilter_buttons").read_text().splitlines()
    return [(row[1], row[2], row[3]) for row in reader(lines) if row[0] == "TRUE"]
