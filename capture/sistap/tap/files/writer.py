# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes records into a pcapng file: one interface for each line, and first an event that describes the capture.

A file that continues another also begins with the telegrams that explain later ones. The next file does not begin
between a command and its reaction.
"""

from __future__ import annotations

import platform
import struct
from collections.abc import Mapping

import sistap
from sistap.tap.files import pcapng
from sistap.tap.files.output import Output
from sistap.tap.files.pcapng import Interface, PacketFlags, Statistics
from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.records.before import Before, heard
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Record, Type

MOST_AWAITED = 1000  # records that a full file still takes: long data come in many pieces

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


class Blocks:
    """The blocks of one capture: a section, an interface for each line when it appears, and packets."""

    def __init__(self, interfaces: Mapping[int, Interface], system: str | None = None) -> None:
        """Describe each line as its interface; a line that appears later gets the description of the first.

        `system` is that of the tap, by default this one; empty for a simulated one.
        """
        self._described = interfaces
        self._first = next(iter(interfaces.values()))
        self._system = f"{platform.system()} {platform.release()}" if system is None else system
        self.numbers: dict[int, int] = {}  # of interfaces, for each line, in the order of this section

    def section(self) -> bytes:
        """Begin a section; return its head and all interfaces known so far."""
        self.numbers = {}
        head = pcapng.section_header(f"sistap {sistap.__version__}", self._system)
        return head + b"".join(map(self.interface, self._described))

    def interface(self, line: int) -> bytes:
        """Return the description of a new line; empty if it was described."""
        if line in self.numbers:
            return b""
        self.numbers[line] = len(self.numbers)
        described = self._described.get(line) or self._first
        which = f", line {line}" if line else ""
        return pcapng.interface_description(described._replace(description=described.description + which))

    def holds(self, record: Record) -> bool:
        """Tell whether this link type can hold a record."""
        return record.type == Type.FRAME or self._first.link_type == pcapng.LINKTYPE_WIRESHARK_UPPER_PDU

    def packet(self, record: Record) -> bytes:
        """Return the block of a record whose line was described."""
        payload = self._payload(record)
        return pcapng.enhanced_packet(self.numbers[record.line], record.time_ns, payload, packet_flags(record))

    def _payload(self, record: Record) -> bytes:
        if self._first.link_type == pcapng.LINKTYPE_WIRESHARK_UPPER_PDU:
            return pcapng.upper_pdu("sertap", record.pack())
        if self._first.link_type == pcapng.LINKTYPE_RTAC_SERIAL:
            seconds, ns = divmod(record.time_ns, 1_000_000_000)
            return _RTAC_HEADER.pack(seconds, ns // 1000, rtac_event(record), 0, 0) + record.data
        return record.data


class PcapngWriter:
    """Writes the file in `output`, or each of several: begin, write, end."""

    def __init__(
        self, output: Output, interfaces: Mapping[int, Interface], counters: Counters, system: str | None = None
    ) -> None:
        """Describe lines and system as `Blocks` does; `counters` are for the statistics at the end of each file."""
        self.output = output
        self._blocks = Blocks(interfaces, system)
        self._counters = counters
        self._started: tuple[Record, ...] = ()
        self._settings: dict[int, LineSettings] = {}  # for each line, of its last record
        self._before = Before() if output.continues else None
        self._awaited = 0  # looks at a full file, one for each record

    def begin(self, *started: Record) -> None:
        """Begin the file: all interfaces known so far, and the events `started`."""
        self._started = self._started or started
        self.output.begin()
        self.output.write(self._blocks.section())
        for record in started:
            self._put(record)

    def write(self, record: Record) -> bool:
        """Write a record, into the next file if this one is full; return whether this link type can hold it."""
        self.look(record.time_ns)
        if self._before:
            self._before.take(heard(record))
        return self._put(record)

    def _put(self, record: Record) -> bool:
        self._settings[record.line] = record.settings
        if not self._blocks.holds(record):
            return False
        if described := self._blocks.interface(record.line):
            self.output.write(described)
        self.output.write(self._blocks.packet(record))
        return True

    def look(self, time_ns: int) -> None:
        """Continue with the next file if this one is full, and nothing is under way that belongs together."""
        output, before = self.output, self._before
        if not output.full or output.done or not before:
            return
        if before.is_under_way(time_ns) and self._awaited < MOST_AWAITED:
            self._awaited += 1
            return
        if output.open_next():
            self.end(time_ns)
            output.go_on()
            self._awaited = 0
            self.begin(*(self._again(started, time_ns) for started in self._started))
            for record in before.records(time_ns, output.heading_bytes):
                self._put(record)

    def end(self, time_ns: int) -> None:
        """End the file with the statistics of its interfaces."""
        started_ns = self._started[0].time_ns if self._started else time_ns
        counters = self._counters
        for line, interface in self._blocks.numbers.items():
            received, accepted = counters.received[line], counters.accepted[line]
            statistics = Statistics(started_ns, time_ns, received, accepted, counters.gaps[line])
            self.output.write(pcapng.interface_statistics(interface, statistics))

    def _again(self, started: Record, time_ns: int) -> Record:
        """Begin another file with the present settings of each line."""
        settings = self._settings.get(started.line, started.settings)
        return started._replace(time_ns=time_ns, settings=settings)
