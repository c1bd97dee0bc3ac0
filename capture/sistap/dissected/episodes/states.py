# SPDX-License-Identifier: GPL-2.0-or-later
"""Changes of the state of the bus and of the tap: phases, rate, limits, devices, clock, adapter, the capture itself."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator

from sistap.dissected.episodes.boots import SWITCH
from sistap.dissected.episodes.episode import ARROW, Hit
from sistap.dissected.episodes.faults import hit_of, slave
from sistap.dissected.episodes.rules import THRESHOLDS, Severity, Thresholds
from sistap.dissected.packets.dissection import Packet, Telegram
from sistap.dissected.wireshark.rows import EVENT
from sistap.tap.records.record import CLOCK_MOVED, Event
from sistap.tap.sis.limits import limit_text

_MOVED = re.compile(CLOCK_MOVED.replace("{:+.3f}", r"([-+][\d.]+)") + r"|system time jumped by ([-+][\d.]+) s")
_IDENTIFY = 0x00
_IDENTITY = {"sis.firmware": "firmware", "sis.type_key": "type key"}


class PhaseChanges:
    """The communication phase of each station."""

    def __init__(self, thresholds: Thresholds = THRESHOLDS, before: PhaseChanges | None = None) -> None:
        """Begin with those of a good capture, or with none known."""
        self._thresholds = thresholds
        self._phases: dict[int, str] = dict(before._phases) if before else {}
        self._switched_s: dict[int, float] = {}

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return switches, and phases that changed by themselves."""
        hits: list[Hit] = []
        for telegram in packet.telegrams:
            if telegram.phase and telegram.good:
                hits += self._of(packet, telegram, telegram.phase)
        return hits

    def _of(self, packet: Packet, telegram: Telegram, phase: str) -> Iterator[Hit]:
        station = slave(telegram)
        if station is None:
            return
        before = self._phases.get(station, "")
        if telegram.service in SWITCH:
            self._switched_s[station] = packet.epoch_s
        elif packet.epoch_s - self._switched_s.get(station, -math.inf) < self._thresholds.switching_s:
            return
        self._phases[station] = phase
        if before != phase and (before or telegram.service in SWITCH):
            yield hit_of("phase", packet, station, f"{before or 'unknown'}{ARROW}{phase}")


class RateChanges:
    """The rate of the line."""

    def __init__(self, before: RateChanges | None = None) -> None:
        """Begin with that of a good capture, or with none known."""
        self._baud: int = before._baud if before else 0

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return a change. What a file begins with again may be older."""
        if packet.is_again:
            return ()
        before, self._baud = self._baud, packet.baud or self._baud
        if before in (0, self._baud):
            return ()
        return (hit_of("rate", packet, None, f"{before}{ARROW}{self._baud} Bd"),)


class LimitChanges:
    """TzA and TrS of each station."""

    def __init__(self, before: LimitChanges | None = None) -> None:
        """Begin with those of a good capture, or with none known."""
        self._limits: dict[tuple[str, int], float] = dict(before._limits) if before else {}

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return changes; the first ones known are none."""
        hits: list[Hit] = []
        for telegram in packet.telegrams:
            if not telegram.good or not telegram.is_reaction or telegram.talker is None:
                continue
            for name, judged in (("TzA", telegram.pause), ("TrS", telegram.reaction)):
                if judged and judged.limit_s is not None:
                    before = self._limits.get((name, telegram.talker))
                    if before != judged.limit_s:
                        self._limits[name, telegram.talker] = judged.limit_s
                        hits += _changed(packet, telegram.talker, name, before, judged.limit_s)
        return hits


def _changed(packet: Packet, station: int, name: str, before_s: float | None, limit_s: float) -> Iterator[Hit]:
    if before_s is not None:
        change = f"{name} {before_s * 1e3:g}{ARROW}{limit_text(limit_s)}"
        yield hit_of("limits", packet, station, change)._replace(topic=change)


class TapTroubles:
    """What happened to the tap: its clock, its adapter, the capture."""

    def __init__(self, thresholds: Thresholds = THRESHOLDS) -> None:
        """Begin with no packet."""
        self._thresholds = thresholds
        self._ends_s: dict[int | None, float] = {}  # of the last characters since the last seam, by line
        self._began_s: float | None = None  # the last seam

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return what a packet says of it."""
        if packet.type == EVENT:
            end_s = None if packet.is_kept_apart else max(self._ends_s.values(), default=self._began_s)
            if packet.is_seam:
                self._ends_s, self._began_s = {}, packet.epoch_s
            return self._event(packet, end_s)
        end_s = self._ends_s.get(packet.line)
        self._ends_s[packet.line] = packet.ended_s
        if end_s is None:
            return ()
        if packet.since_s is not None:
            jump_s = packet.epoch_s - packet.since_s - end_s
            return (self._jump(packet, jump_s),) if abs(jump_s) > self._thresholds.clock_s else ()
        is_back = packet.epoch_s < end_s - self._thresholds.clock_s
        return (self._jump(packet, packet.epoch_s - end_s),) if is_back else ()

    def _event(self, packet: Packet, end_s: float | None) -> Iterator[Hit]:
        if packet.event == Event.ADAPTER_LOST:
            yield hit_of("adapter", packet, None, packet.text)
        elif packet.event == Event.CAPTURE_STARTED and not packet.is_again:
            gap_s = 0.0 if end_s is None else packet.epoch_s - end_s
            if abs(gap_s) > self._thresholds.clock_s:  # the other line of a tap begins at once
                hit = hit_of("gap", packet, None, f"{gap_s:.0f} s between two captures")
                yield hit._replace(from_s=packet.epoch_s - max(gap_s, 0.0))
        elif moved := _MOVED.search(packet.text):
            step = moved[1] or moved[2]
            hit = hit_of("clock", packet, None, f"{step} s; the times of the capture go on without the jump")
            yield hit._replace(worst=float(step), severity=Severity.NOTE)

    def _jump(self, packet: Packet, jump_s: float) -> Hit:
        return hit_of("clock", packet, None, f"{jump_s:+.0f} s")._replace(
            worst=jump_s, to_s=packet.epoch_s + max(-jump_s, 0.0)
        )


class Devices:
    """Which device is at an address of a bus: its firmware and type key (service 0x00)."""

    def __init__(self, before: Devices | None = None) -> None:
        """Begin with those of a good capture, or with none known."""
        self._known: dict[tuple[int, str], str] = dict(before._known) if before else {}

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return that another device answers."""
        hits: list[Hit] = []
        for telegram in packet.telegrams:
            if telegram.service == _IDENTIFY and telegram.is_reaction and telegram.good and not telegram.is_refusal:
                hits += self._of(packet, telegram)
        return hits

    def _of(self, packet: Packet, telegram: Telegram) -> Iterator[Hit]:
        station = telegram.talker
        for field, name in _IDENTITY.items():
            text = telegram.columns.get(field, "")
            if not text or station is None:
                continue
            before = self._known.get((station, name))
            self._known[station, name] = text
            if before not in (None, text):
                yield hit_of("exchanged", packet, station, f"{name} {before}{ARROW}{text}", topic=name)
