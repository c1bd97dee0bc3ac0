# SPDX-License-Identifier: GPL-2.0-or-later
"""All that looks for episodes, packet by packet."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Protocol

from sistap.dissected.episodes import diagnoses, machine
from sistap.dissected.episodes.book import Book
from sistap.dissected.episodes.boots import STEPS, Boots
from sistap.dissected.episodes.diagnoses import STILL, Diagnoses
from sistap.dissected.episodes.episode import Episode, Hit
from sistap.dissected.episodes.faults import Faults, Refusals, UnreadableLine
from sistap.dissected.episodes.folding import fold
from sistap.dissected.episodes.machine import Machine
from sistap.dissected.episodes.masters import Masters
from sistap.dissected.episodes.paces import Paces
from sistap.dissected.episodes.readings import reading
from sistap.dissected.episodes.rules import THRESHOLDS, Thresholds
from sistap.dissected.episodes.silence import BusSilence, StationSilence
from sistap.dissected.episodes.standard import FOLLOWS
from sistap.dissected.episodes.states import Devices, LimitChanges, PhaseChanges, RateChanges, TapTroubles
from sistap.dissected.episodes.values import Values, unlike
from sistap.dissected.episodes.writes import Writes
from sistap.dissected.packets.dissection import Packet, Telegram

_REMEMBERED = 4096
_DUPLEX = {1, 2}  # lines: the two directions of one bus, each at an interface of its own

_Look = Callable[[Packet], Iterable[Hit]]  # returns what it tells by now


class _Looker(Protocol):
    """What looks at packets."""

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return what it tells by now."""


class Bus:
    """What looks at one bus; `before` looked at it in a good capture."""

    def __init__(self, name: str, thresholds: Thresholds, since_s: float, before: Bus | None = None) -> None:
        """Begin with no packet."""
        self.name = name  # of its first interface
        self.begin_s = self.end_s = 0.0
        self.masters: Masters = Masters(thresholds, before.masters if before else None)
        self.writes: Writes = Writes(self.masters, thresholds, before.writes if before else None)
        self.phases: PhaseChanges = PhaseChanges(thresholds, before.phases if before else None)
        self.rate: RateChanges = RateChanges(before.rate if before else None)
        self.limits: LimitChanges = LimitChanges(before.limits if before else None)
        self.devices: Devices = Devices(before.devices if before else None)
        self.silence: StationSilence = StationSilence(thresholds, before.silence if before else None)
        self.bus = BusSilence(thresholds)
        self.faults = Faults()
        self.refusals: Refusals = Refusals(before.refusals if before else None)
        self.unreadable = UnreadableLine()
        self.boots = Boots(self.faults.known)
        self.paces = Paces(thresholds)
        self.machine = Machine()
        self.diagnoses = Diagnoses()
        self.values: Values = Values(thresholds, since_s, before.values if before else None)
        # Most packets are nothing new to any of them. So none is a generator, which costs more than what it looks at;
        # and a good telegram that only reads or writes goes to those alone that learn from it.
        tap = TapTroubles(thresholds)
        lookers: tuple[_Looker, ...] = (
            *(tap, self.bus, self.faults, self.silence, self.masters, self.rate, self.paces, self.limits),
            *(self.unreadable, self.phases, self.boots, self.devices, self.refusals, self.values),
        )
        of_command = self.faults.command, self.silence.command, self.masters.add, self.rate.add
        of_reaction = self.faults.reaction, self.silence.reaction, self.paces.add, self.limits.add
        self._all: Sequence[_Look] = [*(looker.add for looker in lookers), self.writes.unheard]
        self._of_command: Sequence[_Look] = (tap.add, self.bus.add, *of_command)
        self._of_reaction: Sequence[_Look] = (tap.add, self.bus.add, *of_reaction)
        self._looks: dict[object, Sequence[_Look]] = {}  # by what packets have in common
        self.lasting: list[Hit] = []  # of states and levels that begin to last; asked for only while it happens

    def add(self, packet: Packet, *, is_live: bool = False) -> list[Hit]:
        """Look at a packet; return what it tells by now."""
        self.begin_s = self.begin_s or packet.epoch_s
        self.end_s = packet.epoch_s
        looks = self._looks.get(packet.alike)
        if looks is None:
            if len(self._looks) == _REMEMBERED:
                self._looks.clear()
            looks = self._looks[packet.alike] = self._concerned(packet)
        hits: list[Hit] = []
        for look in self._all if self.unreadable.is_begun else looks:
            hits += look(packet)
        if packet.accesses:
            hits += self._read(packet, is_live=is_live)
        return hits

    def _concerned(self, packet: Packet) -> Sequence[_Look]:
        """Return what this packet and its like can concern."""
        if _is_rare(packet):
            return self._all
        (telegram,) = packet.telegrams
        usual = self._of_reaction if telegram.is_reaction else self._of_command
        return (*usual, self.phases.add, self.boots.add) if telegram.phase else usual

    def _read(self, packet: Packet, *, is_live: bool) -> list[Hit]:
        """Take what parameters say."""
        hits = [*self.writes.add(packet)]
        begun = []
        for access in packet.accesses:
            if not access.error:
                self.refusals.know(access.parameter)
            said = reading(access)
            if said is None:
                continue
            ident = access.parameter.ident
            if ident in machine.LOOKED_AT:
                self.machine.add(packet.epoch_s, access.parameter, said)
            if ident in diagnoses.LOOKED_AT:
                hits += self.diagnoses.add(packet, access, said)
            running = self.machine.is_running
            if self.values.take(packet, access, said, is_running=running):
                begun.append(access.parameter)
            if access.minimum or access.maximum or ident in FOLLOWS:
                hits += self.values.judge(packet, access, said, is_running=running)
        if is_live:
            self.lasting = [*self.values.under_way(begun)]
        return hits

    def begun(self) -> list[Hit]:
        """Return what has begun with the last packet, and is told only at its end."""
        begun = [*self.silence.under_way(self.name), *self.masters.begun(), *self.writes.begun()]
        lasting, self.lasting = self.lasting, []
        return [*begun, *self.diagnoses.begun(), *lasting]

    def finish(self) -> Iterator[Hit]:
        """Yield what is known only at the end."""
        yield from self.faults.finish(self.name, self.begin_s, self.end_s)
        yield from self.unreadable.finish(self.name)
        yield from self.silence.finish(self.name)
        yield from self.boots.finish(self.name)
        yield from self.masters.finish(self.name)
        yield from self.writes.finish()
        yield from self.paces.finish(self.name)
        yield from self.diagnoses.finish()
        yield from self.values.finish()
        for from_s, to_s in self.machine.stops(self.begin_s, self.end_s):
            outcome = STILL if to_s == self.end_s else ""
            yield Hit("stopped", 0, from_s, to_s, port=self.name, outcome=outcome)


def _is_rare(packet: Packet) -> bool:
    """Tell whether a packet is more than a good telegram that reads or writes something, as nearly all."""
    if len(packet.telegrams) != 1:
        return True
    (telegram,) = packet.telegrams
    is_odd = not telegram.good or telegram.unanswered or telegram.is_refusal or telegram.is_repeat
    is_told = telegram.is_doubtful or telegram.has_system_error or telegram.signs or packet.errors or packet.faults
    return bool(is_odd or is_told or telegram.service in STEPS)


class Engine:
    """Makes episodes of packets."""

    def __init__(
        self, before: Engine | None = None, thresholds: Thresholds = THRESHOLDS, since_s: float = -math.inf
    ) -> None:
        """Begin with no packet. What was usual before, in a good capture, is usual still: masters, writes, refusals,
        states of the bus, devices, levels of values, drifts. What comes before `since_s` only teaches what is usual.
        """
        self._before = before
        self._thresholds = thresholds
        self._since_s = since_s
        self._book = Book()
        self._buses: dict[str, Bus] = {}
        self._at: dict[str, Bus] = {}  # by interface: a full-duplex bus has two

    @property
    def buses(self) -> Iterable[Bus]:
        """Return those that were heard."""
        return self._buses.values()

    @property
    def undescribed(self) -> int:
        """Return the number of parameters of which only bytes are known."""
        return sum(bus.values.undescribed for bus in self._buses.values())

    def add(self, packet: Packet) -> None:
        """Look at a packet."""
        hits = self.bus_of(packet).add(packet)
        if hits:
            self._book.add(hits)

    def live(self, packet: Packet, *, is_learning: bool) -> list[Hit]:
        """Look at a packet; return what it tells by now. Nothing is noted for the end."""
        bus = self.bus_of(packet)
        hits = bus.add(packet, is_live=True)
        return hits + [hit for hit in bus.begun() if not is_learning or hit.kind not in _LEARNED]

    def unanswered(self, packet: Packet, command: Telegram) -> None:
        """Learn that a command had no reaction: of a packet that was looked at, only the next command tells it."""
        command.unanswered = True
        alone = replace(packet, telegrams=[command], accesses=[])
        bus = self.bus_of(packet)
        bus.silence.add(alone)
        bus.values.add(alone)
        bus.writes.unheard(alone)

    def silent(self, now_s: float) -> list[Hit]:
        """Return what lasts while no packet comes."""
        return [hit for bus in self._buses.values() for hit in bus.bus.under_way(now_s)]

    def bus_of(self, packet: Packet) -> Bus:
        """Return the bus of a packet."""
        bus = self._at.get(packet.interface)
        if bus is None:
            name = "" if packet.line in _DUPLEX else packet.interface
            if name not in self._buses:
                before = self._before._bus(name) if self._before else None
                self._buses[name] = Bus(packet.interface, self._thresholds, self._since_s, before)
                self._expect()
            bus = self._at[packet.interface] = self._buses[name]
        return bus

    def _expect(self) -> None:
        """Expect nobody at a bus that is not in the good capture. An only one may have another name now."""
        if self._before and len(self._buses) > 1:
            for name in self._buses.keys() - self._before._buses.keys():
                self._buses[name].masters.expect_nobody()
                self._buses[name].silence.expect_nobody()

    def finish(self) -> list[Episode]:
        """Return all episodes, in the order of their beginning; some are known only at the end."""
        for name, bus in self._buses.items():
            self._book.add(bus.finish())
            before = self._before._bus(name) if self._before else None
            if before:
                self._book.add(unlike(before.values, bus.values))
        found = []
        for bus in self._buses.values():
            here = [one for one in self._book.episodes() if self._is_of(one, bus)]
            for one in here:
                if one.kind in ("write", "limit_write", "conflict"):
                    one.outcome = bus.writes.outcome(one.hit)
            found += fold(here, bus.faults.telegrams, self._thresholds)
        return sorted(found, key=lambda one: one.from_s)

    def _is_of(self, episode: Episode, bus: Bus) -> bool:
        return len(self._buses) == 1 or self._at.get(episode.hit.port) is bus

    def _bus(self, name: str) -> Bus | None:
        """Return the bus of this name, in a good capture. An only one may have another name now."""
        only = next(iter(self._buses.values())) if len(self._buses) == 1 else None
        return self._buses.get(name, only)


# A recorder learns for a while what is written, and the levels and states of values.
_LEARNED = {"write", "limit_write", "step", "changed"}
