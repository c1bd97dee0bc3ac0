# SPDX-License-Identifier: GPL-2.0-or-later
"""The telegrams of a log as a capture: the blocks of a pcapng file."""

from __future__ import annotations

import platform

import sistap
from sistap.commands.annotate.marks import RECEIVED, SENT, SHARED
from sistap.tap.files import pcapng, writer
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.record import Event, Record, event

# The number of an interface is that of its line. An exchange stays on one line, or on the pair of directions.
_INTERFACES = {SHARED: "log", RECEIVED: "log, received", SENT: "log, sent"}


class LogBlocks:
    """Makes the blocks of one capture. Its first packet is an event that names the log."""

    def __init__(self, log: str) -> None:
        """Nothing has been made yet; `log` is the name of the log."""
        self._log = log
        self._begun = False

    def packet(self, record: Record) -> bytes:
        """Return the block of a record, preceded by the blocks that begin a file if it is the first."""
        block = _packet(record)
        if self._begun:
            return block
        self._begun = True
        return self._beginning(record.time_ns) + block

    def _beginning(self, time_ns: int) -> bytes:
        system = f"{platform.system()} {platform.release()}"
        blocks = [pcapng.section_header(f"sistap {sistap.__version__}", system)]
        for name in _INTERFACES.values():
            interface = pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, name, f"from {self._log}")
            blocks.append(pcapng.interface_description(interface))
        text = f"made from {self._log} by sistap annotate"
        blocks.append(_packet(event(time_ns, SHARED, LineSettings(baud=0), Event.CAPTURE_STARTED, text)))
        return b"".join(blocks)


def _packet(record: Record) -> bytes:
    payload = pcapng.upper_pdu("sertap", record.pack())
    return pcapng.enhanced_packet(record.line, record.time_ns, payload, writer.packet_flags(record))
