# SPDX-License-Identifier: GPL-2.0-or-later
"""Stations that are initialised: after the machine was switched on, or one alone after it restarted."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import chain

from sistap.dissected.episodes.episode import Hit, numbers
from sistap.dissected.episodes.faults import slave
from sistap.dissected.packets.dissection import Packet, Telegram
from sistap.dissected.wireshark.rows import EVENT
from sistap.tap.sis.codes import LIKE, LIKE_IF_SET

_IDENTIFY, _SET = 0x00, 0x03
_LIKE = chain(LIKE.items(), *(like.items() for like in LIKE_IF_SET.values()))
SWITCH = {0x1D, *(service for service, general in _LIKE if general == 0x1D)}  # those with a phase: set by a preference
STEPS = {_IDENTIFY, _SET, *SWITCH}
_READY = "4"  # operating mode (chapter 8.5)
# Topics of an initialisation: of stations that had answered before; the first one of some beside others, their numbers.
AGAIN = "again"
_APART_S = 60.0  # steps that follow one another within this time belong together


@dataclass
class _Boot:
    """Stations that are initialised together."""

    begin_s: float
    last_s: float
    packet: int
    stations: dict[int, set[int]] = field(default_factory=dict)  # the steps of each
    ready_s: float = 0.0
    phases: dict[int, str] = field(default_factory=dict)  # of the stations that were switched, the last one
    known: frozenset[int | None] = frozenset()  # stations that had answered before


class Boots:
    """Those of a bus."""

    def __init__(self, known: Collection[int | None]) -> None:
        """Begin with none; `known` are the stations that have answered until now."""
        self._boot: _Boot | None = None
        self._known = known
        self._has_begun = False  # an event has said where a capture or a file begins
        self._goes_on_s = -math.inf  # when a file began whose beginning is in another one: who answered there?
        self._away: set[int] = set()  # stations that ran, and were switched to another phase
        self._switched: list[Hit] = []  # how they were

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return what is over with a packet."""
        hits: list[Hit] = []
        boot = self._boot
        if boot and packet.epoch_s - boot.last_s > _APART_S:
            hits += self.finish(packet.interface)
        if packet.type == EVENT:
            if packet.is_seam:
                hits += self.finish(packet.interface)
                self._forget_switched()
            if packet.is_kept_apart or (packet.goes_on and not self._has_begun):
                self._goes_on_s = packet.epoch_s
            elif packet.is_seam:
                self._goes_on_s = -math.inf
            self._has_begun |= packet.is_seam or packet.goes_on
            return hits
        for telegram in packet.telegrams:
            if telegram.good and (telegram.service in STEPS or telegram.phase):
                self._step(packet, telegram)
        return hits

    def _step(self, packet: Packet, telegram: Telegram) -> None:
        station, service = slave(telegram), telegram.service or 0
        if station is None:
            return
        if not telegram.is_reaction and (telegram.phase if service in SWITCH else service in STEPS):
            if self._boot is None:
                self._boot = _Boot(packet.epoch_s, packet.ended_s, packet.number, known=frozenset(self._known))
            self._boot.stations.setdefault(station, set()).add(service)
            self._boot.last_s = packet.ended_s
        elif self._boot and telegram.phase and station in self._boot.stations:
            self._boot.phases[station] = telegram.phase
            if telegram.phase == _READY:
                self._boot.last_s = self._boot.ready_s = packet.ended_s

    def _forget_switched(self) -> None:
        self._away.clear()
        self._switched.clear()

    def finish(self, port: str) -> Iterator[Hit]:
        """Yield what is under way: of most stations, or of some alone."""
        boot, self._boot = self._boot, None
        if boot is None:
            return
        begun = {station for station, steps in boot.stations.items() if steps & SWITCH or {_IDENTIFY, _SET} <= steps}
        is_first = bool(begun) and not begun & boot.known and boot.begin_s - self._goes_on_s > _APART_S
        if is_first or (len(begun) > 1 and 2 * len(begun) >= len(self._known)):
            beside_others = " ".join(map(str, sorted(begun))) if boot.known else ""
            yield from self._together(port, boot, begun, beside_others if is_first else AGAIN)
            return
        for station in begun:
            steps = "identified, " if _IDENTIFY in boot.stations[station] else ""
            if boot.stations[station] - SWITCH:
                place = boot.packet, boot.begin_s, boot.last_s, station
                yield Hit("restart", *place, "", f"{steps}initialised again", port=port)

    def _together(self, port: str, boot: _Boot, begun: set[int], topic: str) -> Iterator[Hit]:
        """Yield an initialisation. Stations that run are only switched to another phase, unless all come back."""
        place = boot.packet, boot.begin_s, boot.last_s
        ready = f", ready {boot.ready_s - boot.begin_s:.0f} s later" if boot.ready_s else ""
        detail = f"{numbers(begun)}{ready}"
        hit = Hit("boot", *place, None, "", detail, float(len(begun)), port=port, topic=topic)
        if all(boot.stations[station] <= SWITCH for station in begun):
            if begun & boot.known and not ready:
                self._away |= begun
                self._switched.append(hit)
                return
            self._away -= begun
            if not self._away:
                yield from self._switched
                self._forget_switched()
        else:
            self._forget_switched()
        yield hit
        for station, phase in boot.phases.items() if ready else ():
            if phase != _READY:
                yield Hit("stuck", *place, station, "", f"stays in phase {phase}, others are in phase 4", port=port)
