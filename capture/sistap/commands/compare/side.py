# SPDX-License-Identifier: GPL-2.0-or-later
"""What is counted of one side, good or bad: one capture or several, in bounded memory."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from sistap.commands.compare.samples import Samples
from sistap.dissected.accesses.listing import AccessPlace, Listing
from sistap.dissected.captures import portions
from sistap.dissected.captures.joining import in_order
from sistap.dissected.episodes.engine import Engine
from sistap.dissected.episodes.episode import Episode
from sistap.dissected.packets.dissection import LOST, Dissection, Packet, Telegram
from sistap.dissected.packets.distribution import Distribution
from sistap.dissected.wireshark.rows import FRAME, OTHER
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.common.garbage import uncollected
from sistap.tap.terminal.console import visible

_PROGRESS_EVERY = 5000  # packets
LIMITS = {"tza": "TzA", "trs": "TrS", "tmas": "Tmas"}


class ServiceOfSide(NamedTuple):
    """A service that a station was asked for."""

    station: int
    number: int


@dataclass
class Side:
    """Everything that is compared; times in s."""

    names: list[str] = field(default_factory=list)  # of its captures
    begin_s: float = 0.0  # since 1970
    end_s: float = 0.0
    seconds: float = 0.0
    telegrams: int = 0
    engine: Engine = field(default_factory=Engine)
    episodes: list[Episode] = field(default_factory=list)
    settings: Counter[str] = field(default_factory=Counter)  # rate and format
    limits: dict[str, Counter[float]] = field(default_factory=lambda: {name: Counter() for name in LIMITS})
    uncertainty: Distribution = field(default_factory=Distribution)
    stations: Counter[int] = field(default_factory=Counter)  # telegrams that each has sent
    masters: set[int] = field(default_factory=set)  # those that have sent commands
    services: Counter[ServiceOfSide] = field(default_factory=Counter)  # reactions, and commands that none followed
    reactions: defaultdict[ServiceOfSide, Samples] = field(default_factory=lambda: defaultdict(Samples))
    intervals: defaultdict[int, Samples] = field(default_factory=lambda: defaultdict(Samples))  # by talker
    parameters: Listing = field(default_factory=Listing)

    @property
    def uncertainty_s(self) -> float:
        """Return a lower bound of the uncertainty of half of its times."""
        return self.uncertainty.within_s(0.5)

    def add(self, packet: Packet, place: AccessPlace) -> None:
        """Count a packet."""
        self.engine.add(packet)
        self.begin_s = self.begin_s or packet.epoch_s
        self.end_s = max(self.end_s, packet.ended_s)
        if packet.type in (FRAME, OTHER):
            if packet.baud:
                self.settings[f"{packet.baud} Bd {packet.format}".rstrip()] += 1
            if packet.uncertainty_s is not None:
                self.uncertainty.add([packet.uncertainty_s])
        for telegram in packet.telegrams:
            self._add_telegram(packet, telegram)
        for access in packet.accesses:
            self.parameters.add(place, access)

    def _add_telegram(self, packet: Packet, telegram: Telegram) -> None:
        self.telegrams += 1
        for name, judged in (("tza", telegram.pause), ("trs", telegram.reaction), ("tmas", telegram.cycle)):
            if judged and judged.limit_s is not None:
                self.limits[name][judged.limit_s] += 1
        if not telegram.good or telegram.talker is None:
            return
        self.stations[telegram.talker] += 1
        if not telegram.is_reaction:
            self.masters.add(telegram.talker)
        if len(packet.telegrams) == 1 and packet.intervals_s and not packet.errors & LOST:
            self.intervals[telegram.talker].add(packet.intervals_s)
        if telegram.service is None:
            return
        if telegram.is_reaction:
            service = ServiceOfSide(telegram.talker, telegram.service)
            self.services[service] += 1
            if telegram.reaction and telegram.reaction.measured_s:
                self.reactions[service].add(telegram.reaction.measured_s)
        elif telegram.unanswered and telegram.listener is not None:
            self.services[ServiceOfSide(telegram.listener, telegram.service)] += 1


def read(
    tshark: Tshark,
    captures: Iterable[Path],
    say: Callable[[str], None],
    progress: Callable[[str], None],
    engine: Engine,
) -> Side:
    """Read the captures of a side. Report damage.

    Refusal.
    """
    side = Side(engine=engine)
    side.names = [visible(capture.name) for capture in in_order(captures)]
    for several in portions.as_one(captures):
        progress(f"reading {several[0]}")
        with (
            closing(portions.in_turn(several, portions.TOGETHER, say)) as parts,
            Dissection(tshark, parts, keeps=False) as dissection,
            uncollected(),
        ):
            _read(side, dissection, progress)
        if dissection.warning:
            say(f"{several[-1]}: only what comes before the damage: {dissection.warning}")
        if dissection.missing:
            say(f"left out, as the installed dissector does not know it: {', '.join(dissection.missing)}")
    side.episodes = side.engine.finish()
    return side


def _read(side: Side, dissection: Dissection, progress: Callable[[str], None]) -> None:
    """Count all packets. The time between two captures belongs to neither."""
    begins_s: dict[Path, float] = {}
    ends_s: dict[Path, float] = {}
    for count, packet in enumerate(dissection.packets(), 1):
        capture, number = dissection.place(packet)
        side.add(packet, AccessPlace(visible(capture.name), number, packet.epoch_s))
        begins_s.setdefault(capture, packet.time_s)
        ends_s[capture] = max(ends_s.get(capture, packet.end_s), packet.end_s)
        if count % _PROGRESS_EVERY == 0:
            progress(f"{capture}: {count} packets read, {packet.time_s - begins_s[capture]:.0f} s of it")
    side.seconds += sum(end_s - begins_s[capture] for capture, end_s in ends_s.items())
