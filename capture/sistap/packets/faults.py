# SPDX-License-Identifier: GPL-2.0-or-later
"""Which faults a packet has: those whose display filters find it."""

from __future__ import annotations

from collections.abc import Iterator

from sistap.line.settings import Flag
from sistap.packets.dissection import Packet
from sistap.sis.faults import FAULTS, Fault
from sistap.wireshark.rows import passes

LOST = int(Flag.LOST_BEFORE)


def faults(packet: Packet) -> Iterator[Fault]:
    """Return the faults of a packet."""
    return (fault for fault in FAULTS if passes(fault.tests, packet.columns))
