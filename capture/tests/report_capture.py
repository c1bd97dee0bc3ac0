# SPDX-License-Identifier: GPL-2.0-or-later
"""A capture whose every figure is known because it was made of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from sistap.tap.files import pcapng
from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.records.record import INTERVAL_MAX, Event, Framing, Record, Type, event
from sistap.tap.sis.telegram import build

LINE = LineSettings()  # 9600 8E1
START_NS = 1_700_000_000_000_000_000
UNCERTAINTY_NS = 310_000
STARTED = 'test <b>adapter</b> & "quotes"'

# Limits to all stations, valid at once with 0xFF (chapter 7): TzA 5 ms, TrS 50 ms.
SET_TZA = build(0x03, 16, 255, bytes.fromhex("FF 02 05 00"))
SET_TRS = build(0x03, 16, 255, bytes.fromhex("FF 01 32 00"))
ACCEPT = build(0x03, 16, 255, bytes.fromhex("FF FF"))
READ = build(0x10, 16, 3, bytes.fromhex("3C 03 00 28 00"))
READ_4 = build(0x10, 16, 4, bytes.fromhex("3C 04 00 28 00"))
ANSWER = build(0x10, 16, 3, bytes.fromhex("00 3C 03 E8 03"), reaction=True)
ANSWER_4 = build(0x10, 16, 4, bytes.fromhex("01 3C 04 01 10"), reaction=True)
DAMAGED = ANSWER[:-1] + bytes([ANSWER[-1] ^ 1])


class Sent(NamedTuple):
    """A telegram, or other characters, on the line."""

    data: bytes
    silence_ms: float = 25.0  # from the last character before it to its first
    pauses_ms: Mapping[int, float] = {}  # before its characters, counted from 1
    flags: Mapping[int, Flag] = {}
    uncertainty_ns: int = UNCERTAINTY_NS
    type: Type = Type.FRAME
    framing: Framing = Framing.SIS


# Packet 1 is the event. The exchanges: one as it should be, and one of each fault.
BUS = [
    Sent(SET_TZA),  # 2
    Sent(SET_TRS),
    Sent(ACCEPT),
    Sent(READ),  # 5
    Sent(ANSWER),
    Sent(READ, pauses_ms={6: 7.5}),  # 7: a pause longer than TzA
    Sent(ANSWER),
    Sent(READ_4),
    Sent(ANSWER_4, silence_ms=80.0),  # 10: later than TrS, with an error
    Sent(READ, silence_ms=40.0),  # 11: nobody answers
    Sent(READ_4, silence_ms=100.0),
    Sent(ANSWER_4, pauses_ms={4: 5.2}, uncertainty_ns=500_000),  # 13: perhaps longer than TzA, perhaps not
    Sent(READ, flags={3: Flag.CHARACTER_ERROR}),
    Sent(DAMAGED),  # 15: so this command has no reaction either
    Sent(READ, flags={12: Flag.SAME_READ, 13: Flag.SAME_READ}),
    Sent(ANSWER, flags={2: Flag.LOST_BEFORE}, pauses_ms={2: 3.0}),  # 17
    Sent(b"A03\r\n", type=Type.OTHER),
]


def records(sent: Iterable[Sent], started: str = STARTED) -> list[Record]:
    """Make the records, one after the other."""
    made = [event(START_NS, 0, LINE, Event.CAPTURE_STARTED, started)]
    last_ns = START_NS
    for number, item in enumerate(sent):
        intervals = [round(item.silence_ms * 1e6)] + [LINE.character_ns] * (len(item.data) - 1)
        flags = bytearray(len(item.data))
        for place, flag in item.flags.items():
            flags[place - 1] |= flag
            intervals[place - 1] = 0 if flag == Flag.SAME_READ else intervals[place - 1]
        for place, pause_ms in item.pauses_ms.items():
            intervals[place - 1] = round(pause_ms * 1e6)
        if number == 0:
            flags[0] |= Flag.INTERVAL_UNKNOWN
        first_ns = last_ns + intervals[0]
        last_ns = first_ns + sum(intervals[1:])
        if intervals[0] > INTERVAL_MAX:
            intervals[0] = INTERVAL_MAX
            flags[0] |= Flag.INTERVAL_SATURATED
        record = Record(first_ns, item.type, 0, LINE, item.data, intervals, bytes(flags), item.uncertainty_ns)
        made.append(record._replace(framing=item.framing))
    return made


def write(path: Path, sent: Iterable[Sent], dissector: str = "sertap", started: str = STARTED) -> Path:
    """Write a capture: of records, or of bare telegrams for dissector `sis`."""
    interface = pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, "test port")
    blocks = [pcapng.section_header("test", ""), pcapng.interface_description(interface)]
    for record in records(sent, started):
        if dissector == "sertap":
            blocks.append(pcapng.enhanced_packet(0, record.time_ns, pcapng.upper_pdu("sertap", record.pack())))
        elif record.type == Type.FRAME:
            blocks.append(pcapng.enhanced_packet(0, record.time_ns, pcapng.upper_pdu(dissector, record.data)))
    path.write_bytes(b"".join(blocks))
    return path
