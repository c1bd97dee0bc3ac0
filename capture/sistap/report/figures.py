# SPDX-License-Identifier: GPL-2.0-or-later
"""The figures of a report, counted packet by packet in bounded memory, however long the capture is."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from dataclasses import dataclass, field

from sistap.accesses.listing import Listing, Place
from sistap.packets.dissection import LOST, Judged, Packet, Telegram
from sistap.packets.distribution import Distribution, Slices
from sistap.report.curves import Curves
from sistap.report.pauses import Pauses
from sistap.wireshark.rows import EVENT, FRAME, OTHER

EVENTS_KEPT = 20
SILENCE_S = 0.2  # after which an operator terminal gives up (IF02 chapter 10.1)


@dataclass
class Limit:
    """A time that the bus or a preference limits: what the dissector judged of it."""

    limits_s: Counter[float] = field(default_factory=Counter)
    verdicts: Counter[int | None] = field(default_factory=Counter)  # OK, EXCEEDED, UNRESOLVED; None: no limit known

    def add(self, judged: Judged) -> None:
        """Count one."""
        self.verdicts[judged.verdict] += 1
        if judged.limit_s is not None:
            self.limits_s[judged.limit_s] += 1


@dataclass
class Service:
    """The reactions of one service."""

    times: Distribution = field(default_factory=Distribution)
    trs: Limit = field(default_factory=Limit)


@dataclass
class Station:
    """What a station did, by the addresses of good telegrams: those of a damaged one may be anybody's."""

    commands: int = 0
    reactions: int = 0
    errors: int = 0  # reactions whose status is not 0
    repeats: int = 0  # commands that it sent again
    unanswered: int = 0  # commands to it
    times: Distribution = field(default_factory=Distribution)  # of its reactions
    trs: Limit = field(default_factory=Limit)
    tza: Limit = field(default_factory=Limit)
    longest_pause_s: float = 0.0


@dataclass
class Exactness:
    """How exact the times are, in s."""

    least_s: float = math.inf
    most_s: float = 0.0
    unknown: int = 0  # records without an uncertainty
    same_read: int = 0  # intervals inside telegrams whose two characters came in one read

    def add(self, packet: Packet) -> None:
        """Count a record of characters."""
        if packet.uncertainty_s is None:
            self.unknown += 1
        else:
            self.least_s = min(self.least_s, packet.uncertainty_s)
            self.most_s = max(self.most_s, packet.uncertainty_s)

    @property
    def is_known(self) -> bool:
        """Whether any record says how exact it is."""
        return self.least_s <= self.most_s


@dataclass
class Silences:
    """Those of the line before telegrams."""

    long: int = 0  # above SILENCE_S
    longest_s: float = 0.0
    before: int | None = None  # the packet after the longest

    def add(self, silence_s: float, packet: int) -> None:
        """Count one."""
        self.long += silence_s > SILENCE_S
        if silence_s > self.longest_s:
            self.longest_s, self.before = silence_s, packet


@dataclass
class Figures:
    """All of them; times in s."""

    packets: int = 0
    records: Counter[int | None] = field(default_factory=Counter)  # by type; None: no record of the tap
    telegrams: int = 0
    good: int = 0
    first_epoch_s: float | None = None
    duration_s: float = 0.0
    interfaces: Counter[str] = field(default_factory=Counter)
    settings: Counter[tuple[int, str]] = field(default_factory=Counter)  # rate and format
    events: list[Packet] = field(default_factory=list)  # the first ones
    exactness: Exactness = field(default_factory=Exactness)
    framings: Counter[int] = field(default_factory=Counter)  # frames that are no SIS telegrams, by framing
    frame_intervals: Distribution = field(default_factory=Distribution)  # inside those
    silences: Silences = field(default_factory=Silences)
    limits: dict[str, Limit] = field(default_factory=lambda: {name: Limit() for name in ("tza", "trs", "tmas")})
    services: defaultdict[int, Service] = field(default_factory=lambda: defaultdict(Service))
    stations: defaultdict[int, Station] = field(default_factory=lambda: defaultdict(Station))
    faults: Counter[str] = field(default_factory=Counter)  # packets that have each
    slices: Slices = field(default_factory=Slices)
    parameters: Listing = field(default_factory=Listing)
    curves: Curves = field(default_factory=Curves)
    pauses: Pauses = field(default_factory=Pauses)

    def add(self, packet: Packet) -> None:
        """Count a packet."""
        self.packets += 1
        self.records[packet.type] += 1
        self.interfaces[packet.interface] += 1
        if self.first_epoch_s is None:
            self.first_epoch_s = packet.epoch_s
        self.duration_s = max(self.duration_s, packet.end_s)
        if packet.type == EVENT and len(self.events) < EVENTS_KEPT:
            self.events.append(packet)
        if packet.type in (FRAME, OTHER):
            self._add_record(packet)
            self.pauses.add(packet)
        at = self.slices.at(packet.time_s)
        for telegram in packet.telegrams:
            self._add_telegram(telegram, at)
            if telegram.silence:
                self.silences.add(telegram.silence.time_s, packet.number)
            # In the first second it is the load of a shorter time, 100 % to begin with.
            if telegram.load_percent is not None and packet.time_s >= 1:
                self.slices.add_load(at, telegram.load_percent)
        for access in packet.accesses:
            self.parameters.add(Place("", packet.number, packet.epoch_s), access)
            self.curves.add(packet.time_s, access)
        for fault in packet.faults:
            self.faults[fault.name] += 1
            self.slices.counts[fault.name][at] += 1

    def _add_record(self, packet: Packet) -> None:
        self.exactness.add(packet)
        if packet.baud:
            self.settings[packet.baud, packet.format] += 1
        if packet.type == FRAME and packet.framing:
            self.framings[packet.framing] += 1
            if not packet.errors & LOST:
                self.frame_intervals.add(packet.intervals_s)
        # The time in which characters were lost is none between neighbours.
        if packet.telegrams and not packet.errors & LOST:
            self.exactness.same_read += packet.same_read

    def _add_telegram(self, telegram: Telegram, at: int) -> None:
        self.telegrams += 1
        for name, found in (("tza", telegram.pause), ("trs", telegram.reaction), ("tmas", telegram.cycle)):
            if found:
                self.limits[name].add(found)
        if telegram.reaction and telegram.service is not None:
            service = self.services[telegram.service]
            if telegram.reaction.time_s:
                service.times.put(telegram.reaction.time_s)
            service.trs.add(telegram.reaction)
        if telegram.good:
            self.good += 1
            self._add_stations(telegram, at)

    def _add_stations(self, telegram: Telegram, at: int) -> None:
        if telegram.unanswered and telegram.listener is not None:
            self.stations[telegram.listener].unanswered += 1
        if telegram.talker is None:
            return
        station = self.stations[telegram.talker]
        self.slices.counts[str(telegram.talker)][at] += 1
        if telegram.is_reaction:
            station.reactions += 1
            station.errors += telegram.is_refusal
        else:
            station.commands += 1
            station.repeats += telegram.is_repeat
        if telegram.reaction:
            if telegram.reaction.time_s:
                station.times.put(telegram.reaction.time_s)
            station.trs.add(telegram.reaction)
        if telegram.pause:
            station.tza.add(telegram.pause)
            station.longest_pause_s = max(station.longest_pause_s, telegram.pause.time_s)
