# SPDX-License-Identifier: GPL-2.0-or-later
"""The figures of a report, counted in bounded memory, however long the capture is.

Most packets are alike: they say the same, but for their times. So those of a moment are counted together.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field

from sistap.commands.report.curves import Curves
from sistap.commands.report.pauses import Pauses
from sistap.dissected.accesses.listing import AccessPlace, Listing
from sistap.dissected.packets.dissection import LOST, Judged, Packet, Telegram
from sistap.dissected.packets.distribution import Distribution, Slices
from sistap.dissected.wireshark.rows import EVENT, FRAME, OTHER

EVENTS_KEPT = 20
TOGETHER = 256  # packets that wait to be counted: with more, they leave the cache of the processor
SILENCE_S = 0.2  # after which an operator terminal gives up (IF02 chapter 10.1)


@dataclass
class Limit:
    """A time that the bus or a preference limits: what the dissector judged of it."""

    limits_s: set[float] = field(default_factory=set)  # those that held
    verdicts: Counter[int | None] = field(default_factory=Counter)  # OK, EXCEEDED, UNRESOLVED; None: no limit known

    def add(self, judged: Judged, count: int) -> None:
        """Count so many that were judged in the same way."""
        self.verdicts[judged.verdict] += count
        if judged.limit_s is not None:
            self.limits_s.add(judged.limit_s)


@dataclass
class ServiceFigures:
    """The reactions of one service."""

    times: Distribution = field(default_factory=Distribution)
    trs: Limit = field(default_factory=Limit)


@dataclass
class StationFigures:
    """What a station did, by the addresses of good telegrams: those of a damaged one may be anybody's."""

    commands: int = 0
    reactions: int = 0
    errors: int = 0  # reactions whose status is not 0
    repeats: int = 0  # commands that it sent again
    unanswered: int = 0  # commands to it
    times: Distribution = field(default_factory=Distribution)  # of its reactions
    trs: Limit = field(default_factory=Limit)
    tza: Limit = field(default_factory=Limit)


@dataclass
class ExactnessFigures:
    """How exact the times are, in s."""

    least_s: float = math.inf
    most_s: float = 0.0
    unknown: int = 0  # records without an uncertainty

    def add(self, packets: Sequence[Packet]) -> None:
        """Count records of characters."""
        known_s = [packet.uncertainty_s for packet in packets if packet.uncertainty_s is not None]
        self.unknown += len(packets) - len(known_s)
        self.least_s = min([self.least_s, *known_s])
        self.most_s = max([self.most_s, *known_s])

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

    def add(self, silences_s: Sequence[float], packets: Sequence[Packet]) -> None:
        """Count those before these packets. Of equal ones, the first is the longest."""
        longest_s = max(silences_s)
        if longest_s > SILENCE_S:
            self.long += sum(silence_s > SILENCE_S for silence_s in silences_s)
        number = packets[silences_s.index(longest_s)].number
        if longest_s > self.longest_s or (self.before and longest_s == self.longest_s and number < self.before):
            self.longest_s, self.before = longest_s, number


@dataclass
class Figures:
    """All of them; times in s."""

    packets: int = 0
    records: Counter[int | None] = field(default_factory=Counter)  # by type; None: no record of the tap
    telegrams: int = 0
    good: int = 0
    first_epoch_s: float | None = None
    duration_s: float = 0.0
    interfaces: dict[str, None] = field(default_factory=dict)  # in the order in which they came
    settings: dict[tuple[int, str], None] = field(default_factory=dict)  # rate and format, in the same order
    events: list[Packet] = field(default_factory=list)  # the first ones
    exactness: ExactnessFigures = field(default_factory=ExactnessFigures)
    framings: Counter[int] = field(default_factory=Counter)  # frames that are no SIS telegrams, by framing
    frame_intervals: Distribution = field(default_factory=Distribution)  # inside those
    silences: Silences = field(default_factory=Silences)
    limits: dict[str, Limit] = field(default_factory=lambda: {name: Limit() for name in ("tza", "trs", "tmas")})
    services: defaultdict[int, ServiceFigures] = field(default_factory=lambda: defaultdict(ServiceFigures))
    stations: defaultdict[int, StationFigures] = field(default_factory=lambda: defaultdict(StationFigures))
    faults: Counter[str] = field(default_factory=Counter)  # telegrams and records that have each
    slices: Slices = field(default_factory=Slices)
    parameters: Listing = field(default_factory=Listing)
    curves: Curves = field(default_factory=Curves)
    pauses: Pauses = field(default_factory=Pauses)

    _alike: defaultdict[object, list[Packet]] = field(default_factory=lambda: defaultdict(list))  # that wait
    _waiting: int = 0

    def add(self, packet: Packet) -> None:
        """Count a packet, at the latest when all have come."""
        self.packets += 1
        if self.first_epoch_s is None:
            self.first_epoch_s = packet.epoch_s
        if packet.type == EVENT and len(self.events) < EVENTS_KEPT:
            self.events.append(packet)
        for access in packet.accesses:
            self.parameters.add(AccessPlace("", packet.number, packet.epoch_s), access)
            self.curves.add(packet.time_s, access)
        self._alike[packet.alike].append(packet)
        self._waiting += 1
        if self._waiting == TOGETHER:
            self.finish()

    def finish(self) -> None:
        """Count what waits."""
        for packets in self._alike.values():
            self._add(packets)
        self._alike.clear()
        self._waiting = 0

    def _add(self, packets: Sequence[Packet]) -> None:
        """Count packets that say the same."""
        packet, count = packets[0], len(packets)
        at = self.slices.at([one.time_s for one in packets])
        self.records[packet.type] += count
        self.interfaces[packet.interface] = None
        self.duration_s = max([self.duration_s, *[one.time_s + one.length_s for one in packets]])
        if packet.type in (FRAME, OTHER):
            self._add_records(packets)
            self.pauses.add(packets)
        for place in range(len(packet.telegrams)):
            self._add_telegrams(packets, [one.telegrams[place] for one in packets], at)
        for fault in packet.faults:
            self.faults[fault.name] += count
            self.slices.count(fault.name, at)

    def _add_records(self, packets: Sequence[Packet]) -> None:
        packet, count = packets[0], len(packets)
        self.exactness.add(packets)
        if packet.baud:
            self.settings[packet.baud, packet.format] = None
        if packet.type == FRAME and packet.framing:
            self.framings[packet.framing] += count
            if not packet.errors & LOST:
                for one in packets:
                    self.frame_intervals.add(one.intervals_s)

    def _add_telegrams(self, packets: Sequence[Packet], telegrams: Sequence[Telegram], at: Sequence[int]) -> None:
        telegram = telegrams[0]
        reactions = [one.reaction for one in telegrams if one.reaction]
        pauses = [one.pause for one in telegrams if one.pause]
        cycles = [one.cycle for one in telegrams if one.cycle]
        self.telegrams += len(telegrams)
        for name, found in (("tza", pauses), ("trs", reactions), ("tmas", cycles)):
            if found:
                self.limits[name].add(found[0], len(found))
        if reactions and telegram.service is not None:
            service = self.services[telegram.service]
            service.times.add([one.time_s for one in reactions if one.time_s])
            service.trs.add(reactions[0], len(reactions))
        if telegram.good:
            self.good += len(telegrams)
            self._add_stations(telegram, len(telegrams), reactions, pauses, at)
        self._add_bus(packets, telegrams, at)

    def _add_bus(self, packets: Sequence[Packet], telegrams: Sequence[Telegram], at: Sequence[int]) -> None:
        silences = [(one.silence.time_s, packet) for packet, one in zip(packets, telegrams, strict=True) if one.silence]
        if silences:
            self.silences.add(*zip(*silences, strict=True))
        for number, one in zip(at, telegrams, strict=True):
            if one.load_percent is not None:
                self.slices.add_load(number, one.load_percent)

    def _add_stations(
        self, telegram: Telegram, count: int, reactions: Sequence[Judged], pauses: Sequence[Judged], at: Sequence[int]
    ) -> None:
        """Count telegrams such as this one."""
        if telegram.unanswered and telegram.listener is not None:
            self.stations[telegram.listener].unanswered += count
        if telegram.talker is None:
            return
        station = self.stations[telegram.talker]
        self.slices.count(str(telegram.talker), at)
        if telegram.is_reaction:
            station.reactions += count
            station.errors += telegram.is_refusal * count
        else:
            station.commands += count
            station.repeats += telegram.is_repeat * count
        if reactions:
            station.times.add([one.time_s for one in reactions if one.time_s])
            station.trs.add(reactions[0], len(reactions))
        if pauses:
            station.tza.add(pauses[0], len(pauses))
