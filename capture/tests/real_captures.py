# SPDX-License-Identifier: GPL-2.0-or-later
"""Captures of real drivers (real-captures/README.md), and what was really sent."""

from __future__ import annotations

import json
import lzma
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent / "real-captures"


class Truth(NamedTuple):
    """What went over a line."""

    received: bytes
    sent: bytes
    errors: dict[int, int]  # line status of a FT232R by number of the received character
    packets: list[tuple[int, int]]  # their sizes in characters, and their status


def unpacked(name: str, folder: Path) -> Path:
    """Unpack a capture into a folder."""
    file = folder / name
    file.write_bytes(lzma.decompress((HERE / f"{name}.xz").read_bytes()))
    return file


def truth(name: str) -> Truth:
    """Return what was sent and received while a capture was taken."""
    said = json.loads(lzma.decompress((HERE / "truth.json.xz").read_bytes()))[name]
    return Truth(
        bytes.fromhex(said["received"]),
        bytes.fromhex(said.get("sent", "")),
        {int(place): status for place, status in said.get("errors", {}).items()},
        list(map(tuple, said.get("packets", []))),
    )
