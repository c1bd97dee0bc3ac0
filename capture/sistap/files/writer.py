# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes records into a pcapng file: one interface for each line, and first an event that describes the capture."""

from __future__ import annotations

import platform
import struct
from collections.abc import Mapping

import sistap
from sistap.files import pcapng
from sistap.files.output import Output
from sistap.files.pcapng import Interface, PacketFlags, Statistics
from sistap.line.settings import Flag, LineSettings
from sistap.records.counters import Counters
from sistap.records.record import Record, Type

UPPER_PDU, RTAC = "upper-pdu", "rtac"
LINK_TYPES = {
    UPPER_PDU: pcapng.LINKTYPE_WIRESHARK_UPPER_PDU,
    RTAC: pcapng.LINKTYPE_RTAC_SERIAL,
    **{f"user{i}": pcapng.LINKTYPE_USER0 + i for i in range(16)},
}

# LINKTYPE_RTAC_SERIAL: seconds, microseconds, event, state of the control lines (unknown), footer.
_RTAC_HEADER = struct.Struct(">IIBBH")
_RTAC_SENT, _RTAC_RECEIVED, _RTAC_LOST, _RTAC_FRAMING, _RTAC_PARITY, _RTAC_BREAK = 1, 2, 5, 7, 8, 9

_DIRECTIONS = {1: int(PacketFlags.INBOUND), 2: int(PacketFlags.OUTBOUND)}
_SYMBOL_ERRORS = Flag.CHARACTER_ERROR | Flag.BREAK | Flag.UNLOCATED_ERROR


def packet_flags(record: Record) -> int:
    """Return the packet flags of a record."""
    errors = record.errors
    return (
        _DIRECTIONS.get(record.line, 0)
        | (PacketFlags.SYMBOL_ERROR if errors and errors & _SYMBOL_ERRORS else 0)
        | (PacketFlags.CRC_ERROR if record.checksum_bad else 0)
    )


def rtac_event(record: Record) -> int:
    """Return the event of a record's RTAC header: the most serious error, else the direction."""
    errors = record.errors
    if errors & Flag.LOST_BEFORE:
        return _RTAC_LOST
    if errors & Flag.BREAK:
        return _RTAC_BREAK
    if errors & Flag.CHARACTER_ERROR:
        return _RTAC_FRAMING if record.settings.parity == "N" else _RTAC_PARITY
    return _RTAC_SENT if record.line == 2 else _RTAC_RECEIVED


class PcapngWriter:
    """Writes the file in `output`, or each of several: begin, write, end."""

    def __init__(self, output: Output, interfaces: Mapping[int, Interface], counters: Counters) -> None:
        """Describe each line as its interface; a line that appears later gets the description of the first."""
        self._output = output
        self._described = interfaces
        self._counters = counters
        self._interfaces: dict[int, int] = {}  # for each line, in the order of this file
        self._started: tuple[Record, ...] = ()
        self._settings: dict[int, LineSettings] = {}  # for each line, of its last record

    def begin(self, *started: Record) -> None:
        """Begin the file: all interfaces known so far, and the events `started`."""
        self._started = self._started or started
        self._interfaces = {}
        self._output.begin()
        system = f"{platform.system()} {platform.release()}"
        self._output.write(pcapng.section_header(f"sistap {sistap.__version__}", system))
        for line in self._described:
            self._interface_of(line)
        for record in started:
            self.write(record)

    def write(self, record: Record) -> bool:
        """Write a record, into the next file if this one is full; return whether this link type can hold it."""
        self.look(record.time_ns)
        self._settings[record.line] = record.settings
        payload = self._payload(record)
        if payload is None:
            return False
        interface = self._interface_of(record.line)
        self._output.write(pcapng.enhanced_packet(interface, record.time_ns, payload, packet_flags(record)))
        return True

    def look(self, time_ns: int) -> None:
        """Continue with the next file if this one is full."""
        if self._output.full and not self._output.done and self._output.open_next():
            self.end(time_ns)
            self._output.go_on()
            self.begin(*(self._again(started, time_ns) for started in self._started))

    def end(self, time_ns: int) -> None:
        """End the file with the statistics of its interfaces."""
        started_ns = self._started[0].time_ns if self._started else time_ns
        counters = self._counters
        for line, interface in self._interfaces.items():
            received, accepted = counters.received[line], counters.accepted[line]
            statistics = Statistics(started_ns, time_ns, received, accepted, counters.gaps[line])
            self._output.write(pcapng.interface_statistics(interface, statistics))

    def _again(self, started: Record, time_ns: int) -> Record:
        """Begin another file with the present settings of each line."""
        settings = self._settings.get(started.line, started.settings)
        return started._replace(time_ns=time_ns, settings=settings)

    def _interface_of(self, line: int) -> int:
        if line not in self._interfaces:
            self._interfaces[line] = len(self._interfaces)
            described = self._described.get(line) or next(iter(self._described.values()))
            which = f", line {line}" if line else ""
            description = described.description + which
            self._output.write(pcapng.interface_description(described._replace(description=description)))
        return self._interfaces[line]

    def _payload(self, record: Record) -> bytes | None:
        link_type = next(iter(self._described.values())).link_type
        if link_type == LINK_TYPES[UPPER_PDU]:
            return pcapng.upper_pdu("sertap", record.pack())
        if record.type != Type.FRAME:
            return None
        if link_type == LINK_TYPES[RTAC]:
            seconds, ns = divmod(record.time_ns, 1_000_000_000)
            return _RTAC_HEADER.pack(seconds, ns // 1000, rtac_event(record), 0, 0) + record.data
        return record.data
