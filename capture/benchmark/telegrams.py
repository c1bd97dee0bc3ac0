# SPDX-License-Identifier: GPL-2.0-or-later
"""The traffic of both benchmarks: commands and reactions of a master (16) and two drives (3 and 4), 8 to 19 bytes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

from sistap.tap.sis.telegram import build

# Service, telegram number, body of the command, body of the reaction (IF02 chapters 3 to 9); {} is the drive.
_EXCHANGES = [
    (0x12, None, b"", b"\x00\x04"),  # the phase is 4
    (0x10, None, b"\x3c{}\x00\x2c\x00", b"\x00\x3c{}\x02\x00\x00\x00"),  # S-0-0044
    (0x10, None, b"\x3c{}\x00\x33\x00", b"\x00\x3c{}\x10\x27\x00\x00"),  # S-0-0051
    (0x1F, None, b"\x3c{}\x00\x24\x00\xe8\x03\x00\x00", b"\x00\x3c{}"),  # S-0-0036
    (0x80, None, b"\x3c{}\x00\x0c\x80", b"\x00\x3c{}\x01\x00"),  # P-0-0012
    (0x8F, None, b"\x3c{}\x00\x0c\x80\x05\x00", b"\x00\x3c{}"),
    (0x00, 1, b"{}\x01", b"\x00{}\x0101V01"),
    (0x00, 2, b"{}\x04", b"\x00{}\x04\x0f"),
    (0x10, None, b"\x3c{}\x00\x11\x00", b"\x00\x3c{}\x28\x00\x29\x00\x2a\x00\x2b\x00"),  # S-0-0017, a list
]


def telegrams() -> Iterator[bytes]:
    """Yield telegrams endlessly, always the same; commands and reactions take turns."""
    for service, number, command, reaction in itertools.cycle(_EXCHANGES):
        for drive in (3, 4):
            for is_reaction, body in enumerate((command, reaction)):
                body_of_drive = body.replace(b"{}", bytes([drive]))
                yield build(service, 16, drive, body_of_drive, reaction=bool(is_reaction), number=number)
