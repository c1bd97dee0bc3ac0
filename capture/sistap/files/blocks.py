# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes the blocks of one capture: a section, an interface for each line when it appears, and packets."""

from __future__ import annotations

import platform
from collections.abc import Mapping

import sistap
from sistap.files import pcapng
from sistap.files.pcapng import Interface
from sistap.files.writer import packet_flags
from sistap.records.record import Record


class Blocks:
    """The blocks of a capture of link type upper-pdu."""

    def __init__(self, interfaces: Mapping[int, Interface]) -> None:
        """Describe each line as its interface; a line that appears later gets the description of the first."""
        self._described = interfaces
        self._numbers: dict[int, int] = {}  # of interfaces, for each line

    def section(self) -> bytes:
        """Return the section and all interfaces known so far."""
        system = f"{platform.system()} {platform.release()}"
        section = pcapng.section_header(f"sistap {sistap.__version__}", system)
        return section + b"".join(self.interface(line) for line in self._described)

    def interface(self, line: int) -> bytes:
        """Return the description of a new line; empty if it was described."""
        if line in self._numbers:
            return b""
        self._numbers[line] = len(self._numbers)
        described = self._described.get(line) or next(iter(self._described.values()))
        which = f", line {line}" if line else ""
        return pcapng.interface_description(described._replace(description=described.description + which))

    def packet(self, record: Record) -> bytes:
        """Return the block of a record whose line was described."""
        payload = pcapng.upper_pdu("sertap", record.pack())
        return pcapng.enhanced_packet(self._numbers[record.line], record.time_ns, payload, packet_flags(record))
