# SPDX-License-Identifier: GPL-2.0-or-later
"""Hits in single packets: times against their limits, damage, errors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from sistap.accesses.access import accesses
from sistap.episodes.episode import Hit
from sistap.episodes.rules import Severity
from sistap.packets.dissection import DOUBTFUL, EXCEEDED, LOST, Judged, Packet, Telegram
from sistap.records.record import Event, interval_text
from sistap.sis.telegram import service_name
from sistap.wireshark.rows import OTHER

_ALL = 255  # the address of all stations
_KINDS = {"damaged": "damaged", "error_reaction": "error"}  # of faults in the table
_LIMITS = (("late", "TrS", "reaction"), ("interval", "TzA", "pause"), ("cycle", "Tmas", "cycle"))


def ms(time_s: float) -> str:
    """Write a time as the dissector writes it."""
    return interval_text(round(time_s * 1e9))


def slave(telegram: Telegram) -> int | None:
    """Return the station that a telegram is about: not the master; None for all stations."""
    station = telegram.talker if telegram.is_reaction else telegram.listener
    return None if station == _ALL else station


class Faults:
    """Those of a port."""

    def __init__(self) -> None:
        """Begin without a command."""
        self._asked: int | None = None  # the station whose reaction is due

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return the hits of a packet."""
        bad = 0
        for telegram in packet.telegrams:
            bad += not telegram.good
        is_other = packet.type == OTHER and self._asked is not None
        hits: list[Hit] = []
        if bad or is_other or packet.errors or packet.event == Event.CHARACTERS_LOST:
            hits += self._damage(packet, bad, is_other=is_other)
        for telegram in packet.telegrams:
            if telegram.good:
                if telegram.is_doubtful:
                    hits += _limits(packet, telegram)
                if telegram.has_system_error or telegram.is_refusal:
                    hits += _errors(packet, telegram)
                self._asked = None if telegram.is_reaction else telegram.listener
        if packet.faults and not hits:
            hits += _others(packet)
        return hits

    def _damage(self, packet: Packet, bad: int, *, is_other: bool) -> Iterator[Hit]:
        """Yield damage: of one cause, the first that is known. Its station is the one whose telegram was due."""
        station = self._asked
        if station is None and packet.telegrams:
            station = slave(packet.telegrams[0])
        what = "in a telegram that is damaged" if bad or is_other else "in a telegram that is not damaged"
        if packet.errors & ~LOST:
            yield _hit("line_error", packet, station, what)
        elif packet.errors & LOST:
            yield _hit("lost", packet, station, what)
        elif packet.event == Event.CHARACTERS_LOST:
            yield _hit("lost", packet, None, packet.text)
        elif bad or is_other:
            for _ in range(bad or 1):
                yield _hit("damaged", packet, station, "its checksum is wrong" if bad else "its rest is not a telegram")


def _limits(packet: Packet, telegram: Telegram) -> Iterator[Hit]:
    for kind, name, field in _LIMITS:
        judged: Judged | None = getattr(telegram, field)
        if not judged or judged.verdict not in DOUBTFUL or (kind == "interval" and packet.errors & LOST):
            continue
        limit = f", {name} {judged.limit_s * 1e3:g} ms" if judged.limit_s is not None else ""
        position = f" before character {telegram.pause_position}" if kind == "interval" else ""
        perhaps = "" if judged.verdict == EXCEEDED else "perhaps: "
        yield _hit(
            kind,
            packet,
            telegram.talker,
            f"{perhaps}{ms(judged.time_s)}{position}{limit}",
            worst=judged.time_s,
            severity=None if judged.verdict == EXCEEDED else Severity.NOTE,
            topic=perhaps,
        )


def _others(packet: Packet) -> Iterator[Hit]:
    """Yield faults that other fields tell: a good checksum with a wrong length, an error of the ASCII protocol."""
    found = [(slave(telegram), telegram.faults) for telegram in packet.telegrams] or [(None, packet.faults)]
    for station, faults in found:
        for kind in (_KINDS[fault.name] for fault in faults if fault.name in _KINDS):
            yield _hit(kind, packet, station)


def _errors(packet: Packet, telegram: Telegram) -> Iterator[Hit]:
    if telegram.has_system_error:
        yield _hit("system_error", packet, telegram.talker)
    if not telegram.is_refusal:
        return
    said = packet.accesses if len(packet.telegrams) == 1 else accesses(telegram.columns)
    errors = [access for access in said if access.error]
    service = service_name(telegram.service or 0)
    what = errors[0].error if errors else f"{service}, status 0x{telegram.status or 0:02x}"
    parameter = errors[0].parameter.ident if errors else ""
    yield _hit("error", packet, telegram.talker, what, parameter=parameter, topic=what)


def _hit(kind: str, packet: Packet, station: int | None, detail: str = "", **more: Any) -> Hit:
    found = Hit(kind, packet.number, packet.epoch_s, packet.ended_s, station, detail=detail, port=packet.interface)
    return found._replace(**more)
