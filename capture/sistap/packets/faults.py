# SPDX-License-Identifier: GPL-2.0-or-later
"""Which faults a packet has, of those that display filters find."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from sistap.line.settings import Flag
from sistap.packets.dissection import EXCEEDED, Judged, Packet, Telegram
from sistap.records.record import Event
from sistap.sis.faults import FAULTS, Fault

LOST = int(Flag.LOST_BEFORE)


def _exceeded(judged: Judged | None) -> bool:
    return judged is not None and judged.verdict == EXCEEDED


_OF_TELEGRAM: Mapping[str, Callable[[Telegram], bool]] = {
    "damaged": lambda telegram: not telegram.good,
    "tza_exceeded": lambda telegram: _exceeded(telegram.pause),
    "trs_exceeded": lambda telegram: _exceeded(telegram.reaction),
    "tmas_exceeded": lambda telegram: _exceeded(telegram.cycle),
    "error_reaction": lambda telegram: telegram.good and telegram.is_refusal,
    "system_error": lambda telegram: telegram.good and telegram.has_system_error,
    "unanswered": lambda telegram: telegram.unanswered,
}
_OF_PACKET: Mapping[str, Callable[[Packet], bool]] = {
    "lost": lambda packet: bool(packet.errors & LOST) or packet.event in (Event.CHARACTERS_LOST, Event.ADAPTER_LOST),
    "line_error": lambda packet: bool(packet.errors & ~LOST),
}
COUNTED = [fault for fault in FAULTS if fault.name in _OF_TELEGRAM or fault.name in _OF_PACKET]
_TELEGRAMS = [(fault, _OF_TELEGRAM[fault.name]) for fault in COUNTED if fault.name in _OF_TELEGRAM]
_PACKETS = [(fault, _OF_PACKET[fault.name]) for fault in COUNTED if fault.name in _OF_PACKET]


def faults(packet: Packet) -> Iterator[Fault]:
    """Yield the faults of a packet."""
    for fault, of_packet in _PACKETS:
        if of_packet(packet):
            yield fault
    for fault, of_telegram in _TELEGRAMS if packet.telegrams else ():
        if any(map(of_telegram, packet.telegrams)):
            yield fault
